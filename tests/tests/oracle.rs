//! Single precision against the reference: double precision with every triangle tested for every ray.
//!
//! The two may differ where a path meets the edge of a facet, so pictures are compared by the median error and the share
//! of samples with an error above 1 %.

use gemtrace::scene_file::{LoadedScene, load};
use gemtrace_tests::prelude::{studio as studio_light, *};

fn above() -> Camera {
    eye(DVec3::new(3.0, -11.0, 24.0), 17.0)
}

fn studio(stones: Vec<Stone>) -> Scene {
    scene(above(), 80, studio_light(), stones)
}

/// The default settings with few wavelengths.
fn usual() -> RenderSettings {
    RenderSettings { threshold: 1e-4, ..settings(&[440.0, 550.0, 640.0]) }
}

fn agree(what: &str, scene: &Scene, settings: &RenderSettings) {
    let (expected, found) = (render(&REFERENCE, scene, settings), render(&CPU, scene, settings));
    let difference = Difference::of_stones(&expected, &found);
    let [double, single] = [&expected, &found].map(|p| p.report.energy);
    println!("{what}: {difference}; dropped {:.2e}", single.dropped_share());
    assert!(difference.samples > 3000, "{what}: {difference}");
    assert!(difference.median < 1e-4, "{what}: {difference}");
    assert!(difference.over_1_percent < 5e-3, "{what}: {difference}");
    assert!((difference.mean_ratio - 1.0).abs() < 1e-3, "{what}: {difference}");
    let dropped = (single.dropped_share() - double.dropped_share()).abs();
    assert!(dropped < 1e-5 + 1e-2 * double.dropped_share(), "{what}: {single:?} against {double:?}");
    assert!((single.left_at_limit - double.left_at_limit).abs() < 1e-3 * single.started, "{what}");
    for energy in [single, double] {
        assert!(energy.lost <= 1e-9 * energy.started, "{what}: {energy:?}");
    }
}

fn both_modes(what: &str, scene: &Scene, settings: &RenderSettings) {
    for polarized in [true, false] {
        let mode = if polarized { "polarised" } else { "scalar" };
        agree(&format!("{what}, {mode}"), scene, &RenderSettings { polarized, ..settings.clone() });
    }
}

#[test]
fn brilliant() {
    let scene = studio(vec![gem("round-brilliant", material("diamond"))]);
    both_modes("diamond brilliant", &scene, &usual());
    both_modes("diamond brilliant through the hierarchy", &with_speck(&scene), &usual());
}

#[test]
fn step_cut() {
    let scene = studio(vec![gem("step", material("emerald"))]);
    both_modes("emerald step cut", &scene, &usual());
    both_modes("emerald step cut through the hierarchy", &with_speck(&scene), &usual());
}

#[test]
fn portuguese_cut() {
    let scene = studio(vec![gem("portuguese", material("ruby"))]);
    both_modes("ruby Portuguese cut", &scene, &usual());
}

#[test]
fn depth_limits() {
    let scene = studio(vec![gem("round-brilliant", material("diamond"))]);
    for leftover in [Leftover::Exit, Leftover::Drop] {
        for max_depth in [1, 2, 3, 8] {
            let settings = RenderSettings { leftover, max_depth, ..usual() };
            agree(&format!("{leftover:?} at {max_depth}"), &scene, &settings);
            agree(&format!("{leftover:?} at {max_depth}, hierarchy"), &with_speck(&scene), &settings);
        }
    }
}

#[test]
fn cameras() {
    let stones = vec![gem("round-brilliant", tinted(1.77, 0.05))];
    let light = studio_light();
    let flat = parallel(DVec3::new(3.0, -11.0, 24.0), 7.0);
    both_modes("parallel rays", &scene(flat, 80, light.clone(), stones.clone()), &usual());
    let jittered = RenderSettings {
        samples: 4,
        jitter: true,
        wavelengths: WavelengthGrid::midpoints([380.0, 740.0], 3).expect("a valid grid"),
        ..usual()
    };
    agree("jittered wavelengths", &scene(above(), 64, light.clone(), stones.clone()), &jittered);
    let close = Camera { position: DVec3::new(0.2, -0.3, 0.1), ..eye(DVec3::new(0.0, 0.0, 1.0), 80.0) };
    both_modes("from inside the stone", &scene(close, 64, light, stones), &usual());
}

