use super::*;
use crate::Instructions;
use crate::testing::{self, Mesh, Random};
use glam::Vec3;

const RAYS: u64 = if cfg!(debug_assertions) { 300 } else { 3_000 };

/// A ray to a corner, to a point on an edge or to an inner point of a triangle, from near or far.
fn ray(mesh: &Mesh, random: &mut Random) -> Ray {
    let [a, b, c] = mesh.corners(random.below(mesh.triangles.len()));
    let target = [a, a + (b - a) * random.unit(), (a + b + c) / 3.0][random.below(3)];
    let origin = target + random.direction() * [0.1, 3.0, 300.0][random.below(3)];
    let t_min = [0.0, -0.5, f32::NEG_INFINITY][random.below(3)];
    Ray { t_min, ..Ray::new(origin, (target - origin) * [1.0, 1e-3, 1e3][random.below(3)]) }
}

#[test]
fn every_instruction_set_has_the_hits_of_testing_all_triangles() {
    for (name, mesh) in [
        ("soup", testing::soup(800, 0.3, 1)),
        ("slivers", testing::slivers(800, 1e-3, 2)),
        ("icosphere", testing::icosphere(4)),
        ("torus", testing::torus(0.3, 48, 32)),
        ("stone", testing::stone(16)),
        ("far off", testing::icosphere(3).map(|p| p + Vec3::new(1000.0, -2000.0, 500.0))),
    ] {
        let bvh = mesh.bvh();
        for i in 0..RAYS {
            let ray = ray(&mesh, &mut Random(i));
            let odd = |hit: &Hit| hit.triangle % 2 == 1;
            let expected = [bvh.closest_of_all(&ray, |_| true), bvh.closest_of_all(&ray, odd)];
            for set in Instructions::ALL.into_iter().filter(|set| set.available()) {
                let any = set.run(Closest { bvh: &bvh, ray: &ray, accept: |_: &Hit| true, counter: &mut () });
                let odd = set.run(Closest { bvh: &bvh, ray: &ray, accept: odd, counter: &mut () });
                assert_eq!([any, odd], expected, "{name}, {}, ray {i}: {ray:?}", set.name());
            }
        }
    }
}
