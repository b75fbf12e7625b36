//! The kernel is valid WGSL in every form, and its structures lie as the Rust twins say.

use naga::{
    Module, TypeInner,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};
use spectral_core::kernel::{
    ENABLE_RAY_QUERY, Form, INTERSECT_PLANES, INTERSECT_RAY_QUERY,
    block::{Gathering, Plane, Primary, Scene, Seen, Work, ray_bytes, walk_bytes},
};
use std::mem::offset_of;

fn forms() -> impl Iterator<Item = Form> {
    [(true, true), (true, false), (false, true), (false, false)]
        .into_iter()
        .map(|(polarized, contacts)| Form { polarized, contacts, stack: 16, workgroup: 64 })
}

fn parsed(source: &str) -> Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
}

fn validated(module: &Module, source: &str, able: Capabilities) -> ModuleInfo {
    Validator::new(ValidationFlags::all(), able)
        .validate(module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
}

#[test]
fn every_form_is_valid() {
    for form in forms() {
        for (source, entry) in [(form.trace(INTERSECT_PLANES), "trace"), (form.gather(), "gather")] {
            let module = parsed(&source);
            validated(&module, &source, Capabilities::empty());
            assert_eq!(module.entry_points.len(), 1);
            assert_eq!(module.entry_points[0].name, entry);
            assert_eq!(module.entry_points[0].workgroup_size, [64, 1, 1]);
        }
    }
}

#[test]
fn ray_tracing_forms_are_valid() {
    for form in forms() {
        let queried = ENABLE_RAY_QUERY.to_owned() + &form.trace(INTERSECT_RAY_QUERY);
        let module = parsed(&queried);
        validated(&module, &queried, Capabilities::RAY_QUERY);
        assert_eq!(module.entry_points.len(), 1);
        let piped = form.trace_pipeline();
        let module = parsed(&piped);
        validated(&module, &piped, Capabilities::RAY_TRACING_PIPELINE | Capabilities::PRIMITIVE_INDEX);
        let names: Vec<_> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(names, ["trace", "consider", "pass_by"]);
    }
}

/// Offsets of the members of a structure by name, and its span.
fn layout(module: &Module, name: &str) -> (Vec<(String, usize)>, usize) {
    let found = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name));
    match &found.unwrap_or_else(|| panic!("no structure {name}")).1.inner {
        TypeInner::Struct { members, span } => {
            let offset = |m: &naga::StructMember| (m.name.clone().unwrap_or_default(), m.offset as usize);
            (members.iter().map(offset).collect(), *span as usize)
        }
        other => panic!("{name} is {other:?}"),
    }
}

macro_rules! same_layout {
    ($module:expr, $twin:ident { $($field:ident),* }) => {{
        let (members, span) = layout($module, stringify!($twin));
        let expected = vec![$((stringify!($field).to_owned(), offset_of!($twin, $field))),*];
        assert_eq!(members, expected, stringify!($twin));
        // A uniform block may end before its padding.
        assert_eq!(span.next_multiple_of(16), size_of::<$twin>(), "span of {}", stringify!($twin));
    }};
}

#[test]
fn structures_lie_as_their_twins() {
    for form in forms() {
        let trace = parsed(&form.trace(INTERSECT_PLANES));
        same_layout!(
            &trace,
            Scene {
                light,
                turn,
                margin,
                behind,
                contact,
                threshold,
                eye_nest,
                max_depth,
                lines,
                materials,
                image,
                leave_at_limit,
                transparent,
                builder_scale,
                gain,
                ground_height,
                sky,
                ground_low,
                ground_per_mm,
                ground_last,
                grazing
            }
        );
        same_layout!(&trace, Plane { normal, offset, rank });
        same_layout!(&trace, Primary { origin, first_line, direction, near, background });
        same_layout!(&trace, Work { items, budget, resume });
        let gather = parsed(&form.gather());
        same_layout!(&gather, Gathering { samples, spectral });
        same_layout!(&gather, Seen { xyz, coverage, energies, rays, going });
        assert_eq!(layout(&trace, "Ray").1 as u64, ray_bytes(form.polarized));
        assert_eq!(layout(&trace, "Walk").1 as u64, walk_bytes(form.polarized));
        assert_eq!(layout(&gather, "Walk"), layout(&trace, "Walk"));
    }
}
