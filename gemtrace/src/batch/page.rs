//! All pictures of a batch on one page, with their numbers: one HTML file that loads nothing, sorted as one likes.

mod thumbnail;

use super::entry::Entry;
use super::manifest::Done;

use crate::plot::escape;
use crate::quantity::{count, measured, percent};
use crate::{Error, output};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The page's name in the output folder.
pub const FILE: &str = "index.html";

/// Writes the page into the output folder.
///
/// # Errors
/// [`Error::Output`] if it cannot be written.
pub fn write(folder: &Path, title: &str, entries: &[Entry]) -> Result<PathBuf, Error> {
    let path = folder.join(FILE);
    output::write_text(&path, &html(folder, title, entries))?;
    Ok(path)
}

const STYLE: &str = include_str!("page/style.css");
const SCRIPT: &str = include_str!("page/script.js");

/// The whole page; pictures are read from `folder`.
pub fn html(folder: &Path, title: &str, entries: &[Entry]) -> String {
    let title = escape(title);
    // The one script that may run is the one that stands here.
    let script = STANDARD.encode(Sha256::digest(SCRIPT));
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
         style-src 'unsafe-inline'; script-src 'sha256-{script}'\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
    );
    put(&mut out, format_args!("<p>{}</p>\n", escape(&overview(entries))));
    out += &toolbar(entries);
    out += "<ol class=\"sheet\">\n";
    for (number, entry) in entries.iter().enumerate() {
        out += &card(folder, number, entry);
    }
    put(&mut out, format_args!("</ol>\n<script>{SCRIPT}</script>\n</body>\n</html>\n"));
    out
}

fn overview(entries: &[Entry]) -> String {
    let done: Vec<&Done> = entries.iter().filter_map(|entry| entry.outcome.as_deref().ok()).collect();
    let rays = done.iter().fold(0, |sum: u64, done| sum.saturating_add(done.rays));
    let mut devices: Vec<String> = done.iter().map(|done| device(done)).collect();
    devices.sort();
    devices.dedup();
    let mut text = format!("{} pictures", done.len());
    if done.len() < entries.len() {
        text += &format!(" of {}", entries.len());
    }
    text += &format!(", {} rays", count(rays));
    if !devices.is_empty() {
        text += &format!(", by gemtrace {} on {}", env!("CARGO_PKG_VERSION"), devices.join(", "));
    }
    text + "."
}

fn device(done: &Done) -> String {
    let names = done.devices.as_array().into_iter().flatten();
    let names = names.filter_map(|device| device.get("name").and_then(Value::as_str));
    names.collect::<Vec<_>>().join(" + ")
}

/// Numbers of a picture: what it is called, its key for sorting, its value, and the value as text.
fn figures(done: &Done) -> Vec<(&'static str, &'static str, f64, String)> {
    let share = |key: &str| done.energy.get(key).and_then(Value::as_f64).unwrap_or(0.0);
    let setting = |key: &str| done.settings.get(key).and_then(Value::as_u64).unwrap_or(0);
    let [width, height] = ["width", "height"].map(|key| setting(key) as f64);
    let wavelengths = done.settings.get("wavelengths").and_then(Value::as_array).map_or(0, Vec::len);
    let work = format!("{} × {wavelengths} wavelengths", setting("samples"));
    let bytes = done.outputs.iter().map(|file| file.bytes as f64).sum::<f64>();
    vec![
        ("pixels", "pixels", width * height, format!("{width} × {height}")),
        ("samples", "samples", setting("samples") as f64, work),
        ("rays", "rays", done.rays as f64, count(done.rays)),
        ("time", "time", done.seconds.total, measured(done.seconds.total)),
        ("dropped", "dropped", share("dropped"), percent(share("dropped"))),
        ("out at limit", "limit", share("left_at_limit"), percent(share("left_at_limit"))),
        ("file size", "bytes", bytes, format!("{:.1} kB", bytes / 1e3)),
    ]
}

/// What sets the pictures apart, in order of appearance.
fn axes(entries: &[Entry]) -> Vec<&str> {
    let mut seen = HashSet::new();
    let keys = entries.iter().flat_map(|entry| entry.item.values.keys());
    keys.map(String::as_str).filter(|key| seen.insert(*key)).collect()
}

/// One button for every key to sort by.
fn toolbar(entries: &[Entry]) -> String {
    let mut keys = vec![("order", "order".to_owned()), ("name", "name".to_owned())];
    let axes: Vec<(String, String)> =
        axes(entries).iter().map(|axis| (format!("v-{axis}"), (*axis).to_owned())).collect();
    keys.extend(axes.iter().map(|(key, label)| (key.as_str(), label.clone())));
    let done = entries.iter().find_map(|entry| entry.outcome.as_deref().ok());
    let numbers = done.map(figures).unwrap_or_default();
    keys.extend(numbers.iter().map(|(label, key, ..)| (*key, (*label).to_owned())));
    let mut out = "<div class=\"toolbar\"><span>Sort by</span>\n".to_owned();
    for (key, label) in keys {
        let pressed = if key == "order" { "ascending" } else { "none" };
        put(
            &mut out,
            format_args!(
                "<button type=\"button\" data-key=\"{}\" data-sort=\"{pressed}\">{}</button>\n",
                escape(key),
                escape(&label)
            ),
        );
    }
    out + "</div>\n"
}

fn card(folder: &Path, number: usize, entry: &Entry) -> String {
    let name = &entry.item.item;
    let mut sort = vec![("order".to_owned(), number.to_string()), ("name".to_owned(), name.clone())];
    let mut rows: Vec<(&str, String)> = Vec::new();
    for (axis, value) in &entry.item.values {
        let text = match (value.as_str(), value.as_f64()) {
            (Some(text), _) => text.to_owned(),
            // Two, not 2.0.
            (None, Some(number)) => number.to_string(),
            (None, None) => value.to_string(),
        };
        sort.push((format!("v-{axis}"), text.clone()));
        rows.push((axis, text));
    }
    let picture = match &entry.outcome {
        Ok(done) => {
            for (label, key, value, text) in figures(done) {
                sort.push((key.to_owned(), value.to_string()));
                rows.push((label, text));
            }
            thumbnail::of(folder, done).map_or_else(
                |message| format!("<p class=\"failed\">{}</p>", escape(&message)),
                |address| format!("<img src=\"{address}\" alt=\"{}\"/>", escape(name)),
            )
        }
        Err(message) => format!("<p class=\"failed\">{}</p>", escape(message)),
    };
    let attributes: String =
        sort.iter().map(|(key, value)| format!(" data-{}=\"{}\"", escape(key), escape(value))).collect();
    let rows: String = rows
        .iter()
        .map(|(label, text)| format!("<dt>{}</dt><dd>{}</dd>", escape(label), escape(text)))
        .collect();
    format!(
        "<li{attributes}><div class=\"picture\">{picture}</div>\n<div><h2>{}</h2><dl>{rows}</dl></div></li>\n",
        escape(name)
    )
}

fn put(out: &mut String, arguments: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    out.write_fmt(arguments).ok();
}
