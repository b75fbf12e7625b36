//! The kernel is valid WGSL in every form, and its structures have the layout of their Rust counterparts.

use naga::{
    Module, TypeInner,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};
use spectral_core::kernel::{
    ENABLE_RAY_QUERY, Form, INTERSECT_RAY_QUERY,
    block::{Batch, Plane, Primary, RESULT_BYTES, Scene, Tally, ray_bytes, walk_bytes},
    facets::{Facets, Guess},
};
use spectral_core::{
    material::Catalogue,
    mesh::{Mesh, MeshOptions},
    prepare::PreparedScene,
    scene::{Scene as Described, Stone},
    settings::RenderSettings,
};
use std::f64::consts::TAU;
use std::mem::offset_of;
use std::sync::Arc;

fn forms() -> impl Iterator<Item = Form> {
    let form = |bits: u32| {
        let [polarized, contacts, crystals] = [1, 2, 4].map(|bit| bits & bit != 0);
        Form { polarized, contacts, crystals, stack: 16 }
    };
    (0..8).map(form)
}

fn parsed(source: &str) -> Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
}

fn validated(module: &Module, source: &str, able: Capabilities) -> ModuleInfo {
    Validator::new(ValidationFlags::all(), able)
        .validate(module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
}

/// A prism over a regular polygon.
fn facets(sides: u32, guess: Guess) -> Facets {
    let corner = |i: u32, z: f64| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
        [cos, sin, z].into()
    };
    let positions = [-1.0, 1.0].into_iter().flat_map(|z| (0..sides).map(move |i| corner(i, z))).collect();
    let wall = |i: u32| {
        let j = (i + 1) % sides;
        [[i, j, sides + j], [i, sides + j, sides + i]]
    };
    let ends = |i: u32| [[0, i + 1, i], [sides, sides + i, sides + i + 1]];
    let triangles = (0..sides).flat_map(wall).chain((1..sides - 1).flat_map(ends)).collect();
    let mesh = Mesh::from_triangles(positions, triangles, &MeshOptions::default()).expect("a closed mesh").0;
    let quartz = Catalogue::builtin().get("quartz").expect("a built-in material").clone();
    let scene = Described::in_studio(vec![Stone::new("prism", Arc::new(mesh), Arc::new(quartz))]);
    let scene =
        PreparedScene::new(&scene, &RenderSettings::default().with_samples(1)).expect("a valid scene");
    Facets::new(&scene, guess, 16 << 10)
}

#[test]
fn the_table_of_outlines_lists_each_facets_neighbours() {
    let facets = facets(3, Guess::Start);
    assert_eq!(facets.count, 5);
    let list = |facet: usize| {
        let [begin, end] = [facet, facet + 1].map(|place| facets.outlines[place] as usize);
        &facets.outlines[begin..end]
    };
    // Each side face meets the other side faces and both ends, each end the three side faces.
    let sizes: Vec<_> = (0..5).map(|facet| list(facet).len()).collect();
    assert_eq!(sizes.iter().filter(|size| **size == 4).count(), 3);
    assert_eq!(sizes.iter().filter(|size| **size == 3).count(), 2);
    assert_eq!(facets.outlines[0], 6);
    assert_eq!(facets.outlines[5] as usize, facets.outlines.len());
    assert!(
        (0..5).all(|facet| list(facet).iter().all(|other| list(*other as usize).contains(&(facet as u32))))
    );
}

#[test]
fn every_form_is_valid() {
    for form in forms() {
        let none = Capabilities::empty();
        let gathers = [true, false].map(|chain| (form.gather(chain), "gather", none));
        let mut texts = [&[(form.prime(), "prime", none)], &gathers[..]].concat();
        for guess in Guess::ALL {
            let able = if guess == Guess::Subgroup { Capabilities::SUBGROUP } else { Capabilities::empty() };
            // In workgroup memory, and in storage buffers.
            texts.extend([32, 500].map(|sides| (form.trace_facets(&facets(sides, guess)), "trace", able)));
        }
        for (source, entry, able) in texts {
            let module = parsed(&source);
            validated(&module, &source, able);
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
fn structures_have_the_layout_of_their_counterparts() {
    for form in forms() {
        let trace = parsed(&form.trace_facets(&facets(32, Guess::Start)));
        let tree = parsed(&(ENABLE_RAY_QUERY.to_owned() + &form.trace(INTERSECT_RAY_QUERY)));
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
                grazing,
                facets,
                width,
                tables,
                reach,
                depth,
                middle,
                split,
                centre,
                right,
                down,
                forward,
                across,
                along,
                eye
            }
        );
        same_layout!(&trace, Plane { normal, offset, rank });
        same_layout!(&trace, Primary { origin, first_line, direction, near, background });
        same_layout!(&trace, Batch { pixels, first, count, budget, resume, spectral, fresh });
        assert_eq!(layout(&trace, "Result").1 as u64, RESULT_BYTES);
        assert_eq!(layout(&tree, "Ray").1 as u64, ray_bytes(form.rows()));
        assert_eq!(layout(&tree, "Walk").1 as u64, walk_bytes(form.rows()));
        for chain in [true, false] {
            let gather = parsed(&form.gather(chain));
            same_layout!(&gather, Tally { energies, rays, going });
            assert_eq!(layout(&gather, "Result"), layout(&trace, "Result"));
        }
        assert_eq!(layout(&parsed(&form.gather(false)), "Walk"), layout(&tree, "Walk"));
    }
}
