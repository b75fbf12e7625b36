//! `[pose]`: the whole scene made larger, and all its stones turned, without touching where each stands.

use super::fields::{Entry, Fields};
use crate::{Error, shade};
use glam::{DMat3, DVec3, EulerRot};
use spectral_core::camera::{Camera, Projection};
use spectral_core::scene::Stone;

/// How the stones are held.
pub(super) struct Pose<'a> {
    fields: Fields<'a>,
    /// Degrees about +z.
    turn: f64,
    /// Degrees about the camera's horizontal axis.
    tilt: f64,
    /// mm, with the key.
    size: Option<(f64, Entry<'a>)>,
}

pub(super) fn read<'a>(root: &Fields<'a>) -> Result<Option<Pose<'a>>, Error> {
    let Some(entry) = root.get("pose") else { return Ok(None) };
    let fields = entry.fields("[pose]")?;
    let angle = |key| fields.get(key).map_or(Ok(0.0), |e| e.number("an angle in degrees"));
    let (turn, tilt) = (angle("turn")?, angle("tilt")?);
    let size = match fields.get("size") {
        Some(entry) => {
            let expected = "the first stone's width in mm, above 0 and at most 1e6";
            let size = entry.number(expected)?;
            if !(size > 0.0 && size <= 1e6) {
                return Err(entry.refuse(expected));
            }
            Some((size, entry))
        }
        None => None,
    };
    fields.finish()?;
    Ok(Some(Pose { fields, turn, tilt, size }))
}

impl Pose<'_> {
    /// Scales camera and stones, then turns the stones, then tilts them; returns the scale.
    pub fn apply(&self, camera: &mut Camera, stones: &mut [Stone]) -> Result<f64, Error> {
        let scale = self.scale(stones)?;
        if scale != 1.0 {
            enlarge(scale, camera, stones);
        }
        if !stones.is_empty() && (self.turn != 0.0 || self.tilt != 0.0) {
            turn(self.turn, self.tilt, camera, stones).map_err(|e| self.fields.blame(e))?;
        }
        stones.iter().try_for_each(|stone| stone.check_place().map_err(|e| self.fields.blame(e)))?;
        Ok(scale)
    }

    fn scale(&self, stones: &[Stone]) -> Result<f64, Error> {
        match (&self.size, stones.first()) {
            (None, _) => Ok(1.0),
            (Some((size, _)), Some(stone)) => Ok(size / width(stone)),
            (Some((_, entry)), None) => {
                Err(entry.error("'size' is the first stone's width; this scene has no stone"))
            }
        }
    }
}

/// A stone's width before it is turned, mm.
fn width(stone: &Stone) -> f64 {
    stone.width.unwrap_or_else(|| stone.file_width())
}

/// Everything about the world's origin, so that the picture stays but for what depends on thickness.
fn enlarge(scale: f64, camera: &mut Camera, stones: &mut [Stone]) {
    camera.position *= scale;
    camera.look_at *= scale;
    if let Projection::Orthographic { height } = &mut camera.projection {
        *height *= scale;
    }
    for stone in stones {
        stone.width = Some(width(stone) * scale);
        stone.position *= scale;
    }
}

/// About the middle of the box around all stones as they stand: first about +z, then about the camera's axis to the
/// right, so that with a positive tilt what is upright in the picture comes towards the eye.
fn turn(turn: f64, tilt: f64, camera: &Camera, stones: &mut [Stone]) -> Result<(), spectral_core::Error> {
    let (low, high) = shade::bounds(stones)?;
    let centre = (low + high) / 2.0;
    let onto = DMat3::from_rotation_z(turn.to_radians());
    for stone in stones.iter_mut() {
        stone.rotation.z += turn;
        stone.position = centre + onto * (stone.position - centre);
    }
    let right = (camera.look_at - camera.position).cross(camera.up).normalize_or_zero();
    if tilt == 0.0 || right == DVec3::ZERO {
        return Ok(());
    }
    let over = DMat3::from_axis_angle(right, tilt.to_radians());
    for stone in stones {
        let angles = stone.rotation * std::f64::consts::PI / 180.0;
        // A stone turns about x, then y, then z: the matrix is Z Y X.
        let (z, y, x) =
            (over * DMat3::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x)).to_euler(EulerRot::ZYX);
        stone.rotation = DVec3::new(x, y, z) * 180.0 / std::f64::consts::PI;
        stone.position = centre + over * (stone.position - centre);
    }
    Ok(())
}
