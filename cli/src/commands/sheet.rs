//! `gemtrace sheet`: one scene in several sizes, as one picture.

use crate::arguments::{Rendering, parse_stops};
use crate::console::{Console, Report};
use crate::progress::Onlooker;
use clap::Subcommand;
use gemtrace::quantity::seconds;
use gemtrace::scene_file::Draft;
use gemtrace::sheet::{Cell, Sheet};
use gemtrace::{Error, output, registry};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `sheet`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// What differs from picture to picture.
    #[command(subcommand)]
    pub kind: Kind,
}

/// The kinds of sheets.
#[derive(Debug, Clone, Subcommand)]
pub enum Kind {
    /// One scene with stones of several sizes: the camera keeps step, so that only the colour changes.
    Sizes(SizesArgs),
}

/// Arguments of `sheet sizes`.
#[derive(Debug, Clone, clap::Args)]
pub struct SizesArgs {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Widths of the scene's first stone in mm; everything else keeps its proportion to it.
    #[arg(long, value_name = "MM,MM,…", value_delimiter = ',', default_value = "2,4,8,12", value_parser = parse_width)]
    pub sizes: Vec<f64>,
    /// Write the sheet here, as PNG [default: the scene's name with -sizes.png, in the current folder].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub rendering: Rendering,
    /// Brighten what is shown by this many stops, the same for all pictures.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_stops)]
    pub exposure: f64,
}

/// Pictures side by side before a new row begins.
const COLUMNS: usize = 4;

/// Renders a sheet.
///
/// # Errors
/// [`Error`] of the scene, the output or the device; [`Error::Interrupted`] if it was broken off.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    let Kind::Sizes(args) = &args.kind;
    let start = Instant::now();
    let mut session = args.rendering.session()?;
    session.output.exposure = args.exposure;
    let first = session.load(&args.scene)?;
    first.warnings.iter().for_each(|warning| console.warn(warning));
    if first.scene.stones.is_empty() {
        return Err(Error::file(&args.scene, "a sheet of sizes needs a stone; this scene has none"));
    }
    let draft = Draft::read(&args.scene)?;
    let path = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}-sizes.png", draft.stem())));
    let inputs = first.files.iter().map(|file| file.path.as_path()).chain([args.scene.as_path()]);
    output::prepare(&[&path], inputs)?;
    drop(first);
    let announce = args.rendering.backend == registry::AUTO;
    let mut onlooker = Onlooker::new(console, args.sizes.len(), announce);
    let mut cells = Vec::new();
    for &size in &args.sizes {
        let mut loaded = draft.with("pose", "size", size).load(&mut session.assets)?;
        args.rendering.overrides().apply(&mut loaded);
        let picture = session.render_watched(loaded, &mut onlooker)?;
        cells.push(Cell::new(&picture, format!("{size} mm")));
        onlooker.next();
    }
    drop(onlooker);
    let sheet = Sheet::new(&cells, COLUMNS);
    let bytes = output::write_rgb(&path, sheet.width, &sheet.pixels)?;
    let text = format!("wrote {} – {} sizes in {}", path.display(), cells.len(), seconds(start.elapsed()));
    Ok(Report::new(
        text,
        json!({ "output": path.display().to_string(), "bytes": bytes, "sizes": args.sizes }),
    ))
}

fn parse_width(text: &str) -> Result<f64, String> {
    let width = text.trim().parse::<f64>().ok().filter(|width| *width > 0.0 && *width <= 1e6);
    width.ok_or_else(|| "give widths in mm, above 0 and at most 1e6, such as 2,4,8,12".to_owned())
}
