//! Checks that all pictures of a plan are there and complete, and joins what several machines rendered.

use super::entry::{Entry, ExpectedItem};
use super::manifest::{self, Done, Event};
use super::{Plan, page};
use crate::shard::Shard;
use crate::{Error, import, output};
use serde::Deserialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// What an output folder's [`Plan::FILE`] says.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Expected {
    /// The plan's title.
    pub title: String,
    /// The pictures that belong into the folder, in order.
    pub items: Vec<ExpectedItem>,
}

/// What was joined.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Merged {
    /// Pictures that are there and whole.
    pub items: usize,
    /// The manifests that were joined.
    pub manifests: Vec<PathBuf>,
    /// The joined one.
    pub manifest: PathBuf,
    /// The contact sheet, a page.
    pub page: PathBuf,
}

/// Makes sure that every picture of a folder's plan is there and whole, joins the manifests into `manifest.jsonl`, one
/// line an item in the plan's order, and writes the contact sheet.
///
/// # Errors
/// [`Error::Items`] naming items that are missing, each with its shard and the reason; then nothing is written.
/// [`Error::File`] for a folder without a plan, [`Error::Output`] for what cannot be written.
pub fn merge(folder: &Path) -> Result<Merged, Error> {
    let expected = expected(folder)?;
    let manifests = manifest::all(folder)?;
    let entries = entries(folder, &expected, true)?;
    let missing: Vec<(usize, &Entry)> =
        entries.iter().enumerate().filter(|(_, entry)| entry.outcome.is_err()).collect();
    if !missing.is_empty() {
        return Err(Error::Items(complaint(&missing, entries.len(), &manifests)));
    }
    let lines = entries.iter().filter_map(|entry| entry.outcome.clone().ok()).map(Event::Done);
    let manifest = folder.join(manifest::name(Shard::WHOLE));
    let text: Result<Vec<String>, _> = lines.map(|line| serde_json::to_string(&line)).collect();
    let text = text.map_err(|e| Error::output(&manifest, format!("cannot be written ({e})")))?;
    remove_leftovers(folder);
    output::write_text(&manifest, &(text.join("\n") + "\n"))?;
    let page = page::write(folder, &expected.title, &entries)?;
    let manifests = manifests.into_iter().map(|(_, path)| path).collect();
    Ok(Merged { items: entries.len(), manifests, manifest, page })
}

/// Removes what killed processes left of the files that are written for the whole; to be called where no shard writes.
pub(super) fn remove_leftovers(folder: &Path) {
    let names = [Plan::FILE, page::FILE, &manifest::name(Shard::WHOLE)].map(|name| folder.join(name));
    output::remove_leftovers(&names);
}

/// What belongs into an output folder.
///
/// # Errors
/// [`Error::File`] if no batch has begun there.
pub fn expected(folder: &Path) -> Result<Expected, Error> {
    let path = folder.join(Plan::FILE);
    if !path.exists() {
        let message = format!("there is no {} here: this is not the output folder of a batch", Plan::FILE);
        return Err(Error::file(folder, message));
    }
    parse(&path, &import::read_file(&path)?)
}

/// The same from the bytes of the plan's file, `path` naming it in messages.
///
/// # Errors
/// [`Error::File`] for anything else.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Expected, Error> {
    serde_json::from_slice(bytes).map_err(|e| Error::file(path, format!("this is no plan of a batch ({e})")))
}

/// The outcome of every item by the manifests; with `check`, the pictures are compared, too.
///
/// # Errors
/// [`Error::File`] if a manifest cannot be read.
pub fn entries(folder: &Path, expected: &Expected, check: bool) -> Result<Vec<Entry>, Error> {
    let known = manifest::read_all(folder)?;
    let entry = |item: &ExpectedItem| {
        let lines = known.get(&item.item).map_or(&[][..], Vec::as_slice);
        Entry { item: item.clone(), outcome: outcome(folder, item, lines, check) }
    };
    Ok(expected.items.iter().map(entry).collect())
}

fn outcome(folder: &Path, item: &ExpectedItem, lines: &[Event], check: bool) -> Result<Box<Done>, String> {
    let mut reason = "never begun".to_owned();
    for line in lines.iter().rev() {
        if line.identity() != item.identity {
            continue;
        }
        match line {
            Event::Done(done) => {
                match done.outputs.iter().find(|o| check && !o.holds(&folder.join(&o.path))) {
                    None => return Ok(done.clone()),
                    Some(bad) => return Err(format!("{} is gone, or not what was written", bad.path)),
                }
            }
            Event::Failed { message, .. } => return Err(format!("failed: {message}")),
            Event::Started { .. } => reason = "begun, but its process ended before it was done".to_owned(),
        }
    }
    let other = lines.iter().any(|line| matches!(line, Event::Done(done) if done.identity != item.identity));
    let stale = "rendered from another version of the scene or by another version of the program";
    Err(if other && reason == "never begun" { stale.to_owned() } else { reason })
}

/// How many items a complaint names.
const NAMED: usize = 8;

fn complaint(missing: &[(usize, &Entry)], items: usize, manifests: &[(Shard, PathBuf)]) -> String {
    let mut counts: Vec<u32> =
        manifests.iter().map(|(shard, _)| shard.count()).filter(|count| *count > 1).collect();
    counts.dedup();
    // Where runs with different numbers of shards took part, it is unknown which of them is incomplete.
    let count = if let [count] = counts.as_slice() { Some(*count) } else { None };
    let mut text = format!("{} of {items} items are missing", missing.len());
    let absent: HashMap<Shard, String> = (0..count.unwrap_or(0))
        .filter_map(|index| Shard::new(index, count?))
        .filter(|shard| manifests.iter().all(|(there, _)| there != shard))
        .map(|shard| (shard, shard.to_string()))
        .collect();
    if !absent.is_empty() {
        let mut names: Vec<_> = absent.into_iter().collect();
        names.sort();
        let names: Vec<String> = names.into_iter().map(|(_, name)| name).collect();
        text += &format!("; without a manifest: shard {}", names.join(", "));
    }
    for (number, entry) in missing.iter().take(NAMED) {
        let shard = count.map_or(String::new(), |count| format!(" (shard {})", Shard::of(*number, count)));
        let reason = entry.outcome.as_ref().err().map_or("", String::as_str);
        text += &format!("\n  {}{shard}: {reason}", entry.item.item);
    }
    if missing.len() > NAMED {
        text += &format!("\n  and {} more", missing.len() - NAMED);
    }
    text
}
