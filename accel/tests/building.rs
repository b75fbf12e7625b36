//! The builder: budget, the same tree on any number of threads, lower cost than pre-splitting on slivers, degenerate
//! and hostile input.

use std::time::Duration;

use accel::glam::Vec3;
use accel::obvhs::BvhBuildParams;
use accel::obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris, leaf_collapser::collapse};
use accel::obvhs::cwbvh::builder::build_cwbvh_from_tris;
use accel::stats::{Weights, binary_cost, wide_cost};
use accel::testing::{self, Mesh, Random};
use accel::{BuildOptions, Bvh, Error, Ray, binary_tree};

fn tree(mesh: &Mesh, options: &BuildOptions) -> Bvh2 {
    binary_tree(&mesh.positions, &mesh.triangles, options).unwrap()
}

/// Checks that the tree costs at least 15 % less than `obvhs`'s best tree: as a binary tree with one reference a leaf, as
/// a binary tree collapsed by `obvhs`, and as a wide tree; all by the same cost function.
fn costs_less(name: &str, mesh: &Mesh) {
    let best = BvhBuildParams::very_slow_build();
    assert!(best.pre_split);
    let triangles = mesh.obvhs();
    let single = BvhBuildParams { max_prims_per_leaf: 1, ..best };
    let mut ours = tree(mesh, &BuildOptions::default());
    let other = build_bvh2_from_tris(&triangles, single, &mut Duration::default());
    let binary = binary_cost(&ours, Weights::EQUAL) / binary_cost(&other, Weights::EQUAL);
    collapse(&mut ours, best.max_prims_per_leaf, best.collapse_traversal_cost);
    let other = build_bvh2_from_tris(&triangles, best, &mut Duration::default());
    let leaves = binary_cost(&ours, Weights::EQUAL) / binary_cost(&other, Weights::EQUAL);
    let other = build_cwbvh_from_tris(&triangles, best, &mut Duration::default());
    let wide = mesh.bvh().stats().cost / wide_cost(&other, Weights::WIDE);
    println!("{name}: cost ratio {binary:.3} (binary), {leaves:.3} (collapsed), {wide:.3} (wide)");
    assert!(binary.max(leaves).max(wide) < 0.85, "{name}: {binary}, {leaves}, {wide}");
}

#[test]
fn slivers_cost_less_than_with_pre_splitting() {
    let count = if cfg!(debug_assertions) { 6_000 } else { 60_000 };
    costs_less("few slivers", &testing::slivers(3_000, 1e-3, 3));
    costs_less("slivers", &testing::slivers(count, 1e-3, 1));
    costs_less("thin slivers", &testing::slivers(count, 1e-6, 2));
    costs_less("slanted cylinder", &testing::slanted_cylinder(count as u32 / 2));
}

#[test]
fn the_budget_is_never_exceeded() {
    for mesh in [testing::slivers(2000, 1e-3, 3), testing::soup(2000, 0.5, 4), testing::slanted_cylinder(500)]
    {
        for budget in [1.0, 1.01, 1.5, 2.0, 4.0] {
            let tree = tree(&mesh, &BuildOptions { budget, ..BuildOptions::default() });
            let limit = (mesh.triangles.len() as f64 * f64::from(budget)) as usize;
            assert!(tree.primitive_indices.len() <= limit, "{} > {limit}", tree.primitive_indices.len());
        }
        let mut present = vec![false; mesh.triangles.len()];
        tree(&mesh, &BuildOptions::default())
            .primitive_indices
            .iter()
            .for_each(|&i| present[i as usize] = true);
        assert!(present.iter().all(|&present| present), "every triangle is referenced");
    }
}

/// The boxes of a triangle's references cover it: random points of it lie in one of them.
#[test]
fn references_cover_their_triangles() {
    let mesh = testing::slivers(500, 1e-2, 5);
    let tree = tree(&mesh, &BuildOptions { budget: 4.0, ..BuildOptions::default() });
    let largest = mesh.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
    let scale = if largest >= 1.0 { 0.5 } else { 1.0 };
    let mut boxes = vec![Vec::new(); mesh.triangles.len()];
    for node in tree.nodes.iter().filter(|node| node.is_leaf()) {
        boxes[tree.primitive_indices[node.first_index as usize] as usize].push(*node.aabb());
    }
    let mut random = Random(6);
    for (i, boxes) in boxes.iter().enumerate() {
        for _ in 0..50 {
            let [a, b, c] = mesh.corners(i);
            let (u, v) = (random.unit(), random.unit());
            let point = (a + (b - a) * u + (c - a) * ((1.0 - u) * v)) * scale;
            let slack = accel::glam::Vec3A::splat(1e-6);
            let inside = boxes.iter().any(|aabb| {
                let point = accel::glam::Vec3A::from(point);
                point.cmpge(aabb.min - slack).all() && point.cmple(aabb.max + slack).all()
            });
            assert!(inside, "triangle {i}, {point} outside {boxes:?}");
        }
    }
}

