//! The lists that a matrix is made of.

use super::change::{Change, FORMS};
use super::view::{Angles, Viewpoint};
use crate::batch::plain;
use crate::scene_file::fields::{Entry, Fields};
use crate::{Error, import};
use serde_json::Value;
use spectral_core::{nearest_name, shown};
use std::path::Path;
use toml::Table;

/// What is swept, in the order in which changes are laid over each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    Cut,
    Material,
    Size,
    Light,
    View,
    Variant,
}

impl Axis {
    pub const ALL: [Axis; 6] =
        [Axis::Cut, Axis::Material, Axis::Size, Axis::Light, Axis::View, Axis::Variant];
    pub const NAMES: [&'static str; 6] = ["cut", "material", "size", "light", "view", "variant"];
    pub const LISTS: [&'static str; 6] = ["cuts", "materials", "sizes", "lights", "views", "variants"];

    /// Its key in an `[[item]]` and in templates.
    pub fn name(self) -> &'static str {
        Axis::NAMES[self as usize]
    }
}

/// One value of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub axis: Axis,
    /// In file names.
    pub name: String,
    /// In the manifest: the name, or the number that it is.
    pub value: Value,
    pub change: Change,
}

/// The axes that a sweep gives.
pub struct Axes(Vec<(Axis, Vec<Choice>)>);

pub fn read(root: &Fields) -> Result<Axes, Error> {
    let mut axes = Vec::new();
    for (axis, key) in Axis::ALL.into_iter().zip(Axis::LISTS) {
        let Some(entry) = root.get(key) else { continue };
        let mut choices: Vec<Choice> = Vec::new();
        for (number, entry) in entry.list(&format!("a list of {key}"))?.iter().enumerate() {
            let choice = choice(axis, entry, number + 1)?;
            if choices.iter().any(|other| other.name == choice.name) {
                let message =
                    format!("two of {key} are called '{}'; give one another 'name'", shown(&choice.name));
                return Err(entry.error(message));
            }
            choices.push(choice);
        }
        if choices.is_empty() {
            return Err(entry.error(format!("{key} is empty; leave it out, or give at least one")));
        }
        axes.push((axis, choices));
    }
    Ok(Axes(axes))
}

impl Axes {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn lists(&self) -> impl Iterator<Item = &[Choice]> {
        self.0.iter().map(|(_, choices)| choices.as_slice())
    }

    pub fn has(&self, axis: Axis) -> bool {
        self.0.iter().any(|(known, _)| *known == axis)
    }

    /// What an `[[item]]` chooses: choices by their names, or choices of its own.
    pub fn pick(&self, fields: &Fields) -> Result<Vec<Choice>, Error> {
        let mut picked = Vec::new();
        for axis in Axis::ALL {
            let Some(entry) = fields.get(axis.name()) else { continue };
            let known = self.0.iter().find(|(known, _)| *known == axis).map_or(&[][..], |(_, list)| list);
            let named = entry.value.get_ref().as_str();
            picked.push(match known.iter().find(|choice| Some(choice.name.as_str()) == named) {
                Some(choice) => choice.clone(),
                None => choice(axis, &entry, 1).map_err(|e| hint(e, named, known))?,
            });
        }
        Ok(picked)
    }
}

/// A name that is neither in the list nor one of the shorthands may be a slip.
fn hint(error: Error, named: Option<&str>, known: &[Choice]) -> Error {
    let near = named.and_then(|name| nearest_name(name, known.iter().map(|choice| choice.name.as_str())));
    match (error, near) {
        (Error::Scene { path, line, message }, Some(near)) => {
            Error::Scene { path, line, message: format!("{message}; did you mean '{}'?", shown(near)) }
        }
        (error, _) => error,
    }
}

fn choice(axis: Axis, entry: &Entry, number: usize) -> Result<Choice, Error> {
    let (name, change) = match axis {
        Axis::Size => {
            let width = entry.number("a width in mm")?;
            let value = serde_json::json!(width);
            let change = Change::Width(width);
            return Ok(Choice { axis, name: width.to_string(), value, change });
        }
        Axis::Cut => cut(entry, number)?,
        Axis::Material => material(entry)?,
        Axis::Light => light(entry, number)?,
        Axis::View => view(entry, number)?,
        Axis::Variant => variant(entry)?,
    };
    Ok(Choice { axis, value: Value::String(name.clone()), name: plain(&name), change })
}

/// The keys of a table but for its name, and that.
fn named_table(entry: &Entry, expected: &str) -> Result<(Option<String>, Table), Error> {
    if entry.value.get_ref().as_table().is_none() {
        return Err(entry.refuse(expected));
    }
    let mut keys: Table = entry.read()?;
    match keys.remove("name") {
        None => Ok((None, keys)),
        Some(toml::Value::String(name)) if !plain(&name).is_empty() => Ok((Some(name), keys)),
        Some(_) => Err(entry.error("'name' is a text with at least one letter or digit")),
    }
}

