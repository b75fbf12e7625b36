//! `[render]`.

use super::fields::{Entry, Fields, either};
use crate::Error;
use spectral_core::settings::{Coverage, Leftover, Quality, RenderSettings};
use spectral_core::wavelength::WavelengthGrid;
use toml::de::DeValue;

pub(super) fn read(root: &Fields) -> Result<RenderSettings, Error> {
    let mut settings = RenderSettings::default();
    let Some(entry) = root.get("render") else { return Ok(settings) };
    let fields = entry.fields("[render]")?;
    if let Some(entry) = fields.get("quality") {
        let name = entry.text(&format!("one of {}", either(&Quality::ALL.map(Quality::name))))?;
        settings = settings.at(Quality::by_name(name).map_err(|e| entry.error(e))?);
    }
    if let Some(entry) = fields.get("coverage") {
        let name = entry.text(&format!("one of {}", either(&Coverage::ALL.map(Coverage::name))))?;
        settings.coverage = Coverage::by_name(name).map_err(|e| entry.error(e))?;
    }
    if let Some(entry) = fields.get("samples") {
        settings = settings.with_samples(entry.whole("a whole number of samples a pixel")?);
    }
    let mut jitter = None;
    if let Some(entry) = fields.get("wavelengths") {
        (settings.wavelengths, jitter) = wavelengths(&entry, &settings.wavelengths)?;
    }
    if let Some(entry) = fields.get("jitter") {
        if jitter.is_some() {
            return Err(entry.error("'jitter' is given twice: in [render] and in wavelengths"));
        }
        jitter = Some((entry.flag()?, entry));
    }
    settings.jitter = match jitter {
        Some((true, entry)) if !settings.wavelengths.can_jitter() => {
            return Err(entry
                .error("a list of wavelengths cannot jitter; give a count and a range, or jitter = false"));
        }
        Some((flag, _)) => flag,
        None => settings.jitter && settings.wavelengths.can_jitter(),
    };
    if let Some(entry) = fields.get("tolerance") {
        settings = settings.with_tolerance(entry.number("a colour difference from 0 to 100")?);
    }
    if let Some(entry) = fields.get("max_depth") {
        settings.max_depth = entry.whole("a whole number of surface events")?;
    }
    if let Some(entry) = fields.get("leftover") {
        let name = entry.text(&format!("one of {}", either(&Leftover::ALL.map(Leftover::name))))?;
        settings.leftover = Leftover::by_name(name).map_err(|e| entry.error(e))?;
    }
    if let Some(entry) = fields.get("threshold") {
        settings.threshold = entry.number("a throughput from 0 up to, not including, 1")?;
    }
    if let Some(entry) = fields.get("split") {
        let expected = "a throughput from 0 (follow every mode) up to, not including, 1";
        settings = settings.with_split(entry.number(expected)?);
    }
    for (key, slot) in [("polarized", &mut settings.polarized), ("spectral", &mut settings.spectral)] {
        if let Some(entry) = fields.get(key) {
            *slot = entry.flag()?;
        }
    }
    if settings.spectral && fields.get("wavelengths").is_none() {
        settings.wavelengths = WavelengthGrid::default();
    }
    fields.finish()?;
    settings.validate().map_err(|e| fields.blame(e))?;
    Ok(settings)
}

/// The grid, its count and range by default another's, and whether it says itself that it jitters.
fn wavelengths<'a>(
    entry: &Entry<'a>,
    default: &WavelengthGrid,
) -> Result<(WavelengthGrid, Option<(bool, Entry<'a>)>), Error> {
    let expected = "wavelengths: { count = 32, range = [380.0, 740.0] } or a list, nm";
    match entry.value.get_ref() {
        DeValue::Table(_) => {
            let fields = entry.fields("wavelengths")?;
            let count =
                fields.get("count").map_or(Ok(default.len() as u32), |e| e.whole("a whole number"))?;
            let ends = "two wavelengths [from, to], nm";
            let range = fields.get("range").map_or(Ok(default.range()), |e| e.vector(ends))?;
            let jitter = fields.get("jitter").map(|e| Ok::<_, Error>((e.flag()?, e))).transpose()?;
            fields.finish()?;
            let grid = WavelengthGrid::midpoints(range, count as usize).map_err(|e| entry.error(e))?;
            Ok((grid, jitter))
        }
        DeValue::Array(_) => {
            let grid = WavelengthGrid::list(entry.numbers(expected)?).map_err(|e| entry.error(e))?;
            Ok((grid, None))
        }
        _ => Err(entry.refuse(expected)),
    }
}
