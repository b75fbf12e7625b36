//! Measurements as one HTML page that loads nothing: plots are inline SVG, pictures are `data:` addresses, and a
//! content security policy forbids the rest. The markup is well-formed XML, too.

mod thumbnail;

use super::measurement::Measurement;
use super::table::{self, HEADINGS, label};
use super::{Heat, threads};
use gemtrace::plot::{Strip, escape, strips};
use gemtrace::quantity::{count, measured};
use spectral_core::film::Film;
use std::fmt::Write as _;

/// The whole page.
pub fn html(heats: &[Heat], rounds: usize, interrupted: bool) -> String {
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" \
         content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\"/>\n\
         <title>gemtrace bench</title>\n<style>\n{}</style>\n</head>\n<body>\n<h1>gemtrace bench</h1>\n",
        include_str!("page/style.css")
    );
    put(&mut out, format_args!("<p>{}</p>\n", escape(&circumstances(rounds))));
    if interrupted {
        out += "<p class=\"note\">Interrupted: only what was complete is shown.</p>\n";
    }
    for caveat in table::caveats(heats) {
        put(&mut out, format_args!("<p class=\"note\">{}</p>\n", escape(caveat)));
    }
    out += &machine(heats);
    for heat in heats {
        out += &scene(heat);
    }
    out += METHOD;
    out += "</body>\n</html>\n";
    out
}

const METHOD: &str = "<h2>How it was measured</h2>\n<dl>\n\
<dt>Rounds</dt><dd>Every device is opened once for a scene and warmed up with one sample a pixel. Then, in every round, \
each renders the whole picture once; who begins changes from round to round, so that whatever drifts meets all \
alike. Times are medians, with the least and the greatest beside them.</dd>\n\
<dt>first pixel</dt><dd>From opening the device, with building hierarchies and compiling shaders, to the first pixels \
of the warm-up. Measured once. Drivers keep compiled shaders, so that a later run may begin sooner.</dd>\n\
<dt>rays/s</dt><dd>One ray is one wavelength between two surfaces or out to the environment, by the backend's own \
count and clock.</dd>\n\
<dt>× cpu</dt><dd>The CPU backend's time over this one's in the same round: above 1 is faster than the processor.</dd>\n\
<dt>dropped</dt><dd>The share of the energy that the threshold or the depth limit cut off.</dd>\n\
<dt>median diff, off, mean diff</dt><dd>Against the CPU backend's picture, over the pixels that show a stone: the median \
relative difference of colours (CIE XYZ), the share of pixels off by more than 0.001, and the difference of the mean \
colours. At the edges of facets two sound renderers may fall on different sides.</dd>\n</dl>\n";

fn all(heats: &[Heat]) -> impl Iterator<Item = &Measurement> {
    heats.iter().flat_map(|heat| &heat.measurements)
}

fn circumstances(rounds: usize) -> String {
    let times = if rounds == 1 { "once".to_owned() } else { format!("{rounds} times, in turn") };
    let (system, architecture) = (std::env::consts::OS, std::env::consts::ARCH);
    format!(
        "Every device rendered every scene {times}. gemtrace {} on {system}, {architecture}, {} threads.",
        env!("CARGO_PKG_VERSION"),
        threads()
    )
}

/// What took part.
fn machine(heats: &[Heat]) -> String {
    let mut seen: Vec<(&str, usize)> = Vec::new();
    let mut rows = String::new();
    for m in all(heats) {
        let (device, key) = (&m.entrant.device, (m.entrant.device.backend, m.entrant.device.index));
        if seen.contains(&key) {
            continue;
        }
        seen.push(key);
        let memory = device.memory as f64 / f64::from(1 << 30);
        let memory = if device.memory == 0 { "–".to_owned() } else { format!("{memory:.1} GiB") };
        let cells = [&m.entrant.label, &device.name, m.entrant.kind(), &device.driver, &memory];
        let cells: String = cells.iter().map(|c| format!("<td class=\"text\">{}</td>", escape(c))).collect();
        put(&mut rows, format_args!("<tr>{cells}</tr>\n"));
    }
    let head = head(&["device", "name", "kind", "driver", "memory"]);
    format!("<h2>Devices</h2>\n<div class=\"scroll\"><table>\n{head}{rows}</table></div>\n")
}

