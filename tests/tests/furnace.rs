//! Energy: in uniform light a stone without absorption is invisible, and dropped energy is reported.

use gemtrace_tests::prelude::*;

const SIZE: u32 = 24;

fn world(stones: Vec<Stone>) -> Scene {
    scene(eye(DVec3::new(5.0, -13.0, 17.0), 24.0), SIZE, furnace(), stones)
}

fn block(low: [f64; 3], high: [f64; 3], n: f64) -> Stone {
    stone(cuboid(DVec3::from(low), DVec3::from(high)), glass(n))
}

/// One convex stone: a path does not branch, so any depth is cheap.
fn lone_stones() -> Vec<(&'static str, Scene)> {
    let brilliant = world(vec![gem("round-brilliant", glass(2.417))]);
    let speck = with_speck(&brilliant);
    vec![
        ("brilliant by its planes", brilliant),
        ("brilliant with a speck", speck),
        ("step cut", world(vec![gem("step", glass(1.57))])),
        ("Portuguese cut", world(vec![gem("portuguese", glass(1.77))])),
        ("ball", world(vec![stone(sphere(3.0, 12, 24), glass(1.5))])),
    ]
}

/// Branching paths: at worst the work doubles with every event.
fn many_stones() -> Vec<(&'static str, Scene)> {
    let ball = |n: f64, radius: f64| stone(sphere(radius, 8, 16), glass(n));
    let two = || [gem("round-brilliant", glass(2.417)), gem("step", glass(1.77))];
    let [a, b] = two();
    vec![
        ("torus", world(vec![stone(torus(2.5, 0.9, 24, 12), glass(1.5))])),
        ("star", world(vec![stone(star(7, 1.4, 3.2, 1.5), glass(1.77))])),
        ("two apart", world(vec![at(a, [-2.4, 0.0, 0.4]), at(b, [2.6, 1.0, 0.0])])),
        (
            "touching, two materials",
            world(vec![
                block([-2.0, -2.0, -1.0], [0.0, 2.0, 1.0], 1.5),
                block([0.0, -1.5, -1.0], [2.0, 2.5, 1.2], 1.8),
            ]),
        ),
        (
            "touching, one material",
            world(vec![
                block([-2.0, -2.0, -1.0], [0.0, 2.0, 1.0], 1.6),
                block([0.0, -1.5, -1.0], [2.0, 2.5, 1.2], 1.6),
            ]),
        ),
        (
            "touching, one face shared exactly",
            world(vec![
                block([-2.0, -2.0, -1.0], [0.0, 2.0, 1.0], 1.5),
                block([0.0, -2.0, -1.0], [2.0, 2.0, 1.0], 2.4),
            ]),
        ),
        (
            "an inclusion",
            world(vec![gem("round-brilliant", glass(1.77)), at(ball(2.2, 0.6), [0.3, 0.2, -0.3])]),
        ),
        ("a bubble as a denser shell", world(vec![ball(1.5, 3.0), at(ball(1.0, 1.2), [0.4, 0.3, 0.2])])),
        ("three deep", world(vec![ball(1.4, 3.0), at(ball(1.9, 2.0), [0.2, 0.0, 0.1]), ball(1.3, 0.9)])),
        (
            "overlapping",
            world(vec![at(ball(1.5, 2.0), [-0.9, 0.0, 0.0]), at(ball(2.0, 1.8), [1.0, 0.3, 0.2])]),
        ),
        (
            "set in a bezel",
            world(vec![
                stone(cut("round-brilliant"), glass(2.0)),
                block([-1.5, -1.5, -1.0], [1.5, 1.5, -0.05], 1.5),
            ]),
        ),
    ]
}

/// The worst departure of any pixel and wavelength from the background's radiance, 1.
fn worst(picture: &Picture) -> f64 {
    picture.radiances().concat().into_iter().map(|v| (v - 1.0).abs()).fold(0.0, f64::max)
}

