//! Polarisation from event to event: two mirrors with planes of incidence turned against each other.

use gemtrace_tests::prelude::*;
use spectral_core::mesh::Mesh;

/// A plate whose upper face has the unit `normal` and its middle at `point`.
fn mirror(normal: DVec3, point: DVec3) -> Arc<Mesh> {
    let x = normal.any_orthonormal_vector();
    let turn = DMat3::from_cols(x, normal.cross(x), normal);
    // Not the middle, where an edge between triangles lies.
    let middle = turn * DVec3::new(0.13, 0.07, 0.0);
    Arc::new(plate(4.0, 1.0).transformed(turn, 1.0, point - middle).expect("a rotation"))
}

/// A ray that meets two mirrors of dark glass at `angle` degrees each, the second plane of incidence turned by
/// `turn` degrees against the first.
fn two_mirrors(n: f64, angle: f64, turn: f64) -> Scene {
    let (sin, cos) = angle.to_radians().sin_cos();
    let first = DVec3::new(0.3, -0.5, 0.8).normalize();
    let side = first.cross(DVec3::new(0.9, 0.2, 0.4)).normalize();
    let direction = sin * side - cos * first;
    let between = direction.reflect(first);
    let s = between.cross(first).normalize();
    let p = between.cross(s);
    let (sin_turn, cos_turn) = turn.to_radians().sin_cos();
    let second = -cos * between + sin * (cos_turn * p + sin_turn * s);
    let mirrors = [mirror(first, DVec3::ZERO), mirror(second, 12.0 * between)];
    let stones = mirrors.map(|mesh| stone(mesh, tinted(n, 60.0))).into();
    scene(probe(-20.0 * direction, direction, 1e-3), 1, furnace(), stones)
}

#[test]
fn two_mirrors_obey_malus() {
    // With m = (R_s + R_p)/2 and d = (R_s − R_p)/2 the Mueller matrices give m² + d² cos 2φ: at Brewster's angle
    // Malus's law, R_s² cos²φ / 2, and no light at all where the mirrors are crossed.
    let n = 1.5168_f64;
    for angle in [n.atan().to_degrees(), 35.0, 70.0] {
        let [s, p] = reflectances(n, angle);
        let (mean, half) = ((s + p) / 2.0, (s - p) / 2.0);
        for turn in [0.0, 17.0, 45.0, 60.0, 90.0, 130.0_f64] {
            let scene = two_mirrors(n, angle, turn);
            for way in [Way::Planes, Way::Reference] {
                for polarized in [true, false] {
                    let settings = RenderSettings { polarized, ..settings(&[550.0]) };
                    let found = way.render(&scene, &settings).first_line()[0];
                    let share = if polarized { half * half } else { 0.0 };
                    let expected = mean * mean + share * (2.0 * turn).to_radians().cos();
                    let what = format!("{way:?}, {angle}°, turned by {turn}°, polarised {polarized}");
                    close(found, expected, way.tolerance(2e-7, 1e-8), what);
                }
            }
        }
    }
}
