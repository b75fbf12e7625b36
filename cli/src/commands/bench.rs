//! `gemtrace bench`: the same scenes on every device.
//!
//! * `scene`: what is rendered.
//! * `entrant`: what renders it.
//! * `measurement`: the rounds, and what they found.
//! * `table`, `page`: the report as text, JSON and HTML.

mod entrant;
mod measurement;
mod page;
mod scene;
mod table;

use crate::arguments::parse_size;
use crate::console::{Console, Report};
use entrant::{Entrant, entrants};
use gemtrace::scene_file::Override;
use gemtrace::{Error, output};
use measurement::{Measurement, measure};
use scene::{BUILTIN, Subject};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `bench`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Scene files, or names of the program's own scenes [default: all of those; --list shows them].
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<String>,
    /// Measure the devices of this backend only; may be given more than once [default: all but the reference].
    #[arg(long, value_name = "NAME")]
    pub backend: Vec<String>,
    /// How many times every device renders every scene, in turn.
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub runs: u32,
    /// Picture size in pixels, in place of the scenes'; a GPU shows its speed on large pictures only.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Samples a pixel, in place of the scenes'.
    #[arg(long, value_name = "N")]
    pub samples: Option<u32>,
    /// Write a page with plots and all pictures here, one HTML file that needs no other.
    #[arg(short, long, value_name = "FILE.html")]
    pub output: Option<PathBuf>,
    /// Show what would be measured, and measure nothing.
    #[arg(long)]
    pub list: bool,
}

/// A scene that has been measured.
struct Heat {
    subject: Subject,
    measurements: Vec<Measurement>,
}

/// Measures every scene on every device, or lists them.
///
/// A device that fails does not affect the figures of the others; its reason is in the report and in the report's
/// `failure`. After a request to stop the report holds what is complete.
///
/// # Errors
/// [`Error`] of the scenes, the backends' names or the place for the page, all before the first ray;
/// [`Error::Interrupted`] if nothing was measured.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    let entrants = entrants(&args.backend)?;
    if args.list {
        return Ok(list(&entrants));
    }
    if let Some(path) = &args.output {
        check_page(path, &args.scenes)?;
    }
    let heats = race(args, &entrants, console)?;
    let interrupted = console.interrupt.is_requested();
    if interrupted && heats.iter().flat_map(|h| &h.measurements).all(|m| m.runs.is_empty()) {
        return Err(Error::Interrupted);
    }
    let rounds = args.runs as usize;
    let mut text = table::text(&heats, rounds);
    let mut json = summary(&heats, rounds, interrupted);
    let mut failure = failure(&heats).or(interrupted.then_some(Error::Interrupted));
    if let Some(path) = &args.output {
        match output::write_text(path, &page::html(&heats, rounds, interrupted)) {
            Ok(bytes) => {
                text += &format!("\nwrote {}", path.display());
                json["page"] = json!({ "path": path.display().to_string(), "bytes": bytes });
            }
            // What was measured is reported all the same.
            Err(error) => failure = Some(error),
        }
    }
    Ok(Report { text, json, failure })
}

/// All scenes are read before the first is measured, so that no mistake is found late.
fn race(args: &Args, entrants: &[Entrant], console: &mut Console) -> Result<Vec<Heat>, Error> {
    let names = match args.scenes.as_slice() {
        [] => BUILTIN.iter().map(|b| b.name.to_owned()).collect(),
        names => names.to_vec(),
    };
    let change = Override { size: args.size, samples: args.samples, ..Override::default() };
    let subjects: Vec<Subject> =
        names.iter().map(|name| Subject::new(name, change, console)).collect::<Result<_, _>>()?;
    let mut heats = Vec::new();
    for subject in subjects {
        let rounds = args.runs as usize;
        let measurements = measure(&subject.prepared, entrants, rounds, console.interrupt, console.quiet);
        heats.push(Heat { subject, measurements });
        if console.interrupt.is_requested() {
            break;
        }
    }
    Ok(heats)
}

fn check_page(path: &Path, scenes: &[String]) -> Result<(), Error> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    if !matches!(extension.as_deref(), Some("html" | "htm")) {
        return Err(Error::output(path, "the page is HTML; end the name in '.html'"));
    }
    output::prepare(&[path], scenes.iter().map(Path::new))
}

/// The devices that failed, as one error.
fn failure(heats: &[Heat]) -> Option<Error> {
    let failed = heats.iter().flat_map(|heat| {
        let failed = heat.measurements.iter().filter(|m| m.failure.is_some());
        failed.map(|m| format!("{} on {}", table::name(m), heat.subject.name))
    });
    let failed: Vec<String> = failed.collect();
    let message = || format!("failed: {}; the report says why", failed.join(", "));
    (!failed.is_empty()).then(|| Error::Render { device: "bench".to_owned(), message: message() })
}

fn summary(heats: &[Heat], rounds: usize, interrupted: bool) -> Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "machine": machine(),
        "optimised": !cfg!(debug_assertions),
        "runs": rounds,
        "interrupted": interrupted,
        "scenes": heats.iter().map(table::json).collect::<Vec<_>>(),
    })
}

fn machine() -> Value {
    json!({ "system": std::env::consts::OS, "architecture": std::env::consts::ARCH, "threads": threads() })
}

/// Threads that the processor's backends use.
fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn list(entrants: &[Entrant]) -> Report {
    let scenes = BUILTIN.iter().map(|b| vec![b.name.to_owned(), b.about.to_owned()]);
    let mut scene_rows = vec![["scene", "what it shows"].map(str::to_owned).to_vec()];
    scene_rows.extend(scenes);
    let mut rows = vec![["device", "name", "kind", "surfaces by"].map(str::to_owned).to_vec()];
    rows.extend(entrants.iter().map(|e| {
        let by = if e.held { e.device.intersection } else { "as suits the scene" };
        [&e.label, &e.device.name, e.kind(), by].map(str::to_owned).to_vec()
    }));
    let text = [scene_rows, rows].map(|rows| super::table::columns(4, &rows)).join("\n\n");
    let json = json!({
        "scenes": BUILTIN.iter().map(|b| json!({ "name": b.name, "about": b.about })).collect::<Vec<_>>(),
        "devices": entrants.iter().map(|e| json!({
            "label": e.label,
            "device": output::device(&e.device),
            "software": e.is_software(),
            "held": e.held,
        })).collect::<Vec<_>>(),
    });
    Report::new(text, json)
}
