//! The kernel with the software hierarchy is valid WGSL, and its structures have the layout of their Rust counterparts.

use accel::{
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
    let form = Form { polarized: true, contacts: true, crystals: false, stack: 16 };
    let source = form.trace(&(icosphere(2).bvh().wgsl_constants() + INTERSECT));
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
fn nodes_and_triangles_have_the_layout_of_their_counterparts() {
    let module = module();
    // The kernel reads four bytes at a time; these members begin its words.
    macro_rules! offsets {
        ($of:ident: $($field:ident)*) => { vec![$(offset_of!($of, $field)),*] };
    }
    let node = offsets!(CwBvhNode: p e child_base_idx primitive_base_idx child_meta child_min_x child_max_x child_min_y
        child_max_y child_min_z child_max_z);
    assert_eq!(layout(&module, "Node"), (node, NODE_BYTES));
    assert_eq!(offset_of!(CwBvhNode, imask), offset_of!(CwBvhNode, e) + 3);
    let triangle = offsets!(TriangleBlock: a number b facet c);
    assert_eq!(layout(&module, "Triangle"), (triangle, size_of::<TriangleBlock>()));
}
