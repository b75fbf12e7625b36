//! The builder: a split bounding volume hierarchy (Stich, Friedrich & Dietrich 2009).
//!
//! At each node the best binned object split is found and, where its two sides overlap by more than a set
//! share of the root's area and of the node's own, the best binned spatial split too; the cheaper by the
//! surface area heuristic is taken. Building goes on until each leaf has one reference, which is what the wide
//! conversion wants (it gathers references into leaves itself).
//!
//! **Budget.** A node owns a slice of the reference array which is longer than its references by its share of
//! the budget, and the spare room is divided between its children in proportion to the summed areas of their
//! references: large boxes are what spatial splits make smaller. The array's length is the budget, so it
//! cannot be exceeded, no node waits for another, and the tree is the same for any number of threads.
//! (The layout in place follows the extended ranges of Embree's spatial builder.)
//!
//! **Memory.** The array of nodes has a place for every node that the budget allows, but it comes from the system as
//! zeroed pages and a task fills its part from the front: what the budget is not used for is never touched.

mod clip;
mod node;
mod object;
mod reference;
mod spatial;

use crate::wide::Costs;
pub(crate) use node::Node;
use object::Partition;
use rayon::prelude::*;
pub(crate) use reference::{Extent, Mesh, Reference};

/// Below this depth of the tree nodes are halved by count whatever it costs, which bounds the depth by this
/// plus the logarithm of the reference count, and with it every recursion, on any input.
const MAX_GREEDY_DEPTH: u32 = 56;
/// Least overlap, as a share of the node's own area, from which spatial splits are tried there. The paper has
/// only the share of the root's area, by which almost every node of a large mesh passes for next to no gain:
/// this makes the build of a million triangles two to three times as fast, and slivers lose nothing.
const SHARE: f32 = 0.05;
/// Nodes with this few references are not split spatially: what a triangle gains there it gains more cheaply
/// above, and half of all nodes are this small.
const FEWEST: usize = 8;
/// Subtrees with more references than this are built as tasks of their own.
const TASK: usize = 1 << 12;

/// What steers the build; see [`crate::BuildOptions`].
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

/// Builds the tree over the triangles of the given numbers. Node 0 is the root; the array has vacant places.
/// Empty where there are no triangles.
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

/// Vacant nodes, the first of which has index `base` in the whole array.
struct Place<'a> {
    below: &'a mut [Node],
    base: usize,
}

impl Builder<'_> {
    /// Builds the subtree over `references[..count]`, all but its root into `place`: in parts of their own for other
    /// threads, as long as it is large.
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

    /// The same on this thread, into the first vacant nodes after `used`.
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

    /// Splits the references and divides the room: the right-hand side's begin at the first number returned.
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
        // The right-hand references move up to make the room; their order is free, so only those in the way do.
        let moved = room.min(right_count);
        references.copy_within(left_count..left_count + moved, cut + right_count - moved);
        (cut, left_count, left, right_count, right)
    }

    /// Chooses a split and carries it out: the left side's references come first, the right side's follow.
    /// Both sides are non-empty.
    #[inline(never)] // Its working arrays stay out of the recursion's stack frames.
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
                    // Unsplitting put everything on one side, and nothing was divided: as before.
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

/// The left child's part of the spare room, by summed areas; a child with one reference is a leaf and needs
/// none.
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

/// Moves the references for which `right` holds behind the others. Returns how many stay in front, and the
/// extents of both parts.
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
