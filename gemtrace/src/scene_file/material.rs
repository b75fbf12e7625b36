//! `[material.NAME]` and the names that stones may use.

use super::fields::{Entry, Fields};
use super::source::Sources;
use crate::{Error, import};
use spectral_core::cie::Illuminant;
use spectral_core::material::{Catalogue, ColorSpec, Material, MaterialSpec};
use spectral_core::settings::RenderSettings;
use spectral_core::{shown, spectrum::Tabulated};
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// The name of the material that a cut's own file describes.
const DESIGN: &str = "design";

/// The scene's own materials, before the catalogue's.
pub(super) struct Materials {
    own: HashMap<String, Arc<Material>>,
    /// Their names as they stand.
    names: Vec<String>,
    /// The light of the scene, by which colours are seen.
    light: Illuminant,
}

pub(super) fn read(
    root: &Fields,
    sources: &mut Sources,
    settings: &RenderSettings,
    light: &Illuminant,
) -> Result<Materials, Error> {
    let (mut own, mut names) = (HashMap::new(), Vec::new());
    if let Some(entry) = root.get("material") {
        for entry in entry.fields("[material]")?.entries() {
            own.insert(entry.key.clone(), Arc::new(build(&entry, sources, settings, light)?));
            names.push(entry.key);
        }
    }
    Ok(Materials { own, names, light: light.clone() })
}

fn build(
    entry: &Entry,
    sources: &mut Sources,
    settings: &RenderSettings,
    light: &Illuminant,
) -> Result<Material, Error> {
    let fields = entry.fields(format!("[material.{}]", shown(&entry.key)))?;
    let spec: MaterialSpec = entry.read()?;
    // The core asks for tables through a shared closure and knows only its own errors.
    let (shared, failed) = (RefCell::new(&mut *sources), RefCell::new(None));
    let resolve = |name: &str| {
        let read = shared.borrow_mut().read(name, |path, bytes| {
            let table = Tabulated::from_csv(&import::text(path, &bytes)?, &path.display().to_string())?;
            Ok((table, Vec::new()))
        });
        read.map(Arc::unwrap_or_clone).map_err(|e| {
            let message = spectral_core::Error::value("absorption", name, e.to_string());
            failed.replace(Some(e));
            message
        })
    };
    let built = spec.build_under(light, &entry.key, resolve);
    let (material, warnings) = match (built, failed.into_inner()) {
        (Err(_), Some(file)) => return Err(entry.error(file)),
        (built, _) => built.map_err(|e| fields.blame(e))?,
    };
    sources.warn(warnings);
    // Preparation checks it again; here the complaint has a line.
    material.check(settings.wavelengths.range()).map_err(|e| fields.blame(e))?;
    Ok(material)
}

impl Materials {
    /// The material that a cut's file describes: its index, and its colour seen through `mm`. `None` unless it is asked for.
    pub fn design(
        &self,
        entry: &Entry,
        file: &Entry,
        mm: f64,
        sources: &mut Sources,
    ) -> Result<Option<Arc<Material>>, Error> {
        if entry.value.get_ref().as_str() != Some(DESIGN) || self.own.contains_key(DESIGN) {
            return Ok(None);
        }
        let cut = sources.import(file, |path, bytes| import::cut::read(path, &bytes))?;
        let none = || entry.error("this design says nothing of its index; name a material");
        let index = cut.index_of_refraction.ok_or_else(none)?;
        let color = cut.colour.map(|rgb| ColorSpec { rgb, at: mm });
        let spec = MaterialSpec { index: Some(index), color, ..MaterialSpec::default() };
        let unread = |name: &str| Err(spectral_core::Error::value("absorption", name, "no file"));
        let built = spec.build_under(&self.light, DESIGN, unread);
        built.map(|(material, _)| Some(Arc::new(material))).map_err(|e| entry.error(e))
    }

    /// The material that an entry names.
    pub fn get(&self, entry: &Entry) -> Result<Arc<Material>, Error> {
        let name = entry.text("the name of a material")?;
        if let Some(own) = self.own.get(name) {
            return Ok(own.clone());
        }
        Catalogue::builtin()
            .get(name)
            .map(|m| Arc::new(m.clone()))
            .map_err(|e| entry.error(self.unknown(name, e)))
    }

    /// The catalogue's complaint, unless one of the scene's own names is as near.
    fn unknown(&self, name: &str, error: spectral_core::Error) -> spectral_core::Error {
        let own = || self.names.iter().map(String::as_str);
        match error {
            spectral_core::Error::Unknown { kind, name: given, nearest, valid } => {
                let candidates = own().chain(nearest.as_deref());
                let nearest =
                    spectral_core::nearest_name(name, candidates).map(str::to_owned).or(nearest.clone());
                let valid = own().map(str::to_owned).chain(valid).collect();
                spectral_core::Error::Unknown { kind, name: given, nearest, valid }
            }
            other => other,
        }
    }
}
