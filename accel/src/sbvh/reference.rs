//! A reference: one box around (a part of) one triangle.

use glam::{Vec3, Vec4};

use crate::bounds::Bounds;

/// A box and the triangle it bounds, in 32 bytes.
///
/// The triangle's number is in the fourth lanes, 16 bits in each, with the exponent of 1.0: a plain integer would be a
/// denormal number, for which additions are slow on many processors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    lo: Vec4,
    hi: Vec4,
}

const ONE: u32 = 0x3f80_0000;
const LOW: u32 = 0xffff;
/// A bit of the upper fourth lane that marks a reference for the right side during partitioning.
const RIGHT: u32 = 1 << 20;

impl Reference {
    pub fn new(bounds: Bounds, triangle: u32) -> Reference {
        Reference {
            lo: bounds.lo.truncate().extend(f32::from_bits(ONE | (triangle & LOW))),
            hi: bounds.hi.truncate().extend(f32::from_bits(ONE | (triangle >> 16))),
        }
    }

    /// The same triangle with another box.
    pub fn with_bounds(self, bounds: Bounds) -> Reference {
        Reference { lo: bounds.lo.truncate().extend(self.lo.w), hi: bounds.hi.truncate().extend(self.hi.w) }
    }

    pub fn triangle(self) -> u32 {
        (self.lo.w.to_bits() & LOW) | ((self.hi.w.to_bits() & LOW) << 16)
    }

    pub fn bounds(self) -> Bounds {
        Bounds { lo: self.lo, hi: self.hi }
    }

    /// Twice the box's centre.
    pub fn centroid(self) -> Vec4 {
        self.lo + self.hi
    }

    pub fn marked(self, right: bool) -> Reference {
        let bits = self.hi.w.to_bits() & !RIGHT;
        Reference {
            hi: self.hi.truncate().extend(f32::from_bits(bits | if right { RIGHT } else { 0 })),
            ..self
        }
    }

    pub fn is_right(self) -> bool {
        self.hi.w.to_bits() & RIGHT != 0
    }
}

/// What a node needs of its references: their box, the box of their centroids, and the sum of their half areas, by
/// which the budget is divided.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub bounds: Bounds,
    pub centroids: Bounds,
    pub area: f64,
}

impl Extent {
    pub const EMPTY: Extent = Extent { bounds: Bounds::EMPTY, centroids: Bounds::EMPTY, area: 0.0 };

    pub fn add(&mut self, reference: Reference) {
        self.bounds = self.bounds.union(reference.bounds());
        self.centroids = self.centroids.with_point(reference.centroid());
        self.area += f64::from(reference.bounds().half_area());
    }

    pub fn of(references: &[Reference]) -> Extent {
        let mut extent = Extent::EMPTY;
        references.iter().for_each(|&reference| extent.add(reference));
        extent
    }
}

/// The triangles in the builder's units: scaled by a power of two so that the largest coordinate is below 1. This keeps
/// areas and their sums in range for any unit.
pub(crate) struct Mesh<'a> {
    pub positions: &'a [Vec3],
    pub triangles: &'a [[u32; 3]],
    pub scale: f32,
}

impl Mesh<'_> {
    /// The corners of a triangle; its indices were checked when the build began.
    pub fn corners(&self, triangle: u32) -> [Vec4; 3] {
        // `+ 0.0` turns -0 into +0: the two compare equal, so their minimum would depend on the order.
        self.triangles[triangle as usize]
            .map(|i| (self.positions[i as usize] * self.scale + Vec3::ZERO).extend(1.0))
    }

    pub fn reference(&self, triangle: u32) -> Reference {
        let [a, b, c] = self.corners(triangle);
        Reference::new(Bounds::EMPTY.with_point(a).with_point(b).with_point(c), triangle)
    }
}
