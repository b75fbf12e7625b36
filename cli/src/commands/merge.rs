//! `gemtrace merge`.

use crate::console::{Console, Report};
use gemtrace::batch::{Plan, merge};
use gemtrace::{Error, part};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `merge`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Output folders of batches, folders with parts of pictures, or parts, such as hall.part-1-of-8.exr; a part stands
    /// for all of its picture.
    #[arg(required = true, value_name = "FOLDER|PART")]
    pub paths: Vec<PathBuf>,
}

/// Checks that all shards are there and whole, and joins them: the manifests of a batch, and parts into pictures.
///
/// # Errors
/// As [`merge::merge`] and [`part::merge`].
pub fn run(args: &Args, _: &mut Console) -> Result<Report, Error> {
    let mut seen = Vec::new();
    let (mut texts, mut batches, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
    for path in &args.paths {
        if path.is_dir() {
            let parts = part::pictures(path)?;
            if path.join(Plan::FILE).exists() || parts.is_empty() {
                let (text, json) = batch(path)?;
                texts.push(text);
                batches.push(json);
            }
            seen.extend(parts.into_iter().map(|(stem, count)| (path.clone(), stem, count)));
        } else {
            seen.push(part::picture_of(path)?);
        }
    }
    seen.sort();
    seen.dedup();
    for (folder, stem, count) in &seen {
        let files = part::merge(folder, stem, *count)?;
        let files: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
        texts.push(format!("joined {count} parts: {}", files.join(", ")));
        pictures.push(json!({ "picture": stem, "parts": count, "outputs": files }));
    }
    Ok(Report::new(texts.join("\n"), json!({ "batches": batches, "pictures": pictures })))
}

fn batch(folder: &Path) -> Result<(String, Value), Error> {
    let merged = merge::merge(folder)?;
    let text = format!(
        "{} pictures, all there and whole – {}, {}",
        merged.items,
        merged.manifest.display(),
        merged.page.display()
    );
    let manifests: Vec<String> = merged.manifests.iter().map(|path| path.display().to_string()).collect();
    let json = json!({
        "items": merged.items,
        "manifests": manifests,
        "manifest": merged.manifest.display().to_string(),
        "sheet": merged.page.display().to_string(),
    });
    Ok((text, json))
}