fn vanishes(backend: &Backend, scenes: &[(&str, Scene)], depths: &[u32], tolerance: f64) {
    for (name, scene) in scenes {
        for &max_depth in depths {
            for polarized in [true, false] {
                let settings = RenderSettings { max_depth, polarized, ..settings(&[550.0]) };
                let picture = render(backend, scene, &settings);
                let what = format!("{}, {name}, depth {max_depth}, polarised {polarized}", backend.name);
                assert!(picture.coverage().iter().sum::<f64>() > 20.0, "{what}: no stone in view");
                let (worst, energy) = (worst(&picture), picture.report.energy);
                assert!(worst <= tolerance, "{what}: off by {worst:e}, {energy:?}");
                assert_eq!(energy.dropped_share(), 0.0, "{what}: {energy:?}");
                assert!(energy.lost <= 1e-9 * energy.started, "{what}: {energy:?}");
            }
        }
    }
}

#[test]
fn lone_stones_vanish_at_any_depth() {
    vanishes(&CPU, &lone_stones(), &[1, 2, 3, 5, 16, 64], 1e-5);
}

#[test]
fn stones_with_branching_paths_vanish_at_any_depth() {
    vanishes(&CPU, &many_stones(), &[1, 2, 3, 5, 8, 11], 1e-5);
}

#[test]
fn the_reference_conserves_energy() {
    vanishes(&REFERENCE, &lone_stones(), &[1, 3, 16, 64], 1.2e-7);
    vanishes(&REFERENCE, &many_stones(), &[1, 2, 5, 8], 1.2e-7);
}

/// The mean deficit of the picture, and the dropped share in the report.
fn deficit(picture: &Picture) -> [f64; 2] {
    let values = picture.radiances().concat();
    let mean = values.iter().map(|v| 1.0 - v).sum::<f64>() / values.len() as f64;
    [mean, picture.report.energy.dropped_share()]
}

#[test]
fn the_missing_energy_is_the_dropped_energy() {
    let scenes = [lone_stones(), many_stones()].concat();
    for (name, scene) in &scenes {
        for (threshold, leftover, max_depth) in [
            (1e-2, Leftover::Exit, 64),
            (1e-4, Leftover::Exit, 64),
            (1e-3, Leftover::Drop, 6),
            (0.0, Leftover::Drop, 7),
        ] {
            for (backend, polarized) in [(CPU, true), (CPU, false), (REFERENCE, true)] {
                if backend.name == "reference" && threshold == 1e-4 {
                    continue;
                }
                let settings =
                    RenderSettings { threshold, leftover, max_depth, polarized, ..settings(&[550.0]) };
                let picture = render(&backend, scene, &settings);
                let [missing, dropped] = deficit(&picture);
                let what = format!("{}, {name}, {threshold:e}, {leftover:?}", backend.name);
                assert!((missing - dropped).abs() < 1e-6, "{what}: {missing} missing, {dropped} dropped");
                assert!(dropped > 0.0, "{what}: nothing was dropped");
                let energy = picture.report.energy;
                assert!(energy.lost <= 1e-9 * energy.started, "{what}: {energy:?}");
            }
        }
    }
}

#[test]
fn coloured_light_keeps_its_colour() {
    // In coloured daylight the stone vanishes at every wavelength too.
    let light = Environment::uniform([0.9, 0.4, 0.1]);
    let scene = Scene { environment: light, ..world(vec![gem("round-brilliant", glass(2.417))]) };
    let settings = RenderSettings { wavelengths: WavelengthGrid::default(), ..settings(&[550.0]) };
    let picture = render(&CPU, &scene, &settings);
    let (pixels, coverage) = (picture.radiances(), picture.coverage());
    let background = &pixels[coverage.iter().position(|c| *c == 0.0).expect("a corner without stone")];
    for pixel in &pixels {
        for (found, expected) in pixel.iter().zip(background) {
            assert!((found - expected).abs() <= 1e-5 * expected.max(1e-3), "{found} before {expected}");
        }
    }
}
