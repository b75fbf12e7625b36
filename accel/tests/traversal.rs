//! The traversal has the same result as testing every triangle, bit for bit.

use accel::glam::Vec3;
use accel::stats::Steps;
use accel::testing::{self, Mesh, Random};
use accel::{BuildOptions, Bvh, Hit, Ray};
use rayon::prelude::*;

const RAYS: u64 = if cfg!(debug_assertions) { 300 } else { 5_000 };

fn meshes() -> Vec<(&'static str, Mesh)> {
    let far = Vec3::new(1000.0, -2000.0, 500.0);
    vec![
        ("soup", testing::soup(800, 0.3, 1)),
        ("slivers", testing::slivers(800, 1e-3, 2)),
        ("thin slivers", testing::slivers(800, 1e-6, 3)),
        ("icosphere", testing::icosphere(3)),
        ("torus", testing::torus(0.3, 24, 16)),
        ("stone", testing::stone(16)),
        ("slanted cylinder", testing::slanted_cylinder(300)),
        ("grid in a plane", grid(16)),
        ("tiny", testing::icosphere(2).map(|p| p * 1e-20)),
        ("huge", testing::icosphere(2).map(|p| p * 1e20)),
        ("far off", testing::icosphere(3).map(|p| p + far)),
        ("flat", testing::soup(500, 0.4, 4).map(|p| p * Vec3::new(1.0, 1.0, 0.0))),
        ("stretched", testing::soup(500, 0.4, 5).map(|p| p * Vec3::new(1e4, 1.0, 1e-4))),
    ]
}

/// Unit squares in the plane z = 0. Their corners are small integers, so all arithmetic is exact.
fn grid(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..n {
        for j in 0..n {
            let (x, y) = (i as f32, j as f32);
            let square = [(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)];
            let [a, b, c, d] = square.map(|(x, y)| Vec3::new(x, y, 0.0));
            mesh.push([a, b, c]);
            mesh.push([a, c, d]);
        }
    }
    mesh
}

/// Rays of many kinds about a mesh: at corners, edges and inner points, from far, near and on the surface;
/// parallel to axes and planes; with unnormalised directions and all kinds of intervals.
fn ray(mesh: &Mesh, random: &mut Random) -> Ray {
    let on_surface = |random: &mut Random| {
        let [a, b, c] = mesh.corners(random.below(mesh.triangles.len()));
        match random.below(3) {
            0 => a,
            1 => a + (b - a) * random.unit(),
            _ => {
                let u = random.unit();
                a + (b - a) * u + (c - a) * ((1.0 - u) * random.unit())
            }
        }
    };
    let size = {
        let span = |f: fn(Vec3, Vec3) -> Vec3| mesh.positions.iter().copied().reduce(f).unwrap();
        (span(Vec3::max) - span(Vec3::min)).max_element()
    };
    let target = on_surface(random);
    let origin = match random.below(4) {
        0 => on_surface(random),
        1 => target + random.direction() * size * random.unit(),
        2 => target + random.direction() * size * 100.0,
        _ => random.point() * size,
    };
    let mut direction = match random.below(3) {
        0 => random.direction(),
        _ => target - origin,
    };
    if random.below(3) == 0 {
        direction[random.below(3)] = if random.below(2) == 0 { 0.0 } else { -0.0 };
    }
    if random.below(6) == 0 {
        let axis = random.below(3);
        direction = Vec3::ZERO;
        direction[axis] = if random.below(2) == 0 { 1.0 } else { -1.0 };
    }
    direction *= [1.0, 1e-3, 1e3][random.below(3)];
    let reach = size / direction.abs().max_element().max(f32::MIN_POSITIVE);
    let (t_min, t_max) = match random.below(4) {
        0 => (0.0, f32::INFINITY),
        1 => (f32::NEG_INFINITY, f32::INFINITY),
        2 => (-0.3 * reach, 0.5 * reach),
        _ => (-1e-6 * reach, reach),
    };
    Ray { origin, direction, t_min, t_max }
}

#[test]
fn closest_is_that_of_all_triangles() {
    for (name, mesh) in meshes() {
        for budget in [1.0, 2.5] {
            let options = BuildOptions { budget, ..BuildOptions::default() };
            let bvh = Bvh::build(&mesh.positions, &mesh.triangles, &options).unwrap();
            let hits: usize = (0..RAYS)
                .into_par_iter()
                .map(|i| {
                    let ray = ray(&mesh, &mut Random(i));
                    let found = bvh.closest(&ray, |_| true);
                    assert_eq!(found, bvh.closest_of_all(&ray, |_| true), "{name}, ray {i}: {ray:?}");
                    // As in a renderer: not the triangle the ray starts on, and only some of the others.
                    let own = found.map(|hit| hit.triangle);
                    let other = |hit: &Hit| Some(hit.triangle) != own && !hit.triangle.is_multiple_of(3);
                    let second = bvh.closest(&ray, other);
                    assert_eq!(second, bvh.closest_of_all(&ray, other), "{name}, ray {i}: {ray:?}");
                    usize::from(found.is_some())
                })
                .sum();
            assert!(hits > RAYS as usize / 10, "{name}: only {hits} of {RAYS} rays hit");
        }
    }
}

