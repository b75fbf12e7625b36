//! `gemtrace batch`.

use super::table;
use crate::arguments::Rendering;
use crate::console::{Console, Report};
use crate::progress::Board;
use gemtrace::batch::{Observer, Place, Plan, Summary, manifest::Done, merge, page, run as carry_out, sweep};
use gemtrace::quantity::{percent, seconds};
use gemtrace::registry::Choice;
use gemtrace::shard::Shard;
use gemtrace::{Error, Session, Watch};
use serde_json::{Value, json};
use spectral_core::tracer::Progress;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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
    pub shard: String,
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub rendering: Rendering,
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
/// [`Error`] of the sweep file, the backend's name or the output folder, before the first ray. Items that fail are
/// in the report's `failure`.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    let plan = sweep::load(&args.sweep)?.with(args.rendering.overrides());
    if args.list {
        return Ok(list(&plan));
    }
    if let Some(name) = &args.show {
        return show(&plan, name);
    }
    let shard = Shard::by_name(&args.shard)?;
    let mut session = args.rendering.session()?;
    let output = args.output.clone().unwrap_or_else(|| args.sweep.file_stem().unwrap_or_default().into());
    render(&plan, &Place { output, shard }, &mut session, console)
}

/// Carries out a plan and reports on it; all of it, not a shard, has its contact sheet written, too.
///
/// # Errors
/// As [`carry_out`].
pub fn render(
    plan: &Plan,
    place: &Place,
    session: &mut Session,
    console: &mut Console,
) -> Result<Report, Error> {
    let summary = {
        console.interrupt.heed();
        let onlooker = &mut Follower { console, board: None, announced: false, told: Instant::now() };
        carry_out(plan, place, session, onlooker)?
    };
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

/// Someone at a console, who sees bars, a line for each picture, and warnings, and may press Ctrl-C.
struct Follower<'a, 'b> {
    console: &'a mut Console<'b>,
    board: Option<Board>,
    /// Whether it was said which device renders.
    announced: bool,
    /// When the progress of the current picture was last reported.
    told: Instant,
}

/// How often the progress of a picture is reported where no bar shows it.
const PATIENCE: Duration = Duration::from_secs(30);

impl Follower<'_, '_> {
    /// Writes a line without tearing the bars.
    fn say(&mut self, message: impl std::fmt::Display) {
        self.tell(|console| console.say(message));
    }

    fn tell(&mut self, write: impl FnOnce(&mut Console)) {
        let console = &mut *self.console;
        match &self.board {
            Some(board) => board.aside(|| write(console)),
            None => write(console),
        }
    }
}

impl Watch for Follower<'_, '_> {
    fn chosen(&mut self, choice: &Choice) {
        if !std::mem::replace(&mut self.announced, true) {
            self.say(&choice.reason);
        }
    }

    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        if let Some(board) = &self.board {
            board.set(progress.done, progress.total);
            if !board.is_visible() && self.told.elapsed() > PATIENCE {
                self.told = Instant::now();
                let share = 100.0 * progress.done as f64 / progress.total.max(1) as f64;
                let place = board.current();
                self.say(format_args!("{place} {share:.0} %"));
            }
        }
        self.console.interrupt.flow()
    }

    fn warning(&mut self, message: &str) {
        self.tell(|console| console.warn(message));
    }
}

impl Observer for Follower<'_, '_> {
    fn planned(&mut self, items: usize, kept: usize) {
        if kept > 0 {
            self.say(format_args!("{kept} of {items} pictures are there already"));
        }
        self.board = Some(Board::new(items as u64, kept as u64, self.console.quiet));
    }

    fn begin(&mut self, item: &str) -> ControlFlow<()> {
        self.board.iter().for_each(|board| board.begin(item));
        self.told = Instant::now();
        self.console.interrupt.flow()
    }

    fn end(&mut self, item: &str, outcome: Result<&Done, &Error>) {
        let told = match outcome {
            Ok(done) => {
                let dropped = done.energy.get("dropped").and_then(Value::as_f64).unwrap_or(0.0);
                let time = seconds(Duration::from_secs_f64(done.seconds.total));
                format!("{time}, {} of the energy dropped", percent(dropped))
            }
            Err(error) => format!("failed: {error}"),
        };
        let place = self.board.as_ref().map_or(String::new(), Board::end);
        self.say(format_args!("{place} {item}: {told}"));
    }
}

fn write_sheet(folder: &Path) -> Result<PathBuf, Error> {
    let expected = merge::expected(folder)?;
    page::write(folder, &expected.title, &merge::entries(folder, &expected, false)?)
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
