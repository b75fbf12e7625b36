//! Rays and hits.

use glam::Vec3;

/// The points `origin + t·direction` with `t` between `t_min` and `t_max`.
///
/// The direction need not have unit length: `t` is in units of its length. `t_min` may be negative: the interval of a
/// ray that starts on a surface begins a little behind it, because the starting point is rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is 0, in the mesh's units.
    pub origin: Vec3,
    /// The displacement for an increase of `t` by 1.
    pub direction: Vec3,
    /// Smallest parameter of a hit, inclusive; may be negative or −∞.
    pub t_min: f32,
    /// Largest parameter of a hit, inclusive; may be ∞.
    pub t_max: f32,
}

impl Ray {
    /// The half-line from `origin`: parameters from 0 to ∞.
    pub fn new(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// Whether origin and direction are finite and the direction is not zero.
    #[inline(always)]
    pub(crate) fn is_proper(&self) -> bool {
        self.origin.is_finite() && self.direction.is_finite() && self.direction != Vec3::ZERO
    }

    /// The point at parameter `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Where a ray meets a triangle.
///
/// With corners `a`, `b`, `c` the point is `(1 − u − v)·a + u·b + v·c`; `u` and `v` are at least 0 and their
/// sum at most 1, up to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray parameter, rounded once from double precision.
    pub t: f32,
    /// The triangle's index in the mesh that the hierarchy was built from.
    pub triangle: u32,
    /// Weight of the triangle's second corner.
    pub u: f32,
    /// Weight of the triangle's third corner.
    pub v: f32,
}
