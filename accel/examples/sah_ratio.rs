//! Cost by the surface area heuristic against `obvhs`'s best build, on meshes of several kinds:
//! `cargo run --release -p gemtrace-accel --example sah_ratio`.

use std::time::{Duration, Instant};

use accel::obvhs::{
    BvhBuildParams, bvh2::builder::build_bvh2_from_tris, cwbvh::builder::build_cwbvh_from_tris,
    triangle::Triangle,
};
use accel::stats::{Weights, binary_cost, wide_cost};
use accel::testing::{self, Mesh};
use accel::{BuildOptions, Bvh, binary_tree};

fn main() {
    let options = BuildOptions::default();
    println!(
        "{:<22}{:>8}{:>8}{:>8}{:>8}{:>8}{:>9}",
        "mesh", "binary", "ratio", "wide", "ratio", "refs", "seconds"
    );
    for (name, mesh) in [
        ("slivers", testing::slivers(60_000, 1e-3, 1)),
        ("thin slivers", testing::slivers(60_000, 1e-5, 2)),
        ("slanted cylinder", testing::slanted_cylinder(30_000)),
        ("soup", testing::soup(60_000, 0.1, 3)),
        ("icosphere", testing::icosphere(6)),
        ("torus", testing::torus(0.3, 200, 150)),
    ] {
        row(name, &mesh, &options);
    }
}

fn row(name: &str, mesh: &Mesh, options: &BuildOptions) {
    let Mesh { positions, triangles } = mesh;
    let theirs: Vec<Triangle> = triangles
        .iter()
        .map(|t| t.map(|i| positions[i as usize].into()))
        .map(|[v0, v1, v2]| Triangle { v0, v1, v2 })
        .collect();
    let start = Instant::now();
    let binary = binary_tree(positions, triangles, options).expect("the test meshes are valid");
    let seconds = start.elapsed().as_secs_f64();
    let wide = Bvh::build(positions, triangles, options).expect("the test meshes are valid").stats();
    let best = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::very_slow_build() };
    let their_binary = build_bvh2_from_tris(&theirs, best, &mut Duration::default());
    let their_wide =
        build_cwbvh_from_tris(&theirs, BvhBuildParams::very_slow_build(), &mut Duration::default());
    let cost = binary_cost(&binary, Weights::EQUAL);
    println!(
        "{name:<22}{cost:>8.1}{:>8.3}{:>8.1}{:>8.3}{:>8.2}{seconds:>9.2}  obvhs refs {:.2}",
        cost / binary_cost(&their_binary, Weights::EQUAL),
        wide.cost,
        wide.cost / wide_cost(&their_wide, Weights::WIDE),
        wide.references as f64 / triangles.len() as f64,
        their_wide.primitive_indices.len() as f64 / triangles.len() as f64,
    );
}
