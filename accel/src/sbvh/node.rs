//! A node of the binary tree, in 32 bytes.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::cost::{Costs, Form};
use crate::bounds::Bounds;

/// A node of the binary tree in the builder's sparse array. Vacant entries are all zero bits.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Node {
    lo: [f32; 3],
    link: u32,
    hi: [f32; 3],
    form: Form,
}

impl Node {
    /// The box of one reference to a triangle.
    pub fn leaf(bounds: Bounds, triangle: u32) -> (Node, Costs) {
        (Node::new(bounds, triangle, Form::LEAF), Costs::leaf(bounds.half_area()))
    }

    /// A node with children at `first` and `first + 1`, of the given costs.
    pub fn inner(bounds: Bounds, first: usize, left: &Costs, right: &Costs) -> (Node, Costs) {
        let (form, costs) = Costs::inner(bounds.half_area(), left, right);
        (Node::new(bounds, first as u32, form), costs)
    }

    fn new(bounds: Bounds, link: u32, form: Form) -> Node {
        let (lo, hi) = bounds.corners();
        Node { lo: lo.into(), link, hi: hi.into(), form }
    }

    pub fn lo(&self) -> Vec3 {
        self.lo.into()
    }

    pub fn hi(&self) -> Vec3 {
        self.hi.into()
    }

    /// For an inner node, the index of the first of two adjacent children; for a leaf, its triangle.
    pub fn link(&self) -> u32 {
        self.link
    }

    /// The cheapest way to build its subtree from wide nodes.
    pub fn form(&self) -> Form {
        self.form
    }

    pub fn is_leaf(&self) -> bool {
        self.form == Form::LEAF
    }
}
