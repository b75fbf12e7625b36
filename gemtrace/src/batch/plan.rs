//! What is to be rendered: named scenes.

use crate::Error;
use crate::output::{Format, Options};
use crate::scene_file::Override;
use crate::scene_file::source::Hash;
use serde_json::{Map, Value, json};
use spectral_core::shown;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// One picture to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// The place of its files below the output folder, without an extension: `"ruby/top"`. Letters, digits and
    /// `. _ - + /`.
    pub name: String,
    /// What sets it apart, for the manifest and the contact sheet: `cut`, `material` and so on. Texts and numbers.
    pub values: Map<String, Value>,
    /// The scene, as a scene file would have it (see [`crate::scene_file`]); its paths start from the plan's folder.
    pub scene: toml::Table,
}

/// How the pictures of a plan are written; the same for all, so that they can be compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Pictures {
    /// The files made of each item.
    pub formats: Vec<Format>,
    /// Colour space, bits, exposure and tone.
    pub options: Options,
}

impl Default for Pictures {
    /// PNG of 8 bits in sRGB.
    fn default() -> Self {
        Pictures { formats: vec![Format::Png], options: Options::default() }
    }
}

/// A list of pictures.
///
/// ```
/// use gemtrace::batch::{Item, Pictures, Plan};
///
/// let scene: toml::Table = toml::from_str(
///     r#"
///     format = 1
///     camera = { position = [0, -20, 20], look_at = [0, 0, 0] }
///     stone = [{ shape = "round-brilliant", width = 6.5, material = "diamond" }]
///     "#,
/// )?;
/// let item = |name: &str| Item { name: name.into(), values: Default::default(), scene: scene.clone() };
/// let plan = Plan::new("two frames", ".".into(), vec![item("a"), item("b")], Pictures::default())?;
/// assert_eq!(plan.items().len(), 2);
///
/// let twice = Plan::new("two frames", ".".into(), vec![item("a"), item("a")], Pictures::default());
/// assert_eq!(twice.unwrap_err().to_string(), "items 1 and 2 have the same name, 'a'");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    title: String,
    folder: PathBuf,
    items: Vec<Item>,
    pictures: Pictures,
    overrides: Override,
}

impl Plan {
    /// The file that says what belongs into an output folder.
    pub const FILE: &'static str = "plan.json";

    /// A plan, whose scenes name their files from `folder`.
    ///
    /// # Errors
    /// [`Error::Usage`] for an empty plan, one without a format, and for names that are no relative paths of plain
    /// characters, or not distinct.
    pub fn new(
        title: impl Into<String>,
        folder: PathBuf,
        items: Vec<Item>,
        pictures: Pictures,
    ) -> Result<Self, Error> {
        if items.is_empty() || pictures.formats.is_empty() {
            return Err(Error::Usage(
                "nothing to render: no items, or no picture files asked for".to_owned(),
            ));
        }
        // Compared without case, as some file systems do.
        let mut seen = HashMap::new();
        for (number, item) in items.iter().enumerate() {
            check_name(&item.name)?;
            if let Some(first) = seen.insert(item.name.to_lowercase(), number) {
                let (first, second) = (first + 1, number + 1);
                let message =
                    format!("items {first} and {second} have the same name, '{}'", shown(&item.name));
                return Err(Error::Usage(message));
            }
        }
        Ok(Plan { title: title.into(), folder, items, pictures, overrides: Override::default() })
    }

    /// The same with another picture size or other settings in place of every scene's own.
    #[must_use]
    pub fn with(self, overrides: Override) -> Self {
        Plan { overrides, ..self }
    }

    /// What is rendered in place of what the scenes say.
    pub fn overrides(&self) -> &Override {
        &self.overrides
    }

    /// What it is called on the contact sheet.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Where the scenes' paths start.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The pictures to be made, in order.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// How they are written.
    pub fn pictures(&self) -> &Pictures {
        &self.pictures
    }

    /// The scene of an item as the text of a scene file.
    ///
    /// # Errors
    /// [`Error::Usage`] for a table that TOML cannot write.
    pub fn scene_text(&self, item: &Item) -> Result<String, Error> {
        toml::to_string(&item.scene)
            .map_err(|e| Error::Usage(format!("the scene of '{}' is no TOML: {e}", item.name)))
    }

    /// What an item's pictures depend on but for the contents of the files that its scene names: SHA-256 in
    /// hexadecimal over this program's version, the scene, what overrides it and the options of the pictures.
    ///
    /// # Errors
    /// As [`Plan::scene_text`].
    pub fn identity(&self, item: &Item) -> Result<String, Error> {
        let mut hash = Hash::new();
        let (scene, options) = (self.scene_text(item)?, json!([self.pictures.to_json(), self.overrides]));
        let parts = [env!("CARGO_PKG_VERSION"), &scene, &options.to_string()];
        parts.iter().for_each(|part| hash.add(part.as_bytes()));
        Ok(hash.finish())
    }

    /// Names of the files made of an item, below the output folder.
    pub fn files<'a>(&'a self, item: &'a Item) -> impl Iterator<Item = (String, Format)> + 'a {
        self.pictures.formats.iter().map(|format| (format!("{}.{}", item.name, format.extension()), *format))
    }

    /// What [`merge`](super::merge) must know of the plan.
    ///
    /// # Errors
    /// As [`Plan::scene_text`].
    pub fn to_json(&self) -> Result<Value, Error> {
        let item = |item: &Item| {
            let files: Vec<String> = self.files(item).map(|(name, _)| name).collect();
            let (name, values, identity) = (&item.name, &item.values, self.identity(item)?);
            Ok(json!({ "item": name, "values": values, "identity": identity, "files": files }))
        };
        let items = self.items.iter().map(item).collect::<Result<Vec<_>, Error>>()?;
        Ok(json!({ "title": self.title, "version": env!("CARGO_PKG_VERSION"), "items": items }))
    }
}

impl Pictures {
    fn to_json(&self) -> Value {
        let formats: Vec<&str> = self.formats.iter().map(|format| format.extension()).collect();
        json!({
            "formats": formats,
            "space": self.options.space.name(),
            "bits": self.options.depth.bits(),
            "exposure": self.options.exposure,
            "tone": self.options.tone,
        })
    }
}

/// A text as a part of a name: whatever is no letter, digit or one of `._+` becomes `-`.
pub(crate) fn plain(text: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "._+".contains(c) { c } else { '-' };
    let text: String = text.chars().map(plain).collect();
    text.trim_matches(['-', '.']).to_owned()
}

/// Refuses names that would leave the output folder, or that some file system cannot hold.
fn check_name(name: &str) -> Result<(), Error> {
    let plain = |c: char| c.is_alphanumeric() || "._-+".contains(c);
    let part = |part: &str| {
        !part.is_empty() && part.len() <= 200 && !part.starts_with('.') && part.chars().all(plain)
    };
    if name.split('/').all(part) {
        return Ok(());
    }
    let expected =
        "letters, digits and '.', '_', '-', '+', with '/' between folders, none beginning with '.'";
    Err(Error::Usage(format!("item name '{}' is not valid: expected {expected}", shown(name))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_output_folder() {
        for good in ["a", "ruby/top", "6.5mm_b-1+2", "größe"] {
            assert_eq!(check_name(good), Ok(()));
        }
        for bad in ["", "/a", "a/", "../a", "a/../b", ".a", "a b", "a\\b", "a\0", "a:b", &"x".repeat(201)] {
            assert!(check_name(bad).is_err(), "{bad}");
        }
    }
}
