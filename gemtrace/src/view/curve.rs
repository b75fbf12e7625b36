//! Light return over tilt, as `gemtrace measure` has it, of the stone that is shown.

use super::message::Question;
use super::sight::Sight;
use super::solid::Solid;
use crate::measure::{Conditions, Measurement};
use crate::{Error, Session, Watch, registry};
use serde_json::{Value, json};
use spectral_core::environment::Pattern;
use spectral_core::scene::Stone;
use spectral_core::tracer::{OpenOptions, Progress};
use spectral_core::wavelength::WavelengthGrid;
use std::ops::ControlFlow;
use std::time::Duration;

/// Tilts, degrees.
const FROM: i32 = -30;
const STEP: i32 = 5;
const STEPS: i32 = 13;
/// Rays along an edge of the raster, and their wavelengths: coarse, within a percent of the light.
const RAYS: u32 = 64;
const WAVELENGTHS: usize = 4;
/// How long it rests where pictures are rendered.
const REST: Duration = Duration::from_millis(5);

/// Lets pictures go first, and ends where it is no longer asked for.
struct Patience<'a> {
    busy: &'a dyn Fn() -> bool,
    overtaken: &'a dyn Fn() -> bool,
}

impl Watch for Patience<'_> {
    fn progress(&mut self, _: Progress) -> ControlFlow<()> {
        while (self.busy)() && !(self.overtaken)() {
            std::thread::sleep(REST);
        }
        if (self.overtaken)() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// The message `curve`; `None` where another question has overtaken this one.
///
/// # Errors
/// As [`Measurement::at`].
pub fn answer(
    sight: &Sight,
    question: &Question,
    busy: &dyn Fn() -> bool,
    overtaken: &dyn Fn() -> bool,
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
    // One thread: it rests where pictures are rendered.
    let open = OpenOptions { threads: Some(1), ..OpenOptions::default() };
    let mut session = Session::new(registry::choose("cpu", None)?, open);
    let mut measurement = Measurement::new(&stone, &conditions, &mut session)?;
    let mut watch = Patience { busy, overtaken };
    let (mut tilts, mut values, mut figures) = (Vec::new(), Vec::new(), Value::Null);
    for step in 0..STEPS {
        let tilt = f64::from(FROM + STEP * step);
        let position = match measurement.at(tilt, &mut watch) {
            Ok(position) => position,
            Err(Error::Interrupted) => return Ok(None),
            Err(error) => return Err(error),
        };
        let seen = &position.stone;
        if tilt == 0.0 {
            let figure =
                |label: &str, share: f64| json!({ "label": label, "value": 100.0 * share, "unit": "%" });
            figures = json!([
                figure("Return", seen.light_return[0]),
                figure("Leakage", seen.leakage),
                figure("Head shadow", seen.extinction),
                figure("Contrast", seen.contrast),
            ]);
        }
        tilts.push(tilt);
        values.push(100.0 * seen.light_return[0]);
    }
    Ok(Some(json!({
        "type": "curve", "id": id, "tilts": tilts, "values": values, "figures": figures,
        "label": "Light return, %, ISO, a head of 10°",
    })))
}
