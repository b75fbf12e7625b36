//! The hierarchy for GPUs: its traversal in WGSL, and its nodes and triangles as bytes.

use bytemuck::{Pod, Zeroable};

use crate::{Bvh, slabs};

/// The WGSL function `intersect` of gemtrace's kernel for this hierarchy; needs [`Bvh::wgsl_constants`].
pub const INTERSECT: &str = include_str!("intersect_software.wgsl");

/// A triangle in the layout of `Triangle` in `intersect_software.wgsl`.
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
    /// Unused.
    pub padding: u32,
}

/// Size of `Node` in `intersect_software.wgsl`, bytes.
pub const NODE_BYTES: usize = size_of::<obvhs::cwbvh::node::CwBvhNode>();

impl Bvh {
    /// The constants of [`INTERSECT`] for this hierarchy, in WGSL.
    pub fn wgsl_constants(&self) -> String {
        format!(
            "const WIDENING: f32 = {:?};\nconst STEEPEST: f32 = {:?};\nconst TRAVERSAL_STACK: u32 = {};\n",
            f64::from(slabs::WIDENING),
            f64::from(slabs::STEEPEST),
            self.stack_size(),
        )
    }

    /// Units of the nodes' boxes per unit of the mesh: a power of two.
    pub fn builder_scale(&self) -> f32 {
        self.scale
    }

    /// The largest stack of a traversal: seven siblings of the visited node on each level. Rounded up, so that scenes
    /// share compiled shaders.
    fn stack_size(&self) -> usize {
        (7 * self.stats().depth + 2).next_multiple_of(32)
    }

    /// All nodes, [`NODE_BYTES`] each, the root first. Empty for an empty mesh.
    pub fn node_bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.nodes)
    }

    /// All references in the order of the nodes. `facet_of` gives the facet of a triangle by its index in the input.
    pub fn triangle_blocks(&self, facet_of: impl Fn(u32) -> u32) -> Vec<TriangleBlock> {
        let block = |reference: &crate::triangle::Triangle| {
            let [a, b, c] = *reference.corners();
            let number = reference.number();
            TriangleBlock { a, number, b, facet: facet_of(number), c, padding: 0 }
        };
        self.references.iter().map(block).collect()
    }
}