fn stem(file: &str) -> String {
    Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A shape's name, a cut's or a mesh's file, or a table of what `[[stone]]` takes.
fn cut(entry: &Entry, number: usize) -> Result<(String, Change), Error> {
    if let Some(text) = entry.value.get_ref().as_str() {
        let form = match (text.contains('.'), import::mesh::Format::of(Path::new(text))) {
            (false, _) => "shape",
            (true, Some(_)) => "mesh",
            (true, None) => "cut",
        };
        let name = if form == "shape" { text.to_owned() } else { stem(text) };
        let keys = Table::from_iter([(form.to_owned(), toml::Value::String(text.to_owned()))]);
        return Ok((name, Change::Stone(keys)));
    }
    let expected = "a shape's name, a cut or mesh file, or a table of what a [[stone]] takes";
    let (name, keys) = named_table(entry, expected)?;
    let form = FORMS.iter().find_map(|form| keys.get(*form));
    let own = form.and_then(|form| match form {
        toml::Value::String(text) => Some(stem(text)),
        toml::Value::Table(shape) => shape.get("name")?.as_str().map(str::to_owned),
        _ => None,
    });
    Ok((name.or(own).unwrap_or_else(|| format!("cut-{number}")), Change::Stone(keys)))
}

/// A material's name, or a table of what `[material.NAME]` takes, with its `name`.
fn material(entry: &Entry) -> Result<(String, Change), Error> {
    if let Some(text) = entry.value.get_ref().as_str() {
        return Ok((text.to_owned(), Change::Material(text.to_owned(), None)));
    }
    let (name, keys) = named_table(entry, "a material's name, or a table of what [material.NAME] takes")?;
    let name = name.ok_or_else(|| entry.error("a material of its own needs a 'name'"))?;
    Ok((name.clone(), Change::Material(name, Some(keys))))
}

/// What `preset` may be; any other name without a dot is that of a `model`.
const PRESETS: [&str; 1] = ["studio"];

/// The name of a preset or a model, an image file, or a table of what `[environment]` takes.
fn light(entry: &Entry, number: usize) -> Result<(String, Change), Error> {
    if let Some(text) = entry.value.get_ref().as_str() {
        let key = match text.contains('.') {
            true => "image",
            false if PRESETS.contains(&text) => "preset",
            false => "model",
        };
        let keys = Table::from_iter([(key.to_owned(), toml::Value::String(text.to_owned()))]);
        return Ok((if key == "image" { stem(text) } else { text.to_owned() }, Change::Light(keys)));
    }
    let (name, keys) = named_table(
        entry,
        "the name of a preset or a model, an image file, or a table of what [environment] takes",
    )?;
    let text = |key: &str| keys.get(key).and_then(toml::Value::as_str);
    let own = text("image").map(stem).or_else(|| text("preset").or(text("model")).map(str::to_owned));
    Ok((name.or(own).unwrap_or_else(|| format!("light-{number}")), Change::Light(keys)))
}

/// Angles about the stone, or a table of what `[camera]` takes.
fn view(entry: &Entry, number: usize) -> Result<(String, Change), Error> {
    let (name, mut keys) = named_table(entry, "a table: azimuth and elevation, or what [camera] takes")?;
    let mut angle = |key: &str| match keys.remove(key) {
        None => Ok(None),
        Some(toml::Value::Integer(i)) => Ok(Some(i as f64)),
        Some(toml::Value::Float(f)) if f.is_finite() => Ok(Some(f)),
        Some(other) => Err(entry.error(format!("{key} = {other}: expected a number"))),
    };
    let (azimuth, elevation, distance) = (angle("azimuth")?, angle("elevation")?, angle("distance")?);
    let angles = match (azimuth, elevation, distance) {
        (None, None, None) => None,
        _ => Some(Angles { azimuth: azimuth.unwrap_or(0.0), elevation: elevation.unwrap_or(90.0), distance }),
    };
    if let Some(key) = ["position", "up"].into_iter().find(|key| angles.is_some() && keys.contains_key(*key))
    {
        return Err(entry.error(format!("a view is given by angles or by '{key}', not by both")));
    }
    let own = angles.map_or_else(
        || format!("view-{number}"),
        |angles| format!("az{}-el{}", angles.azimuth, angles.elevation),
    );
    Ok((name.unwrap_or(own), Change::View(Viewpoint { angles, keys })))
}

/// A name and any keys of a scene, under `set`.
fn variant(entry: &Entry) -> Result<(String, Change), Error> {
    let fields = entry.fields("variants")?;
    let name = fields.need("name", "a name for its files")?;
    let name = name.text("a name for its files")?.to_owned();
    let keys = fields.need("set", "a table of what a scene takes")?.read()?;
    fields.finish()?;
    Ok((name, Change::Any(keys)))
}
