//! Measures of a tree: cost by the surface area heuristic, size, and traversal steps.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;

/// The costs of steps in the surface area heuristic (MacDonald & Booth 1990; Goldsmith & Salmon 1987).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Visiting an inner node.
    pub node: f64,
    /// Testing a triangle.
    pub triangle: f64,
}

impl Weights {
    /// The usual choice for binary trees.
    pub const EQUAL: Weights = Weights { node: 1.0, triangle: 1.0 };
    /// The costs that the wide conversion minimises.
    pub const WIDE: Weights = Weights { node: 1.0, triangle: 0.3 };
}

/// The expected cost of a random line that meets the tree's box: `(Σ inner A·node + Σ leaf A·n·triangle) / A(root)`, with
/// the surface area `A` of a node's box and the reference count `n` of a leaf. Zero for an empty tree or a box without
/// area.
pub fn binary_cost(tree: &Bvh2, weights: Weights) -> f64 {
    let Some(root) = tree.nodes.first() else { return 0.0 };
    let sum: f64 = tree
        .nodes
        .iter()
        .map(|node| {
            let weight =
                if node.is_leaf() { f64::from(node.prim_count) * weights.triangle } else { weights.node };
            f64::from(node.aabb().half_area()) * weight
        })
        .sum();
    per_root(sum, root.aabb())
}

/// The same for a wide tree, with the boxes of the compressed nodes.
pub fn wide_cost(tree: &CwBvh, weights: Weights) -> f64 {
    cost(&tree.nodes, &tree.total_aabb, weights)
}

pub(crate) fn cost(nodes: &[CwBvhNode], root: &Aabb, weights: Weights) -> f64 {
    if nodes.is_empty() {
        return 0.0;
    }
    let mut sum = f64::from(root.half_area()) * weights.node;
    for node in nodes {
        for child in (0..8).filter(|&child| !node.is_child_empty(child)) {
            let weight = if node.is_leaf(child) {
                f64::from(node.child_primitives(child).1) * weights.triangle
            } else {
                weights.node
            };
            sum += f64::from(node.child_aabb(child).half_area()) * weight;
        }
    }
    per_root(sum, root)
}

fn per_root(sum: f64, root: &Aabb) -> f64 {
    let area = f64::from(root.half_area());
    if area > 0.0 { sum / area } else { 0.0 }
}

/// Levels of wide nodes, 0 for an empty tree.
pub(crate) fn depth(nodes: &[CwBvhNode]) -> usize {
    let mut depth = 0;
    let mut pending = Vec::new();
    if !nodes.is_empty() {
        pending.push((0, 1));
    }
    while let Some((index, level)) = pending.pop() {
        depth = depth.max(level);
        let node: &CwBvhNode = &nodes[index as usize];
        pending.extend(
            (0..8)
                .filter(|&child| !node.is_leaf(child) && !node.is_child_empty(child))
                .map(|child| (node.child_node_index(child), level + 1)),
        );
    }
    depth
}

/// The figures of a built [`crate::Bvh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stats {
    /// Triangles in the tree.
    pub triangles: usize,
    /// Triangles without area. They are left out, since no ray can hit them.
    pub degenerate: usize,
    /// References to triangles; spatial splits make them more than the triangles.
    pub references: usize,
    /// Wide nodes, of up to eight children.
    pub nodes: usize,
    /// Levels of wide nodes.
    pub depth: usize,
    /// Cost of the wide tree by the surface area heuristic, with [`Weights::WIDE`].
    pub cost: f64,
}

/// Counts the steps of a traversal. `()` counts nothing at no cost.
pub trait Counter {
    /// A wide node was visited: up to eight boxes tested.
    #[inline]
    fn node(&mut self) {}
    /// A triangle was tested.
    #[inline]
    fn triangle(&mut self) {}
}

impl Counter for () {}

/// The work of one or more rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Steps {
    /// Wide nodes visited.
    pub nodes: u64,
    /// Triangles tested.
    pub triangles: u64,
}

impl Counter for Steps {
    fn node(&mut self) {
        self.nodes += 1;
    }

    fn triangle(&mut self) {
        self.triangles += 1;
    }
}
