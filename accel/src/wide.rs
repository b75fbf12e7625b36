//! From the binary tree to the eight-way compressed tree (Ylitie, Karras & Laine 2017).
//!
//! The choice of binary nodes that become wide nodes is the optimum of the paper (section 4.1). `C(n, i)` is the cost of
//! the subtree of node `n` as a forest of at most `i` wide trees; the [`Form`] of the node records how it is reached for
//! each `i`. The costs depend on those of the children alone, so the builder computes them bottom-up, on all threads and
//! without a table. The wide nodes are then written from the root down.
//!
//! The tree is bit for bit the one that `obvhs` makes from the same binary tree. But `obvhs` keeps 56 bytes of costs and
//! 48 bytes of node for each binary node, which for ten million triangles is more than everything else together.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;

use crate::sbvh::{LEAF, Node};

/// A wide tree.
#[derive(Default)]
pub(crate) struct Wide {
    pub nodes: Vec<CwBvhNode>,
    /// The triangle of each reference, in the order of the leaves.
    pub triangles: Vec<u32>,
    pub bounds: Aabb,
}

/// Packs the builder's sparse array into `obvhs`'s binary tree: siblings adjacent, one reference a leaf, in depth-first
/// order, so that subtrees are contiguous in memory.
pub(crate) fn binary(nodes: &[Node]) -> Bvh2 {
    let mut packed = Vec::new();
    let mut primitives = Vec::new();
    let mut pending = Vec::new();
    if let Some(root) = nodes.first() {
        packed.push(Bvh2Node::new(aabb(root), 0, 0));
        pending.push((0, 0));
    }
    while let Some((from, to)) = pending.pop() {
        let node: &Node = &nodes[from];
        if node.is_leaf() {
            packed[to] = Bvh2Node::new(aabb(node), 1, primitives.len() as u32);
            primitives.push(node.link());
            continue;
        }
        let (child, place) = (node.link() as usize, packed.len());
        packed[to].first_index = place as u32;
        packed.push(Bvh2Node::new(aabb(&nodes[child]), 0, 0));
        packed.push(Bvh2Node::new(aabb(&nodes[child + 1]), 0, 0));
        pending.push((child + 1, place + 1));
        pending.push((child, place));
    }
    Bvh2 {
        nodes: packed,
        primitive_indices: primitives,
        uses_spatial_splits: true,
        children_are_ordered_after_parents: true,
        ..Bvh2::default()
    }
}

/// Moves subtrees to where they cost less, by `obvhs` (Meister & Bittner 2018).
pub(crate) fn reinsert(tree: &mut Bvh2, ratio: f32) {
    if ratio > 0.0 {
        ReinsertionOptimizer::default().run(tree, ratio, None);
    }
}

/// The wide tree of a binary tree that `obvhs` has changed.
pub(crate) fn convert_packed(tree: &Bvh2) -> Wide {
    let wide = bvh2_to_cwbvh(tree, LEAF, true, false);
    Wide { nodes: wide.nodes, triangles: wide.primitive_indices, bounds: wide.total_aabb }
}

/// The wide tree of the builder's array.
pub(crate) fn convert(nodes: &[Node]) -> Wide {
    let Some(root) = nodes.first() else { return Wide::default() };
    let mut writer = Writer { binary: nodes, wide: Wide { bounds: aabb(root), ..Wide::default() } };
    writer.wide.nodes.push(CwBvhNode::default());
    writer.node(0, 0);
    writer.wide
}

struct Writer<'a> {
    binary: &'a [Node],
    wide: Wide,
}

