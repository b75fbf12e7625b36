//! Cost by the surface area heuristic and build time against `obvhs`'s builds, in one run:
//! `cargo run --release -p gemtrace-accel --example against_obvhs [-- TRIANGLES]`.

use std::time::{Duration, Instant};

use accel::obvhs::bvh2::builder::build_bvh2_from_tris;
use accel::obvhs::{BvhBuildParams, cwbvh::builder::build_cwbvh_from_tris};
use accel::stats::{Weights, binary_cost, wide_cost};
use accel::testing::{self, Mesh};
use accel::{BuildOptions, binary_tree};

fn main() {
    let argument = std::env::args().nth(1);
    let count = argument.and_then(|argument| argument.parse().ok()).unwrap_or(1_000_000u32);
    let across = f64::from(count / 2).sqrt() as u32;
    let size = 2.0 / (count as f32).cbrt();
    for (name, mesh) in [
        ("slivers", testing::slivers(60_000, 1e-3, 1)),
        ("thin slivers", testing::slivers(60_000, 1e-5, 2)),
        ("slanted cylinder", testing::slanted_cylinder(30_000)),
        ("soup", testing::soup(60_000, 0.1, 3)),
        ("icosphere", testing::icosphere(6)),
        ("torus", testing::torus(0.3, 200, 150)),
        ("large torus", testing::torus(0.4, count / 2 / across, across)),
        ("large soup", testing::soup(count as usize, size, 1)),
    ] {
        compare(name, &mesh);
    }
}

fn compare(name: &str, mesh: &Mesh) {
    let options = BuildOptions::default();
    let binary = binary_tree(&mesh.positions, &mesh.triangles, &options).expect("a valid mesh");
    let (start, bvh) = (Instant::now(), mesh.bvh());
    let seconds = start.elapsed().as_secs_f64();
    let (stats, triangles) = (bvh.stats(), mesh.obvhs());
    let cost = binary_cost(&binary, Weights::EQUAL);
    let per_triangle = |references: usize| references as f64 / triangles.len() as f64;
    println!(
        "{name}, {} triangles: {seconds:.2} s, {:.2} references a triangle, cost {cost:.1} binary, {:.1} wide",
        triangles.len(),
        per_triangle(stats.references),
        stats.cost
    );
    let best = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::very_slow_build() };
    let other =
        binary_cost(&build_bvh2_from_tris(&triangles, best, &mut Duration::default()), Weights::EQUAL);
    println!("  of obvhs's best binary tree: cost ratio {:.3}", cost / other);
    for (preset, params) in [
        ("fastest", BvhBuildParams::fastest_build()),
        ("very fast", BvhBuildParams::very_fast_build()),
        ("fast", BvhBuildParams::fast_build()),
        ("medium", BvhBuildParams::medium_build()),
        ("slow", BvhBuildParams::slow_build()),
        ("very slow", BvhBuildParams::very_slow_build()),
    ] {
        let params = BvhBuildParams { pre_split: true, ..params };
        let start = Instant::now();
        let tree = build_cwbvh_from_tris(&triangles, params, &mut Duration::default());
        let (time, other) = (start.elapsed().as_secs_f64(), wide_cost(&tree, Weights::WIDE));
        println!(
            "  of obvhs {preset}: time ratio {:.2}, cost ratio {:.3}, {:.2} references a triangle",
            seconds / time,
            stats.cost / other,
            per_triangle(tree.primitive_indices.len())
        );
    }
}
