//! `gemtrace batch`.

use super::figure::seconds;
use super::render::parse_size;
use super::{Console, Report, table};
use crate::Error;
use crate::batch::{Place, Plan, Portion, Shard, Summary, merge, run as carry_out, sheet, sweep};
use crate::effort::Effort;
use crate::registry::{self, Candidates};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `batch`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The sweep file (TOML).
    pub sweep: PathBuf,
    /// Folder for the pictures, the manifest and the contact sheet [default: the sweep's name, in the current folder].
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Render the i-th of n shares only; auto: the one that Slurm or Kubernetes says, else everything.
    #[arg(long, value_name = "I/N", default_value = "auto")]
    pub shard: Portion,
    /// What renders: auto, or a name that `gemtrace devices` lists.
    #[arg(long, value_name = "NAME", default_value = registry::AUTO)]
    pub backend: String,
    /// Which of the backend's devices, counted from 0.
    #[arg(long, value_name = "N")]
    pub device: Option<usize>,
    /// How much work each is worth.
    #[command(flatten)]
    pub effort: Effort,
    /// Picture size in pixels, in place of the scenes'.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Worker threads [default: one a core]; the pictures are the same for any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Show what would be rendered, and render nothing.
    #[arg(long)]
    pub list: bool,
    /// Print the scene of this item, as a scene file, and render nothing.
    #[arg(long, value_name = "ITEM", conflicts_with = "list")]
    pub show: Option<String>,
}

/// Renders what is missing of a sweep, or lists it.
///
/// # Errors
/// [`Error`] of the sweep file, the backend's name or the output folder, before the first ray. Items that fail are told
/// in the report's `failure`.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    let plan = sweep::load(&args.sweep)?.with_film(args.size, &args.effort)?;
    if args.list {
        return Ok(list(&plan));
    }
    if let Some(name) = &args.show {
        return show(&plan, name);
    }
    let shard = args.shard.resolve()?;
    let candidates = registry::choose(&args.backend, args.device)?;
    let output = args.output.clone().unwrap_or_else(|| args.sweep.file_stem().unwrap_or_default().into());
    let place = Place { output, shard, threads: args.threads.map(|n| n as usize) };
    render(&plan, &place, candidates, console)
}

/// Carries out a plan and reports on it; all of it, not a shard, has its contact sheet written, too.
///
/// # Errors
/// As [`carry_out`].
pub fn render(
    plan: &Plan,
    place: &Place,
    candidates: Candidates,
    console: &mut Console,
) -> Result<Report, Error> {
    let summary = carry_out(plan, place, candidates, console)?;
    let mut failure = summary.failure();
    let mut sheet = None;
    if place.shard.is_whole() && !summary.interrupted {
        match write_sheet(&place.output) {
            Ok(path) => sheet = Some(path),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    let text = line(&summary, place, sheet.as_deref());
    Ok(Report { text, json: describe(&summary, place, sheet.as_deref()), failure })
}

fn write_sheet(folder: &Path) -> Result<PathBuf, Error> {
    let expected = merge::expected(folder)?;
    sheet::write(folder, &expected.title, &merge::entries(folder, &expected, false)?)
}

/// The closing line.
fn line(summary: &Summary, place: &Place, sheet: Option<&Path>) -> String {
    let mut text = match place.shard {
        Shard::WHOLE => String::new(),
        shard => format!("shard {shard}: "),
    };
    text += &format!("rendered {} of {} pictures", summary.rendered, summary.items);
    if summary.kept > 0 {
        text += &format!(", {} were there", summary.kept);
    }
    if !summary.failed.is_empty() {
        text += &format!(", {} failed", summary.failed.len());
    }
    let place = sheet.unwrap_or(&place.output).display();
    text + &format!(", in {} – {place}", seconds(summary.elapsed))
}

fn describe(summary: &Summary, place: &Place, sheet: Option<&Path>) -> Value {
    let failed = summary.failed.iter();
    let failed: Vec<Value> = failed
        .map(|(item, error)| json!({ "item": item, "message": error.to_string(), "exit_code": error.exit_code() }))
        .collect();
    json!({
        "output": place.output.display().to_string(),
        "shard": place.shard.to_string(),
        "items": summary.items,
        "kept": summary.kept,
        "rendered": summary.rendered,
        "failed": failed,
        "interrupted": summary.interrupted,
        "sheet": sheet.map(|path| path.display().to_string()),
        "seconds": summary.elapsed.as_secs_f64(),
    })
}

fn list(plan: &Plan) -> Report {
    let mut rows = vec![["number", "item"].map(str::to_owned).to_vec()];
    rows.extend(
        plan.items().iter().enumerate().map(|(i, item)| vec![(i + 1).to_string(), item.name.clone()]),
    );
    let items: Vec<Value> =
        plan.items().iter().map(|item| json!({ "item": item.name, "values": item.values })).collect();
    Report::new(table::columns(2, &rows), json!({ "title": plan.title(), "items": items }))
}

fn show(plan: &Plan, name: &str) -> Result<Report, Error> {
    let names = || plan.items().iter().map(|item| item.name.as_str());
    let item = plan.items().iter().find(|item| item.name == name);
    let item =
        item.ok_or_else(|| Error::Usage(spectral_core::Error::unknown("item", name, names()).to_string()))?;
    let text = plan.scene_text(item)?;
    Ok(Report::new(text.trim_end(), json!({ "item": item.name, "scene": text })))
}
