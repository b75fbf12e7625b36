//! The builder: a split bounding volume hierarchy (Stich, Friedrich & Dietrich 2009).
//!
//! At each node the builder finds the best binned object split. Where its two sides overlap by more than a set share
//! of the root's area and of the node's own, it also finds the best binned spatial split, and takes the cheaper of the
//! two by the surface area heuristic. It continues until each leaf has one reference; the wide conversion then gathers
//! references into leaves.
//!
//! **Budget.** A node owns a slice of the reference array that is longer than its references by its share of the
//! budget. This spare room is divided between its children in proportion to the summed areas of their references,
//! because spatial splits gain most on large boxes. The length of the array is the budget, so it cannot be exceeded,
//! no node waits for another, and the tree is the same for any number of threads. (The layout in place follows the
//! extended ranges of Embree's spatial builder.)
//!
//! **Memory.** The node array has room for every node that the budget allows. The system supplies it as zeroed pages,
//! and each task fills its part from the front, so pages that are not needed are never touched.

mod clip;
mod cost;
mod node;
mod object;
mod reference;
mod spatial;

use cost::Costs;
pub(crate) use cost::LEAF;
pub(crate) use node::Node;
use object::Partition;
use rayon::prelude::*;
pub(crate) use reference::{Extent, Mesh, Reference};

/// Below this depth nodes are halved by count at any cost. So on any input the depth, and with it every recursion, is
/// bounded by this number plus the logarithm of the reference count.
const MAX_GREEDY_DEPTH: u32 = 56;
/// Least overlap, as a share of the node's own area, from which spatial splits are tried. The paper compares with the
/// root's area alone, which lets almost every node of a large mesh pass for almost no gain. This second limit makes the
/// build of a million triangles two to three times as fast, and the trees of slivers are as good.
const SHARE: f32 = 0.05;
/// Nodes with at most this many references are not split spatially: splits higher up gain the same at less cost, and
/// half of all nodes are this small.
const FEWEST: usize = 8;
/// Subtrees with more references than this are built as separate tasks.
const TASK: usize = 1 << 12;

/// Limits of the build; see [`crate::BuildOptions`].
pub(crate) struct Settings {
    /// Largest number of references.
    pub budget: usize,
    /// Overlap, as a share of the root's area, from which spatial splits are tried.
    pub alpha: f32,
}

struct Builder<'a> {
    mesh: &'a Mesh<'a>,
    least_overlap: f32,
}

/// Builds the tree over the triangles with the given numbers. Node 0 is the root; some entries of the array stay
/// vacant. Empty if there are no triangles.
pub(crate) fn build(mesh: &Mesh, numbers: Vec<u32>, settings: &Settings) -> Vec<Node> {
    let count = numbers.len();
    if count == 0 {
        return Vec::new();
    }
    let room = settings.budget.max(count);
    let mut references = Vec::with_capacity(room);
    numbers.par_iter().map(|&number| mesh.reference(number)).collect_into_vec(&mut references);
    drop(numbers);
    let extent = Extent::of(&references);
    references.resize(room, references[0]);
    let mut nodes: Vec<Node> = bytemuck::zeroed_vec(2 * room - 1);
    let builder = Builder { mesh, least_overlap: settings.alpha * extent.bounds.half_area() };
    if let Some((root, below)) = nodes.split_first_mut() {
        (*root, _) = builder.task(Place { below, base: 1 }, &mut references, count, extent, 0);
    }
    nodes
}

/// Vacant nodes; the first has index `base` in the whole array.
struct Place<'a> {
    below: &'a mut [Node],
    base: usize,
}