#[test]
fn every_tree_gives_the_same_hit() {
    let mesh = testing::slivers(3000, 1e-2, 9);
    let trees: Vec<Bvh> = [(1.0, 0.0), (1.5, 0.0), (4.0, 0.0), (2.5, 1.0)]
        .map(|(budget, reinsertion)| {
            let options = BuildOptions { budget, reinsertion, ..BuildOptions::default() };
            Bvh::build(&mesh.positions, &mesh.triangles, &options).unwrap()
        })
        .into();
    for i in 0..RAYS {
        let ray = ray(&mesh, &mut Random(i));
        let first = trees[0].closest(&ray, |_| true);
        assert!(trees.iter().all(|tree| tree.closest(&ray, |_| true) == first), "ray {i}");
    }
}

#[test]
fn hits_are_where_they_should_be() {
    let bvh = grid(4).bvh();
    let ray = Ray::new(Vec3::new(1.75, 2.25, 8.0), Vec3::new(0.0, 0.0, -2.0));
    let hit = bvh.closest(&ray, |_| true).unwrap();
    // The square at (1, 2) is the sixth (4·1 + 2); its first triangle has the corners (1,2), (2,2), (2,3).
    assert_eq!(hit, Hit { t: 4.0, triangle: 12, u: 0.5, v: 0.25 });
}

#[test]
fn ties_go_to_the_lower_triangle() {
    let mesh = grid(4);
    let mut twice = mesh.clone();
    twice.triangles.extend(mesh.triangles);
    let bvh = twice.bvh();
    // On an edge and on a corner of the grid: two and six triangles, and their duplicates.
    for (x, y, first) in [(1.5, 2.5, 12), (2.0, 2.0, 10)] {
        let ray = Ray::new(Vec3::new(x, y, 1.0), -Vec3::Z);
        let mut seen = std::collections::BTreeSet::new();
        bvh.closest(&ray, |hit| {
            seen.insert(hit.triangle);
            false
        });
        assert_eq!(seen.first(), Some(&first));
        assert_eq!(bvh.closest(&ray, |_| true).map(|hit| hit.triangle), Some(first));
    }
}

#[test]
fn negative_parameters_count_when_asked_for() {
    let bvh = Bvh::build(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]], &BuildOptions::default()).unwrap();
    let ray = Ray { t_min: -0.5, ..Ray::new(Vec3::new(0.25, 0.25, -0.5), -Vec3::Z) };
    assert_eq!(bvh.closest(&ray, |_| true).map(|hit| hit.t), Some(-0.5));
    assert_eq!(bvh.closest(&Ray { t_min: -0.25, ..ray }, |_| true), None);
}

#[test]
fn invalid_rays_hit_nothing() {
    let bvh = testing::icosphere(1).bvh();
    let whole = Ray { t_min: f32::NEG_INFINITY, ..Ray::new(Vec3::ZERO, Vec3::X) };
    for ray in [
        Ray { direction: Vec3::ZERO, ..whole },
        Ray { direction: Vec3::new(f32::NAN, 1.0, 0.0), ..whole },
        Ray { direction: Vec3::splat(f32::INFINITY), ..whole },
        Ray { origin: Vec3::new(0.0, f32::NAN, 0.0), ..whole },
        Ray { origin: Vec3::splat(f32::INFINITY), ..whole },
        Ray { t_min: f32::NAN, ..whole },
        Ray { t_max: f32::NAN, ..whole },
        Ray { t_min: 1.0, t_max: -1.0, ..whole },
    ] {
        assert_eq!(bvh.closest(&ray, |_| true), None, "{ray:?}");
    }
    for scale in [f32::MIN_POSITIVE, 1e-45, 1e38] {
        let ray = Ray { direction: whole.direction * scale, ..whole };
        assert_eq!(bvh.closest(&ray, |_| true), bvh.closest_of_all(&ray, |_| true), "{ray:?}");
        let ray = Ray { origin: Vec3::splat(scale), ..whole };
        assert_eq!(bvh.closest(&ray, |_| true), bvh.closest_of_all(&ray, |_| true), "{ray:?}");
    }
}

#[test]
fn work_grows_slowly_with_the_mesh() {
    let work = |levels| {
        let bvh = testing::icosphere(levels).bvh();
        let mut steps = Steps::default();
        for i in 0..1000 {
            let mut random = Random(i);
            let origin = random.direction() * 3.0;
            let ray = Ray::new(origin, random.direction() * 0.5 - origin);
            bvh.closest_counted(&ray, |_| true, &mut steps);
        }
        steps
    };
    let (small, large) = (work(2), work(5));
    // 64 times the triangles: two more levels of eight.
    assert!(large.nodes < 3 * small.nodes, "{small:?}, {large:?}");
    assert!(large.triangles < 2 * small.triangles, "{small:?}, {large:?}");
}