#[test]
fn the_tree_does_not_depend_on_the_threads() {
    // Large enough for binning in parallel, at the root and below.
    let mesh = testing::soup(if cfg!(debug_assertions) { 70_000 } else { 200_000 }, 0.05, 7);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tree(&mesh, &BuildOptions::default()))
    };
    let one = with(1);
    for threads in [2, 7] {
        let other = with(threads);
        assert_eq!(one.primitive_indices, other.primitive_indices);
        let same = one.nodes.iter().zip(&other.nodes).all(|(a, b)| {
            let bits = |v: accel::glam::Vec3A| v.to_array().map(f32::to_bits);
            let (p, q) = (a.aabb(), b.aabb());
            (bits(p.min), bits(p.max)) == (bits(q.min), bits(q.max)) && a.first_index == b.first_index
        });
        assert!(same && one.nodes.len() == other.nodes.len());
    }
}

#[test]
fn an_empty_mesh_is_hit_by_nothing() {
    let bvh = Bvh::build(&[], &[], &BuildOptions::default()).unwrap();
    assert_eq!(bvh.closest(&Ray::new(Vec3::ZERO, Vec3::X), |_| true), None);
    assert_eq!((bvh.stats().references, bvh.stats().depth, bvh.stats().cost), (0, 0, 0.0));
}

#[test]
fn triangles_without_area_are_left_out() {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0, Vec3::Y];
    let triangles = [[0, 1, 2], [1, 1, 1], [0, 1, 1], [0, 1, 3], [2, 2, 3]];
    let bvh = Bvh::build(&positions, &triangles, &BuildOptions::default()).unwrap();
    assert_eq!((bvh.stats().triangles, bvh.stats().degenerate), (1, 4));
    let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z);
    assert_eq!(bvh.closest(&ray, |_| true).map(|hit| hit.triangle), Some(3));
    let only = Bvh::build(&positions, &triangles[..3], &BuildOptions::default()).unwrap();
    assert_eq!(only.closest(&ray, |_| true), None);
}

#[test]
fn bad_input_is_named() {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, f32::NAN, 0.0)];
    let default = BuildOptions::default();
    let message = |positions: &[Vec3], triangles: &[[u32; 3]], options: &BuildOptions| {
        Bvh::build(positions, triangles, options).unwrap_err().to_string()
    };
    assert_eq!(
        message(&positions, &[[0, 1, 2]], &default),
        "vertex 3 is (1, NaN, 0): every coordinate must be a finite number of at most 1e36 in magnitude"
    );
    assert_eq!(
        message(&positions[..3], &[[0, 1, 2], [0, 1, 3]], &default),
        "triangle 1 names vertex 3, but there are 3 vertices, numbered from 0"
    );
    for value in [0.5, 5.0, f32::NAN] {
        let options = BuildOptions { budget: value, ..default.clone() };
        let expected = format!("build option `budget` is {value}: it must be from 1 to 4");
        assert_eq!(message(&positions[..3], &[[0, 1, 2]], &options), expected);
    }
    let infinite = [Vec3::splat(f32::INFINITY)];
    assert!(matches!(Bvh::build(&infinite, &[], &default), Err(Error::Position { index: 0, .. })));
    let large = [Vec3::splat(1e37)];
    assert!(matches!(Bvh::build(&large, &[], &default), Err(Error::Position { index: 0, .. })));
}

/// Meshes on which builders recurse without end, or too deep.
#[test]
fn hostile_meshes_build() {
    let count = if cfg!(debug_assertions) { 20_000 } else { 100_000 };
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let identical = Mesh { positions: corners.into(), triangles: vec![[0, 1, 2]; count] };
    let stats = identical.bvh().stats();
    assert_eq!(stats.triangles, count);
    assert!(stats.depth < 20, "{stats:?}");

    // One centroid, all sizes.
    let mut nested = Mesh::default();
    for i in 0..count {
        nested.push(corners.map(|p| (p - Vec3::new(0.5, 0.5, 0.0)) * (1.0 + i as f32)));
    }
    // Sizes and distances from 1e-30 to 1e30.
    let mut chain = Mesh::default();
    for i in 0..4000 {
        let scale = 10f32.powf(-30.0 + 60.0 * i as f32 / 4000.0);
        chain.push(corners.map(|p| (p + Vec3::new(1.0, 2.0, 3.0)) * scale));
    }
    for mesh in [nested, chain] {
        let bvh = mesh.bvh();
        assert!(bvh.stats().depth < 100, "{:?}", bvh.stats());
        for i in 0..20 {
            let mut random = Random(i);
            let [a, b, c] = mesh.corners(random.below(mesh.triangles.len()));
            let middle = (a + b + c) / 3.0;
            let origin = middle + random.direction() * middle.length().max(1e-30);
            let ray = Ray::new(origin, middle - origin);
            assert_eq!(bvh.closest(&ray, |_| true), bvh.closest_of_all(&ray, |_| true));
        }
    }
}
