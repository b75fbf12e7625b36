//! The two directions in which a ray goes on from a surface.

use glam::Vec3;

/// One Newton step towards length 1: keeps the rounding of a hundred reflections from adding up.
#[inline]
fn renormalized(v: Vec3) -> Vec3 {
    v * (1.5 - 0.5 * v.dot(v))
}

/// Mirrored at a surface of unit `normal`, either way round.
#[inline]
pub(crate) fn reflected(direction: Vec3, normal: Vec3) -> Vec3 {
    renormalized(direction - normal * (2.0 * direction.dot(normal)))
}

/// Refracted by Snell's law. `normal` points to the side the ray comes from; `eta` is the index on that side
/// over the one beyond; the cosines are both positive.
#[inline]
pub(crate) fn refracted(direction: Vec3, normal: Vec3, cos_i: f32, cos_t: f32, eta: f32) -> Vec3 {
    renormalized(direction * eta + normal * (eta * cos_i - cos_t))
}
