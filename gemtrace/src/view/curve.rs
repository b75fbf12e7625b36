//! Light return over tilt, as `gemtrace measure` has it, of the stone that is shown.

use super::message::Question;
use super::sight::Sight;
use super::solid::Solid;
use super::watch::Patience;
use crate::measure::{Conditions, Figures, Measurement};
use crate::{Error, Session, registry};
use serde_json::{Value, json};
use spectral_core::environment::Pattern;
use spectral_core::scene::Stone;
use spectral_core::tracer::OpenOptions;
use spectral_core::wavelength::WavelengthGrid;

/// Tilts, degrees.
const FROM: i32 = -30;
const STEP: i32 = 5;
const STEPS: i32 = 13;
/// Rays along an edge of the raster, and their wavelengths: coarse, within a percent of the light.
const RAYS: u32 = 64;
const WAVELENGTHS: usize = 4;
/// What measures: one thread, which rests where pictures are rendered.
///
/// # Errors
/// [`Error::Usage`] where there is no processor to render on.
pub fn session() -> Result<Session, Error> {
    let open = OpenOptions { threads: Some(1), ..OpenOptions::default() };
    Ok(Session::new(registry::choose("cpu", None)?, open))
}

/// The message `curve`; `None` where another question has overtaken this one. The session keeps the light models.
///
/// # Errors
/// As [`Measurement::at`].
pub fn answer(
    sight: &Sight,
    question: &Question,
    session: &mut Session,
    watch: &mut Patience,
) -> Result<Option<Value>, Error> {
    let Question::Curve { id, .. } = *question else { return Ok(None) };
    let Some(stone) = sight.loaded.scene.stones.first() else { return Ok(None) };
    // As the scene has it, whatever its pose.
    let rotation = Solid::new(&sight.loaded, sight.setup.pose()).rotation(stone);
    let stone = Stone { rotation, ..stone.clone() };
    let defaults = Conditions::default();
    let settings = spectral_core::settings::RenderSettings {
        wavelengths: WavelengthGrid::midpoints([400.0, 700.0], WAVELENGTHS)?,
        ..defaults.settings.clone()
    };
    let conditions = Conditions { models: vec![Pattern::Iso], size: RAYS, settings, ..defaults };
    let mut measurement = Measurement::new(&stone, &conditions, session)?;
    let (mut tilts, mut values, mut figures) = (Vec::new(), Vec::new(), Value::Null);
    for step in 0..STEPS {
        let tilt = f64::from(FROM + STEP * step);
        let position = match measurement.at(tilt, watch) {
            Ok(position) => position,
            Err(Error::Interrupted) => return Ok(None),
            Err(error) => return Err(error),
        };
        if tilt == 0.0 {
            figures = face_up(&position.stone);
        }
        tilts.push(tilt);
        values.push(100.0 * position.stone.light_return[0]);
    }
    Ok(Some(json!({
        "type": "curve", "id": id, "tilts": tilts, "values": values, "figures": figures,
        "label": "%, ISO, a head of 10°",
    })))
}

/// The figures of a stone whose table is turned to the eye.
fn face_up(seen: &Figures) -> Value {
    let figure = |label: &str, share: f64| json!({ "label": label, "value": 100.0 * share, "unit": "%" });
    json!([
        figure("Return", seen.light_return[0]),
        figure("Leakage", seen.leakage),
        figure("Head shadow", seen.extinction),
        figure("Contrast", seen.contrast),
    ])
}
