//! The scenes on which every backend must agree with the double-precision reference.

use crate::prelude::*;
use spectral_core::environment::Ground;

/// A scene with its settings and the allowed difference of a backend's picture from the reference picture.
pub struct Case {
    /// The name of the trial.
    pub name: &'static str,
    /// The scene.
    pub scene: Scene,
    /// The settings.
    pub settings: RenderSettings,
    /// The share of the stones' pixels whose difference may exceed
    /// [`TOLERANCE`](spectral_core::film::Agreement::TOLERANCE).
    pub outliers: f64,
}

/// The largest median of the relative difference.
pub const MEDIAN: f64 = 1e-5;
/// The largest relative difference of the mean colours.
pub const MEAN: f64 = 1e-4;

/// Every case, cheapest first.
pub fn cases() -> Vec<Case> {
    let case = |name, scene, settings| Case { name, scene, settings, outliers: 0.005 };
    let one = |size, light, stone| scene(view(14.0), size, light, vec![stone]);
    let brilliant = |material| gem("round-brilliant", material);
    let diamond = || brilliant(material("diamond"));
    let scalar = RenderSettings { polarized: false, ..lines(4) };
    let coarse = RenderSettings { threshold: 1e-2, ..lines(3) };
    let block = cuboid(DVec3::splat(-2.0), DVec3::splat(2.0));
    let flat = parallel(DVec3::new(4.0, -6.0, 20.0), 8.0);
    let transparent = scene(flat, 96, studio(), vec![gem("step", glass(1.7))]);
    let sapphire = vec![brilliant(material("sapphire"))];
    let bluish = Environment::uniform([0.6, 0.8, 1.0]);
    let ring = vec![stone(torus(2.2, 0.8, 24, 12), glass(1.5))];
    let from = |position: [f64; 3], look_at: [f64; 3]| {
        let camera = Camera { position: position.into(), look_at: look_at.into(), ..view(50.0) };
        scene(camera, 64, studio(), vec![stone(block.clone(), glass(1.5))])
    };
    vec![
        case("box", one(64, studio(), stone(block.clone(), glass(1.5))), lines(3)),
        case("round-brilliant", one(96, studio(), diamond()), lines(4)),
        case("round-brilliant-scalar", one(96, studio(), diamond()), scalar.clone()),
        case("step-cut", one(96, studio(), gem("step", material("emerald"))), lines(4)),
        case("portuguese-scalar", one(96, studio(), gem("portuguese", material("sapphire"))), scalar),
        case("absorbing", one(96, studio(), brilliant(tinted(1.76, 0.25))), lines(4)),
        case("two-stones", two_stones(studio()), lines(4)),
        case("nested-and-touching", nested(), coarse.clone()),
        case("torus", scene(view(16.0), 64, studio(), ring), coarse.clone()),
        case("star", star_scene(), coarse.clone()),
        case("metal-beside-stone", beside_metal(), coarse.clone()),
        case("tiny-lights", one(96, lamps(), diamond()), lines(4)),
        case(
            "orthographic-transparent",
            Scene { background: Background::Transparent, ..transparent },
            lines(4),
        ),
        case(
            "jittered-wavelengths",
            one(64, studio(), brilliant(material("zircon"))),
            RenderSettings { samples: 4, jitter: true, ..lines(4) },
        ),
        case(
            "depth-limit",
            one(96, studio(), diamond()),
            RenderSettings { max_depth: 5, threshold: 0.0, ..lines(4) },
        ),
        case(
            "depth-limit-dropped",
            one(96, studio(), diamond()),
            RenderSettings { max_depth: 5, leftover: Leftover::Drop, ..lines(4) },
        ),
        case("furnace", one(64, furnace(), diamond()), RenderSettings { threshold: 0.0, ..lines(4) }),
        case(
            "on-a-ground",
            scene(view(18.0), 96, above_ground(studio()), sapphire),
            RenderSettings { max_depth: 12, ..lines(4) },
        ),
        case("two-stones-on-a-ground", two_stones(above_ground(bluish)), lines(4)),
        case("camera-on-a-facet", from([0.3, -2.0, -0.2], [0.0, 4.0, 0.5]), coarse.clone()),
        case("camera-on-a-corner", from([-2.0, -2.0, 2.0], [0.0, 0.0, 0.0]), coarse.clone()),
        case("camera-on-a-corner-of-two", corner_of_two(), coarse),
        case("curved", one(64, studio(), stone(sphere(2.5, 12, 24), glass(1.5))), lines(3)),
    ]
}

