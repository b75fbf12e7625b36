//! Boxes around the parts of a triangle on either side of an axis-aligned plane.
//!
//! Crossing points are rounded, so a clipped box may be smaller than the exact part by a few units in the last place
//! of the mesh's extent. Errors do not accumulate, because every face comes from one clip of the original triangle.
//! The widening of boxes in [`crate::traverse`] covers them.

use glam::Vec4;

use crate::bounds::Bounds;

/// Bounds of the points where the triangle's outline crosses the plane `axis = position` (empty if nowhere).
pub(crate) fn section(corners: &[Vec4; 3], axis: usize, position: f32) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    let mut from = corners[2];
    for &to in corners {
        let (a, b) = (from[axis], to[axis]);
        if (a < position && position < b) || (b < position && position < a) {
            let point = from + (to - from) * ((position - a) / (b - a));
            bounds = bounds.with_point(point);
        }
        from = to;
    }
    bounds
}

/// The boxes of the two parts of a triangle cut at a plane. Both lie within `bounds`, the box before the cut.
pub(crate) fn split(corners: &[Vec4; 3], bounds: Bounds, axis: usize, position: f32) -> (Bounds, Bounds) {
    let cut = section(corners, axis, position);
    let (mut left, mut right) = (cut, cut);
    for &corner in corners {
        if corner[axis] <= position {
            left = left.with_point(corner);
        }
        if corner[axis] >= position {
            right = right.with_point(corner);
        }
    }
    let (mut below, mut above) = (bounds, bounds);
    below.hi[axis] = below.hi[axis].min(position);
    above.lo[axis] = above.lo[axis].max(position);
    (within(left, below), within(right, above))
}

/// The common part of two boxes; `outer` if rounding leaves it empty, so that no part is lost.
pub(crate) fn within(inner: Bounds, outer: Bounds) -> Bounds {
    let common = inner.intersection(outer);
    if common.is_empty() { outer } else { common }
}
