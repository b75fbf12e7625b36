//! `[environment]`.

use super::fields::{Entry, Fields};
use super::source::Sources;
use crate::{Error, import};
use glam::DVec3;
use spectral_core::camera::Camera;
use spectral_core::cie::Illuminant;
use spectral_core::environment::{Environment, Head, LatLong, LightModel, Pattern};
use spectral_core::spectrum::Tabulated;
use std::sync::{Arc, LazyLock};

const PRESETS: [&str; 1] = ["studio"];

pub(super) fn read(root: &Fields, sources: &mut Sources, camera: &Camera) -> Result<Environment, Error> {
    let Some(entry) = root.get("environment") else { return Ok(studio()) };
    let fields = entry.fields("[environment]")?;
    let mut environment = match fields.one_of(&["image", "uniform", "preset", "model"])? {
        #[cfg(feature = "formats")]
        Some(("image", entry)) => Environment::image(sources.import(&entry, import::environment::read)?),
        #[cfg(not(feature = "formats"))]
        Some(("image", entry)) => return Err(entry.error("images need the feature 'formats'")),
        Some(("uniform", entry)) => Environment::uniform(entry.vector("three linear sRGB values [r, g, b]")?),
        Some(("preset", entry)) => preset(&entry)?,
        Some((_, entry)) => {
            let model = model(&fields, &entry, camera)?;
            Environment::image(sources.drawn(&model).map_err(|e| fields.blame(e))?)
        }
        None => studio(),
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

/// The built-in studio, drawn once.
fn studio() -> Environment {
    static STUDIO: LazyLock<Arc<LatLong>> = LazyLock::new(|| Arc::new(LatLong::studio()));
    Environment::image(Arc::clone(&STUDIO))
}

fn preset(entry: &Entry) -> Result<Environment, Error> {
    match entry.text("the name of a built-in environment: 'studio'")? {
        "studio" => Ok(studio()),
        other => Err(entry.error(spectral_core::Error::unknown("environment preset", other, PRESETS))),
    }
}

/// A light model; only the keys that it knows are asked for, so that others are refused with these.
fn model(fields: &Fields, entry: &Entry, camera: &Camera) -> Result<LightModel, Error> {
    let name = entry.text("the name of a light model, such as 'iso', 'cos' or 'aset'")?;
    let mut pattern = Pattern::by_name(name).map_err(|e| entry.error(e))?;
    match &mut pattern {
        Pattern::RandomPatch { seed } => {
            if let Some(entry) = fields.get("seed") {
                *seed = entry.whole("a whole number from 0 upwards")?;
            }
        }
        Pattern::Dome { half_angle } => {
            if let Some(entry) = fields.get("half_angle") {
                *half_angle = entry.number("an angle from the zenith, degrees")?;
            }
        }
        Pattern::Spots { count, radius } => {
            if let Some(entry) = fields.get("count") {
                *count = entry.whole("a whole number of spots")?;
            }
            if let Some(entry) = fields.get("radius") {
                *radius = entry.number("the half-angle of a spot, degrees")?;
            }
        }
        Pattern::Iso | Pattern::Cos | Pattern::Sc2 | Pattern::Aset | Pattern::IdealScope => {}
    }
    let mut model = LightModel::new(pattern);
    let towards = (camera.position - camera.look_at).normalize_or(DVec3::Z);
    if let Some(entry) = fields.get("zenith") {
        model.zenith = zenith(&entry, towards)?;
    }
    if let Some(entry) = fields.get("head_shadow") {
        let half_angle = entry.number("the half-angle of the viewer's head, degrees")?;
        model.head = Some(Head { half_angle, towards });
    }
    if let Some(entry) = fields.get("below") {
        model.below = entry.vector("three linear sRGB values [r, g, b]")?;
    }
    Ok(model)
}

/// A direction, or that of the camera.
fn zenith(entry: &Entry, camera: DVec3) -> Result<DVec3, Error> {
    let expected = "a direction [x, y, z], or \"camera\"";
    if entry.value.get_ref().as_str() == Some("camera") {
        return Ok(camera);
    }
    let direction = DVec3::from(entry.vector(expected)?);
    direction.try_normalize().ok_or_else(|| entry.refuse(expected))
}

/// A name, or else a file: whatever has an extension.
fn illuminant(entry: &Entry, sources: &mut Sources) -> Result<Illuminant, Error> {
    let name = entry.text("D65, A, E or the name of a table file (nm, relative power)")?;
    match Illuminant::by_name(name) {
        Ok(light) => Ok(light),
        Err(_) if name.contains('.') => sources
            .import(entry, |path, bytes| {
                let table = Tabulated::from_csv(&import::text(path, &bytes)?, &path.display().to_string())?;
                Ok((Illuminant::table(table)?, Vec::new()))
            })
            .map(Arc::unwrap_or_clone),
        Err(unknown) => {
            Err(entry.error(format!("{unknown}, or the name of a table file (nm, relative power)")))
        }
    }
}