pub(crate) fn lines(wavelengths: usize) -> RenderSettings {
    RenderSettings {
        wavelengths: WavelengthGrid::midpoints([400.0, 700.0], wavelengths).expect("a valid grid"),
        max_depth: 32,
        threshold: 1e-3,
        spectral: false,
        ..settings(&[550.0])
    }
}

pub(crate) fn studio() -> Environment {
    Environment { rotation: 25.0, ..crate::light::studio() }
}

/// Small lights, a thousand times as bright as the room.
fn lamps() -> Environment {
    let (width, height) = (256, 128);
    let lit = |k: u32| k % width % 32 < 2 && k / width % 24 < 2;
    let texel = |k| if lit(k) { [300.0, 280.0, 250.0] } else { [0.2, 0.25, 0.3] };
    let texels = (0..width * height).map(texel).collect();
    Environment::image(LatLong::new(width, height, texels).expect("a valid image").0)
}

/// The usual view: from above and the side.
pub(crate) fn view(fov: f64) -> Camera {
    eye(DVec3::new(3.0, -11.0, 28.0), fov)
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

fn two_stones(light: Environment) -> Scene {
    let diamond = at(gem("round-brilliant", material("diamond")), [-2.0, 0.0, 0.0]);
    let sapphire = at(gem("step", material("sapphire")), [3.5, 3.0, -1.5]);
    scene(view(22.0), 64, light, vec![diamond, sapphire])
}

/// A bubble and an inclusion in a block, and a second block face to face with it.
fn nested() -> Scene {
    let block = |low: f64, high: f64| cuboid(DVec3::new(low, -2.0, -1.5), DVec3::new(high, 2.0, 1.5));
    let stones = vec![
        stone(block(-3.0, 0.0), glass(1.5)),
        stone(block(0.0, 3.0), glass(1.7)),
        at(stone(sphere(0.7, 6, 8), tinted(2.0, 0.2)), [-1.5, 0.1, 0.2]),
        at(stone(sphere(0.6, 6, 8), glass(1.0)), [1.4, -0.2, 0.1]),
    ];
    scene(view(16.0), 64, studio(), stones)
}

/// The same view with a second stone in it, so that every backend goes through a hierarchy.
fn corner_of_two() -> Scene {
    let block = |shift: f64| {
        let corner = DVec3::new(2.0, 1.9, 1.8);
        at(stone(cuboid(-corner, corner), glass(1.5)), [shift, 0.0, 0.0])
    };
    let corner = DVec3::new(-2.0, -1.9, 1.8);
    let camera = Camera { position: corner, look_at: DVec3::new(0.3, 0.1, -0.2), ..view(50.0) };
    scene(camera, 64, studio(), vec![block(0.0), block(4.5)])
}

fn star_scene() -> Scene {
    let star = stone(star(5, 1.2, 3.0, 1.4), glass(1.55));
    let turned = Stone { rotation: DVec3::new(20.0, 10.0, 5.0), ..star };
    scene(view(14.0), 64, studio(), vec![turned])
}

fn beside_metal() -> Scene {
    let tray = cuboid(DVec3::new(-5.0, -5.0, -4.2), DVec3::new(5.0, 5.0, -3.6));
    let stones = vec![gem("round-brilliant", glass(1.77)), stone(tray, metal(0.2, 3.4))];
    scene(view(18.0), 64, studio(), stones)
}
