//! `gemtrace sheet sizes`: one scene in several sizes.

use super::{COLUMNS, Common};
use crate::console::{Console, Report};
use crate::progress::Onlooker;
use gemtrace::quantity::seconds;
use gemtrace::sheet::{Cell, Sheet};
use gemtrace::{Error, output, registry};
use serde_json::json;
use std::time::Instant;

/// Arguments of `sheet sizes`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub common: Common,
    /// Widths of the scene's first stone in mm; everything else keeps its proportion to it.
    #[arg(long, value_name = "MM,MM,…", value_delimiter = ',', default_value = "2,4,8,12", value_parser = parse_width)]
    pub sizes: Vec<f64>,
}

/// Renders the sheet.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    let start = Instant::now();
    let common = &args.common;
    let (mut session, draft, _, path) = common.begin("sizes", console)?;
    let mut onlooker = Onlooker::new(console, args.sizes.len(), common.rendering.backend == registry::AUTO);
    let mut cells = Vec::new();
    for &size in &args.sizes {
        let mut loaded = draft.with("pose", "size", size).load(&mut session.assets)?;
        common.rendering.overrides().apply(&mut loaded);
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
