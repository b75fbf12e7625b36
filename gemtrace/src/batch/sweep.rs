//! Sweep files: a base scene, and what is changed in it from picture to picture. `docs/batch.md` describes them.
//!
//! Everything happens in the TOML document: each change is laid over the base scene, and the result is read by
//! [`crate::scene_file`] like any other scene. So a light may be whatever `[environment]` accepts, a stone whatever
//! `[[stone]]` does, and nothing about them is said twice.
//!
//! ```
//! use gemtrace::batch::sweep;
//! let text = r#"
//!     format = 1
//!     cuts = ["round-brilliant", "step"]
//!     sizes = [2, 4]
//!     views = [{ name = "top", elevation = 90 }]
//!     [base]
//!     format = 1
//!     camera = { position = [0, -20, 20], look_at = [0, 0, 0] }
//!     stone = [{ material = "diamond" }]
//! "#;
//! let plan = sweep::parse(text, "sweep.toml".as_ref(), ".".as_ref())?;
//! let names: Vec<&str> = plan.items().iter().map(|item| item.name.as_str()).collect();
//! assert_eq!(
//!     names,
//!     ["round-brilliant-2-top", "round-brilliant-4-top", "step-2-top", "step-4-top"]
//! );
//! # Ok::<(), gemtrace::Error>(())
//! ```

mod axis;
pub(crate) mod base;
mod change;
pub(crate) mod overlay;
mod template;
mod view;

use super::{Item, Pictures, Plan};
use crate::output::{Depth, Format};
use crate::scene_file::fields::{Document, Entry, Fields, either};
use crate::{Error, import};
use axis::{Axes, Axis, Choice};
use base::Base;
use serde_json::Map;
use spectral_core::color::{RgbSpace, Tone};
use spectral_core::shown;
use std::path::Path;
use template::Template;
use toml::Table;
use toml::de::DeTable;

/// The only version of the format so far.
pub const FORMAT: i64 = 1;

/// The most pictures of one sweep; more is a slip in a matrix.
pub const MAX_ITEMS: usize = 100_000;

/// Reads a sweep file and the base scene that it names.
///
/// # Errors
/// [`Error::File`] if a file cannot be read, [`Error::Scene`] with the line of what is wrong in it, [`Error::Usage`] for
/// items whose names clash. Scenes are read when their turn comes: what is wrong with one is that item's failure.
pub fn load(path: &Path) -> Result<Plan, Error> {
    let bytes = import::read_file(path)?;
    let text = import::text(path, &bytes)?;
    parse(&text, path, path.parent().unwrap_or(Path::new("")))
}

/// Reads a sweep from its text. `path` names it in messages; the files it names are found from `folder`.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, path: &Path, folder: &Path) -> Result<Plan, Error> {
    let document = Document { path, text };
    let table = DeTable::parse(text).map_err(|e| document.toml_error(&e))?;
    let root = Fields::new(document, "the sweep", 0, table.get_ref());
    match root.get("format") {
        None => {
            return Err(root.error(format!("a sweep begins with 'format = {FORMAT}', which is missing here")));
        }
        Some(entry) => match entry.whole::<i64>("a whole number")? {
            FORMAT => {}
            _ => return Err(entry.refuse(&format!("the version of the sweep format, {FORMAT}"))),
        },
    }
    let title = match root.get("title") {
        Some(entry) => entry.text("a title")?.to_owned(),
        None => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
    };
    let base = base::read(&root, folder)?;
    let pictures = pictures(&root)?;
    let axes = axis::read(&root)?;
    let listed = root.get("item");
    let template =
        root.get("name").map(|entry| Template::read(&entry, &axes, listed.is_some())).transpose()?;
    root.finish()?;
    let items = match listed {
        Some(entry) => listed_items(&entry, &base, &axes, template.as_ref())?,
        None if axes.is_empty() => {
            let names = either(&Axis::LISTS);
            return Err(root.error(format!("nothing to sweep: give at least one of {names}, or [[item]]s")));
        }
        None => matrix(&root, &base, &axes, template.as_ref())?,
    };
    Plan::new(title, folder.to_owned(), items, pictures).map_err(|e| root.error(e))
}

