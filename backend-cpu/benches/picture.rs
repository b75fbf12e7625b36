//! Small pictures, in rays: `cargo bench -p gemtrace-cpu`.
//!
//! One convex stone is a chain of surfaces against facet planes; two stones and a non-convex one are trees of rays
//! through the hierarchy.

use backend_cpu::CPU;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use spectral_core::{
    film::Film,
    material::Catalogue,
    mesh::{Mesh, MeshOptions},
    prepare::PreparedScene,
    scene::{Scene, Stone},
    settings::RenderSettings,
    shape::ShapeSpec,
    tracer::{OpenOptions, TraceReport, Tracer},
    wavelength::WavelengthGrid,
};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;

fn stone(mesh: Mesh, material: &str) -> Stone {
    let material = Catalogue::builtin().get(material).expect("a built-in material").clone();
    Stone::new(material.name.clone(), Arc::new(mesh), Arc::new(material))
}

fn brilliant(width: f64, material: &str) -> Stone {
    let cut = ShapeSpec::by_name("round-brilliant").and_then(|shape| shape.cut()).expect("a built-in cut");
    Stone { width: Some(width), ..stone(cut.solid().expect("it closes").0, material) }
}

/// A diamond inside a quartz.
fn nested() -> Vec<Stone> {
    let inclusion = Stone { position: DVec3::new(0.3, 0.1, -0.2), ..brilliant(1.5, "diamond") };
    vec![brilliant(6.5, "quartz"), inclusion]
}

/// A torus about the z axis, 1152 triangles.
fn torus() -> Stone {
    const AROUND: u32 = 48;
    const ACROSS: u32 = 12;
    let point = |i: u32, j: u32| {
        let (turn, tilt) = (TAU * f64::from(i) / f64::from(AROUND), TAU * f64::from(j) / f64::from(ACROSS));
        let out = 2.2 + 0.8 * tilt.cos();
        DVec3::new(out * turn.cos(), out * turn.sin(), 0.8 * tilt.sin())
    };
    let positions = (0..AROUND).flat_map(|i| (0..ACROSS).map(move |j| point(i, j))).collect();
    let index = |i: u32, j: u32| (i % AROUND) * ACROSS + j % ACROSS;
    let triangles = (0..AROUND * ACROSS).flat_map(|k| {
        let (i, j) = (k / ACROSS, k % ACROSS);
        let corners = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
        [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    });
    let mesh = Mesh::from_triangles(positions, triangles.collect(), &MeshOptions::default());
    stone(mesh.expect("a closed mesh").0, "quartz")
}

/// A tracer, a film for it, and the rays of one picture.
fn open(stones: Vec<Stone>, size: u32, wavelengths: usize, polarized: bool) -> (Box<dyn Tracer>, Film, u64) {
    let scene = Scene { width: size, height: size, ..Scene::in_studio(stones) };
    let wavelengths = WavelengthGrid::midpoints([380.0, 740.0], wavelengths).expect("a valid grid");
    let settings = RenderSettings {
        wavelengths,
        threshold: 1e-3,
        polarized,
        ..RenderSettings::default().with_samples(1)
    };
    let scene = Arc::new(PreparedScene::new(&scene, &settings).expect("a valid scene"));
    let mut film = Film::new(&scene);
    let mut tracer =
        CPU.tracer(&(CPU.devices)()[0], scene, &OpenOptions::default()).expect("the processor opens");
    let rays = trace(tracer.as_mut(), &mut film).rays;
    (tracer, film, rays)
}

fn trace(tracer: &mut dyn Tracer, film: &mut Film) -> TraceReport {
    tracer.trace(0..1, film, &mut |_| ControlFlow::Continue(())).expect("the processor traces")
}

fn pictures(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("picture");
    group.sample_size(10);
    for (name, stones, size, wavelengths, polarized) in [
        ("one stone, 8 wavelengths, scalar", vec![brilliant(6.5, "diamond")], 64, 8, false),
        ("one stone, 8 wavelengths, polarised", vec![brilliant(6.5, "diamond")], 64, 8, true),
        ("one stone, 32 wavelengths, scalar", vec![brilliant(6.5, "diamond")], 48, 32, false),
        ("one stone, 32 wavelengths, polarised", vec![brilliant(6.5, "diamond")], 48, 32, true),
        ("nested stones, 8 wavelengths, polarised", nested(), 32, 8, true),
        ("torus, 8 wavelengths, polarised", vec![torus()], 32, 8, true),
    ] {
        let (mut tracer, mut film, rays) = open(stones, size, wavelengths, polarized);
        group.throughput(Throughput::Elements(rays));
        group.bench_function(name, |bencher| bencher.iter(|| trace(tracer.as_mut(), &mut film)));
    }
    group.finish();
}

criterion_group!(benches, pictures);
criterion_main!(benches);
