//! The kernel with the software hierarchy is valid WGSL, and its structures lie as the Rust twins say.

use accel::{
    BuildOptions, Bvh,
    obvhs::cwbvh::node::CwBvhNode,
    software::{INTERSECT, NODE_BYTES, TriangleBlock},
    testing::icosphere,
};
use naga::{
    Module, TypeInner,
    valid::{Capabilities, ValidationFlags, Validator},
};
use spectral_core::kernel::Form;
use std::mem::offset_of;

fn module() -> Module {
    let mesh = icosphere(2);
    let bvh = Bvh::build(&mesh.positions, &mesh.triangles, &BuildOptions::default()).expect("a valid mesh");
    let form = Form { polarized: true, contacts: true, stack: 16 };
    let source = form.trace(&(bvh.wgsl_constants() + INTERSECT));
    let module =
        naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    module
}

/// Offsets of the members of a structure by name, and its span.
fn layout(module: &Module, name: &str) -> (Vec<usize>, usize) {
    let found = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name));
    match &found.unwrap_or_else(|| panic!("no structure {name}")).1.inner {
        TypeInner::Struct { members, span } => {
            (members.iter().map(|m| m.offset as usize).collect(), *span as usize)
        }
        other => panic!("{name} is {other:?}"),
    }
}

#[test]
fn nodes_and_triangles_lie_as_their_twins() {
    let module = module();
    // The kernel reads bytes four at a time: the members named here begin its words.
    let node = vec![
        offset_of!(CwBvhNode, p),
        offset_of!(CwBvhNode, e),
        offset_of!(CwBvhNode, child_base_idx),
        offset_of!(CwBvhNode, primitive_base_idx),
        offset_of!(CwBvhNode, child_meta),
        offset_of!(CwBvhNode, child_min_x),
        offset_of!(CwBvhNode, child_max_x),
        offset_of!(CwBvhNode, child_min_y),
        offset_of!(CwBvhNode, child_max_y),
        offset_of!(CwBvhNode, child_min_z),
        offset_of!(CwBvhNode, child_max_z),
    ];
    assert_eq!(layout(&module, "Node"), (node, NODE_BYTES));
    assert_eq!(offset_of!(CwBvhNode, imask), offset_of!(CwBvhNode, e) + 3);
    let triangle = vec![
        offset_of!(TriangleBlock, a),
        offset_of!(TriangleBlock, number),
        offset_of!(TriangleBlock, b),
        offset_of!(TriangleBlock, facet),
        offset_of!(TriangleBlock, c),
    ];
    assert_eq!(layout(&module, "Triangle"), (triangle, size_of::<TriangleBlock>()));
}
