//! The camera: perspective or orthographic, in a right-handed world in millimetres.

use crate::Error;
use glam::DVec3;

/// The projection of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Rays from one point.
    Perspective {
        /// Full angle across the image height, degrees, in (0, 180).
        fov: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Height of the image in the world, mm.
        height: f64,
    },
}

/// A camera. Pixel (0, 0) is top left; image rows run from the top down.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// The eye (perspective), or the centre of the image plane (orthographic), mm.
    pub position: DVec3,
    /// A point on the image's centre line, mm.
    pub look_at: DVec3,
    /// A direction that is upright in the picture; of any length, not along the view.
    pub up: DVec3,
    /// The projection.
    pub projection: Projection,
}

/// A ray backwards from the eye: `origin + t · direction`, direction of length 1, t in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraRay {
    /// Start, mm.
    pub origin: DVec3,
    /// Unit direction away from the eye.
    pub direction: DVec3,
}

/// A camera prepared for an image size.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    origin: DVec3,
    forward: DVec3,
    /// World step from the image centre to its right edge (at unit distance in perspective).
    right: DVec3,
    /// World step from the image centre to its top edge.
    up: DVec3,
    parallel: bool,
    size: [f64; 2],
}

/// A view as linear maps of a place in the picture, for a device that makes its rays in single precision: the ray through
/// (x, y) pixels to the right of the picture's middle and down from it passes through `centre + right·x + down·y` with
/// the direction `forward + across·x + along·y`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The picture's middle from its top left corner, pixels.
    pub middle: [f64; 2],
    /// How far before the points above the rays begin, in units of their directions.
    pub depth: f64,
    /// mm.
    pub centre: DVec3,
    /// mm a pixel.
    pub right: DVec3,
    /// mm a pixel.
    pub down: DVec3,
    /// Of length 1 in the picture's middle.
    pub forward: DVec3,
    /// Its change a pixel to the right; 0 for parallel rays.
    pub across: DVec3,
    /// Its change a pixel down; 0 for parallel rays.
    pub along: DVec3,
}

impl Camera {
    /// The camera's rays for an image of `width` × `height` pixels.
    ///
    /// # Errors
    /// [`Error::Value`] if the view direction or the extent of the image is undefined.
    pub fn view(&self, width: u32, height: u32) -> Result<View, Error> {
        for (what, v) in
            [("camera.position", self.position), ("camera.look_at", self.look_at), ("camera.up", self.up)]
        {
            if !v.is_finite() || v.abs().max_element() > 1e9 {
                return Err(Error::value(what, v, "three finite numbers, at most 1e9 in size"));
            }
        }
        let forward = (self.look_at - self.position).try_normalize().ok_or_else(|| {
            Error::value("camera.look_at", self.look_at, "a point other than the camera's position")
        })?;
        let sideways = forward.cross(self.up.normalize_or_zero());
        if sideways.length() < 1e-9 {
            let expected = "a direction that is not along the view (looking straight down: up = [0, 1, 0])";
            return Err(Error::value("camera.up", self.up, expected));
        }
        let right = sideways.normalize();
        let half_height = self.half_height()?;
        let aspect = f64::from(width) / f64::from(height);
        Ok(View {
            origin: self.position,
            forward,
            right: right * (half_height * aspect),
            up: right.cross(forward) * half_height,
            parallel: matches!(self.projection, Projection::Orthographic { .. }),
            size: [f64::from(width), f64::from(height)],
        })
    }

    fn half_height(&self) -> Result<f64, Error> {
        match self.projection {
            Projection::Perspective { fov } if fov > 0.0 && fov < 180.0 => Ok((fov.to_radians() / 2.0).tan()),
            Projection::Perspective { fov } => {
                Err(Error::value("camera.fov", fov, "an angle between 0 and 180 degrees"))
            }
            Projection::Orthographic { height } if height > 0.0 && height < 1e9 => Ok(height / 2.0),
            Projection::Orthographic { height } => {
                Err(Error::value("camera.orthographic", height, "an image height in mm, above 0"))
            }
        }
    }
}

impl View {
    /// The ray through image point (`x`, `y`), in pixels from the top left corner: the centre of pixel
    /// (i, j) is (i + ½, j + ½).
    pub fn ray(&self, x: f64, y: f64) -> CameraRay {
        let across = self.right * (2.0 * x / self.size[0] - 1.0) + self.up * (1.0 - 2.0 * y / self.size[1]);
        if self.parallel {
            return CameraRay { origin: self.origin + across, direction: self.forward };
        }
        CameraRay { origin: self.origin, direction: (self.forward + across).normalize() }
    }

    /// The common origin of all rays, or `None` for parallel rays.
    pub fn eye(&self) -> Option<DVec3> {
        (!self.parallel).then_some(self.origin)
    }

