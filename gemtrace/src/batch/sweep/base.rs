//! The scene that is changed.

use super::overlay;
use crate::scene_file::fields::{Document, Fields};
use crate::{Error, import};
use std::path::Path;
use toml::{Table, Value};

/// The scene that every picture begins with; its paths start from the sweep's folder.
pub struct Base {
    pub scene: Table,
    /// Which of its stones cuts, materials and sizes are about, from 0; all of them if `None`.
    pub stone: Option<usize>,
}

/// `base = "scene.toml"` or `[base]`, `set`, `stone`.
pub fn read(root: &Fields, folder: &Path) -> Result<Base, Error> {
    let entry = root.need("base", "the scene that is changed: a file's name, or a table")?;
    let mut scene = match entry.value.get_ref().as_str() {
        Some(name) => file(name, folder).map_err(|e| entry.error(e))?,
        None => {
            entry.fields("[base]")?;
            entry.read()?
        }
    };
    if let Some(entry) = root.get("set") {
        entry.fields("[set]")?;
        overlay::lay(&mut scene, &entry.read()?);
    }
    let stones = scene.get("stone").and_then(Value::as_array).map_or(0, Vec::len);
    let stone = match root.get("stone") {
        None => None,
        Some(entry) => {
            let expected = format!("one of the base scene's stones, counted from 1; it has {stones}");
            let number: usize = entry.whole(&expected)?;
            Some(number.checked_sub(1).filter(|i| *i < stones).ok_or_else(|| entry.refuse(&expected))?)
        }
    };
    Ok(Base { scene, stone })
}

fn file(name: &str, folder: &Path) -> Result<Table, Error> {
    let path = folder.join(name);
    let bytes = import::read_file(&path)?;
    let text = import::text(&path, &bytes)?;
    let document = Document { path: &path, text: &text };
    let mut scene: Table = toml::from_str(&text).map_err(|e| document.toml_error(&e))?;
    match Path::new(name).parent() {
        Some(prefix) if !prefix.as_os_str().is_empty() => rebase_table(&mut scene, prefix),
        _ => {}
    }
    Ok(scene)
}

/// Keys whose texts name files, wherever they stand.
const FILES: [&str; 4] = ["cut", "mesh", "image", "absorption"];
/// Keys whose texts name files if there is a dot in them, and otherwise something that the program brings.
const NAMES_OR_FILES: [&str; 1] = ["illuminant"];

/// Puts the folder `prefix` before every file's name.
fn rebase_table(table: &mut Table, prefix: &Path) {
    rename_files(table, &mut |name| prefix.join(name).to_string_lossy().replace('\\', "/"));
}

/// Gives every file that a scene names the name that `rename` makes of it.
pub(crate) fn rename_files(table: &mut Table, rename: &mut dyn FnMut(&str) -> String) {
    for (key, value) in table.iter_mut() {
        match value {
            Value::String(name)
                if FILES.contains(&key.as_str())
                    || (NAMES_OR_FILES.contains(&key.as_str()) && name.contains('.')) =>
            {
                *name = rename(name);
            }
            other => rename_within(other, rename),
        }
    }
}

fn rename_within(value: &mut Value, rename: &mut dyn FnMut(&str) -> String) {
    match value {
        Value::Table(table) => rename_files(table, rename),
        Value::Array(list) => list.iter_mut().for_each(|value| rename_within(value, rename)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_from_the_sweep() {
        let text = r#"
            environment = { image = "sky.exr", illuminant = "D65" }
            stone = [{ cut = "a.asc", material = "diamond" }, { mesh = "/far/b.stl" }]
            material = { ink = { like = "quartz", absorption = "ink.csv" } }
        "#;
        let mut scene: Table = toml::from_str(text).unwrap();
        rebase_table(&mut scene, Path::new("../scenes"));
        let wanted = text
            .replace("sky.exr", "../scenes/sky.exr")
            .replace("a.asc", "../scenes/a.asc")
            .replace("ink.csv", "../scenes/ink.csv");
        assert_eq!(scene, toml::from_str(&wanted).unwrap());
    }
}
