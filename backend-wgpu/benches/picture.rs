//! A small picture, in rays, on every device: `cargo bench -p backend-wgpu`.

use backend_wgpu::WGPU;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use spectral_core::{
    film::Film,
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

/// A diamond brilliant, 32 × 32 pixels and 4 wavelengths: a software device has to manage, too.
fn diamond() -> Arc<PreparedScene> {
    let cut = ShapeSpec::by_name("round-brilliant").and_then(|shape| shape.cut()).expect("a built-in cut");
    let mesh = Arc::new(cut.solid().expect("it closes").0);
    let material = Catalogue::builtin().get("diamond").expect("a built-in material").clone();
    let stone = Stone { width: Some(6.5), ..Stone::new("brilliant", mesh, Arc::new(material)) };
    let scene = Scene { width: 32, height: 32, ..Scene::in_studio(vec![stone]) };
    let wavelengths = WavelengthGrid::midpoints([400.0, 700.0], 4).expect("a valid grid");
    let settings = RenderSettings { samples: 1, wavelengths, threshold: 1e-3, ..RenderSettings::default() };
    Arc::new(PreparedScene::new(&scene, &settings).expect("a valid scene"))
}

fn trace(tracer: &mut dyn Tracer, film: &mut Film) -> TraceReport {
    tracer.trace(0..1, film, &mut |_| ControlFlow::Continue(())).expect("the device traces")
}

fn pictures(criterion: &mut Criterion) {
    let devices = (WGPU.devices)();
    if devices.is_empty() {
        println!("nothing to measure: this machine has no device that wgpu can compute on");
    }
    let scene = diamond();
    let mut group = criterion.benchmark_group("picture");
    group.sample_size(10);
    for device in devices {
        let mut film = Film::new(&scene);
        let opened = (WGPU.open)(&device, Arc::clone(&scene), &OpenOptions::default());
        let mut tracer = opened.expect("a device that is listed opens");
        group.throughput(Throughput::Elements(trace(tracer.as_mut(), &mut film).rays));
        group.bench_function(&device.name, |bencher| bencher.iter(|| trace(tracer.as_mut(), &mut film)));
    }
    group.finish();
}

criterion_group!(benches, pictures);
criterion_main!(benches);