fn head(names: &[&str]) -> String {
    let cells: String = names.iter().map(|name| format!("<th>{}</th>", escape(name))).collect();
    format!("<tr>{cells}</tr>\n")
}

fn scene(heat: &Heat) -> String {
    let mut out = format!("<h2>{}</h2>\n<p>{}.", escape(&heat.subject.name), escape(&table::work(heat)));
    if let Some(fastest) = table::fastest(&heat.measurements) {
        put(&mut out, format_args!(" Fastest: {}.", escape(&label(heat, fastest))));
    }
    put(&mut out, format_args!("</p>\n<div class=\"scroll\"><table class=\"figures\">\n{}", head(&HEADINGS)));
    heat.measurements.iter().for_each(|m| out += &row(heat, m));
    out += "</table></div>\n<div class=\"plots\">\n";
    out += &plot("Rays a second", "million rays a second", &rates(heat));
    out += &plot("Time to first pixel", "milliseconds", &first_pixels(heat));
    out += "</div>\n";
    out += &pictures(heat);
    out
}

fn row(heat: &Heat, m: &Measurement) -> String {
    let cells = table::cells(heat, m);
    let failed = format!(" class=\"failed\" colspan=\"{}\"", HEADINGS.len() - 2);
    let cell = |(i, text): (usize, &String)| {
        let class = match i {
            0 | 1 => " class=\"text\"",
            _ if m.failure.is_some() => &failed,
            _ => "",
        };
        format!("<td{class}>{}</td>", escape(text))
    };
    let class = if m.entrant.is_software() { " class=\"software\"" } else { "" };
    format!("<tr{class}>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
}

fn plot(title: &str, axis: &str, rows: &[Strip]) -> String {
    let drawing = strips(axis, rows);
    if drawing.is_empty() {
        return String::new();
    }
    format!("<div><h3>{title}</h3>\n{drawing}</div>\n")
}

fn rates(heat: &Heat) -> Vec<Strip> {
    let strip = |m: &Measurement| {
        let middle = m.rate()?.median;
        let values = m.runs.iter().map(|r| r.rays_per_second / 1e6).collect();
        Some(Strip {
            label: label(heat, m),
            note: count(middle as u64),
            values,
            middle: middle / 1e6,
            muted: m.entrant.is_software(),
        })
    };
    heat.measurements.iter().filter_map(strip).collect()
}

fn first_pixels(heat: &Heat) -> Vec<Strip> {
    let strip = |m: &Measurement| {
        let time = m.first_pixel?;
        Some(Strip {
            label: label(heat, m),
            note: measured(time),
            values: Vec::new(),
            middle: 1e3 * time,
            muted: m.entrant.is_software(),
        })
    };
    heat.measurements.iter().filter_map(strip).collect()
}

/// Every picture, each with its difference from the CPU backend's beside it where that took part.
fn pictures(heat: &Heat) -> String {
    let yardstick = heat.measurements.iter().find(|m| m.entrant.is_yardstick());
    let expected = yardstick.and_then(|m| m.film.as_ref());
    let mut figures = String::new();
    for m in &heat.measurements {
        let Some(film) = &m.film else { continue };
        let mut caption = label(heat, m);
        let mut images = image(&caption, film, thumbnail::of(film));
        if let Some(expected) = expected.filter(|_| !m.entrant.is_yardstick()) {
            caption += &format!("; difference × {}", thumbnail::GAIN);
            images += &image(&caption, film, thumbnail::of_difference(expected, film));
        }
        let caption = escape(&caption);
        put(
            &mut figures,
            format_args!("<figure><div>{images}</div>\n<figcaption>{caption}</figcaption></figure>\n"),
        );
    }
    if figures.is_empty() {
        return figures;
    }
    format!("<h3>Pictures</h3>\n<div class=\"pictures\">\n{figures}</div>\n")
}

fn image(alternative: &str, film: &Film, address: Option<String>) -> String {
    let Some(address) = address else { return String::new() };
    let (width, height, alternative) = (film.width(), film.height(), escape(alternative));
    format!("<img src=\"{address}\" width=\"{width}\" height=\"{height}\" alt=\"{alternative}\"/>")
}

fn put(out: &mut String, arguments: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    out.write_fmt(arguments).ok();
}
