//! Rays that are linear in the place in the picture.

use crate::camera::View;
use glam::DVec3;

/// The rays about one ray: to first order, the ray of the place (u, v) begins at `origin + u·origin_by[0] + v·origin_by[1]`
/// and has the direction `direction + u·direction_by[0] + v·direction_by[1]`. Lengths in mm, places in pixels.
///
/// On the way, with p the origins, d the directions, ∂ a derivative by u or v, and n·x = o a plane:
///
/// ```text
/// at the plane     t = (o − n·p)/(n·d)           H = p + t d          ∂t = −(n·∂p + t n·∂d)/(n·d)     ∂H = ∂p + ∂t d + t ∂d
/// reflected        d' = d − 2 (n·d) n                                 ∂d' = ∂d − 2 (n·∂d) n
/// refracted        d' = η d + (η c − c') n,  c = −n·d,  c'² = 1 − η² (1 − c²)
///                  ∂d' = η ∂d + (η ∂c − ∂c') n,  ∂c = −n·∂d,  ∂c' = η² c ∂c/c'
/// ```
///
/// The derivatives of directions are perpendicular to the ray: directions stay of length 1 to first order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pencil {
    /// Where the ray begins.
    pub origin: DVec3,
    /// Its direction, of length 1.
    pub direction: DVec3,
    /// The origin's derivatives by u and v, mm a pixel.
    pub origin_by: [DVec3; 2],
    /// The direction's derivatives by u and v, 1 a pixel.
    pub direction_by: [DVec3; 2],
}

/// A value that is linear in (u, v).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Its value at u = v = 0.
    pub value: f64,
    /// Its derivatives.
    pub by: [f64; 2],
}

impl Line {
    /// The value at a place.
    pub fn at(&self, [u, v]: [f64; 2]) -> f64 {
        self.value + u * self.by[0] + v * self.by[1]
    }
}

impl Pencil {
    /// A camera's rays about the ray through (x, y), pixels from the picture's top left corner.
    ///
    /// ```
    /// # use spectral_core::{beam::Pencil, camera::{Camera, Projection}};
    /// # use glam::DVec3;
    /// let projection = Projection::Perspective { fov: 20.0 };
    /// let camera = Camera { position: DVec3::Y * -30.0, look_at: DVec3::ZERO, up: DVec3::Z, projection };
    /// let view = camera.view(64, 48)?;
    /// let pencil = Pencil::of_camera(&view, [7.5, 11.5]);
    /// let ray = view.ray(7.6, 11.5);
    /// assert!(ray.direction.abs_diff_eq(pencil.direction + 0.1 * pencil.direction_by[0], 1e-6));
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn of_camera(view: &View, [x, y]: [f64; 2]) -> Self {
        let ray = view.ray(x, y);
        // Without a least distance: only derivatives are asked for, per unit of it.
        let frame = view.frame(1.0);
        if view.eye().is_none() {
            let origin_by = [frame.right, frame.down];
            let direction_by = [DVec3::ZERO; 2];
            return Pencil { origin: ray.origin, direction: ray.direction, origin_by, direction_by };
        }
        // The direction before it is made of length 1 is linear.
        let [x, y] = [x - frame.middle[0], y - frame.middle[1]];
        let length = (frame.forward + frame.across * x + frame.along * y).length();
        let direction_by = [frame.across, frame.along].map(|by| across(ray.direction, by / length));
        Pencil { origin: ray.origin, direction: ray.direction, origin_by: [DVec3::ZERO; 2], direction_by }
    }

    /// The same rays about that of another place, which is (0, 0) from then on.
    #[must_use]
    pub fn about(&self, [u, v]: [f64; 2]) -> Self {
        let [along, down] = self.direction_by;
        let direction = self.direction + u * along + v * down;
        let length = direction.length();
        let direction = direction / length;
        Pencil {
            origin: self.origin + u * self.origin_by[0] + v * self.origin_by[1],
            direction,
            direction_by: self.direction_by.map(|by| across(direction, by / length)),
            ..*self
        }
    }

    /// The distance to the plane `normal`·x = `offset` along the ray, mm.
    pub fn distance(&self, normal: DVec3, offset: f64) -> f64 {
        (offset - normal.dot(self.origin)) / normal.dot(self.direction)
    }

    /// The same rays, beginning in the plane `normal`·x = `offset`.
    #[must_use]
    pub fn at_plane(&self, normal: DVec3, offset: f64) -> Self {
        let (distance, towards) = (self.distance(normal, offset), normal.dot(self.direction));
        let moved = |k: usize| {
            let (by, turn) = (self.origin_by[k], self.direction_by[k]);
            let farther = -(normal.dot(by) + distance * normal.dot(turn)) / towards;
            by + farther * self.direction + distance * turn
        };
        let origin = self.origin + distance * self.direction;
        Pencil { origin, origin_by: [moved(0), moved(1)], ..*self }
    }

    /// What a mirror of this normal, of length 1, makes of it; the origins must lie in it.
    #[must_use]
    pub fn reflected(&self, normal: DVec3) -> Self {
        let mirrored = |v: DVec3| v - 2.0 * normal.dot(v) * normal;
        Pencil { direction: mirrored(self.direction), direction_by: self.direction_by.map(mirrored), ..*self }
    }