    /// The view as linear maps about points beside the origin, which are at least `reach` mm from the eye.
    ///
    /// ```
    /// # use spectral_core::camera::{Camera, Projection};
    /// # use glam::DVec3;
    /// let projection = Projection::Perspective { fov: 20.0 };
    /// let camera = Camera { position: DVec3::Y * -30.0, look_at: DVec3::ZERO, up: DVec3::Z, projection };
    /// let (view, frame) = (camera.view(64, 48)?, camera.view(64, 48)?.frame(4.0));
    /// let (x, y) = (7.5 - frame.middle[0], 11.5 - frame.middle[1]);
    /// let towards = frame.forward + frame.across * x + frame.along * y;
    /// let ray = view.ray(7.5, 11.5);
    /// assert!(ray.direction.abs_diff_eq(towards.normalize(), 1e-12));
    /// let begin = frame.centre + frame.right * x + frame.down * y - towards * frame.depth;
    /// assert!(ray.origin.abs_diff_eq(begin, 1e-12));
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn frame(&self, reach: f64) -> Frame {
        let (right, down) = (self.right * (2.0 / self.size[0]), self.up * (-2.0 / self.size[1]));
        let depth = (-self.origin).dot(self.forward).max(reach);
        // Parallel rays spread at the image plane, others with the distance.
        let [spread, turn] = if self.parallel { [1.0, 0.0] } else { [depth, 1.0] };
        Frame {
            middle: self.size.map(|pixels| pixels / 2.0),
            depth,
            centre: self.origin + self.forward * depth,
            right: right * spread,
            down: down * spread,
            forward: self.forward,
            across: right * turn,
            along: down * turn,
        }
    }

    /// The height of a pixel where a point is, mm.
    pub(crate) fn pixel_at(&self, point: DVec3) -> f64 {
        let distance = if self.parallel { 1.0 } else { point.distance(self.origin) };
        2.0 * self.up.length() * distance / self.size[1]
    }

    /// The same view from another origin.
    pub(crate) fn from(&self, origin: DVec3) -> View {
        View { origin, ..self.clone() }
    }

    /// Where parallel rays begin: the image plane's middle and its direction; `None` for rays from an eye.
    pub(crate) fn plane(&self) -> Option<(DVec3, DVec3)> {
        self.parallel.then_some((self.origin, self.forward))
    }

    /// A point seen by parallel rays: to the right and upwards, −1 to 1 within the picture, and mm before the image plane.
    pub(crate) fn on_plane(&self, point: DVec3) -> DVec3 {
        let from = point - self.origin;
        let share = |axis: DVec3| from.dot(axis) / axis.length_squared();
        DVec3::new(share(self.right), share(self.up), from.dot(self.forward))
    }

    /// The same view with the world's origin moved to `origin`.
    pub(crate) fn seen_from(&self, origin: DVec3) -> View {
        View { origin: self.origin - origin, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        Camera { position: DVec3::new(0.0, -10.0, 0.0), look_at: DVec3::ZERO, up: DVec3::Z, projection }
    }

    #[test]
    fn the_field_of_view_spans_the_height() {
        let view = camera(Projection::Perspective { fov: 90.0 }).view(200, 100).unwrap();
        assert!(view.ray(100.0, 50.0).direction.abs_diff_eq(DVec3::Y, 1e-15));
        let top = view.ray(100.0, 0.0).direction;
        assert!(top.abs_diff_eq(DVec3::new(0.0, 1.0, 1.0).normalize(), 1e-15), "{top}");
        let right = view.ray(200.0, 50.0).direction;
        assert!(right.abs_diff_eq(DVec3::new(2.0, 1.0, 0.0).normalize(), 1e-15), "{right}");
    }

    #[test]
    fn orthographic_rays_are_parallel_and_span_the_height() {
        let view = camera(Projection::Orthographic { height: 8.0 }).view(64, 64).unwrap();
        let ray = view.ray(64.0, 0.0);
        assert_eq!(ray.direction, DVec3::Y);
        assert!(ray.origin.abs_diff_eq(DVec3::new(4.0, -10.0, 4.0), 1e-12));
    }

    #[test]
    fn a_view_along_up_is_refused_with_advice() {
        let mut c = camera(Projection::Perspective { fov: 14.0 });
        c.up = DVec3::Y;
        assert!(c.view(10, 10).unwrap_err().to_string().contains("up = [0, 1, 0]"));
        c = camera(Projection::Perspective { fov: 180.0 });
        assert!(c.view(10, 10).unwrap_err().to_string().contains("between 0 and 180"));
        c.look_at = c.position;
        assert!(c.view(10, 10).unwrap_err().to_string().contains("other than"));
    }
}
