//! No ray passes through a closed mesh, not even at edges and corners.

use accel::Ray;
use accel::glam::Vec3;
use accel::testing::{self, Mesh, Random};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Rays in all: ten million, in debug builds fewer.
const RAYS: u64 = if cfg!(debug_assertions) { 60_000 } else { 10_000_000 };

/// Counts the rays that leave from inside or enter from outside without a hit. `inside` gives points well within the
/// solid.
fn leaks(name: &str, mesh: &Mesh, inside: impl Fn(&mut Random) -> Vec3 + Sync) {
    let bvh = mesh.bvh();
    let each = RAYS.div_ceil(6);
    let lost: u64 = (0..each)
        .into_par_iter()
        .map(|i| {
            let mut random = Random(i.wrapping_mul(0x5851_f42d_4c95_7f2d));
            let [a, b, _] = mesh.corners(random.below(mesh.triangles.len()));
            // A quarter at corners, a quarter at middles of edges, half anywhere on them.
            let target = match random.below(4) {
                0 => a,
                1 => (a + b) * 0.5,
                _ => a + (b - a) * random.unit(),
            };
            let within = inside(&mut random);
            let out = target - within;
            let leaving = Ray::new(within, out);
            // From outside through the same point to an inner point.
            let origin = target + out * (4.0 / out.length());
            let entering = Ray { t_max: 1.0, ..Ray::new(origin, within - origin) };
            [leaving, entering].iter().filter(|ray| bvh.closest(ray, |_| true).is_none()).count() as u64
        })
        .sum();
    println!("{name}: {lost} of {} rays lost", 2 * each);
    assert_eq!(lost, 0, "{name}");
}

#[test]
fn icosphere() {
    leaks("icosphere", &testing::icosphere(5), |random| (random.point() - 0.5) * 0.8);
}

#[test]
fn stone() {
    leaks("stone", &testing::stone(16), |random| (random.point() - 0.5) * 0.3);
}

#[test]
fn torus() {
    leaks("torus", &testing::torus(0.3, 96, 48), |random| {
        let (sin, cos) = (TAU * random.unit()).sin_cos();
        Vec3::new(cos, sin, 0.0) + (random.point() - 0.5) * 0.1
    });
}
