//! `gemtrace merge`.

use super::{Console, Report};
use crate::Error;
use crate::batch::merge;
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `merge`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The output folder of a batch.
    pub folder: PathBuf,
}

/// Checks that all of a batch is there and whole, and joins its manifests.
///
/// # Errors
/// As [`merge::merge`].
pub fn run(args: &Args, _: &mut Console) -> Result<Report, Error> {
    let merged = merge::merge(&args.folder)?;
    let text = format!(
        "{} pictures, all there and whole – {}, {}",
        merged.items,
        merged.manifest.display(),
        merged.sheet.display()
    );
    let manifests: Vec<String> = merged.manifests.iter().map(|path| path.display().to_string()).collect();
    let json = json!({
        "items": merged.items,
        "manifests": manifests,
        "manifest": merged.manifest.display().to_string(),
        "sheet": merged.sheet.display().to_string(),
    });
    Ok(Report::new(text, json))
}
