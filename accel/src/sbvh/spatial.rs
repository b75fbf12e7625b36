//! Spatial splits: space is cut by a plane, and a reference that straddles it goes to both sides, each part
//! with its own clipped box (Stich, Friedrich & Dietrich 2009, section 4).

use rayon::prelude::*;

use super::clip;
use super::reference::{Extent, Mesh, Reference};
use crate::bounds::Bounds;

pub(crate) const BINS: usize = 16;
const PIECE: usize = 1 << 12;

/// The best spatial split of a node.
#[derive(Clone, Copy)]
pub(crate) struct SpatialSplit {
    /// Half area × references, summed over the two sides.
    pub cost: f32,
    pub axis: usize,
    pub position: f32,
    left: Side,
    right: Side,
}

#[derive(Clone, Copy)]
struct Side {
    bounds: Bounds,
    count: u32,
}

#[derive(Clone, Copy)]
struct Bins {
    bounds: [Bounds; BINS],
    enter: [u32; BINS],
    exit: [u32; BINS],
}

impl Bins {
    const EMPTY: Bins = Bins { bounds: [Bounds::EMPTY; BINS], enter: [0; BINS], exit: [0; BINS] };

    fn merge(mut self, other: &Bins) -> Bins {
        for bin in 0..BINS {
            self.bounds[bin] = self.bounds[bin].union(other.bounds[bin]);
            self.enter[bin] += other.enter[bin];
            self.exit[bin] += other.exit[bin];
        }
        self
    }
}

/// The cutting planes along one axis of a node's box.
struct Planes {
    axis: usize,
    count: usize,
    origin: f32,
    step: f32,
    scale: f32,
}

impl Planes {
    /// `None` where the box is too thin along the axis to cut.
    fn new(bounds: Bounds, axis: usize, count: usize) -> Option<Planes> {
        let (origin, extent) = (bounds.lo[axis], bounds.hi[axis] - bounds.lo[axis]);
        let (step, scale) = (extent / count as f32, count as f32 / extent);
        let planes = Planes { axis, count, origin, step, scale };
        let distinct = origin < planes.position(1) && planes.position(count - 1) < bounds.hi[axis];
        (distinct && scale.is_finite()).then_some(planes)
    }

    /// The plane below bin `bin`.
    fn position(&self, bin: usize) -> f32 {
        self.origin + self.step * bin as f32
    }

    fn bin(&self, value: f32) -> usize {
        // `as` saturates below at 0.
        (((value - self.origin) * self.scale) as usize).min(self.count - 1)
    }

    /// Chopped binning: a reference's part in each bin that it reaches.
    fn add(&self, bins: &mut Bins, reference: Reference, mesh: &Mesh) {
        let bounds = reference.bounds();
        let first = self.bin(bounds.lo[self.axis]);
        let last = self.bin(bounds.hi[self.axis]).max(first);
        bins.enter[first] += 1;
        bins.exit[last] += 1;
        if first == last {
            bins.bounds[first] = bins.bounds[first].union(bounds);
            return;
        }
        let corners = mesh.corners(reference.triangle());
        let mut below = Bounds::EMPTY;
        for bin in first..=last {
            let mut slab = bounds;
            let mut part = below;
            if bin > first {
                slab.lo[self.axis] = slab.lo[self.axis].max(self.position(bin));
            }
            if bin < last {
                let top = self.position(bin + 1);
                slab.hi[self.axis] = slab.hi[self.axis].min(top);
                below = clip::section(&corners, self.axis, top);
                part = part.union(below);
            }
            for corner in corners {
                if self.bin(corner[self.axis]) == bin {
                    part = part.with_point(corner);
                }
            }
            bins.bounds[bin] = bins.bounds[bin].union(clip::within(part, slab));
        }
    }
}

/// The cheapest cut that duplicates at most `spare` references, or `None`.
pub(crate) fn find(
    references: &[Reference],
    extent: &Extent,
    mesh: &Mesh,
    spare: usize,
) -> Option<SpatialSplit> {
    let count = if references.len() <= 16 { BINS / 2 } else { BINS };
    let mut best: Option<SpatialSplit> = None;
    for axis in 0..3 {
        let Some(planes) = Planes::new(extent.bounds, axis, count) else { continue };
        let fill = |references: &[Reference]| {
            let mut bins = Bins::EMPTY;
            references.iter().for_each(|&reference| planes.add(&mut bins, reference, mesh));
            bins
        };
        let bins = if references.len() > PIECE * 4 {
            let pieces: Vec<Bins> = references.par_chunks(PIECE).map(fill).collect();
            pieces.iter().fold(Bins::EMPTY, Bins::merge)
        } else {
            fill(references)
        };
        let mut right = [Side { bounds: Bounds::EMPTY, count: 0 }; BINS];
        let mut sum = right[0];
        for bin in (1..count).rev() {
            sum = Side { bounds: sum.bounds.union(bins.bounds[bin]), count: sum.count + bins.exit[bin] };
            right[bin] = sum;
        }
        let mut left = Side { bounds: Bounds::EMPTY, count: 0 };
        for bin in 1..count {
            left = Side {
                bounds: left.bounds.union(bins.bounds[bin - 1]),
                count: left.count + bins.enter[bin - 1],
            };
            let right = right[bin];
            let both = (left.count + right.count) as usize;
            if left.count == 0 || right.count == 0 || both > references.len() + spare {
                continue;
            }
            let cost =
                left.bounds.half_area() * left.count as f32 + right.bounds.half_area() * right.count as f32;
            if best.is_none_or(|best| cost < best.cost) {
                best = Some(SpatialSplit { cost, axis, position: planes.position(bin), left, right });
            }
        }
    }
    best
}

/// Carries out a cut: marks each of the first `count` references for its side, and puts the right-hand parts
/// of divided ones behind them. Returns the new number of references, at most `references.len()`.
///
/// A straddling reference is put wholly on one side where that is cheaper than dividing it ("reference
/// unsplitting", equations 1–3 of the paper), or where the budget is spent.
pub(crate) fn divide(references: &mut [Reference], count: usize, split: &SpatialSplit, mesh: &Mesh) -> usize {
    let SpatialSplit { axis, position, mut left, mut right, .. } = *split;
    let mut end = count;
    for i in 0..count {
        let reference = references[i];
        let bounds = reference.bounds();
        if bounds.hi[axis] <= position {
            references[i] = reference.marked(false);
            continue;
        }
        if bounds.lo[axis] >= position {
            references[i] = reference.marked(true);
            continue;
        }
        let (with_left, with_right) = (left.bounds.union(bounds), right.bounds.union(bounds));
        let (area_left, area_right) = (left.bounds.half_area(), right.bounds.half_area());
        let (n_left, n_right) = (left.count as f32, right.count as f32);
        let divided =
            if end < references.len() { area_left * n_left + area_right * n_right } else { f32::INFINITY };
        let only_left = with_left.half_area() * n_left + area_right * (n_right - 1.0);
        let only_right = area_left * (n_left - 1.0) + with_right.half_area() * n_right;
        if divided < only_left.min(only_right) {
            let (below, above) = clip::split(&mesh.corners(reference.triangle()), bounds, axis, position);
            references[i] = reference.with_bounds(below).marked(false);
            references[end] = reference.with_bounds(above).marked(true);
            end += 1;
        } else if only_left <= only_right {
            left.bounds = with_left;
            right.count = right.count.saturating_sub(1);
            references[i] = reference.marked(false);
        } else {
            right.bounds = with_right;
            left.count = left.count.saturating_sub(1);
            references[i] = reference.marked(true);
        }
    }
    end
}