    /// What a plane surface refracts of it, the origins lying in it. `normal` has length 1 and points against the rays;
    /// `eta` is the index here over that beyond, `cos_t` the cosine of refraction, above 0.
    #[must_use]
    pub fn refracted(&self, normal: DVec3, eta: f64, cos_t: f64) -> Self {
        let cos_i = -normal.dot(self.direction);
        let direction = (self.direction * eta + normal * (eta * cos_i - cos_t)).normalize();
        let turned = |by: DVec3| {
            let cos_i_by = -normal.dot(by);
            let cos_t_by = eta * eta * cos_i * cos_i_by / cos_t;
            across(direction, by * eta + normal * (eta * cos_i_by - cos_t_by))
        };
        Pencil { direction, direction_by: self.direction_by.map(turned), ..*self }
    }

    /// How far the origins lie before the plane `normal`·x = `offset`, along its normal: mm, to first order.
    pub fn before(&self, normal: DVec3, offset: f64) -> Line {
        Line { value: normal.dot(self.origin) - offset, by: self.origin_by.map(|by| normal.dot(by)) }
    }
}

/// The part of a vector that is perpendicular to a direction.
fn across(direction: DVec3, vector: DVec3) -> DVec3 {
    vector - direction * direction.dot(vector)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Projection};

    fn views() -> [View; 2] {
        [Projection::Perspective { fov: 30.0 }, Projection::Orthographic { height: 8.0 }].map(|projection| {
            let [position, look_at] = [DVec3::new(3.0, -12.0, 9.0), DVec3::new(0.2, 0.1, -0.3)];
            Camera { position, look_at, up: DVec3::Z, projection }.view(80, 60).unwrap()
        })
    }

    const PLANE: (DVec3, f64) = (DVec3::new(0.6, -0.48, 0.64), 1.5);

    /// The ray of a place, on its way by itself: to a plane, into glass, to another plane and back.
    fn followed(view: &View, [x, y]: [f64; 2]) -> [DVec3; 2] {
        let ray = view.ray(x, y);
        let (n, offset) = PLANE;
        let p = ray.origin + (offset - n.dot(ray.origin)) / n.dot(ray.direction) * ray.direction;
        let (eta, cos_i) = (1.0 / 1.7, -n.dot(ray.direction));
        let cos_t = (1.0 - eta * eta * (1.0 - cos_i * cos_i)).sqrt();
        let d = eta * ray.direction + (eta * cos_i - cos_t) * n;
        let p = p + (-2.0 - p.z) / d.z * d;
        [p, DVec3::new(d.x, d.y, -d.z)]
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        const STEP: f64 = 1e-4;
        for view in views() {
            for place in [[40.0, 30.0], [11.5, 47.25]] {
                let (n, offset) = PLANE;
                let entry = Pencil::of_camera(&view, place).at_plane(n, offset);
                let cos_i = -n.dot(entry.direction);
                let cos_t = (1.0 - (1.0 - cos_i * cos_i) / 1.7 / 1.7).sqrt();
                let there = entry.refracted(n, 1.0 / 1.7, cos_t).at_plane(DVec3::Z, -2.0).reflected(DVec3::Z);
                let [origin, direction] = followed(&view, place);
                assert!(there.origin.abs_diff_eq(origin, 1e-12));
                assert!(there.direction.abs_diff_eq(direction, 1e-12));
                for k in 0..2 {
                    let at = |sign: f64| {
                        let mut place = place;
                        place[k] += sign * STEP;
                        followed(&view, place)
                    };
                    let ([p, d], [q, e]) = (at(1.0), at(-1.0));
                    assert!(there.origin_by[k].abs_diff_eq((p - q) / (2.0 * STEP), 1e-9));
                    assert!(there.direction_by[k].abs_diff_eq((d - e) / (2.0 * STEP), 1e-9));
                }
            }
        }
    }

    #[test]
    fn rays_about_another_place_are_the_same_rays() {
        for view in views() {
            let pencil = Pencil::of_camera(&view, [40.0, 30.0]).at_plane(PLANE.0, PLANE.1);
            // Near enough that the second order is small.
            let moved = pencil.about([0.04, -0.03]);
            let there = Pencil::of_camera(&view, [40.04, 29.97]).at_plane(PLANE.0, PLANE.1);
            assert!(moved.origin.abs_diff_eq(there.origin, 1e-5), "{} {}", moved.origin, there.origin);
            assert!(moved.direction.abs_diff_eq(there.direction, 1e-7));
            assert!((moved.direction.length() - 1.0).abs() < 1e-15);
            assert!(moved.direction_by.iter().all(|by| by.dot(moved.direction).abs() < 1e-16));
            let line = moved.before(DVec3::X, 0.25);
            let place = moved.origin + 0.1 * moved.origin_by[0] - 0.2 * moved.origin_by[1];
            assert!((line.at([0.1, -0.2]) - (place.x - 0.25)).abs() < 1e-14);
        }
    }
}
