//! Measurements as text and as JSON.

use super::Heat;
use super::measurement::{Measurement, Run, Spread};
use crate::commands::table;
use gemtrace::output;
use gemtrace::quantity::{count, measured, percent, significant};
use serde_json::{Value, json};
use spectral_core::film::Agreement;

const SOFTWARE: &str =
    "software: this driver computes on the processor; its speed says nothing about any GPU.";
const UNOPTIMISED: &str = "gemtrace was built without optimisation (--release): the processor's figures say nothing about its speed.";

/// Below this a picture's time is the start and the end of work more than the work, s.
const SHORT: f64 = 0.02;
const TOO_SHORT: &str = "some pictures took less than 20 ms, too little work for a device to show its speed: ask for more \
     with --size and --samples.";

/// The columns of a scene's table, by what they show; the first two are names.
pub const HEADINGS: [&str; 11] = [
    "device",
    "surfaces by",
    "first pixel",
    "picture",
    "min–max",
    "rays/s",
    "× cpu",
    "dropped",
    "median diff",
    "off",
    "mean diff",
];

/// A measurement under [`HEADINGS`]; one that failed has its reason in the third place.
pub fn cells(heat: &Heat, m: &Measurement) -> Vec<String> {
    let mut cells = vec![name(m), m.entrant.intersection(&heat.subject.prepared).to_owned()];
    if let Some(failure) = &m.failure {
        cells.push(format!("failed: {failure}"));
        return cells;
    }
    let dash = || "–".to_owned();
    let or = |text: Option<String>| text.unwrap_or_else(dash);
    cells.push(or(m.first_pixel.map(measured)));
    cells.push(or(m.seconds().map(|s| measured(s.median))));
    cells.push(or(m.seconds().map(|s| format!("{}–{}", measured(s.min), measured(s.max)))));
    cells.push(or(m.rate().map(|s| count(s.median as u64))));
    cells.push(or(m.speed().map(|s| significant(s.median))));
    cells.push(or((!m.runs.is_empty()).then(|| percent(m.energy.dropped_share()))));
    let agreement = m.agreement.as_ref();
    cells.push(or(agreement.map(|a| difference(a.median))));
    cells.push(or(agreement.map(|a| percent(a.off))));
    cells.push(or(agreement.map(|a| difference(a.mean))));
    cells
}

/// A relative difference.
pub fn difference(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") }
}

/// The entrant's name, marked where it only stands for a GPU.
pub fn name(m: &Measurement) -> String {
    let mark = if m.entrant.is_software() { " (software)" } else { "" };
    format!("{}{mark}", m.entrant.label)
}

/// What a scene asks of a device, on one line.
pub fn work(heat: &Heat) -> String {
    let scene = &heat.subject.prepared;
    let (samples, lines) = (scene.settings.samples, scene.wavelength_count());
    let s = if samples == 1 { "" } else { "s" };
    format!("{} × {} pixels, {samples} sample{s} each, {lines} wavelengths", scene.width, scene.height)
}

/// An entrant with how its rays find the surfaces of a scene.
pub fn label(heat: &Heat, m: &Measurement) -> String {
    format!("{}, {}", name(m), m.entrant.intersection(&heat.subject.prepared))
}

/// What a reader of the figures must know first.
pub fn caveats(heats: &[Heat]) -> Vec<&'static str> {
    let all = || heats.iter().flat_map(|heat| &heat.measurements);
    let software = all().any(|m| m.entrant.is_software());
    let short = all().filter_map(Measurement::seconds).any(|s| s.median < SHORT);
    let caveats = [(software, SOFTWARE), (cfg!(debug_assertions), UNOPTIMISED), (short, TOO_SHORT)];
    caveats.into_iter().filter(|(applies, _)| *applies).map(|(_, text)| text).collect()
}

/// The one with the shortest median; `None` where nothing was measured.
pub fn fastest(measurements: &[Measurement]) -> Option<&Measurement> {
    let timed = measurements.iter().filter(|m| m.failure.is_none());
    let timed = timed.filter_map(|m| Some((m.seconds()?.median, m)));
    timed.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, m)| m)
}

/// All tables one below the other.
pub fn text(heats: &[Heat], rounds: usize) -> String {
    let mut parts: Vec<String> = heats.iter().map(scene_text).collect();
    let runs = if rounds == 1 { "1 run".to_owned() } else { format!("{rounds} runs in turn") };
    parts.push(format!(
        "medians of {runs}; first pixel: from opening the device, once; × cpu: the cpu's time over this one's in the \
         same round; diff: against the cpu's picture; off: by more than {:.0e}",
        Agreement::TOLERANCE
    ));
    parts.extend(caveats(heats).into_iter().map(str::to_owned));
    parts.join("\n\n")
}

fn scene_text(heat: &Heat) -> String {
    let mut rows = vec![HEADINGS.map(str::to_owned).to_vec()];
    let (failed, whole): (Vec<_>, Vec<_>) = heat.measurements.iter().partition(|m| m.failure.is_some());
    rows.extend(whole.iter().map(|m| cells(heat, m)));
    let mut lines = vec![format!("{}: {}", heat.subject.name, work(heat)), table::columns(2, &rows)];
    // A reason is longer than any figure, and would push the columns apart.
    lines.extend(failed.iter().map(|m| cells(heat, m).join("  ")));
    lines.extend(fastest(&heat.measurements).map(|m| format!("fastest: {}", label(heat, m))));
    lines.join("\n")
}

/// A scene for scripts.
pub fn json(heat: &Heat) -> Value {
    let fastest = fastest(&heat.measurements);
    let position = fastest.and_then(|m| heat.measurements.iter().position(|other| std::ptr::eq(other, m)));
    json!({
        "name": heat.subject.name,
        "hash": heat.subject.hash,
        "settings": output::settings(&heat.subject.prepared),
        "fastest": position,
        "devices": heat.measurements.iter().map(|m| measurement_json(heat, m)).collect::<Vec<_>>(),
    })
}

fn measurement_json(heat: &Heat, m: &Measurement) -> Value {
    let mut device = output::device(&m.entrant.device);
    device["intersection"] = m.entrant.intersection(&heat.subject.prepared).into();
    let measured = !m.runs.is_empty();
    json!({
        "label": m.entrant.label,
        "device": device,
        "software": m.entrant.is_software(),
        "error": m.failure,
        "open_seconds": m.open,
        "build_seconds": m.first_pixel.map(|_| m.build),
        "first_pixel_seconds": m.first_pixel,
        "seconds": m.seconds().map(spread_json),
        "rays_per_second": m.rate().map(spread_json),
        "speed_against_cpu": m.speed().map(spread_json),
        "runs": m.runs.iter().map(run_json).collect::<Vec<_>>(),
        "rays": measured.then_some(m.rays),
        "energy": measured.then(|| output::energy(&m.energy)),
        "repeats": measured.then_some(m.repeats),
        "agreement": m.agreement.map(|a| json!({
            "pixels": a.pixels, "median": a.median, "off": a.off, "mean": a.mean, "worst": a.worst,
        })),
    })
}

fn spread_json(spread: Spread) -> Value {
    json!({ "median": spread.median, "min": spread.min, "max": spread.max })
}

fn run_json(run: &Run) -> Value {
    json!({ "seconds": run.seconds, "rays_per_second": run.rays_per_second })
}