impl Writer<'_> {
    /// Writes the subtree of a binary node as the wide node `to`, then its wide children. The recursion is no deeper than
    /// the binary tree, whose depth the builder bounds.
    fn node(&mut self, from: u32, to: usize) {
        let mut children = Children::default();
        self.gather(from, self.binary[from as usize].form().children(), &mut children);
        let own = aabb(&self.binary[from as usize]);
        let slots = self.ordered(&own, &children);
        let mut node = self.framed(&own);
        let base = self.wide.nodes.len();
        (node.child_base_idx, node.primitive_base_idx) = (base as u32, self.wide.triangles.len() as u32);
        let mut inner = Children::default();
        for (slot, child) in slots.into_iter().enumerate().filter_map(|(slot, c)| Some((slot, c?))) {
            self.enclose(&mut node, slot, child);
            if self.binary[child as usize].form().is_gathered() {
                let start = self.wide.triangles.len() as u32 - node.primitive_base_idx;
                self.references(child);
                let count = self.wide.triangles.len() as u32 - node.primitive_base_idx - start;
                // The count in unary in the upper three bits, the offset in the lower five.
                node.child_meta[slot] = (((1 << count) - 1) << 5) as u8 | start as u8;
            } else {
                node.imask |= 1 << slot;
                node.child_meta[slot] = 0b10_0000 | (24 + slot as u8);
                inner.push(child);
            }
        }
        self.wide.nodes.resize(base + inner.count, CwBvhNode::default());
        self.wide.nodes[to] = node;
        for (offset, &child) in inner.list().iter().enumerate() {
            self.node(child, base + offset);
        }
    }

    /// The roots of the forest into which the children of a binary node are converted.
    fn gather(&self, node: u32, (left, right): (usize, usize), into: &mut Children) {
        let this = &self.binary[node as usize];
        if this.is_leaf() {
            into.push(node);
            return;
        }
        for (child, trees) in [(this.link(), left), (this.link() + 1, right)] {
            match self.binary[child as usize].form().shares(trees) {
                Some(shares) => self.gather(child, shares, into),
                None => into.push(child),
            }
        }
    }

    /// The triangles under a binary node, in order.
    fn references(&mut self, node: u32) {
        let this = self.binary[node as usize];
        if this.is_leaf() {
            self.wide.triangles.push(this.link());
        } else {
            self.references(this.link());
            self.references(this.link() + 1);
        }
    }

    /// An empty node whose grid, 255 cells along each axis, covers the box.
    fn framed(&self, own: &Aabb) -> CwBvhNode {
        let extent = (own.max - own.min).max(Vec3A::splat(1e-20));
        let cell = (extent * (1.0 / 255.0)).log2().ceil().exp2();
        // A power of two is given by its exponent.
        let e = cell.to_array().map(|c: f32| (c.to_bits() >> 23) as u8);
        CwBvhNode { p: own.min.into(), e, ..CwBvhNode::default() }
    }

    /// Writes a child's box on the node's grid, rounded outwards.
    fn enclose(&self, node: &mut CwBvhNode, slot: usize, child: u32) {
        let (own, child) = (Vec3A::from(node.p), aabb(&self.binary[child as usize]));
        let inverse = 1.0 / Vec3A::from(node.e.map(|e| f32::from_bits(u32::from(e) << 23)));
        let clamp = |v: Vec3A| v.clamp(Vec3A::ZERO, Vec3A::splat(255.0)).to_array().map(|c| c as u8);
        let low = clamp(((child.min - own) * inverse).floor());
        let high = clamp(((child.max - own) * inverse).ceil());
        [node.child_min_x[slot], node.child_min_y[slot], node.child_min_z[slot]] = low;
        [node.child_max_x[slot], node.child_max_y[slot], node.child_max_z[slot]] = high;
    }

    /// The assignment of children to slots, such that the octant of a ray gives their traversal order (section 3.2 of the
    /// paper). It is greedy: slot `s` prefers the child furthest against direction `s`.
    fn ordered(&self, own: &Aabb, children: &Children) -> [Option<u32>; 8] {
        let mut cost = [[0.0_f32; 8]; 8];
        for (costs, &child) in cost.iter_mut().zip(children.list()) {
            let offset = aabb(&self.binary[child as usize]).center() - own.center();
            for (s, cost) in costs.iter_mut().enumerate() {
                let sign = |bit: usize| if s & bit == 0 { 1.0 } else { -1.0 };
                *cost = Vec3A::new(sign(4), sign(2), sign(1)).dot(offset);
            }
        }
        let mut slots = [None; 8];
        let mut placed = [false; 8];
        for _ in 0..children.count {
            let mut best = (f32::MAX, 0, 0);
            for c in (0..children.count).filter(|&c| !placed[c]) {
                for s in (0..8).filter(|&s| slots[s].is_none()) {
                    if cost[c][s] < best.0 {
                        best = (cost[c][s], c, s);
                    }
                }
            }
            let (_, c, s) = best;
            (slots[s], placed[c]) = (Some(children.list()[c]), true);
        }
        slots
    }
}

/// Up to eight binary nodes.
#[derive(Default)]
struct Children {
    nodes: [u32; 8],
    count: usize,
}

impl Children {
    fn push(&mut self, node: u32) {
        self.nodes[self.count] = node;
        self.count += 1;
    }

    fn list(&self) -> &[u32] {
        &self.nodes[..self.count]
    }
}

fn aabb(node: &Node) -> Aabb {
    Aabb::new(node.lo().into(), node.hi().into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sbvh::{Mesh, Settings, build};
    use crate::testing;

    #[test]
    fn the_tree_is_the_one_that_obvhs_makes() {
        for mesh in [
            testing::icosphere(5),
            testing::slivers(3000, 1e-3, 1),
            testing::soup(5000, 0.2, 2),
            testing::stone(3),
            testing::soup(1, 0.2, 3),
            testing::soup(2, 0.2, 4),
            testing::soup(9, 0.2, 5),
        ] {
            let (positions, triangles) = (&mesh.positions[..], &mesh.triangles[..]);
            let numbers = (0..triangles.len() as u32).collect();
            let settings = Settings { budget: 2 * triangles.len(), alpha: 1e-4 };
            let nodes = build(&Mesh { positions, triangles, scale: 0.5 }, numbers, &settings);
            let (ours, theirs) = (convert(&nodes), convert_packed(&binary(&nodes)));
            assert_eq!(ours.triangles, theirs.triangles);
            assert_eq!(ours.nodes, theirs.nodes);
            assert_eq!(ours.bounds, theirs.bounds);
        }
    }
}
