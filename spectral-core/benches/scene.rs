//! The time of preparing a scene and of evaluating environments: `cargo bench -p gemtrace-core --bench scene`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use spectral_core::{
    environment::{Environment, LatLong},
    material::Catalogue,
    prepare::PreparedScene,
    scene::{Scene, Stone},
    settings::RenderSettings,
    shape::ShapeSpec,
    wavelength::WavelengthGrid,
};
use std::hint::black_box;
use std::sync::Arc;

fn diamond() -> Scene {
    let cut = ShapeSpec::by_name("round-brilliant").and_then(|shape| shape.cut()).expect("a built-in cut");
    let mesh = Arc::new(cut.solid().expect("it closes").0);
    let material = Catalogue::builtin().get("diamond").expect("a built-in material").clone();
    let stone = Stone { width: Some(6.5), ..Stone::new("brilliant", mesh, Arc::new(material)) };
    Scene::in_studio(vec![stone])
}

/// From planes to facets, and from a scene to a prepared scene.
fn preparing(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("solid of a cut");
    for name in ShapeSpec::NAMES {
        let cut = ShapeSpec::by_name(name).and_then(|shape| shape.cut()).expect("a built-in cut");
        group.throughput(Throughput::Elements(cut.facets.len() as u64));
        group.bench_function(name, |bencher| bencher.iter(|| black_box(&cut).solid()));
    }
    group.finish();

    let mut group = criterion.benchmark_group("preparing 16 jittered samples");
    let scene = diamond();
    for count in [1, 2, 4, 6, 8, 32] {
        let wavelengths = WavelengthGrid::midpoints([380.0, 740.0], count).expect("a valid grid");
        let settings = RenderSettings { wavelengths, ..RenderSettings::default().with_samples(16) };
        group.bench_function(format!("{count} wavelengths"), |bencher| {
            bencher.iter(|| PreparedScene::new(black_box(&scene), &settings));
        });
    }
    let settings = RenderSettings::default();
    let prepared = PreparedScene::new(&scene, &settings).expect("a valid scene");
    group.bench_function("another camera", |bencher| {
        let mut scene = scene.clone();
        bencher.iter(|| {
            scene.camera.position.x += 1e-6;
            prepared.update(black_box(&scene), &settings)
        });
    });
    group.finish();
}

/// A thousand look-ups of the environment.
fn looking(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("environment");
    group.throughput(Throughput::Elements(1000));
    let studio = Environment::image(LatLong::studio());
    let directions: Vec<DVec3> = (0..1000)
        .map(|i| {
            let z = 1.0 - f64::from(2 * i + 1) / 1000.0;
            let (sin, cos) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
            let out = (1.0 - z * z).sqrt();
            DVec3::new(out * cos, out * sin, z)
        })
        .collect();
    group.bench_function("1000 look-ups", |bencher| {
        bencher.iter(|| {
            for direction in &directions {
                black_box(studio.rgb(*direction));
            }
        });
    });
    group.finish();
}

criterion_group!(benches, preparing, looking);
criterion_main!(benches);
