//! The materials that come with the crate.

use std::sync::LazyLock;

use serde::Deserialize;

use super::{Material, MaterialSpec, Source, within};
use crate::{Error, shown};

/// A data file: the optics as a scene would give them, and what a scene need not say.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    aliases: Vec<String>,
    #[serde(default)]
    notes: Vec<String>,
    optics: MaterialSpec,
    sources: Vec<Source>,
}

/// One file of the data folder, by the material's name.
macro_rules! files {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../data/materials/", $name, ".toml")))),*]
    };
}

const FILES: [(&str, &str); 46] = files![
    "alexandrite",
    "amethyst",
    "andalusite",
    "apatite",
    "aquamarine",
    "benitoite",
    "beryl",
    "blue-topaz",
    "blue-zircon",
    "calcite",
    "chrysoberyl",
    "citrine",
    "colour-change-sapphire",
    "copper",
    "corundum",
    "cubic-zirconia",
    "demantoid",
    "diamond",
    "diopside",
    "emerald",
    "fused-silica",
    "gold",
    "green-tourmaline",
    "iolite",
    "kunzite",
    "moissanite",
    "n-bk7",
    "peridot",
    "pink-sapphire",
    "pink-tourmaline",
    "platinum",
    "quartz",
    "rose-gold",
    "ruby",
    "rutile",
    "sapphire",
    "silver",
    "sphene",
    "spinel",
    "strontium-titanate",
    "tanzanite",
    "topaz",
    "tourmaline",
    "unheated-tanzanite",
    "yag",
    "zircon",
];

static BUILTIN: LazyLock<Catalogue> = LazyLock::new(|| {
    // The files are part of the program. `every_file_of_the_catalogue_parses` checks them; one that does not parse is
    // left out here.
    Catalogue { entries: FILES.iter().filter_map(|(name, text)| parse(name, text).ok()).collect() }
});

/// Materials by name and alias.
#[derive(Debug, Clone)]
pub struct Catalogue {
    entries: Vec<(Material, Vec<String>)>,
}

impl Catalogue {
    /// The materials that come with the crate.
    pub fn builtin() -> &'static Self {
        &BUILTIN
    }

    /// The material called `name`, or of which that is an alias; case, blanks and underscores do not matter.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the nearest name, or all of them.
    pub fn get(&self, name: &str) -> Result<&Material, Error> {
        let wanted = canonical(name);
        let matches = |(material, aliases): &&(Material, Vec<String>)| {
            material.name == wanted || aliases.contains(&wanted)
        };
        match self.entries.iter().find(matches) {
            Some((material, _)) => Ok(material),
            None => Err(self.unknown(name, &wanted)),
        }
    }

    /// The names, in alphabetical order, without aliases.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|(material, _)| material.name.as_str())
    }

    /// The materials, in the order of their names.
    pub fn materials(&self) -> impl Iterator<Item = &Material> {
        self.entries.iter().map(|(material, _)| material)
    }

    /// Other names of the material called `name`.
    pub fn aliases(&self, name: &str) -> &[String] {
        self.entries.iter().find(|(m, _)| m.name == name).map_or(&[], |(_, aliases)| aliases)
    }

    fn unknown(&self, name: &str, wanted: &str) -> Error {
        let aliases = self.entries.iter().flat_map(|(_, aliases)| aliases.iter().map(String::as_str));
        let nearest = crate::nearest_name(wanted, self.names().chain(aliases)).map(str::to_owned);
        Error::Unknown {
            kind: "material",
            name: shown(name),
            nearest,
            valid: self.names().map(str::to_owned).collect(),
        }
    }
}

fn canonical(name: &str) -> String {
    name.trim().to_lowercase().replace([' ', '_'], "-")
}

fn parse(name: &str, text: &str) -> Result<(Material, Vec<String>), Error> {
    let entry: Entry = toml::from_str(text).map_err(|error| Error::Data {
        what: format!("{name}.toml"),
        line: 0,
        message: error.to_string(),
    })?;
    let no_files = |file: &str| Err(Error::value("absorption", file, "the catalogue's files stand alone"));
    let (mut material, warnings) = entry.optics.build(name, no_files)?;
    if let Some(warning) = warnings.first() {
        return Err(within(name, Error::value("figures", warning, "the catalogue's files give no warnings")));
    }
    material.ray = ["isotropic", "ordinary", "alpha"][material.axes.len().min(2)].to_owned();
    material.notes = entry.notes;
    material.sources = entry.sources;
    Ok((material, entry.aliases))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_catalogue_parses() {
        for (name, text) in FILES {
            let (material, aliases) = parse(name, text).unwrap();
            assert_eq!(material.name, canonical(name));
            assert!(aliases.iter().all(|alias| *alias == canonical(alias)), "{name}: {aliases:?}");
        }
    }

    #[test]
    fn no_two_materials_share_a_name() {
        let catalogue = Catalogue::builtin();
        let mut names: Vec<String> = catalogue.names().map(str::to_owned).collect();
        assert!(names.is_sorted());
        for name in names.clone() {
            names.extend(catalogue.aliases(&name).iter().cloned());
        }
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
