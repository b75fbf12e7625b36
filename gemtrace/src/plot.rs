//! Plots as SVG text: lines over wavelength or another quantity, and strips of measurements.
//!
//! Panels of lines stand one above the other and share the axis across, as n(λ) and absorption do.

mod strip;

pub use strip::{Strip, strips};

use std::fmt::Write as _;

/// A line through points (nm, value), ascending in nm, or in whatever the plot is over.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Name in the legend; empty for none.
    pub label: String,
    /// Any colour that SVG knows.
    pub colour: &'static str,
    /// (nm, value).
    pub points: Vec<[f64; 2]>,
}

/// One pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// What the vertical axis measures, with its unit.
    pub label: String,
    /// Whether the vertical axis must show zero.
    pub from_zero: bool,
    /// What is drawn.
    pub lines: Vec<Curve>,
}

const WIDTH: f64 = 720.0;
const PANEL: f64 = 240.0;
const LEFT: f64 = 76.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 40.0;
const GAP: f64 = 24.0;
const BOTTOM: f64 = 48.0;

/// The panels under a title, over wavelength, as an SVG document.
///
/// ```
/// use gemtrace::plot::{Curve, Panel, svg};
/// let line = Curve { label: String::new(), colour: "black", points: vec![[400.0, 2.46], [700.0, 2.41]] };
/// let text = svg("diamond", &[Panel { label: "n".into(), from_zero: false, lines: vec![line] }]);
/// assert!(text.starts_with("<svg") && text.contains("polyline"));
/// ```
pub fn svg(title: &str, panels: &[Panel]) -> String {
    svg_over("wavelength, nm", title, panels)
}

/// The same over another quantity, named with its unit.
pub fn svg_over(quantity: &str, title: &str, panels: &[Panel]) -> String {
    let height = TOP + panels.len() as f64 * (PANEL + GAP) - GAP + BOTTOM;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"white\"/>\n\
         <text x=\"{LEFT}\" y=\"24\" font-size=\"15\">{}</text>\n",
        escape(title)
    );
    let across = Axis::new(extent(panels.iter().flat_map(|p| &p.lines), 0), [LEFT, WIDTH - RIGHT], false);
    for (i, panel) in panels.iter().enumerate() {
        let top = TOP + i as f64 * (PANEL + GAP);
        draw(&mut out, panel, &across, top, i + 1 == panels.len());
    }
    let middle = (LEFT + WIDTH - RIGHT) / 2.0;
    text(&mut out, [middle, height - 12.0], "middle", quantity);
    out.push_str("</svg>\n");
    out
}

fn draw(out: &mut String, panel: &Panel, across: &Axis, top: f64, last: bool) {
    let bottom = top + PANEL;
    let mut values = extent(&panel.lines, 1);
    if panel.from_zero {
        values = [values[0].min(0.0), values[1].max(0.0)];
    }
    let up = Axis::new(values, [bottom, top], true);
    for tick in across.ticks() {
        let x = across.place(tick);
        rule(out, [x, top], [x, bottom]);
        if last {
            text(out, [x, bottom + 16.0], "middle", &number(tick, across.step));
        }
    }
    for tick in up.ticks() {
        let y = up.place(tick);
        rule(out, [LEFT, y], [WIDTH - RIGHT, y]);
        text(out, [LEFT - 6.0, y + 4.0], "end", &number(tick, up.step));
    }
    let middle = (top + bottom) / 2.0;
    put(
        out,
        format_args!(
            "<text transform=\"translate(16 {middle}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
            escape(&panel.label)
        ),
    );
    for line in &panel.lines {
        let points: Vec<String> = line
            .points
            .iter()
            .map(|[nm, v]| format!("{:.2},{:.2}", across.place(*nm), up.place(*v)))
            .collect();
        put(
            out,
            format_args!(
                "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\" points=\"{}\"/>\n",
                line.colour,
                points.join(" ")
            ),
        );
    }
    // The legend stands above all lines, in a halo that keeps them off it.
    for (i, line) in panel.lines.iter().enumerate().filter(|(_, line)| !line.label.is_empty()) {
        put(
            out,
            format_args!(
                "<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"{}\" stroke=\"white\" stroke-width=\"4\" \
                 paint-order=\"stroke\">{}</text>\n",
                WIDTH - RIGHT - 8.0,
                top + 18.0 + 16.0 * i as f64,
                line.colour,
                escape(&line.label)
            ),
        );
    }
}