impl Builder<'_> {
    /// Builds the subtree over `references[..count]`: returns its root and writes the rest into `place`. Large subtrees
    /// are divided among threads.
    fn task(
        &self,
        place: Place,
        references: &mut [Reference],
        count: usize,
        extent: Extent,
        depth: u32,
    ) -> (Node, Costs) {
        let Place { below, base } = place;
        if count <= TASK {
            return self.subtree(&mut Place { below, base }, &mut 0, references, count, extent, depth);
        }
        let (cut, left_count, left, right_count, right) = self.spread(references, count, &extent, depth);
        let (left_references, right_references) = references.split_at_mut(cut);
        let (pair, rest) = below.split_at_mut(2);
        let (left_below, right_below) = rest.split_at_mut(2 * (cut - 1));
        let left_place = Place { base: base + 2, below: left_below };
        let right_place = Place { base: base + 2 * cut, below: right_below };
        let (first, second) = rayon::join(
            || self.task(left_place, left_references, left_count, left, depth + 1),
            || self.task(right_place, right_references, right_count, right, depth + 1),
        );
        (pair[0], pair[1]) = (first.0, second.0);
        Node::inner(extent.bounds, base, &first.1, &second.1)
    }

    /// The same on this thread alone, into the first vacant nodes after `used`.
    fn subtree(
        &self,
        place: &mut Place,
        used: &mut usize,
        references: &mut [Reference],
        count: usize,
        extent: Extent,
        depth: u32,
    ) -> (Node, Costs) {
        if count == 1 {
            return Node::leaf(extent.bounds, references[0].triangle());
        }
        let (cut, left_count, left, right_count, right) = self.spread(references, count, &extent, depth);
        let (left_references, right_references) = references.split_at_mut(cut);
        let pair = *used;
        *used += 2;
        let first = self.subtree(place, used, left_references, left_count, left, depth + 1);
        let second = self.subtree(place, used, right_references, right_count, right, depth + 1);
        (place.below[pair], place.below[pair + 1]) = (first.0, second.0);
        Node::inner(extent.bounds, place.base + pair, &first.1, &second.1)
    }

    /// Splits the references and divides the spare room: the right side begins at the first number returned.
    fn spread(
        &self,
        references: &mut [Reference],
        count: usize,
        extent: &Extent,
        depth: u32,
    ) -> (usize, usize, Extent, usize, Extent) {
        let (left_count, left, right_count, right) = self.split(references, count, extent, depth);
        let room =
            share(references.len() - left_count - right_count, (left_count, &left), (right_count, &right));
        let cut = left_count + room;
        // The right references make room for the left ones. Their order is free, so only those in the way move.
        let moved = room.min(right_count);
        references.copy_within(left_count..left_count + moved, cut + right_count - moved);
        (cut, left_count, left, right_count, right)
    }

    /// Chooses a split and performs it: the references of the left side come first. Both sides are non-empty.
    #[inline(never)] // Keeps its working arrays out of the stack frames of the recursion.
    fn split(
        &self,
        references: &mut [Reference],
        count: usize,
        extent: &Extent,
        depth: u32,
    ) -> (usize, Extent, usize, Extent) {
        if depth < MAX_GREEDY_DEPTH {
            let spare = references.len() - count;
            let object = object::find(&references[..count], extent);
            let least = self.least_overlap.max(SHARE * extent.bounds.half_area());
            let overlapping = object.is_none_or(|object| object.overlap > least);
            if spare > 0 && overlapping && count > FEWEST {
                let spatial = spatial::find(&references[..count], extent, self.mesh, spare);
                let limit = object.map_or(f32::INFINITY, |object| object.cost);
                if let Some(spatial) = spatial.filter(|spatial| spatial.cost < limit) {
                    let end = spatial::divide(references, count, &spatial, self.mesh);
                    let (middle, left, right) = partition(&mut references[..end], Reference::is_right);
                    if middle > 0 && middle < end {
                        return (middle, left, end - middle, right);
                    }
                    // Unsplitting put everything on one side and divided nothing: the references are as before.
                }
            }
            if let Some(object) = object {
                let references = &mut references[..count];
                match object.kind {
                    Partition::Bin { axis, bin, grid } => {
                        let (middle, left, right) =
                            partition(references, |r| grid.bin(r.centroid(), axis) >= bin);
                        if middle > 0 && middle < count {
                            return (middle, left, count - middle, right);
                        }
                    }
                    Partition::Rank { axis, count: middle } => {
                        object::sort(references, axis);
                        return halves(references, middle);
                    }
                }
            }
        }
        halves(&references[..count], count / 2)
    }
}

fn halves(references: &[Reference], middle: usize) -> (usize, Extent, usize, Extent) {
    let (left, right) = references.split_at(middle);
    (middle, Extent::of(left), right.len(), Extent::of(right))
}

/// The left child's part of the spare room, by summed areas. A child with one reference is a leaf and gets none.
fn share(
    spare: usize,
    (left_count, left): (usize, &Extent),
    (right_count, right): (usize, &Extent),
) -> usize {
    match (left_count, right_count) {
        (1, _) => 0,
        (_, 1) => spare,
        _ => {
            let sum = left.area + right.area;
            let part = if sum > 0.0 { left.area / sum } else { 0.5 };
            ((spare as f64 * part).round() as usize).min(spare)
        }
    }
}

/// Moves the references for which `right` holds behind the others. Returns the number in front and both extents.
fn partition(references: &mut [Reference], right: impl Fn(Reference) -> bool) -> (usize, Extent, Extent) {
    let (mut left_extent, mut right_extent) = (Extent::EMPTY, Extent::EMPTY);
    let (mut i, mut j) = (0, references.len());
    while i < j {
        if right(references[i]) {
            right_extent.add(references[i]);
            j -= 1;
            references.swap(i, j);
        } else {
            left_extent.add(references[i]);
            i += 1;
        }
    }
    (i, left_extent, right_extent)
}
