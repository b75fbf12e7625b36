//! `[material.NAME]` and the names that stones may use.

use super::fields::{Entry, Fields};
use super::source::Sources;
use crate::{Error, import};
use spectral_core::material::{Catalogue, Material, MaterialSpec};
use spectral_core::settings::RenderSettings;
use spectral_core::{shown, spectrum::Tabulated};
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// The scene's own materials, before the catalogue's.
pub(super) struct Materials {
    own: HashMap<String, Arc<Material>>,
    /// Their names as they stand.
    names: Vec<String>,
}

pub(super) fn read(
    root: &Fields,
    sources: &mut Sources,
    settings: &RenderSettings,
) -> Result<Materials, Error> {
    let (mut own, mut names) = (HashMap::new(), Vec::new());
    if let Some(entry) = root.get("material") {
        for entry in entry.fields("[material]")?.entries() {
            own.insert(entry.key.clone(), Arc::new(build(&entry, sources, settings)?));
            names.push(entry.key);
        }
    }
    Ok(Materials { own, names })
}

fn build(entry: &Entry, sources: &mut Sources, settings: &RenderSettings) -> Result<Material, Error> {
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
    let built = spec.build(&entry.key, resolve);
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
