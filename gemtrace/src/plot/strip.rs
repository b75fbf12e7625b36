//! Repeated measurements of several things, one strip each over a shared logarithmic axis.

use super::{escape, put};

/// The measurements of one thing.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// What was measured.
    pub label: String,
    /// The figure to print at the strip's end.
    pub note: String,
    /// Every measurement; only those above 0 have a place on the axis.
    pub values: Vec<f64>,
    /// The one to point out.
    pub middle: f64,
    /// Whether to hold it back against the others.
    pub muted: bool,
}

const WIDTH: f64 = 420.0;
const LEFT: f64 = 14.0;
const RIGHT: f64 = 14.0;
const ROW: f64 = 42.0;
const BOTTOM: f64 = 40.0;

/// The strips as an `<svg>` element to stand in an HTML page: it takes the page's colours (`currentColor`, and the
/// property `--accent`) and has no names or addresses in it. Empty where there is nothing to draw.
///
/// ```
/// use gemtrace::plot::{Strip, strips};
/// let strip = |label: &str, middle: f64| Strip {
///     label: label.into(), note: String::new(), values: vec![0.9 * middle, 1.2 * middle], middle, muted: false,
/// };
/// let text = strips("milliseconds", &[strip("one", 3.0), strip("other", 200.0)]);
/// assert!(text.starts_with("<svg") && text.contains("milliseconds") && text.contains(">100<"));
/// ```
pub fn strips(axis: &str, strips: &[Strip]) -> String {
    let values =
        strips.iter().flat_map(|s| s.values.iter().copied().chain([s.middle])).filter(|v| drawable(*v));
    let [low, high] = values.fold([f64::INFINITY, 0.0], |[low, high], v| [v.min(low), v.max(high)]);
    if low > high {
        return String::new();
    }
    let axis_of = Logarithmic::new(low, high);
    let foot = ROW * strips.len() as f64;
    let height = foot + BOTTOM;
    let mut out = format!(
        "<svg viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"{}\" font-size=\"13\" fill=\"currentColor\">\n",
        escape(axis)
    );
    for tick in axis_of.ticks() {
        let x = axis_of.place(tick);
        put(
            &mut out,
            format_args!(
                "<line x1=\"{x:.2}\" y1=\"0\" x2=\"{x:.2}\" y2=\"{foot}\" stroke=\"currentColor\" opacity=\"0.15\"/>\n\
                 <text x=\"{x:.2}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11\">{tick}</text>\n",
                foot + 14.0
            ),
        );
    }
    for (i, strip) in strips.iter().enumerate() {
        draw(&mut out, strip, &axis_of, ROW * i as f64);
    }
    put(
        &mut out,
        format_args!(
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11\">{}</text>\n</svg>\n",
            WIDTH / 2.0,
            height - 6.0,
            escape(axis)
        ),
    );
    out
}

fn drawable(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

fn draw(out: &mut String, strip: &Strip, axis: &Logarithmic, top: f64) {
    let (label, note) = (escape(&strip.label), escape(&strip.note));
    let y = top + 27.0;
    let places: Vec<f64> = strip.values.iter().filter(|v| drawable(**v)).map(|v| axis.place(*v)).collect();
    let colour = if strip.muted { "currentColor\" opacity=\"0.6" } else { "var(--accent)" };
    put(
        out,
        format_args!(
            "<g><text x=\"{LEFT}\" y=\"{}\">{label}</text>\n\
             <text x=\"{}\" y=\"{}\" text-anchor=\"end\">{note}</text></g>\n<g fill=\"{colour}\">\n",
            top + 15.0,
            WIDTH - RIGHT,
            top + 15.0,
        ),
    );
    let first = places.iter().copied().fold(f64::INFINITY, f64::min);
    let last = places.iter().copied().fold(0.0, f64::max);
    if last > first {
        put(
            out,
            format_args!(
                "<rect x=\"{first:.2}\" y=\"{}\" width=\"{:.2}\" height=\"4\" opacity=\"0.4\"/>\n",
                y - 2.0,
                last - first
            ),
        );
    }
    for x in places {
        put(out, format_args!("<circle cx=\"{x:.2}\" cy=\"{y}\" r=\"2.5\" opacity=\"0.5\"/>\n"));
    }
    if drawable(strip.middle) {
        let x = axis.place(strip.middle) - 1.5;
        put(out, format_args!("<rect x=\"{x:.2}\" y=\"{}\" width=\"3\" height=\"14\"/>\n", y - 7.0));
    }
    out.push_str("</g>\n");
}

/// A logarithmic axis from values to pixels.
struct Logarithmic {
    /// Decimal logarithms of the ends.
    ends: [f64; 2],
}

impl Logarithmic {
    /// An axis over positive values, with some room on both sides.
    fn new(low: f64, high: f64) -> Self {
        let [low, high] = [low.log10(), high.log10()];
        let margin = (0.06 * (high - low)).max(0.08);
        Logarithmic { ends: [low - margin, high + margin] }
    }

    fn place(&self, value: f64) -> f64 {
        let share = (value.log10() - self.ends[0]) / (self.ends[1] - self.ends[0]);
        LEFT + share * (WIDTH - LEFT - RIGHT)
    }

    /// Powers of ten, with 2 and 5 between them or every tenth where there is room.
    fn ticks(&self) -> Vec<f64> {
        let steps: &[f64] = match self.ends[1] - self.ends[0] {
            span if span > 2.5 => &[1.0],
            span if span > 0.7 => &[1.0, 2.0, 5.0],
            _ => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
        };
        let [low, high] = self.ends;
        let powers = low.floor() as i32..=high.floor() as i32;
        let ticks = powers.flat_map(|p| {
            // Through text, so that a tenth is written 0.1.
            steps.iter().filter_map(move |step| format!("{step}e{p}").parse::<f64>().ok())
        });
        ticks.filter(|tick| (low..=high).contains(&tick.log10())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_few_round_and_within_the_ends() {
        for (low, high, wanted) in [
            (0.9, 120.0, vec![1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]),
            (0.05, 3e4, vec![0.1, 1.0, 10.0, 100.0, 1e3, 1e4]),
            (1.0, 1.0, vec![1.0]),
        ] {
            assert_eq!(
                Logarithmic::new(low, high).ticks().iter().filter(|t| (low..=high).contains(*t)).count(),
                wanted.len(),
                "{low} to {high}"
            );
        }
    }

    #[test]
    fn what_has_no_place_on_the_axis_is_left_out() {
        let strip = |values: Vec<f64>, middle| Strip {
            label: "<a & b>".into(),
            note: "\"1\"".into(),
            values,
            middle,
            muted: true,
        };
        assert_eq!(strips("s", &[]), "");
        assert_eq!(strips("s", &[strip(vec![0.0, f64::NAN, f64::INFINITY], -1.0)]), "");
        let text = strips("s", &[strip(vec![0.0, 2.0], 2.0), strip(vec![], f64::NAN)]);
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        assert!(text.contains("&lt;a &amp; b&gt;") && text.contains("&quot;1&quot;"), "{text}");
    }
}
