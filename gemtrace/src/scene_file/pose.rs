//! `[pose]`: the whole scene made larger, and all its stones turned, without touching where each stands.

use super::fields::{Entry, Fields};
use crate::{Error, shade};
use glam::{DMat3, DVec3, EulerRot};
use spectral_core::camera::{Camera, Projection};
use spectral_core::scene::Stone;

/// How the stones are held.
pub(super) struct Pose<'a> {
    fields: Fields<'a>,
    /// Degrees about x, then y, then z.
    rotation: DVec3,
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
    let rotation = match fields.get("rotation") {
        Some(entry) => entry.vector("three angles [x, y, z], degrees")?.into(),
        None => DVec3::ZERO,
    };
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
    Ok(Some(Pose { fields, rotation, turn, tilt, size }))
}

impl Pose<'_> {
    /// Scales camera and stones, then rotates, turns and tilts the stones; returns the scale.
    pub fn apply(&self, camera: &mut Camera, stones: &mut [Stone]) -> Result<f64, Error> {
        let scale = self.scale(stones)?;
        if scale != 1.0 {
            enlarge(scale, camera, stones);
        }
        if let Some(centre) = middle(stones).map_err(|e| self.fields.blame(e))? {
            if self.rotation != DVec3::ZERO {
                rotate(of_degrees(self.rotation), centre, stones);
            }
            if self.turn != 0.0 || self.tilt != 0.0 {
                turn(self.turn, self.tilt, camera, centre, stones);
            }
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

/// The middle of the box around all stones as they stand, about which they are turned.
pub(super) fn middle(stones: &[Stone]) -> Result<Option<DVec3>, spectral_core::Error> {
    let (low, high) = shade::bounds(stones)?;
    Ok((!stones.is_empty()).then(|| (low + high) / 2.0))
}

/// A rotation about x, then y, then z, by degrees.
fn of_degrees(angles: DVec3) -> DMat3 {
    let angles = angles * std::f64::consts::PI / 180.0;
    DMat3::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x)
}

/// The stones turned by a rotation about a point.
fn rotate(over: DMat3, centre: DVec3, stones: &mut [Stone]) {
    for stone in stones {
        // A stone turns about x, then y, then z: the matrix is Z Y X.
        let (z, y, x) = (over * of_degrees(stone.rotation)).to_euler(EulerRot::ZYX);
        stone.rotation = DVec3::new(x, y, z) * 180.0 / std::f64::consts::PI;
        stone.position = centre + over * (stone.position - centre);
    }
}

/// First about +z, then about the camera's axis to the right, so that with a positive tilt what is upright in the
/// picture comes towards the eye.
fn turn(turn: f64, tilt: f64, camera: &Camera, centre: DVec3, stones: &mut [Stone]) {
    let onto = DMat3::from_rotation_z(turn.to_radians());
    for stone in stones.iter_mut() {
        stone.rotation.z += turn;
        stone.position = centre + onto * (stone.position - centre);
    }
    let right = (camera.look_at - camera.position).cross(camera.up).normalize_or_zero();
    if tilt != 0.0 && right != DVec3::ZERO {
        rotate(DMat3::from_axis_angle(right, tilt.to_radians()), centre, stones);
    }
}
