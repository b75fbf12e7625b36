//! A mesh of shells that overlap renders as its parts do, as stones of one material.

use gemtrace_tests::prelude::*;
use spectral_core::mesh::{Mesh, MeshOptions};
use std::sync::Arc;

/// Both meshes in one.
fn joined(a: &Mesh, b: &Mesh) -> Arc<Mesh> {
    let shift = a.positions().len() as u32;
    let moved = b.triangles().iter().map(|t| t.map(|v| v + shift));
    let triangles = a.triangles().iter().copied().chain(moved).collect();
    let positions = [a.positions(), b.positions()].concat();
    Arc::new(Mesh::from_triangles(positions, triangles, &MeshOptions::default()).unwrap().0)
}

#[test]
fn overlapping_shells_render_as_two_stones() {
    let cube = cuboid(DVec3::splat(-1.0), DVec3::ONE);
    let ring = torus(1.2, 0.4, 16, 8);
    let overlapping = cuboid(DVec3::new(0.5, -0.5, -0.5), DVec3::new(1.5, 0.5, 0.5));
    let flush = cuboid(DVec3::new(0.5, -1.0, -1.0), DVec3::new(1.5, 1.0, 1.0));
    let touching = cuboid(DVec3::new(1.0, -0.5, -0.5), DVec3::new(2.0, 0.5, 0.5));
    let inner = cuboid(DVec3::splat(-0.5), DVec3::splat(0.5));
    let pairs = [
        ("overlapping", cube.clone(), overlapping),
        ("flush", cube.clone(), flush),
        ("touching", cube.clone(), touching),
        ("inside", cube.clone(), inner),
        ("ring", cube, ring),
    ];
    for (name, a, b) in pairs {
        let view = || eye(DVec3::new(6.0, -20.0, 16.0), 10.0);
        let one = scene(view(), 32, studio(), vec![stone(joined(&a, &b), glass(1.5))]);
        let two = scene(view(), 32, studio(), vec![stone(a, glass(1.5)), stone(b, glass(1.5))]);
        let settings = RenderSettings { threshold: 1e-3, ..settings(&[450.0, 550.0, 650.0]) };
        for backend in [&CPU, &REFERENCE] {
            let [one, two] = [&one, &two].map(|scene| render(backend, scene, &settings));
            assert_eq!(one.bits(), two.bits(), "{name}, {}", backend.name);
            assert_eq!(one.report.energy.lost, 0.0, "{name}, {}", backend.name);
        }
    }
}
