//! The slab test of a node's eight children against one ray.

#[cfg(target_arch = "x86_64")]
mod x86;

use crate::Ray;
use glam::Vec3;
use obvhs::cwbvh::node::CwBvhNode;
#[cfg(target_arch = "x86_64")]
pub use x86::Eight;

/// `δ / R`, see `traverse`: 48 · 2⁻²⁴.
pub(crate) const WIDENING: f32 = 48.0 / 16_777_216.0;
/// Largest `|i|` in units of `1 / |direction|∞`.
pub(crate) const STEEPEST: f32 = 8_388_608.0;

/// A ray in the builder's units with its direction scaled to a largest component of 1. Slab distances are then of the
/// size of the mesh.
#[derive(Clone, Copy, Debug)]
pub struct ScaledRay {
    origin: Vec3,
    inverse: Vec3,
    /// The widening of slabs, in slab distance.
    widening: Vec3,
    /// Slab distance per ray parameter.
    rate: f64,
}

impl ScaledRay {
    /// Scales a proper ray; `scale` is in builder's units per unit of the mesh.
    #[inline(always)]
    pub fn new(ray: &Ray, scale: f32) -> ScaledRay {
        let size = ray.direction.abs().max_element();
        let inverse = (size / ray.direction.abs()).min(Vec3::splat(STEEPEST)).copysign(ray.direction);
        let origin = ray.origin * scale;
        let widening = inverse.abs() * (WIDENING * (origin.abs().max_element() + 1.0));
        ScaledRay { origin, inverse, widening, rate: f64::from(size) * f64::from(scale) }
    }

    /// A slab distance below which no hit has parameter `t` or more.
    #[inline(always)]
    pub fn first(&self, t: f32) -> f32 {
        let distance = (f64::from(t) * self.rate) as f32;
        (distance * (1.0 - ROUNDING)).min(distance * (1.0 + ROUNDING))
    }

    /// A slab distance above which no hit has parameter `t` or less.
    #[inline(always)]
    pub fn last(&self, t: f32) -> f32 {
        let distance = (f64::from(t) * self.rate) as f32;
        (distance * (1.0 - ROUNDING)).max(distance * (1.0 + ROUNDING))
    }
}

/// More than the rounding error of two products.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// The children that a ray meets.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Entries {
    /// The slab distances at which they are entered.
    pub near: [f32; 8],
    /// Child i as bit i; undefined for empty children.
    pub hit: u32,
}

/// The slab test of eight boxes in one instruction set. An overflow to NaN counts as a hit.
pub trait Slabs: Copy {
    /// Prepares a ray that starts at slab distance `first`.
    fn new(ray: &ScaledRay, first: f32) -> Self;

    /// The children that the ray meets up to slab distance `last`.
    fn enter(&self, node: &CwBvhNode, last: f32) -> Entries;

    /// Prefetches an item into the cache, if there is an instruction for that.
    #[inline(always)]
    fn prefetch<T>(_item: &[T], _index: usize) {}
}

/// The portable form.
#[derive(Clone, Copy, Debug)]
pub struct Plain {
    ray: ScaledRay,
    first: f32,
}

impl Slabs for Plain {
    #[inline(always)]
    fn new(ray: &ScaledRay, first: f32) -> Self {
        Plain { ray: *ray, first }
    }

    #[inline(always)]
    fn enter(&self, node: &CwBvhNode, last: f32) -> Entries {
        let ScaledRay { origin, inverse, widening, .. } = self.ray;
        let mut near = [self.first; 8];
        let mut far = [last; 8];
        let planes = [
            (&node.child_min_x, &node.child_max_x),
            (&node.child_min_y, &node.child_max_y),
            (&node.child_min_z, &node.child_max_z),
        ];
        let cell = node.compute_extent();
        for (axis, (lo, hi)) in planes.into_iter().enumerate() {
            let inverse = inverse[axis];
            let step = cell[axis] * inverse;
            let start = (node.p[axis] - origin[axis]) * inverse;
            let (start, end) = (start - widening[axis], start + widening[axis]);
            let (lo, hi) = if inverse >= 0.0 { (lo, hi) } else { (hi, lo) };
            for i in 0..8 {
                near[i] = max(near[i], f32::from(lo[i]) * step + start);
                far[i] = min(far[i], f32::from(hi[i]) * step + end);
            }
        }
        let mut hit = 0;
        for i in 0..8 {
            let missed = near[i] > far[i];
            hit |= u32::from(!missed) << i;
        }
        Entries { near, hit }
    }
}

// One instruction each; the running value is kept if the other is NaN.
#[inline(always)]
fn max(running: f32, other: f32) -> f32 {
    if other > running { other } else { running }
}

#[inline(always)]
fn min(running: f32, other: f32) -> f32 {
    if other < running { other } else { running }
}

#[cfg(test)]
mod tests;
