//! The scenes on which every backend must agree with the double-precision oracle.

use crate::{
    light::furnace,
    scene::{eye, gem, glass, material, metal, parallel, scene, stone, tinted},
    solid::{cuboid, sphere, star, torus},
};
use glam::DVec3;
use spectral_core::{
    environment::{Environment, Ground, LatLong},
    scene::{Background, Scene, Stone},
    settings::{Leftover, RenderSettings},
    wavelength::WavelengthGrid,
};
use std::sync::Arc;

/// A scene, its settings, and how far a backend's picture of it may be from the oracle's.
pub struct Exhibit {
    /// Names the trial.
    pub name: &'static str,
    /// The scene.
    pub scene: Scene,
    /// The settings.
    pub settings: RenderSettings,
    /// The share of the stones' pixels that may be off by more than
    /// [`TOLERANCE`](spectral_core::film::Agreement::TOLERANCE).
    pub outliers: f64,
}

/// The largest median of the relative difference.
pub const MEDIAN: f64 = 1e-5;
/// The largest relative difference of the mean pictures.
pub const MEAN: f64 = 1e-4;

fn settings(wavelengths: usize) -> RenderSettings {
    RenderSettings {
        samples: 1,
        tolerance: 0.0,
        wavelengths: WavelengthGrid::midpoints([400.0, 700.0], wavelengths).expect("a valid grid"),
        jitter: false,
        max_depth: 32,
        leftover: Leftover::Exit,
        threshold: 1e-3,
        polarized: true,
        spectral: false,
    }
}

fn studio() -> Environment {
    Environment { rotation: 25.0, ..Environment::image(LatLong::studio()) }
}

/// Small lights, a thousand times as bright as the room.
fn lamps() -> Environment {
    let (width, height) = (256, 128);
    let texels = (0..width * height)
        .map(|k| {
            let (i, j) = (k % width, k / width);
            if i % 32 < 2 && j % 24 < 2 { [300.0, 280.0, 250.0] } else { [0.2, 0.25, 0.3] }
        })
        .collect();
    Environment::image(LatLong::new(width, height, texels).expect("a valid image").0)
}

fn at(stone: Stone, x: f64, y: f64, z: f64) -> Stone {
    Stone { position: DVec3::new(x, y, z), ..stone }
}

/// The usual view: from above and the side.
fn view(fov: f64) -> spectral_core::camera::Camera {
    eye(DVec3::new(3.0, -11.0, 28.0), fov)
}

