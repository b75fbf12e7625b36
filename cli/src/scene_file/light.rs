//! `[environment]`.

use super::fields::{Entry, Fields};
use super::source::Sources;
use crate::{Error, import};
use spectral_core::cie::Illuminant;
use spectral_core::environment::{Environment, LatLong};
use spectral_core::spectrum::Tabulated;

const PRESETS: [&str; 1] = ["studio"];

pub(super) fn read(root: &Fields, sources: &mut Sources) -> Result<Environment, Error> {
    let Some(entry) = root.get("environment") else { return Ok(Environment::image(LatLong::studio())) };
    let fields = entry.fields("[environment]")?;
    let mut environment = match fields.one_of(&["image", "uniform", "preset"])? {
        Some(("image", entry)) => Environment::image(sources.import(&entry, import::environment::read)?),
        Some(("uniform", entry)) => Environment::uniform(entry.vector("three linear sRGB values [r, g, b]")?),
        Some((_, entry)) => preset(&entry)?,
        None => Environment::image(LatLong::studio()),
    };
    if let Some(entry) = fields.get("rotation") {
        environment.rotation = entry.number("an angle in degrees")?;
    }
    if let Some(entry) = fields.get("scale") {
        environment.scale = entry.number("a factor from 0 upwards")?;
    }
    if let Some(entry) = fields.get("illuminant") {
        environment.illuminant = illuminant(&entry, sources)?;
    }
    fields.finish()?;
    environment.validate().map_err(|e| fields.blame(e))?;
    Ok(environment)
}

fn preset(entry: &Entry) -> Result<Environment, Error> {
    match entry.text("the name of a built-in environment: 'studio'")? {
        "studio" => Ok(Environment::image(LatLong::studio())),
        other => Err(entry.error(spectral_core::Error::unknown("environment preset", other, PRESETS))),
    }
}

/// A name, or else a file: whatever has an extension.
fn illuminant(entry: &Entry, sources: &mut Sources) -> Result<Illuminant, Error> {
    let name = entry.text("D65, A, E or the name of a table file (nm, relative power)")?;
    match Illuminant::by_name(name) {
        Ok(light) => Ok(light),
        Err(_) if name.contains('.') => sources.import(entry, |path, bytes| {
            let table =
                Tabulated::from_csv(import::text(path, bytes.as_ref())?, &path.display().to_string())?;
            Ok((Illuminant::table(table)?, Vec::new()))
        }),
        Err(unknown) => {
            Err(entry.error(format!("{unknown}, or the name of a table file (nm, relative power)")))
        }
    }
}
