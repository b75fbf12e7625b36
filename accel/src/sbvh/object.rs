//! Object splits: each reference goes to one side.

use glam::Vec4;
use rayon::prelude::*;

use super::reference::{Extent, Reference};
use crate::bounds::Bounds;

pub(crate) const MAX_BINS: usize = 16;
/// Nodes with at most this many references are sorted and swept exactly.
pub(crate) const SWEEP: usize = 6;
/// Larger nodes are binned in pieces of [`PIECE`] by all threads. Both numbers are fixed, and minima, maxima and
/// counts do not depend on the order of reduction, so the tree does not depend on the number of threads.
pub(crate) const PARALLEL: usize = 1 << 16;
const PIECE: usize = 1 << 14;

/// The best object split of a node.
#[derive(Clone, Copy)]
pub(crate) struct ObjectSplit {
    /// Half area × references, summed over the two sides.
    pub cost: f32,
    pub kind: Partition,
    /// What a spatial split could save: see [`overlap`].
    pub overlap: f32,
}

/// How the references are partitioned.
#[derive(Clone, Copy)]
pub(crate) enum Partition {
    /// By the bin of the centroid along an axis: below `bin` goes left.
    Bin { axis: usize, bin: u32, grid: Grid },
    /// By the order of centroids along an axis: the first `count` go left. Only for small nodes.
    Rank { axis: usize, count: usize },
}

/// The map from a (doubled) centroid to its bin along each axis.
#[derive(Clone, Copy)]
pub(crate) struct Grid {
    origin: Vec4,
    scale: Vec4,
    last: Vec4,
}

impl Grid {
    fn new(centroids: Bounds, bins: usize) -> Grid {
        let extent = centroids.hi - centroids.lo;
        // An extent so small that its reciprocal overflows counts as none.
        let scale = Vec4::splat(bins as f32) / extent.max(Vec4::splat(f32::MIN_POSITIVE));
        let scale = Vec4::select(scale.cmplt(Vec4::splat(f32::MAX)), scale, Vec4::ZERO);
        Grid { origin: centroids.lo, scale, last: Vec4::splat((bins - 1) as f32) }
    }

    fn bins(&self, centroid: Vec4) -> [u32; 3] {
        let bin = ((centroid - self.origin) * self.scale).min(self.last);
        [bin.x as u32, bin.y as u32, bin.z as u32]
    }

    pub fn bin(&self, centroid: Vec4, axis: usize) -> u32 {
        self.bins(centroid)[axis]
    }
}

#[derive(Clone)]
struct Bins {
    bounds: [[Bounds; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

impl Bins {
    const EMPTY: Bins = Bins { bounds: [[Bounds::EMPTY; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] };

    fn fill(references: &[Reference], grid: &Grid) -> Bins {
        let mut bins = Bins::EMPTY;
        for reference in references {
            for (axis, bin) in grid.bins(reference.centroid()).into_iter().enumerate() {
                let bin = bin as usize & (MAX_BINS - 1);
                bins.bounds[axis][bin] = bins.bounds[axis][bin].union(reference.bounds());
                bins.counts[axis][bin] += 1;
            }
        }
        bins
    }

    fn merge(mut self, other: Bins) -> Bins {
        for axis in 0..3 {
            for bin in 0..MAX_BINS {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(other.bounds[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }
}

/// The cheapest object split, or `None` if all centroids coincide.
pub(crate) fn find(references: &[Reference], extent: &Extent) -> Option<ObjectSplit> {
    if references.len() <= SWEEP {
        return sweep(references);
    }
    let count = (4 + references.len() / 4).min(MAX_BINS);
    let grid = Grid::new(extent.centroids, count);
    let bins = if references.len() > PARALLEL {
        references.par_chunks(PIECE).map(|piece| Bins::fill(piece, &grid)).reduce(|| Bins::EMPTY, Bins::merge)
    } else {
        Bins::fill(references, &grid)
    };
    let mut best: Option<ObjectSplit> = None;
    for axis in 0..3 {
        let (bounds, counts) = (&bins.bounds[axis][..count], &bins.counts[axis][..count]);
        let mut right = [(Bounds::EMPTY, 0); MAX_BINS];
        let mut sum = (Bounds::EMPTY, 0);
        for bin in (1..count).rev() {
            sum = (sum.0.union(bounds[bin]), sum.1 + counts[bin]);
            right[bin] = sum;
        }
        let mut left = (Bounds::EMPTY, 0);
        for bin in 1..count {
            left = (left.0.union(bounds[bin - 1]), left.1 + counts[bin - 1]);
            let right = right[bin];
            if left.1 == 0 || right.1 == 0 {
                continue;
            }
            let cost = left.0.half_area() * left.1 as f32 + right.0.half_area() * right.1 as f32;
            if best.is_none_or(|best| cost < best.cost) {
                let overlap = overlap(left.0, right.0, axis);
                best =
                    Some(ObjectSplit { cost, kind: Partition::Bin { axis, bin: bin as u32, grid }, overlap });
            }
        }
    }
    best
}

/// Every split of a few references along every axis.
fn sweep(references: &[Reference]) -> Option<ObjectSplit> {
    let mut best: Option<ObjectSplit> = None;
    let n = references.len();
    let mut sorted = [references[0]; SWEEP];
    for axis in 0..3 {
        let sorted = &mut sorted[..n];
        sorted.copy_from_slice(references);
        sort(sorted, axis);
        let mut right = [Bounds::EMPTY; SWEEP];
        let mut sum = Bounds::EMPTY;
        for i in (1..n).rev() {
            sum = sum.union(sorted[i].bounds());
            right[i] = sum;
        }
        let mut left = Bounds::EMPTY;
        for i in 1..n {
            left = left.union(sorted[i - 1].bounds());
            let cost = left.half_area() * i as f32 + right[i].half_area() * (n - i) as f32;
            if best.is_none_or(|best| cost < best.cost) {
                let overlap = overlap(left, right[i], axis);
                best = Some(ObjectSplit { cost, kind: Partition::Rank { axis, count: i }, overlap });
            }
        }
    }
    best
}

/// The area of the sides of a split along `axis` in excess of a clean cut: half the area of their common part, without
/// the face across the axis, which any cut has. Two flat boxes in one plane overlap by their common rectangle.
fn overlap(left: Bounds, right: Bounds, axis: usize) -> f32 {
    let common = left.intersection(right);
    if common.is_empty() {
        return 0.0;
    }
    let extent = common.hi - common.lo;
    extent[axis] * (extent[(axis + 1) % 3] + extent[(axis + 2) % 3])
}

/// Sorts by the centroid along an axis, stably.
pub(crate) fn sort(references: &mut [Reference], axis: usize) {
    for i in 1..references.len() {
        let mut j = i;
        while j > 0 && references[j - 1].centroid()[axis] > references[j].centroid()[axis] {
            references.swap(j - 1, j);
            j -= 1;
        }
    }
}
