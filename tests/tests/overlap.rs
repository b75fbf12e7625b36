//! Scenes with more stones over one point than a ray can be in are refused; stones that only touch are not.

use gemtrace_tests::prelude::*;
use spectral_core::{mesh::Mesh, prepare::Nest};
use std::f64::consts::TAU;
use std::time::Instant;

fn prepared_or(stones: Vec<Stone>) -> Result<PreparedScene, Error> {
    PreparedScene::new(
        &scene(eye(DVec3::new(3.0, -20.0, 60.0), 14.0), 8, studio(), stones),
        &settings(&[550.0]),
    )
}

fn copies(mesh: &Arc<Mesh>, count: usize, place: impl Fn(f64) -> (DVec3, DVec3)) -> Vec<Stone> {
    let stone = |k| {
        let (position, rotation) = place(k as f64);
        let name = format!("stone {}", k + 1);
        Stone { name, position, rotation, ..stone(mesh.clone(), glass(1.5)) }
    };
    (0..count).map(stone).collect()
}

/// A triangular prism along z whose edge is the z axis and which spans one of `parts` parts of a turn.
fn slices(parts: usize) -> Vec<Stone> {
    let corner = |angle: f64| glam::DVec2::from_angle(angle) * 3.0;
    let slice = |k: usize| {
        let [from, to] = [k, k + 1].map(|k| TAU * k as f64 / parts as f64);
        stone(extruded(&[glam::DVec2::ZERO, corner(from), corner(to)], -1.0, 1.0), glass(1.5))
    };
    (0..parts).map(slice).collect()
}

fn cubes(n: usize) -> Vec<Stone> {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let at =
        |k: f64| DVec3::new(k % n as f64, (k / n as f64).floor() % n as f64, (k / (n * n) as f64).floor());
    copies(&cube, n * n * n, |k| (at(k), DVec3::ZERO))
}

#[test]
fn more_stones_over_a_point_than_a_nest_holds_are_refused() {
    let brilliant = cut("round-brilliant");
    let bar = cuboid(DVec3::new(-9.0, -0.1, -0.1), DVec3::new(9.0, 0.1, 0.1));
    let ring = torus(2.0, 0.5, 24, 12);
    let still = |_: f64| (DVec3::ZERO, DVec3::ZERO);
    let turned = |k: f64| (DVec3::ZERO, DVec3::new(0.0, 0.0, 25.0 * k));
    // Around a circle that they touch: each crosses its neighbours, and no three have a point in common.
    let around = |k: f64| {
        let angle = TAU * k / 9.0;
        (DVec3::new(angle.cos(), angle.sin(), 0.0) * 3.0, DVec3::new(0.0, 0.0, angle.to_degrees() + 90.0))
    };
    let beside = |k: f64| (DVec3::new(0.95 * k, 0.0, 0.0), DVec3::new(0.0, 30.0, 0.0));
    let shifted = |k: f64| (DVec3::new(0.05 * k, 0.02 * k * k, 0.01 * k), DVec3::splat(10.0 * k));
    let sphere_of = |k: f64| stone(sphere(1.0 + k, 24, 48), glass(1.5 + 0.01 * k));
    let spheres = |count: usize| (0..count).map(|k| sphere_of(k as f64)).collect::<Vec<_>>();
    let cases: [(&str, Vec<Stone>, bool); 17] = [
        ("six coincident", copies(&brilliant, 6, still), true),
        ("seven coincident", copies(&brilliant, 7, still), false),
        ("a thousand coincident", copies(&brilliant, 1000, still), false),
        ("seven shifted", copies(&brilliant, 7, shifted), false),
        ("twelve shifted", copies(&brilliant, 12, shifted), false),
        ("seven crossing bars", copies(&bar, 7, turned), false),
        ("six crossing bars", copies(&bar, 6, turned), true),
        ("nine bars around", copies(&bar, 9, around), true),
        ("a row of tilted stones", copies(&brilliant, 40, beside), true),
        ("six spheres", spheres(6), true),
        ("seven spheres", spheres(7), false),
        ("seven rings", copies(&ring, 7, |k| (DVec3::X * 0.1 * k, DVec3::ZERO)), false),
        ("rings apart in one box", copies(&ring, 7, |k| (DVec3::Z * 1.01 * k, DVec3::ZERO)), true),
        ("eight cubes at a corner", cubes(2), true),
        ("27 cubes", cubes(3), true),
        ("nine slices", slices(9), true),
        ("twenty slices", slices(20), true),
    ];
    for (what, stones, sound) in cases {
        let start = Instant::now();
        let outcome = prepared_or(stones);
        let seconds = start.elapsed().as_secs_f64();
        println!("{what}: {seconds:.3} s");
        assert!(seconds < 5.0, "{what}: {seconds} s");
        match outcome {
            Ok(_) => assert!(sound, "{what} is accepted"),
            Err(error) => {
                assert!(!sound, "{what}: {error}");
                let message = error.to_string();
                let expected = format!("at most {} may overlap at one point", Nest::CAPACITY);
                assert!(message.contains("over the point (") && message.contains(&expected), "{message}");
            }
        }
    }
}

#[test]
fn the_stones_and_the_point_are_named() {
    let cube = cuboid(DVec3::splat(-0.5), DVec3::splat(0.5));
    let mut stones = copies(&cube, 9, |k| (DVec3::new(20.0 + 0.1 * k, 5.0, 7.0), DVec3::ZERO));
    stones.extend(copies(&cube, 3, |k| (DVec3::X * -20.0 * k, DVec3::ZERO)));
    let message = prepared_or(stones).unwrap_err().to_string();
    assert!(
        message.contains("stone 3, stone 4") && message.contains("5.") && message.contains("7."),
        "{message}"
    );
}
