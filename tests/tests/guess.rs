//! Guessing facets on a GPU never changes the picture: every form of guessing gives the same bits, on every device and for
//! any number of wavelengths and facets.

use accel::testing::Random;
use backend_vulkan::VULKAN;
use backend_wgpu::{Gpu, WGPU};
use bytemuck::{bytes_of, cast_slice};
use gemtrace_tests::gpu::{Row, entry, gpus, map, row};
use gemtrace_tests::prelude::*;
use glam::Vec3;
use spectral_core::kernel::{
    DIRECTION, NEST, SCENE, SURFACE,
    facets::{Facets, Guess},
    pack,
};
use spectral_core::prepare::Geometry;

/// A backend with its forms of guessing.
type Forms = (Backend, fn(Guess) -> Backend);

const BACKENDS: [Forms; 2] = [(WGPU, backend_wgpu::guessing), (VULKAN, backend_vulkan::guessing)];

fn view(stone: Stone, size: u32) -> Scene {
    let camera = eye(DVec3::new(3.0, -11.0, 20.0), 19.0);
    scene(camera, size, studio(), vec![stone])
}

/// `count` wavelengths.
fn lines(count: u32) -> RenderSettings {
    let wavelengths: Vec<f64> = (0..count).map(|i| 400.0 + 300.0 * f64::from(i) / f64::from(count)).collect();
    RenderSettings { threshold: 1e-4, max_depth: 24, ..settings(&wavelengths) }
}

/// Renders in every form that the devices of this machine support, and compares.
fn same_bits(scene: &Scene, settings: &RenderSettings, what: &str) {
    for (backend, guessing) in BACKENDS {
        if (backend.devices)().is_empty() {
            eprintln!("skipped: {} has no device here", backend.name);
            continue;
        }
        let expected = render(&guessing(Guess::Nothing), scene, settings);
        assert!(expected.coverage().iter().any(|share| *share > 0.0), "{what}: no stone in view");
        let able = |guess: &Guess| !(guessing(*guess).devices)().is_empty();
        for guess in [Guess::Start, Guess::Subgroup].into_iter().filter(able) {
            let (name, found) = (guess.name(), render(&guessing(guess), scene, settings));
            assert!(expected.bits() == found.bits(), "{what}: {}, guessing {name}", backend.name);
            assert_eq!(expected.report.rays, found.report.rays, "{what}: {}, {name}", backend.name);
            assert_eq!(expected.report.energy, found.report.energy, "{what}: {}, {name}", backend.name);
        }
    }
}

#[test]
fn for_any_number_of_wavelengths_polarised_or_not() {
    // As many as the invocations of a subgroup, fewer, and other numbers, for which a subgroup has wavelengths of several
    // samples. Only a few shaders, since compiling takes longer than rendering.
    for (count, polarized) in [(1, true), (8, false), (8, true), (16, true), (32, true), (33, false)] {
        let settings = RenderSettings { polarized, samples: 2, ..lines(count) };
        let scene = view(gem("round-brilliant", material("diamond")), 10);
        same_bits(&scene, &settings, &format!("{count} wavelengths, polarised {polarized}"));
    }
}

#[test]
fn for_few_facets_and_for_more_than_workgroup_memory_holds() {
    let solids = [("prism", prism(60.0, 4.0)), ("sphere", sphere(3.0, 13, 32))];
    for (name, mesh) in solids {
        let scene = view(stone(mesh, glass(1.7)), 10);
        let settings = lines(8);
        let prepared = prepared(&scene, &settings);
        let lone = prepared.lone_convex_stone().unwrap_or_else(|| panic!("{name} is one convex stone"));
        let facets = Facets::new(&prepared, Guess::Start, 16 << 10);
        assert_eq!(facets.count as usize, lone.facets.len());
        assert_eq!(facets.fits(), name != "sphere", "{name}, {} facets", facets.count);
        same_bits(&scene, &settings, name);
    }
}

#[test]
fn however_the_work_is_divided() {
    let scene = view(gem("round-brilliant", material("diamond")), 12);
    let settings = RenderSettings { samples: 5, ..lines(8) };
    for (backend, guessing) in BACKENDS {
        let form = guessing(Guess::Subgroup);
        if (form.devices)().is_empty() {
            eprintln!("skipped: {} has no device with subgroups here", backend.name);
            continue;
        }
        let whole = render(&form, &scene, &settings);
        let tiled = OpenOptions { tile: Some(3), ..OpenOptions::default() };
        let pieces = render_with(&form, &scene, &settings, &tiled, &[0..2, 2..3, 3..5]);
        assert!(whole.bits() == pieces.bits(), "{}", backend.name);
    }
}

/// A ray that starts inside the stone, arrives from outside, or leaves it.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Inside,
    Arriving,
    Leaving,
}