/// A linear axis from values to pixels.
struct Axis {
    values: [f64; 2],
    pixels: [f64; 2],
    step: f64,
}

impl Axis {
    /// An axis over `values`; `round` widens it to whole ticks.
    fn new(values: [f64; 2], pixels: [f64; 2], round: bool) -> Self {
        let [mut low, mut high] = values;
        if low >= high {
            // A constant lies in the middle, nothing at all on the axis.
            let margin = low.abs() * 0.1;
            (low, high) = if low == 0.0 { (0.0, 1.0) } else { (low - margin, high + margin) };
        }
        let step = nice_step(high - low);
        if round {
            (low, high) = ((low / step).floor() * step, (high / step).ceil() * step);
        }
        Axis { values: [low, high], pixels, step }
    }

    fn place(&self, value: f64) -> f64 {
        let share = (value - self.values[0]) / (self.values[1] - self.values[0]);
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }

    fn ticks(&self) -> impl Iterator<Item = f64> {
        let first = (self.values[0] / self.step - 1e-9).ceil();
        let count = (self.values[1] / self.step + 1e-9).floor() - first;
        (0..=count.clamp(0.0, 100.0) as u32).map(move |i| (first + f64::from(i)) * self.step)
    }
}

/// A step of 1, 2 or 5 times a power of ten that cuts `span` into four to ten parts.
fn nice_step(span: f64) -> f64 {
    let power = 10f64.powf((span / 10.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|step| span / step <= 10.0).unwrap_or(span)
}

/// The least and greatest of the points' coordinate `c`; (0, 1) where there is none.
fn extent<'a>(lines: impl IntoIterator<Item = &'a Curve>, c: usize) -> [f64; 2] {
    let values = lines.into_iter().flat_map(|line| &line.points).map(|point| point[c]);
    let [low, high] = values
        .filter(|v| v.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    if low <= high { [low, high] } else { [0.0, 1.0] }
}

/// A tick's value with as many decimals as its step has.
fn number(value: f64, step: f64) -> String {
    let decimals = (-step.log10() + 1e-9).ceil().clamp(0.0, 9.0) as usize;
    // Adding zero turns -0 into 0.
    format!("{:.decimals$}", value + 0.0)
}

fn rule(out: &mut String, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) {
    put(
        out,
        format_args!("<line x1=\"{x1:.2}\" y1=\"{y1:.2}\" x2=\"{x2:.2}\" y2=\"{y2:.2}\" stroke=\"#ddd\"/>\n"),
    );
}

fn text(out: &mut String, [x, y]: [f64; 2], anchor: &str, content: &str) {
    put(
        out,
        format_args!("<text x=\"{x:.2}\" y=\"{y:.2}\" text-anchor=\"{anchor}\">{}</text>\n", escape(content)),
    );
}

fn put(out: &mut String, arguments: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    out.write_fmt(arguments).ok();
}

/// Text for the inside of an element or of an attribute in double quotes.
pub fn escape(content: &str) -> String {
    content.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_cover_the_data() {
        for (low, high) in [(380.0, 780.0), (2.40, 2.47), (0.0, 0.013), (-3.0, 1e6)] {
            let axis = Axis::new([low, high], [0.0, 100.0], true);
            let ticks: Vec<f64> = axis.ticks().collect();
            assert!((4..=13).contains(&ticks.len()), "{ticks:?}");
            assert!(axis.values[0] <= low && axis.values[1] >= high);
            assert!((axis.place(axis.values[1]) - 100.0).abs() < 1e-9);
        }
    }

    #[test]
    fn constants_and_nothing_still_make_a_plot() {
        let line = |points| Curve { label: "<n>".into(), colour: "black", points };
        for points in [vec![], vec![[500.0, 0.0]], vec![[400.0, 1.5], [700.0, 1.5]]] {
            let text =
                svg("a & b", &[Panel { label: "n".into(), from_zero: true, lines: vec![line(points)] }]);
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
            assert!(text.contains("a &amp; b") && text.contains("&lt;n&gt;"));
        }
    }
}
