//! Spatial splits: a plane cuts space, and a reference that straddles it goes to both sides, each part with its own
//! clipped box (Stich, Friedrich & Dietrich 2009, section 4).

use glam::Vec4;
use rayon::prelude::*;

use super::clip;
use super::reference::{Extent, Mesh, Reference};
use crate::bounds::Bounds;

/// The discount for a duplicate, as a share of the node's area. The heuristic prices each side as a leaf, but the boxes
/// of a duplicate shrink further down, most of all those of slivers. Without the discount a cut through slivers that
/// cross the whole node looks no better than an object split, and whole subtrees are never cut: 3,000 to 60,000 slivers
/// then cost 0.9 to 1.1 of `obvhs`'s best tree, and 0.65 to 0.67 with it. (0.05 is too little for the smaller sets, 0.3
/// gains no more; well-shaped meshes are unaffected.)
const DISCOUNT: f32 = 0.2;
const PIECE: usize = 1 << 12;

/// The best spatial split of a node.
#[derive(Clone, Copy)]
pub(crate) struct SpatialSplit {
    /// Half area × references, summed over the two sides, less the discount for duplicates.
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
struct Bins<const N: usize> {
    bounds: [Bounds; N],
    enter: [u32; N],
    exit: [u32; N],
}

impl<const N: usize> Bins<N> {
    const EMPTY: Self = Bins { bounds: [Bounds::EMPTY; N], enter: [0; N], exit: [0; N] };

    fn merge(mut self, other: &Self) -> Self {
        for bin in 0..N {
            self.bounds[bin] = self.bounds[bin].union(other.bounds[bin]);
            self.enter[bin] += other.enter[bin];
            self.exit[bin] += other.exit[bin];
        }
        self
    }
}

/// The cutting planes along one axis of a node's box.
struct Planes<const N: usize> {
    axis: usize,
    origin: f32,
    step: f32,
    scale: f32,
}

impl<const N: usize> Planes<N> {
    /// `None` if the box is too thin along the axis to cut.
    fn new(bounds: Bounds, axis: usize) -> Option<Self> {
        let (origin, extent) = (bounds.lo[axis], bounds.hi[axis] - bounds.lo[axis]);
        let (step, scale) = (extent / N as f32, N as f32 / extent);
        let planes = Planes { axis, origin, step, scale };
        let distinct = origin < planes.position(1) && planes.position(N - 1) < bounds.hi[axis];
        (distinct && scale.is_finite()).then_some(planes)
    }

    /// The plane below bin `bin`.
    fn position(&self, bin: usize) -> f32 {
        self.origin + self.step * bin as f32
    }

    fn bin(&self, value: f32) -> usize {
        // `as` saturates below at 0.
        (((value - self.origin) * self.scale) as usize).min(N - 1)
    }

    /// Chopped binning: adds the part of a reference in each bin it reaches.
    fn add(&self, bins: &mut Bins<N>, bounds: Bounds, corners: impl FnOnce() -> [Vec4; 3]) {
        let first = self.bin(bounds.lo[self.axis]);
        let last = self.bin(bounds.hi[self.axis]).max(first);
        bins.enter[first] += 1;
        bins.exit[last] += 1;
        if first == last {
            bins.bounds[first] = bins.bounds[first].union(bounds);
            return;
        }
        let corners = corners();
        let mut parts = [Bounds::EMPTY; N];
        let values = corners.map(|corner| corner[self.axis]);
        let places = values.map(|value| self.bin(value));
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            parts[places[from]] = parts[places[from]].with_point(corners[from]);
            let (low, high) = (places[from].min(places[to]), places[from].max(places[to]));
            let step = corners[to] - corners[from];
            let inverse = 1.0 / (values[to] - values[from]);
            for bin in low.max(first)..high.min(last) {
                let share = (self.position(bin + 1) - values[from]) * inverse;
                let point = corners[from] + step * share.clamp(0.0, 1.0);
                parts[bin] = parts[bin].with_point(point);
                parts[bin + 1] = parts[bin + 1].with_point(point);
            }
        }
        for (whole, part) in bins.bounds[first..=last].iter_mut().zip(&parts[first..=last]) {
            *whole = whole.union(clip::within(*part, bounds));
        }
    }
}

/// The cheapest cut that duplicates at most `spare` references, or `None`. Small nodes get few bins, because almost
/// every reference reaches several of them and is clipped for each.
pub(crate) fn find(
    references: &[Reference],
    extent: &Extent,
    mesh: &Mesh,
    spare: usize,
) -> Option<SpatialSplit> {
    match references.len() {
        0..=32 => find_among::<4>(references, extent, mesh, spare),
        33..=1024 => find_among::<8>(references, extent, mesh, spare),
        _ => find_among::<16>(references, extent, mesh, spare),
    }
}

fn find_among<const N: usize>(
    references: &[Reference],
    extent: &Extent,
    mesh: &Mesh,
    spare: usize,
) -> Option<SpatialSplit> {
    let mut best: Option<SpatialSplit> = None;
    let planes = [0, 1, 2].map(|axis| Planes::<N>::new(extent.bounds, axis));
    let fill = |references: &[Reference]| {
        let mut bins = [Bins::<N>::EMPTY; 3];
        for reference in references {
            // Read only if the reference is cut: the corners are far apart in memory.
            let mut corners = None;
            for (planes, bins) in planes.iter().zip(&mut bins) {
                if let Some(planes) = planes {
                    planes.add(bins, reference.bounds(), || {
                        *corners.get_or_insert_with(|| mesh.corners(reference.triangle()))
                    });
                }
            }
        }
        bins
    };
    let bins = if references.len() > PIECE * 4 {
        references
            .par_chunks(PIECE)
            .map(fill)
            .reduce(|| [Bins::<N>::EMPTY; 3], |[x, y, z], [a, b, c]| [x.merge(&a), y.merge(&b), z.merge(&c)])
    } else {
        fill(references)
    };
    for axis in 0..3 {
        let (Some(planes), bins) = (&planes[axis], &bins[axis]) else { continue };
        let mut right = [Side { bounds: Bounds::EMPTY, count: 0 }; N];
        let mut sum = right[0];
        for bin in (1..N).rev() {
            sum = Side { bounds: sum.bounds.union(bins.bounds[bin]), count: sum.count + bins.exit[bin] };
            right[bin] = sum;
        }
        let mut left = Side { bounds: Bounds::EMPTY, count: 0 };
        for bin in 1..N {
            left = Side {
                bounds: left.bounds.union(bins.bounds[bin - 1]),
                count: left.count + bins.enter[bin - 1],
            };
            let right = right[bin];
            let both = (left.count + right.count) as usize;
            if left.count == 0 || right.count == 0 || both > references.len() + spare {
                continue;
            }
            let duplicates = both.saturating_sub(references.len());
            let cost = left.bounds.half_area() * left.count as f32
                + right.bounds.half_area() * right.count as f32
                - DISCOUNT * extent.bounds.half_area() * duplicates as f32;
            if best.is_none_or(|best| cost < best.cost) {
                best = Some(SpatialSplit { cost, axis, position: planes.position(bin), left, right });
            }
        }
    }
    best
}

/// Performs a cut: marks each of the first `count` references with its side, and puts the right parts of divided ones
/// behind them. Returns the new number of references, at most `references.len()`.
///
/// A straddling reference goes undivided to one side where that is cheaper ("reference unsplitting", equations 1–3 of
/// the paper), or where the budget is used up.
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
