//! Where the camera stands.

use super::overlay::lay;
use toml::{Table, Value};

/// A camera by its keys, or by two angles about what the base scene's camera looks at.
#[derive(Debug, Clone, PartialEq)]
pub struct Viewpoint {
    pub angles: Option<Angles>,
    /// Keys of `[camera]`, laid over the base scene's.
    pub keys: Table,
}

/// A direction to look from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// Degrees counter-clockwise seen from +z; 0 looks from −y, as the base scenes do.
    pub azimuth: f64,
    /// Degrees above the girdle; 90 looks straight down on the table.
    pub elevation: f64,
    /// Millimetres from what is looked at; as far as the base scene's camera if `None`.
    pub distance: Option<f64>,
}

/// Coordinates are rounded to this many parts of a millimetre: what sine and cosine leave in the last digit differs
/// from one system's library to the next, and the same sweep must be the same scenes everywhere.
const PARTS: f64 = 1e9;

impl Viewpoint {
    /// Sets up a camera.
    ///
    /// # Errors
    /// What the camera lacks for it.
    pub fn apply(&self, camera: &mut Table) -> Result<(), String> {
        // One kind of projection takes the place of the other.
        let projections = ["fov", "orthographic"];
        if projections.iter().any(|key| self.keys.contains_key(*key)) {
            projections.iter().for_each(|key| drop(camera.remove(*key)));
        }
        lay(camera, &self.keys);
        let Some(angles) = self.angles else { return Ok(()) };
        let look_at = point(camera, "look_at")?.unwrap_or_default();
        let position = point(camera, "position")?;
        let from = |position: [f64; 3]| {
            position.iter().zip(look_at).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let distance = angles.distance.or(position.map(from)).filter(|distance| *distance > 0.0);
        let distance =
            distance.ok_or("a view by angles needs a distance: its own, or that of the base camera")?;
        let (sin_a, cos_a) = angles.azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = angles.elevation.to_radians().sin_cos();
        let direction = [sin_a * cos_e, -cos_a * cos_e, sin_e];
        // Where the direction moves as the elevation grows, so that straight down is no exception.
        let up = [-sin_a * sin_e, cos_a * sin_e, cos_e];
        let position = [0, 1, 2].map(|i| look_at[i] + distance * direction[i]);
        for (key, value) in [("position", position), ("look_at", look_at), ("up", up)] {
            let list = value.map(|v| Value::Float((v * PARTS).round() / PARTS + 0.0));
            camera.insert(key.to_owned(), Value::Array(list.to_vec()));
        }
        Ok(())
    }
}

fn point(camera: &Table, key: &str) -> Result<Option<[f64; 3]>, String> {
    let Some(value) = camera.get(key) else { return Ok(None) };
    let number = |v: &Value| v.as_float().or_else(|| v.as_integer().map(|i| i as f64));
    let list: Option<Vec<f64>> = value.as_array().and_then(|list| list.iter().map(number).collect());
    let wrong = || format!("'{key}' of the camera is no list of three numbers");
    list.and_then(|list| list.try_into().ok()).map(Some).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(azimuth: f64, elevation: f64) -> Table {
        let mut camera: Table = toml::from_str("position = [0, -6, 9]\nlook_at = [0, 0, 1]").unwrap();
        let angles = Some(Angles { azimuth, elevation, distance: None });
        Viewpoint { angles, keys: Table::new() }.apply(&mut camera).unwrap();
        camera
    }

    #[test]
    fn angles_go_about_what_is_looked_at() {
        let camera = |position: &str, up: &str| {
            toml::from_str::<Table>(&format!("position = {position}\nlook_at = [0.0, 0.0, 1.0]\nup = {up}"))
                .unwrap()
        };
        assert_eq!(seen(0.0, 90.0), camera("[0.0, 0.0, 11.0]", "[0.0, 1.0, 0.0]"));
        assert_eq!(seen(0.0, 0.0), camera("[0.0, -10.0, 1.0]", "[0.0, 0.0, 1.0]"));
        assert_eq!(seen(90.0, 0.0), camera("[10.0, 0.0, 1.0]", "[0.0, 0.0, 1.0]"));
        assert_eq!(seen(0.0, 30.0)["position"], camera("[0.0, -8.660254038, 6.0]", "[0]")["position"]);
    }

    #[test]
    fn a_projection_takes_the_place_of_the_other() {
        let mut camera: Table = toml::from_str("fov = 14.0\nposition = [0, 0, 1]").unwrap();
        let keys = toml::from_str("orthographic = 8.0").unwrap();
        Viewpoint { angles: None, keys }.apply(&mut camera).unwrap();
        assert_eq!(camera, toml::from_str("orthographic = 8.0\nposition = [0, 0, 1]").unwrap());
    }
}