/// A ray through a point at 10⁻⁸ mm to a few mm from an edge of a facet, on either side: guesses can be wrong near edges
/// and corners. Origin, direction, 1 if the ray is inside.
fn ray(geometry: &Geometry, random: &mut Random, kind: Kind) -> Row {
    let triangle = geometry.triangles[random.below(geometry.triangles.len())];
    let first = random.below(3);
    let [a, b, c] = [0, 1, 2].map(|k| geometry.positions[triangle[(first + k) % 3] as usize]);
    let mut near = |scale: f64| scale * 10f64.powf(-8.0 * f64::from(random.unit()));
    let side = (1.0 - near(1.0)).clamp(0.0, 1.0);
    let on_edge = a + (b - a) * side;
    let target = on_edge + (c - on_edge) * near(1.0) - (c - on_edge).normalize() * near(1e-5);
    let normal = (b - a).cross(c - a).normalize();
    let mut towards = random.direction().as_dvec3();
    if matches!(kind, Kind::Inside | Kind::Leaving) != (towards.dot(normal) > 0.0) {
        towards = -towards;
    }
    let back = match kind {
        // At most as far as the stone extends in this direction.
        Kind::Inside => {
            let far = geometry.facets.iter().filter(|f| f.normal.dot(towards) < 0.0);
            let far = far.map(|f| (f.offset - f.normal.dot(target)) / -f.normal.dot(towards));
            far.fold(f64::INFINITY, f64::min).max(0.0) * f64::from(random.unit())
        }
        Kind::Arriving => f64::from(random.unit() * random.unit()) * 4.0,
        Kind::Leaving => 0.0,
    };
    let origin = (target - towards * back).as_vec3();
    let direction: Vec3 = towards.as_vec3();
    let inside = f32::from(u8::from(matches!(kind, Kind::Inside)));
    row(&[&origin.to_array()[..], &direction.to_array(), &[inside]].concat())
}

/// Verifies every facet for every ray: how many are accepted, and how many of these a search contradicts. `margins`
/// replaces the kernel's own.
fn trial(gpu: &Gpu, scene: &PreparedScene, rays: &[Row], margins: f32) -> [f64; 2] {
    const BODY: &str = "
        let nest = Nest(u32(in[6]), 0u, 0u);
        let query = Query(vec3(in[0], in[1], in[2]), 0u, vec3(in[3], in[4], in[5]), -scene.behind, LARGEST, nest,
            false, vec3(0.0), Nest(0u));
        let searched = facets_search(query);
        for (var facet = 0u; facet < scene.facets; facet++) {
            let answer = facet_verify(query, facet);
            let same = answer.hit.found == searched.found &&
                (!searched.found || (answer.hit.facet == searched.facet && answer.hit.t == searched.t));
            out[0] += select(0.0, 1.0, answer.known);
            out[1] += select(0.0, 1.0, answer.known && !same);
        }";
    // Without workgroup memory the tables are read from the buffers bound here.
    let facets = Facets::new(scene, Guess::Start, 0);
    let own = |margins: f32| format!("GUESS_MARGINS: f32 = {margins:?};");
    let intersect = facets.intersect();
    assert!(intersect.contains(&own(Facets::MARGINS)));
    let intersect = intersect.replace(&own(Facets::MARGINS), &own(margins));
    let constants = pack::form(scene).constants();
    let library = [&constants, SCENE, NEST, DIRECTION, SURFACE, &intersect].join("\n");
    let contents = pack::scene(scene);
    let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    let block = gpu.buffer("scene", size_of_val(&contents) as u64, uniform).expect("memory");
    gpu.queue.write_buffer(&block, 0, bytes_of(&contents));
    let filled = |what, bytes| gpu.filled(what, bytes).expect("memory");
    let planes = pack::planes(&scene.geometry);
    let planes = filled("planes", cast_slice(&planes));
    let outlines = filled("outlines", cast_slice(&facets.outlines));
    let [block, planes, outlines] = [&block, &planes, &outlines].map(wgpu::Buffer::as_entire_binding);
    let found = map(gpu, &library, BODY, &[entry(0, block), entry(3, planes), entry(5, outlines)], rays);
    [0, 1].map(|at| found.iter().map(|row| f64::from(row[at])).sum())
}

#[test]
fn an_accepted_facet_is_the_one_that_a_search_finds() {
    const RAYS: usize = 40_000;
    let solids = [
        ("brilliant", gem("round-brilliant", glass(1.7))),
        ("step", gem("step", glass(1.7))),
        ("prism", stone(prism(60.0, 4.0), glass(1.7))),
        ("sphere", stone(sphere(3.0, 9, 20), glass(1.7))),
    ];
    for gpu in gpus() {
        let mut without_margin = 0.0;
        for (name, solid) in &solids {
            let scene = prepared(&view(solid.clone(), 8), &lines(1));
            for kind in [Kind::Inside, Kind::Arriving, Kind::Leaving] {
                let mut random = Random(11);
                let rays: Vec<Row> = (0..RAYS).map(|_| ray(&scene.geometry, &mut random, kind)).collect();
                let [accepted, wrong] = trial(&gpu, &scene, &rays, Facets::MARGINS);
                println!("{name}, {kind:?}: of {RAYS} rays {accepted} accepted, {wrong} wrongly");
                assert_eq!(wrong, 0.0, "{name}, {kind:?}");
                // The distances to an edge, log-uniform from 10⁻⁸ mm to a few mm, mostly exceed the margin.
                assert!(accepted > RAYS as f64 / 3.0, "{name}, {kind:?}: {accepted}");
                without_margin += trial(&gpu, &scene, &rays, 0.0)[1];
            }
        }
        // The rays are critical enough: without a margin some facets are accepted wrongly.
        assert!(without_margin > 0.0);
    }
}
