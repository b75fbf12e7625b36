//! A picture of one convex stone, in rays, on every device in every form of guessing: `cargo bench -p gemtrace-wgpu`.
//!
//! `guessing nothing` compares all planes; the others are what it is to be compared with. To choose between them on a GPU,
//! run this there.

use backend_wgpu::{WGPU, guessing};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use spectral_core::{
    film::Film,
    kernel::facets::Guess,
    material::Catalogue,
    prepare::PreparedScene,
    scene::{Scene, Stone},
    settings::RenderSettings,
    shape::ShapeSpec,
    tracer::{OpenOptions, TraceReport, Tracer},
    wavelength::WavelengthGrid,
};
use std::ops::ControlFlow;
use std::sync::Arc;

/// A diamond brilliant, `size` × `size` pixels and 32 wavelengths.
fn diamond(size: u32) -> Arc<PreparedScene> {
    let cut = ShapeSpec::by_name("round-brilliant").and_then(|shape| shape.cut()).expect("a built-in cut");
    let mesh = Arc::new(cut.solid().expect("it closes").0);
    let material = Catalogue::builtin().get("diamond").expect("a built-in material").clone();
    let stone = Stone { width: Some(6.5), ..Stone::new("brilliant", mesh, Arc::new(material)) };
    let scene = Scene { width: size, height: size, ..Scene::in_studio(vec![stone]) };
    let wavelengths = WavelengthGrid::midpoints([400.0, 700.0], 32).expect("a valid grid");
    let settings =
        RenderSettings { wavelengths, threshold: 1e-3, ..RenderSettings::default().with_samples(1) };
    Arc::new(PreparedScene::new(&scene, &settings).expect("a valid scene"))
}

fn trace(tracer: &mut dyn Tracer, film: &mut Film) -> TraceReport {
    tracer.trace(0..1, film, &mut |_| ControlFlow::Continue(())).expect("the device traces")
}

fn pictures(criterion: &mut Criterion) {
    if (WGPU.devices)().is_empty() {
        println!("nothing to measure: this machine has no device that wgpu can compute on");
    }
    let mut group = criterion.benchmark_group("picture");
    group.sample_size(10);
    for guess in Guess::ALL {
        let backend = guessing(guess);
        for device in (backend.devices)() {
            // Enough to fill a GPU; little enough for a software device.
            let scene = diamond(if device.hardware { 512 } else { 16 });
            let mut film = Film::new(&scene);
            let opened = backend.tracer(&device, Arc::clone(&scene), &OpenOptions::default());
            let mut tracer = opened.expect("a device that is listed opens");
            group.throughput(Throughput::Elements(trace(tracer.as_mut(), &mut film).rays));
            let name = format!("{}, guessing {}", device.name, guess.name());
            group.bench_function(name, |bencher| bencher.iter(|| trace(tracer.as_mut(), &mut film)));
        }
    }
    group.finish();
}

criterion_group!(benches, pictures);
criterion_main!(benches);