fn pictures(root: &Fields) -> Result<Pictures, Error> {
    let mut pictures = Pictures::default();
    if let Some(entry) = root.get("files") {
        let expected = "[\"png\"], [\"exr\"] or both";
        let names: Vec<String> = entry.read().map_err(|_| entry.refuse(expected))?;
        pictures.formats = Vec::new();
        for name in &names {
            let format = [Format::Png, Format::Exr].into_iter().find(|format| format.extension() == name);
            let format = format.filter(|format| !pictures.formats.contains(format));
            pictures.formats.push(format.ok_or_else(|| entry.refuse(expected))?);
        }
        if pictures.formats.is_empty() {
            return Err(entry.refuse(expected));
        }
    }
    if let Some(entry) = root.get("space") {
        pictures.options.space =
            RgbSpace::by_name(entry.text("the name of a colour space")?).map_err(|e| entry.error(e))?;
    }
    if let Some(entry) = root.get("bits") {
        let depth = Depth::of_bits(entry.whole("8 or 16")?);
        pictures.options.depth = depth.ok_or_else(|| entry.refuse("8 or 16"))?;
    }
    if let Some(entry) = root.get("exposure") {
        let expected = "a number of stops from -64 to 64";
        let stops = entry.number(expected)?;
        pictures.options.exposure =
            Some(stops).filter(|stops| stops.abs() <= 64.0).ok_or_else(|| entry.refuse(expected))?;
    }
    if let Some(entry) = root.get("tone") {
        let name = entry.text(&format!("one of {}", either(&Tone::ALL.map(Tone::name))))?;
        pictures.options.tone = Some(Tone::by_name(name).map_err(|e| entry.error(e))?);
    }
    Ok(pictures)
}

/// Every combination, the last axis changing fastest.
fn matrix(root: &Fields, base: &Base, axes: &Axes, template: Option<&Template>) -> Result<Vec<Item>, Error> {
    let lists: Vec<&[Choice]> = axes.lists().collect();
    let count = lists.iter().try_fold(1usize, |count, list| count.checked_mul(list.len()));
    let count = count.filter(|count| *count <= MAX_ITEMS);
    let count = count.ok_or_else(|| root.error(format!("more than {MAX_ITEMS} pictures")))?;
    let pick = |number: usize| {
        let mut rest = number;
        let mut picked: Vec<&Choice> = Vec::with_capacity(lists.len());
        for list in lists.iter().rev() {
            picked.push(&list[rest % list.len()]);
            rest /= list.len();
        }
        picked.reverse();
        item(number, base, &picked, None, template).map_err(|e| root.error(e))
    };
    (0..count).map(pick).collect()
}

/// The pictures of `[[item]]`, whose values are names of the axes' choices or choices of their own.
fn listed_items(
    entry: &Entry,
    base: &Base,
    axes: &Axes,
    template: Option<&Template>,
) -> Result<Vec<Item>, Error> {
    let tables = entry.tables("[[item]]")?;
    let read = |(number, fields): (usize, &Fields)| {
        let name = fields.get("name").map(|e| e.text("a name for the picture's files")).transpose()?;
        let picked = axes.pick(fields)?;
        let change = fields.get("set").map(|e| e.read::<Table>()).transpose()?;
        fields.finish()?;
        if name.is_none() && picked.is_empty() {
            let names = either(&Axis::NAMES);
            return Err(fields.error(format!("[[item]] needs a 'name', or one of {names} to be named after")));
        }
        let picked: Vec<&Choice> = picked.iter().collect();
        let mut item = item(number, base, &picked, name, template).map_err(|e| fields.error(e))?;
        if let Some(change) = &change {
            overlay::lay(&mut item.scene, change);
        }
        Ok(item)
    };
    tables.iter().enumerate().map(read).collect()
}

fn item(
    number: usize,
    base: &Base,
    picked: &[&Choice],
    name: Option<&str>,
    template: Option<&Template>,
) -> Result<Item, String> {
    let name = match (name, template) {
        (Some(name), _) => name.to_owned(),
        (None, Some(template)) => template.fill(number, picked)?,
        (None, None) => template::joined(picked),
    };
    let mut scene = base.scene.clone();
    for choice in picked {
        choice.change.apply(&mut scene, base.stone).map_err(|e| format!("item '{}': {e}", shown(&name)))?;
    }
    let values: Map<_, _> =
        picked.iter().map(|choice| (choice.axis.name().to_owned(), choice.value.clone())).collect();
    Ok(Item { name, values, scene })
}
