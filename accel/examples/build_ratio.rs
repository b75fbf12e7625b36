//! Build times against `obvhs`'s builds with pre-splitting, in one run:
//! `cargo run --release -p gemtrace-accel --example build_ratio [-- TRIANGLES]`.

use std::time::{Duration, Instant};

use accel::obvhs::{BvhBuildParams, cwbvh::builder::build_cwbvh_from_tris, triangle::Triangle};
use accel::testing::{self, Mesh};
use accel::{BuildOptions, Bvh};

fn main() {
    let count = std::env::args().nth(1).and_then(|argument| argument.parse().ok()).unwrap_or(1_000_000u32);
    let across = f64::from(count / 2).sqrt() as u32;
    let size = 2.0 / (count as f32).cbrt();
    for (name, mesh) in [
        ("torus", testing::torus(0.4, count / 2 / across, across)),
        ("soup", testing::soup(count as usize, size, 1)),
    ] {
        compare(name, &mesh);
    }
}

fn compare(name: &str, mesh: &Mesh) {
    let Mesh { positions, triangles } = mesh;
    let theirs: Vec<Triangle> = triangles
        .iter()
        .map(|t| t.map(|i| positions[i as usize].into()))
        .map(|[v0, v1, v2]| Triangle { v0, v1, v2 })
        .collect();
    let presplit = |preset: BvhBuildParams| BvhBuildParams { pre_split: true, ..preset };
    let start = Instant::now();
    let bvh = Bvh::build(positions, triangles, &BuildOptions::default()).expect("the mesh is valid");
    let ours = start.elapsed().as_secs_f64();
    let stats = bvh.stats();
    println!(
        "{name}, {} triangles: {ours:.2} s, {:.2} references a triangle, cost {:.1}",
        triangles.len(),
        stats.references as f64 / triangles.len() as f64,
        stats.cost
    );
    for (preset, params) in [
        ("fastest", presplit(BvhBuildParams::fastest_build())),
        ("very fast", presplit(BvhBuildParams::very_fast_build())),
        ("fast", presplit(BvhBuildParams::fast_build())),
        ("medium", presplit(BvhBuildParams::medium_build())),
        ("slow", presplit(BvhBuildParams::slow_build())),
        ("very slow", presplit(BvhBuildParams::very_slow_build())),
    ] {
        let start = Instant::now();
        let tree = build_cwbvh_from_tris(&theirs, params, &mut Duration::default());
        let seconds = start.elapsed().as_secs_f64();
        let cost = accel::stats::wide_cost(&tree, accel::stats::Weights::WIDE);
        println!("  obvhs {preset:<10}{seconds:>7.2} s  ratio {:.2}  cost {cost:.1}", ours / seconds);
    }
}