#[test]
fn harsh_light() {
    // A dim room with lamps one degree wide and 20,000 times as bright.
    let lamps = [[0.3, 0.2, 0.9], [-0.8, 0.1, 0.5], [0.1, -0.9, 0.3], [0.6, 0.6, -0.5]].map(DVec3::from);
    let cos = 0.6_f64.to_radians().cos();
    let light = painted(256, |d| {
        if lamps.iter().any(|lamp| lamp.normalize().dot(d) > cos) { 2000.0 } else { 0.1 + 0.05 * d.z }
    });
    let scene = scene(above(), 96, light, vec![gem("round-brilliant", material("diamond"))]);
    both_modes("tiny bright lamps", &scene, &usual());
    agree("tiny bright lamps, hierarchy", &with_speck(&scene), &usual());
}

#[test]
fn several_stones() {
    let ball = |radius: f64, material| stone(sphere(radius, 10, 20), material);
    let nested = studio(vec![
        at(ball(0.5, glass(1.0)), [0.6, 0.3, -0.4]),
        gem("round-brilliant", material("sapphire")),
        at(ball(0.4, material("ruby")), [-0.5, 0.2, -0.3]),
    ]);
    let coarse = RenderSettings { threshold: 1e-3, ..usual() };
    both_modes("inclusions", &nested, &coarse);
    let touching = studio(vec![
        stone(cuboid(DVec3::new(-3.0, -2.0, -1.0), DVec3::new(0.0, 2.0, 1.0)), tinted(1.5, 0.05)),
        stone(cuboid(DVec3::new(0.0, -2.0, -1.0), DVec3::new(2.5, 2.0, 1.0)), tinted(1.9, 0.02)),
        stone(cuboid(DVec3::new(-1.5, -1.5, 1.0), DVec3::new(1.0, 1.2, 2.0)), tinted(1.5, 0.3)),
    ]);
    both_modes("blocks in contact", &touching, &coarse);
    let overlapping = studio(vec![
        at(ball(2.2, tinted(1.5, 0.1)), [-1.0, 0.0, 0.0]),
        at(ball(2.0, tinted(2.0, 0.02)), [1.2, 0.3, 0.2]),
    ]);
    both_modes("overlapping balls", &overlapping, &coarse);
}

#[test]
fn not_convex() {
    let coarse = RenderSettings { threshold: 1e-3, ..usual() };
    let ring = studio(vec![stone(torus(2.4, 0.9, 24, 12), tinted(1.6, 0.1))]);
    both_modes("torus", &ring, &coarse);
    let star = studio(vec![stone(star(7, 1.4, 3.2, 1.5), material("amethyst"))]);
    both_modes("star", &star, &coarse);
}

#[test]
fn metal_beside_and_under_a_stone() {
    let coarse = RenderSettings { threshold: 1e-3, ..usual() };
    let floor = at(stone(plate(9.0, 0.5), metal(0.3, 3.0)), [0.0, 0.0, -3.2]);
    let prong = stone(cuboid(DVec3::new(2.6, -0.4, -2.0), DVec3::new(3.4, 0.4, 0.9)), material("gold"));
    let scene = studio(vec![gem("round-brilliant", material("diamond")), floor, prong]);
    both_modes("gold prong in a diamond, above a mirror", &scene, &coarse);
}

#[test]
fn the_scenes_that_come_with_the_program() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let files = std::fs::read_dir(&folder).expect("a folder of scenes").map(|f| f.expect("an entry").path());
    let mut files: Vec<_> = files.filter(|f| f.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    assert!(!files.is_empty());
    for file in files {
        let LoadedScene { scene, settings: own, .. } = load(&file).expect("a valid scene");
        let scene = Scene { width: 64, height: 64, ..scene };
        let wavelengths = WavelengthGrid::list(vec![440.0, 550.0, 640.0]).expect("ascending");
        let threshold = own.threshold.max(1e-3);
        let settings = RenderSettings { samples: 1, wavelengths, threshold, spectral: true, ..own };
        agree(&file.display().to_string(), &scene, &settings);
    }
}
