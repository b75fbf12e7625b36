//! A scene document that is changed before it is read: sequences, sheets, sweeps.

use super::{Assets, LoadedScene};
use crate::{Error, import};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A scene file as a table of values, with the place that its paths start from.
///
/// ```
/// use gemtrace::scene_file::{Assets, Draft};
/// let text = "format = 1\ncamera = { position = [0, -20, 20], look_at = [0, 0, 0] }\n[film]\nwidth = 9";
/// let draft = Draft::new("scene.toml".as_ref(), text)?;
/// let wide = draft.with("film", "width", 64);
/// let mut assets = Assets::default();
/// assert_eq!((draft.load(&mut assets)?.scene.width, wide.load(&mut assets)?.scene.width), (9, 64));
/// # Ok::<(), gemtrace::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// The scene file: it names the scene in messages, and paths in it start from its folder.
    pub path: PathBuf,
    /// What it says.
    pub table: Table,
}

impl Draft {
    /// Reads a scene file's text, and nothing of what it names.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read or is no TOML.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = import::read_file(path)?;
        Draft::new(path, &import::text(path, &bytes)?)
    }

    /// A document from its text.
    ///
    /// # Errors
    /// [`Error::File`] if it is no TOML.
    pub fn new(path: &Path, text: &str) -> Result<Self, Error> {
        let table = text.parse().map_err(|e: toml::de::Error| Error::file(path, e.message()))?;
        Ok(Draft { path: path.to_owned(), table })
    }

    /// The scene file's name.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The scene file's name without its extension.
    pub fn stem(&self) -> String {
        self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The same with another value for `key` in `[section]`, which is made if it is not there. A section that is no
    /// table stays as it is: the error comes when the scene is read.
    #[must_use]
    pub fn with(&self, section: &str, key: &str, value: impl Into<Value>) -> Self {
        let mut draft = self.clone();
        let table = draft.table.entry(section).or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(table) = table {
            table.insert(key.to_owned(), value.into());
        }
        draft
    }

    /// The number under `key` in `[section]`, if there is one.
    pub fn number(&self, section: &str, key: &str) -> Option<f64> {
        let value = self.table.get(section)?.get(key)?;
        value.as_float().or(value.as_integer().map(|v| v as f64))
    }

    /// Reads the scene as it is now; lines in messages are those of the changed text.
    ///
    /// # Errors
    /// As [`parse`](super::parse).
    pub fn load(&self, assets: &mut Assets) -> Result<LoadedScene, Error> {
        let text = toml::to_string(&self.table).map_err(|e| Error::file(&self.path, e))?;
        assets.parse(&text, &self.path, self.path.parent().unwrap_or(Path::new("")))
    }
}
