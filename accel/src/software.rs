//! The hierarchy for the GPU: its traversal in WGSL, and its nodes and triangles as bytes.

use bytemuck::{Pod, Zeroable};

use crate::{Bvh, traverse};

/// `intersect` of gemtrace's kernel by this hierarchy; needs [`Bvh::wgsl_constants`].
pub const INTERSECT: &str = include_str!("intersect_software.wgsl");

/// A triangle as the kernel reads it: the Rust twin of `Triangle` in `intersect_software.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TriangleBlock {
    /// First corner.
    pub a: [f32; 3],
    /// Index in the input.
    pub number: u32,
    /// Second corner.
    pub b: [f32; 3],
    /// Index of its facet.
    pub facet: u32,
    /// Third corner.
    pub c: [f32; 3],
    /// Nothing.
    pub padding: u32,
}

/// Bytes of a node: `Node` in `intersect_software.wgsl`.
pub const NODE_BYTES: usize = size_of::<obvhs::cwbvh::node::CwBvhNode>();

impl Bvh {
    /// The WGSL text of the constants of [`INTERSECT`] for this hierarchy.
    pub fn wgsl_constants(&self) -> String {
        format!(
            "const WIDENING: f32 = {:?};\nconst STEEPEST: f32 = {:?};\nconst TRAVERSAL_STACK: u32 = {};\n",
            f64::from(traverse::WIDENING),
            f64::from(traverse::STEEPEST),
            self.most_waiting(),
        )
    }

    /// Units of the nodes' boxes per unit of the mesh: a power of two.
    pub fn builder_scale(&self) -> f32 {
        self.scale
    }

    /// The most nodes that wait during a traversal: on each level seven siblings of the one that is visited.
    /// Rounded up, so that scenes share compiled shaders.
    fn most_waiting(&self) -> usize {
        (7 * self.stats().depth + 2).next_multiple_of(32)
    }

    /// All nodes, [`NODE_BYTES`] each, the root first. Empty for an empty mesh.
    pub fn node_bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.nodes)
    }

    /// All references in the order of the nodes, with the facet of each as `facet_of` gives it by the triangle's
    /// index in the input.
    pub fn triangle_blocks(&self, facet_of: impl Fn(u32) -> u32) -> Vec<TriangleBlock> {
        let block = |reference: &crate::triangle::Triangle| {
            let [a, b, c] = *reference.corners();
            let number = reference.number();
            TriangleBlock { a, number, b, facet: facet_of(number), c, padding: 0 }
        };
        self.references.iter().map(block).collect()
    }
}
