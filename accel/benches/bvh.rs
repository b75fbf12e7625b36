//! Building and traversing: `cargo bench -p gemtrace-accel`.

use std::hint::black_box;
use std::time::Duration;

use accel::obvhs::{BvhBuildParams, cwbvh::builder::build_cwbvh_from_tris};
use accel::testing::{self, Mesh, Random};
use accel::{BuildOptions, Bvh, Ray};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

/// A million triangles: our build, and `obvhs`'s medium build with pre-splitting.
fn building(criterion: &mut Criterion) {
    let mesh = testing::torus(0.4, 1000, 500);
    let Mesh { positions, triangles } = &mesh;
    let theirs = mesh.obvhs();
    let params = BvhBuildParams { pre_split: true, ..BvhBuildParams::medium_build() };
    let mut group = criterion.benchmark_group("build 1M");
    group.sample_size(10);
    group.bench_function("sbvh", |bencher| {
        bencher.iter(|| Bvh::build(positions, black_box(triangles), &BuildOptions::default()));
    });
    group.bench_function("obvhs presplit", |bencher| {
        bencher.iter(|| build_cwbvh_from_tris(black_box(&theirs), params, &mut Duration::default()));
    });
    group.finish();
}

/// A thousand rays from outside into each mesh.
fn traversing(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("1000 rays");
    group.throughput(Throughput::Elements(1000));
    for (name, mesh) in [
        ("stone", testing::stone(16)),
        ("icosphere 20k", testing::icosphere(5)),
        ("torus 300k", testing::torus(0.4, 500, 300)),
        ("slivers 60k", testing::slivers(60_000, 1e-3, 1)),
    ] {
        let bvh = mesh.bvh();
        let rays: Vec<Ray> = (0..1000)
            .map(|i| {
                let mut random = Random(i);
                let origin = random.direction() * 3.0;
                Ray::new(origin, random.point() - 0.5 - origin)
            })
            .collect();
        group.bench_function(name, |bencher| {
            bencher.iter(|| rays.iter().filter(|ray| bvh.closest(ray, |_| true).is_some()).count());
        });
    }
    group.finish();
}

criterion_group!(benches, building, traversing);
criterion_main!(benches);
