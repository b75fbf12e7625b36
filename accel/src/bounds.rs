//! Axis-aligned boxes in four lanes, as the builder computes with them.

use glam::{Vec3, Vec4, Vec4Swizzles};

/// An axis-aligned box. The fourth lanes are not read here; a [`crate::sbvh::Reference`] keeps its triangle there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub lo: Vec4,
    pub hi: Vec4,
}

impl Bounds {
    /// The neutral element of [`Bounds::union`].
    pub const EMPTY: Bounds = Bounds { lo: Vec4::splat(f32::INFINITY), hi: Vec4::splat(f32::NEG_INFINITY) };

    pub fn union(self, other: Bounds) -> Bounds {
        Bounds { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    pub fn with_point(self, point: Vec4) -> Bounds {
        Bounds { lo: self.lo.min(point), hi: self.hi.max(point) }
    }

    /// The common part, possibly inverted: see [`Bounds::is_empty`].
    pub fn intersection(self, other: Bounds) -> Bounds {
        Bounds { lo: self.lo.max(other.lo), hi: self.hi.min(other.hi) }
    }

    pub fn is_empty(self) -> bool {
        self.lo.xyz().cmpgt(self.hi.xyz()).any()
    }

    /// Half the surface area, to which the hit probability of the surface area heuristic is proportional. Zero for an
    /// empty box.
    pub fn half_area(self) -> f32 {
        let d = (self.hi - self.lo).max(Vec4::ZERO);
        (d.x + d.y) * d.z + d.x * d.y
    }

    pub fn corners(self) -> (Vec3, Vec3) {
        (self.lo.xyz(), self.hi.xyz())
    }
}
