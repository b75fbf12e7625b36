//! From the binary tree to the eight-way compressed tree (Ylitie, Karras & Laine 2017) through `obvhs`.

use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;

use crate::sbvh::Node;

/// References that the conversion may gather in one leaf; the node format holds no more.
const LEAF: u32 = 3;

/// Packs the builder's sparse array into `obvhs`'s binary tree: siblings side by side, one reference a leaf,
/// in depth-first order, so that subtrees lie together in memory.
pub(crate) fn binary(nodes: &[Node]) -> Bvh2 {
    let count = nodes.len();
    let mut packed = Vec::with_capacity(count);
    let mut primitives = Vec::with_capacity(count.div_ceil(2));
    let mut pending = Vec::new();
    if let Some(root) = nodes.first() {
        packed.push(Bvh2Node::new(aabb(root), 0, 0));
        pending.push((0, 0));
    }
    while let Some((from, to)) = pending.pop() {
        let node: &Node = &nodes[from];
        if node.leaf {
            packed[to] = Bvh2Node::new(aabb(node), 1, primitives.len() as u32);
            primitives.push(node.link);
            continue;
        }
        let (child, place) = (node.link as usize, packed.len());
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

/// Lets `obvhs` move subtrees to where they cost less (Meister & Bittner 2018).
pub(crate) fn reinsert(tree: &mut Bvh2, ratio: f32) {
    if ratio > 0.0 {
        ReinsertionOptimizer::default().run(tree, ratio, None);
    }
}

/// The wide tree; its `primitive_indices` name the triangle of each reference in traversal order.
pub(crate) fn convert(tree: &Bvh2) -> CwBvh {
    bvh2_to_cwbvh(tree, LEAF, true, false)
}

fn aabb(node: &Node) -> Aabb {
    let (lo, hi) = node.bounds.corners();
    Aabb::new(lo.into(), hi.into())
}
