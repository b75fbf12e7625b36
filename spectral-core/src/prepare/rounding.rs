//! What single precision does to the surfaces, for the backends that trace in it.
//!
//! Every such backend takes the same bounds, so that all make the same decisions but for rounding itself.

use super::{Geometry, PreparedStone};
use crate::camera::CameraRay;
use glam::DVec3;

/// Bounds of rounding for a scene traced in single precision. Lengths in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Rounding {
    /// Largest distance by which rounding puts the start of a ray beyond the surface it starts on.
    pub margin: f32,
    /// How far behind its start a ray may meet a plane that the start is `margin` beyond: grazing ones lie far.
    pub behind: f32,
    /// Distance between surfaces in optical contact; 0 where no two stones come near each other.
    pub contact: f32,
}

impl Rounding {
    /// Surfaces of one ray that are no optical interface are crossed at most so many times.
    pub const MOST_CROSSINGS: u32 = 10_000;
    /// Faces in optical contact are parallel: their normals' cosine is at least this.
    pub const PARALLEL: f32 = 0.999;
    /// Cosines are taken to be at least this where a bound is divided by them.
    pub const GRAZING: f32 = 1e-6;
    /// A ray that misses a stone it is in is cast again from so many margins to each side, in this order.
    pub const RESCUE: [f32; 2] = [4.0, 64.0];
}

/// The part of a ray that is inside all planes of a convex stone; none if `far` is less than `near`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Span {
    /// Where the ray is inside of all planes that face its origin, mm along the ray; not negative.
    pub near: f64,
    /// The last of those planes, counted from the stone's first facet; `usize::MAX` if the ray begins inside of all.
    pub first: usize,
    /// Where the ray meets the first of the planes that face away, mm.
    pub far: f64,
    /// That plane; `usize::MAX` if there is none.
    pub last: usize,
}

impl Span {
    /// Where the ray enters, and by which facet.
    pub fn entry(&self, ray: &CameraRay) -> Option<(DVec3, usize)> {
        let enters = self.first != usize::MAX && self.near <= self.far;
        enters.then(|| (ray.origin + ray.direction * self.near, self.first))
    }
}

impl Geometry {
    /// The bounds of rounding for these surfaces.
    pub fn rounding(&self) -> Rounding {
        let radius = self.radius as f32;
        Rounding {
            // origin + t·direction rounds three times in each coordinate, plane and vertex once more.
            margin: 8.0 * f32::EPSILON * radius,
            behind: 1e-2 * radius,
            contact: if self.contacts { Self::CONTACT as f32 * radius } else { 0.0 },
        }
    }

    /// Where a ray from outside enters a convex stone, and by which facet, counted from the stone's first.
    pub fn entry(&self, stone: &PreparedStone, ray: &CameraRay) -> Option<(DVec3, usize)> {
        self.span(stone, ray).entry(ray)
    }

    /// Between which planes a ray is inside a convex stone.
    pub fn span(&self, stone: &PreparedStone, ray: &CameraRay) -> Span {
        let mut span = Span { near: 0.0, first: usize::MAX, far: f64::INFINITY, last: usize::MAX };
        for (index, plane) in self.facets_of(stone).iter().enumerate() {
            let towards = plane.normal.dot(ray.direction);
            let gap = plane.offset - plane.normal.dot(ray.origin);
            if towards < 0.0 {
                if gap / towards > span.near {
                    (span.near, span.first) = (gap / towards, index);
                }
            } else if towards > 0.0 {
                if gap / towards < span.far {
                    (span.far, span.last) = (gap / towards, index);
                }
            } else if gap < 0.0 {
                // Beside the stone, along one of its facets.
                span.far = f64::NEG_INFINITY;
            }
        }
        span
    }

    /// The point where a camera ray comes near the stones, in double precision: single precision is then spent
    /// on the stones and not on the way to them. Of one convex stone it is the point where the ray enters. `None`
    /// if it passes them by.
    pub fn approach(&self, ray: &CameraRay) -> Option<DVec3> {
        if self.stones.is_empty() {
            return None;
        }
        if let [stone] = self.stones.as_slice()
            && stone.has_few_planes()
            && self.facets.iter().any(|f| f.normal.dot(ray.origin) > f.offset)
        {
            return self.entry(stone, ray).map(|(point, _)| point);
        }
        let reach = self.radius * 1.001;
        let middle = -ray.origin.dot(ray.direction);
        let across2 = (ray.origin + ray.direction * middle).length_squared();
        let half2 = reach * reach - across2;
        if half2 < 0.0 || middle + half2.sqrt() < 0.0 {
            return None;
        }
        Some(ray.origin + ray.direction * (middle - half2.sqrt()).max(0.0))
    }
}
