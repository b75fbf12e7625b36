//! Pictures, in rays a second, on every device of this machine: `cargo bench -p gemtrace-tests`.
//!
//! On the processor, one convex stone is a chain of surfaces against facet planes; two stones and a non-convex one are
//! trees of rays through the hierarchy. A GPU renders one convex stone in every form of guessing and of intersection;
//! `guessing nothing`, which compares all planes, is the baseline of the others.

use backend_vulkan::Intersection;
use criterion::{
    BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use gemtrace_tests::prelude::{prepared as prepare, *};
use spectral_core::kernel::facets::Guess;

fn pictures(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("picture");
    group.sample_size(10);
    let diamond = || vec![gem("round-brilliant", material("diamond"))];
    let inclusion = at(Stone { width: Some(1.5), ..diamond().remove(0) }, [0.3, 0.1, -0.2]);
    let nested = vec![gem("round-brilliant", material("quartz")), inclusion];
    let torus = vec![stone(torus(2.2, 0.8, 48, 12), material("quartz"))];
    for (name, stones, size, wavelengths, polarized) in [
        ("one stone, 8 wavelengths, scalar", diamond(), 64, 8, false),
        ("one stone, 8 wavelengths, polarised", diamond(), 64, 8, true),
        ("one stone, 32 wavelengths, scalar", diamond(), 48, 32, false),
        ("one stone, 32 wavelengths, polarised", diamond(), 48, 32, true),
        ("nested stones, 8 wavelengths, polarised", nested, 32, 8, true),
        ("torus, 8 wavelengths, polarised", torus, 32, 8, true),
    ] {
        let scene = prepared(stones, size, wavelengths, polarized);
        picture(&mut group, name, &CPU, &(CPU.devices)()[0], &scene);
    }
    let wgpu = Guess::ALL.map(|guess| (format!("guessing {}", guess.name()), backend_wgpu::guessing(guess)));
    let vulkan =
        Guess::ALL.map(|guess| (format!("guessing {}", guess.name()), backend_vulkan::guessing(guess)));
    let forms = Intersection::ALL.map(|form| (form.name().to_owned(), form.backend()));
    for (form, backend) in wgpu.into_iter().chain(vulkan).chain(forms) {
        for device in (backend.devices)() {
            // Enough to fill a GPU, and little enough for a software device.
            let scene = prepared(diamond(), if device.hardware { 512 } else { 16 }, 32, true);
            picture(
                &mut group,
                &format!("{}, {}, {form}", device.backend, device.name),
                &backend,
                &device,
                &scene,
            );
        }
    }
    group.finish();
}

fn prepared(stones: Vec<Stone>, size: u32, wavelengths: usize, polarized: bool) -> Arc<PreparedScene> {
    let scene = Scene { width: size, height: size, ..Scene::in_studio(stones) };
    let wavelengths = WavelengthGrid::midpoints([380.0, 740.0], wavelengths).expect("a valid grid");
    let settings = RenderSettings {
        wavelengths,
        threshold: 1e-3,
        polarized,
        ..RenderSettings::default().with_samples(1)
    };
    prepare(&scene, &settings)
}

fn picture(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    backend: &Backend,
    device: &DeviceInfo,
    scene: &Arc<PreparedScene>,
) {
    let mut film = Film::new(scene);
    let opened = backend.tracer(device, scene.clone(), &OpenOptions::default());
    let mut tracer = opened.expect("a device that is listed opens");
    group.throughput(Throughput::Elements(trace(tracer.as_mut(), 0..1, &mut film).rays));
    group.bench_function(name, |bencher| bencher.iter(|| trace(tracer.as_mut(), 0..1, &mut film)));
}

criterion_group!(benches, pictures);
criterion_main!(benches);