/// Every scene, cheapest first.
pub fn gallery() -> Vec<Exhibit> {
    let exhibit = |name, scene, settings| Exhibit { name, scene, settings, outliers: 0.005 };
    let polarized = settings(4);
    let scalar = RenderSettings { polarized: false, ..settings(4) };
    let cuts = [
        ("round-brilliant", "round-brilliant", "diamond", polarized.clone()),
        ("round-brilliant-scalar", "round-brilliant", "diamond", scalar.clone()),
        ("step-cut", "step", "emerald", polarized.clone()),
        ("portuguese-scalar", "portuguese", "sapphire", scalar),
    ];
    let mut all = vec![exhibit(
        "box",
        scene(
            view(14.0),
            64,
            studio(),
            vec![stone(cuboid(DVec3::splat(-2.0), DVec3::splat(2.0)), glass(1.5))],
        ),
        settings(3),
    )];
    all.extend(cuts.map(|(name, cut, matter, settings)| {
        exhibit(name, scene(view(14.0), 96, studio(), vec![gem(cut, material(matter))]), settings)
    }));
    all.extend([
        exhibit(
            "absorbing",
            scene(view(14.0), 96, studio(), vec![gem("round-brilliant", tinted(1.76, 0.25))]),
            polarized.clone(),
        ),
        exhibit("two-stones", two_stones(), polarized.clone()),
        exhibit("nested-and-touching", nested(), RenderSettings { threshold: 1e-2, ..settings(3) }),
        exhibit(
            "torus",
            scene(view(16.0), 64, studio(), vec![stone(torus(2.2, 0.8, 24, 12), glass(1.5))]),
            RenderSettings { threshold: 1e-2, ..settings(3) },
        ),
        exhibit("star", star_scene(), RenderSettings { threshold: 1e-2, ..settings(3) }),
        exhibit("metal-beside-stone", beside_metal(), RenderSettings { threshold: 1e-2, ..settings(3) }),
        exhibit(
            "tiny-lights",
            scene(view(14.0), 96, lamps(), vec![gem("round-brilliant", material("diamond"))]),
            polarized.clone(),
        ),
        exhibit(
            "orthographic-transparent",
            Scene {
                background: Background::Transparent,
                ..scene(
                    parallel(DVec3::new(4.0, -6.0, 20.0), 8.0),
                    96,
                    studio(),
                    vec![gem("step", glass(1.7))],
                )
            },
            polarized.clone(),
        ),
        exhibit(
            "jittered-wavelengths",
            scene(view(14.0), 64, studio(), vec![gem("round-brilliant", material("zircon"))]),
            RenderSettings { samples: 4, jitter: true, ..settings(4) },
        ),
        exhibit(
            "depth-limit",
            scene(view(14.0), 96, studio(), vec![gem("round-brilliant", material("diamond"))]),
            RenderSettings { max_depth: 5, threshold: 0.0, ..settings(4) },
        ),
        exhibit(
            "depth-limit-dropped",
            scene(view(14.0), 96, studio(), vec![gem("round-brilliant", material("diamond"))]),
            RenderSettings { max_depth: 5, leftover: Leftover::Drop, ..settings(4) },
        ),
        exhibit(
            "furnace",
            scene(view(14.0), 64, furnace(), vec![gem("round-brilliant", material("diamond"))]),
            RenderSettings { threshold: 0.0, ..settings(4) },
        ),
        exhibit(
            "on-a-ground",
            scene(view(18.0), 96, above_ground(studio()), vec![gem("round-brilliant", material("sapphire"))]),
            RenderSettings { max_depth: 12, ..polarized.clone() },
        ),
        exhibit(
            "two-stones-on-a-ground",
            Scene { environment: above_ground(Environment::uniform([0.6, 0.8, 1.0])), ..two_stones() },
            polarized.clone(),
        ),
        exhibit(
            "curved",
            scene(view(14.0), 64, studio(), vec![stone(sphere(2.5, 12, 24), glass(1.5))]),
            settings(3),
        ),
    ]);
    all
}

/// The same light with a diffuse ground below, darkest in its middle, and of another colour beyond its picture.
fn above_ground(light: Environment) -> Environment {
    let edge = 33;
    let texel = |k: u32| {
        let [x, y] = [k % edge, k / edge].map(|i| (i as f32 - 16.0) / 16.0);
        let far = (x * x + y * y).min(1.0);
        [0.1 + 0.6 * far, 0.1 + 0.4 * far, 0.3 * far + 0.05 * x + 0.05]
    };
    let texels = (0..edge * edge).map(texel).collect();
    let ground = Ground::new(-3.0, [-12.0; 2], 0.75, edge, texels).expect("a valid ground");
    Environment { ground: Some(Arc::new(ground)), ..light }
}

fn two_stones() -> Scene {
    let stones = vec![
        at(gem("round-brilliant", material("diamond")), -2.0, 0.0, 0.0),
        at(gem("step", material("sapphire")), 3.5, 3.0, -1.5),
    ];
    scene(view(22.0), 64, studio(), stones)
}

/// A bubble and an inclusion in a block, and a second block face to face with it.
fn nested() -> Scene {
    let block = |low: f64, high: f64| cuboid(DVec3::new(low, -2.0, -1.5), DVec3::new(high, 2.0, 1.5));
    let stones = vec![
        stone(block(-3.0, 0.0), glass(1.5)),
        stone(block(0.0, 3.0), glass(1.7)),
        at(stone(sphere(0.7, 6, 8), tinted(2.0, 0.2)), -1.5, 0.1, 0.2),
        at(stone(sphere(0.6, 6, 8), glass(1.0)), 1.4, -0.2, 0.1),
    ];
    scene(view(16.0), 64, studio(), stones)
}

fn star_scene() -> Scene {
    let mut star = stone(star(5, 1.2, 3.0, 1.4), glass(1.55));
    star.rotation = DVec3::new(20.0, 10.0, 5.0);
    scene(view(14.0), 64, studio(), vec![star])
}

fn beside_metal() -> Scene {
    let tray = cuboid(DVec3::new(-5.0, -5.0, -4.2), DVec3::new(5.0, 5.0, -3.6));
    let stones = vec![gem("round-brilliant", glass(1.77)), stone(tray, metal(0.2, 3.4))];
    scene(view(18.0), 64, studio(), stones)
}
