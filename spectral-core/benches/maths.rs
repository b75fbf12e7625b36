//! The time of surface events, curves and colours: `cargo bench -p gemtrace-core --bench maths`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use spectral_core::{
    Real,
    cie::Illuminant,
    color::Response,
    dispersion::{Dispersion, fraunhofer},
    fresnel::dielectric,
    material::Catalogue,
    stokes::{StokesRow, align, any_axis},
    upsample::Upsampler,
    wavelength::WavelengthGrid,
};
use std::hint::black_box;

/// Repetitions of small operations that are timed together.
const COUNT: u64 = 1000;

/// Unit vectors spread over the sphere by the golden ratio.
fn directions<T: Real>() -> Vec<[T; 3]> {
    (0..COUNT)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / COUNT as f64;
            let (sin, cos) = (2.399_963_229_728_653 * i as f64).sin_cos();
            let out = (1.0 - z * z).sqrt();
            [out * cos, out * sin, z].map(T::from_f64)
        })
        .collect()
}

fn grid(count: usize) -> WavelengthGrid {
    WavelengthGrid::midpoints([380.0, 740.0], count).expect("a valid grid")
}

/// One surface event inside a diamond, as in transport: rotation into the plane of incidence, Fresnel's equations, and both
/// children.
fn event<T: Real>(direction: [T; 3], normal: [T; 3], eta: T) -> [StokesRow<T>; 2] {
    let aligned = align(direction, any_axis(direction), normal);
    let row = StokesRow::<T>::eye().rotated(aligned.cos2, aligned.sin2);
    let cos = direction.iter().zip(normal).fold(T::ZERO, |sum, (&d, n)| sum + d * n);
    let fresnel = dielectric(cos.max(-cos), eta);
    [row.reflected(&fresnel), row.refracted(&fresnel)]
}

/// Keeps the compiler from removing an unused result.
fn consume<T>(result: T) {
    black_box(result);
}

fn surfaces(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("1000 surfaces");
    group.throughput(Throughput::Elements(COUNT));
    let (single, double) = (directions::<f32>(), directions::<f64>());
    group.bench_function("polarised, single precision", |bencher| {
        let normal = black_box([0.0, 0.6, 0.8]);
        bencher.iter(|| single.iter().map(|d| event(*d, normal, 2.4)).for_each(consume));
    });
    group.bench_function("polarised, double precision", |bencher| {
        let normal = black_box([0.0, 0.6, 0.8]);
        bencher.iter(|| double.iter().map(|d| event(*d, normal, 2.4)).for_each(consume));
    });
    group.finish();
}

fn indices(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("dispersion");
    let lines = [[fraunhofer::B, 2.40728], [fraunhofer::D, 2.41726], [fraunhofer::G, 2.45173]];
    group.bench_function("Cauchy fit of three lines", |bencher| {
        bencher.iter(|| Dispersion::fit(black_box(&lines)));
    });
    let diamond = Catalogue::builtin().get("diamond").expect("a built-in material");
    let grid = grid(32);
    group.throughput(Throughput::Elements(32));
    group.bench_function("Sellmeier at 32 wavelengths", |bencher| {
        bencher.iter(|| black_box(&grid).nm().iter().map(|nm| diamond.index(*nm)).sum::<f64>());
    });
    group.finish();
}

fn colours(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("upsampling");
    for count in [4, 8, 32] {
        let grid = grid(count);
        let response = Response::new(&grid).expect("a response");
        group.bench_function(format!("bases at {count} wavelengths"), |bencher| {
            bencher.iter(|| Upsampler::new(black_box(&grid), &response));
        });
    }
    let grid = grid(32);
    let response = Response::new(&grid).expect("a response");
    let upsampler = Upsampler::new(&grid, &response).expect("the bases").with_illuminant(&Illuminant::D65);
    group.throughput(Throughput::Elements(32));
    group.bench_function("colour to 32 wavelengths", |bencher| {
        bencher.iter(|| upsampler.spectrum(black_box([0.3, 0.5, 0.9])));
    });
    group.bench_function("32 wavelengths to colour", |bencher| {
        let sky = upsampler.spectrum([0.3, 0.5, 0.9]);
        bencher.iter(|| response.to_linear_srgb(black_box(&sky)));
    });
    group.finish();
}

criterion_group!(benches, surfaces, indices, colours);
criterion_main!(benches);
