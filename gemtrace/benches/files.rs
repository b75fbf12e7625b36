//! Reading scenes, cuts and meshes, and writing pictures: `cargo bench -p gemtrace`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use gemtrace::import;
use gemtrace::output::{Depth, Options, Picture, Target};
use gemtrace::scene_file::{self, LoadedScene};
use spectral_core::{
    film::{Film, PixelSample, Tile, TileSums},
    prepare::PreparedScene,
    scene::Scene,
    settings::RenderSettings,
    tracer::TraceReport,
};
use std::hint::black_box;
use std::path::{Path, PathBuf};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes")
}

fn reading(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("reading");
    // Its environment is the larger part of it; what stays in memory between two runs is the disk's.
    let scene = scenes().join("brilliant.toml");
    group.bench_function("a scene and all it names", |bencher| {
        bencher.iter(|| scene_file::load(black_box(&scene)).expect("a scene"));
    });
    for name in ["brilliant.asc", "step.gem", "portuguese.gcs"] {
        let path = scenes().join("cuts").join(name);
        let bytes = import::read_file(&path).expect("a cut");
        group.throughput(Throughput::Bytes(bytes.len() as u64));
        group.bench_function(name, |bencher| {
            bencher.iter(|| import::cut::read(&path, black_box(&bytes)).expect("a cut"));
        });
    }
    for (folder, name) in [("meshes", "ring.obj"), ("environments", "hall.exr")] {
        let path = scenes().join(folder).join(name);
        let bytes = import::read_file(&path).expect("a file");
        group.throughput(Throughput::Bytes(bytes.len() as u64));
        if folder == "meshes" {
            group.bench_function(name, |bencher| {
                bencher.iter(|| import::mesh::read(&path, black_box(&bytes)))
            });
        } else {
            group.bench_function(name, |bencher| {
                bencher.iter(|| import::environment::read(&path, black_box(&bytes)));
            });
        }
    }
    group.finish();
}

/// A film of smooth colours, and the scene it would belong to.
fn film() -> (PreparedScene, Film) {
    let scene = PreparedScene::new(&Scene::in_studio(vec![]), &RenderSettings::default()).expect("a scene");
    let mut film = Film::new(&scene);
    let tile = Tile { x: 0, y: 0, width: scene.width, height: scene.height };
    let samples = (0..tile.width * tile.height)
        .map(|k| {
            let [x, y] = [k % tile.width, k / tile.width].map(|i| i as f32 * 0.05);
            PixelSample { xyz: [x.sin().abs(), (x * y).sin().abs(), y.cos().abs()], coverage: 1.0 }
        })
        .collect();
    film.add(&TileSums { tile, samples, radiance: vec![] }).expect("a tile of the film");
    (scene, film)
}

fn writing(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("writing 256 × 256 pixels");
    group.throughput(Throughput::Elements(256 * 256));
    let (scene, film) = film();
    let loaded = LoadedScene::from(Scene::in_studio(vec![]));
    let mut picture = Picture::new(film, &scene, &loaded, &[], &TraceReport::default(), Options::default());
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    for (name, depth) in
        [("eight.png", Depth::Eight), ("sixteen.png", Depth::Sixteen), ("float.exr", Depth::Eight)]
    {
        let target = Target::new(folder.path().join(name)).expect("a known extension");
        picture.options.depth = depth;
        group.bench_function(name, |bencher| {
            bencher.iter(|| picture.write(&target).expect("the folder can be written to"));
        });
    }
    group.finish();
}

criterion_group!(benches, reading, writing);
criterion_main!(benches);
