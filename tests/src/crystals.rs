//! Scenes with doubly refracting crystals, in which every backend must agree with the double-precision reference.

use crate::cases::{Case, lines, studio, view};
use crate::prelude::*;
use spectral_core::material::Catalogue;

/// Every case, cheapest first.
pub fn crystals() -> Vec<Case> {
    let case = |name, scene, settings| Case { name, scene, settings, outliers: 0.005 };
    let one = |size, stone| scene(view(14.0), size, studio(), vec![stone]);
    let brilliant = |material, axis| lying(gem("round-brilliant", material), axis);
    let tilted = [0.5, 0.3, 0.8];
    let coarse = RenderSettings { threshold: 1e-2, split: 0.05, ..lines(3) };
    let fine = RenderSettings { threshold: 3e-3, split: 0.02, ..lines(2) };
    let calcite = || crystal(&[1.658, 1.486]);
    let peridot = || crystal(&[1.654, 1.671, 1.689]);
    let leftover = |leftover| RenderSettings { max_depth: 4, leftover, split: 0.0, ..coarse.clone() };
    let dispersive = Catalogue::builtin().get("zircon").expect("a crystal").clone();
    let star = lying(stone(star(5, 1.2, 3.0, 1.4), crystal(&[1.6, 1.75])), tilted);
    vec![
        case("calcite-block", one(64, lying(stone(block(-2.0, 2.0), calcite()), tilted)), fine.clone()),
        case("zircon", one(64, brilliant(crystal(&[1.925, 1.984]), tilted)), fine.clone()),
        case(
            "axis-to-the-table",
            one(48, brilliant(crystal(&[1.77, 1.762]), [0.0, 0.0, 1.0])),
            coarse.clone(),
        ),
        case(
            "tourmaline-step-scalar",
            one(64, lying(gem("step", pleochroic(&[1.644, 1.624], &[0.6, 0.1])), [0.0, 1.0, 0.0])),
            RenderSettings { polarized: false, ..fine.clone() },
        ),
        case(
            "tanzanite-step",
            one(64, lying(gem("step", pleochroic(&[1.692, 1.694, 1.70], &[0.2, 0.5, 0.1])), tilted)),
            fine.clone(),
        ),
        case("peridot", one(64, brilliant(peridot(), tilted)), coarse.clone()),
        case("biaxial-high-index", one(48, brilliant(crystal(&[2.3, 2.0, 2.6]), tilted)), coarse.clone()),
        case("star-of-crystal", scene(view(14.0), 48, studio(), vec![star]), coarse.clone()),
        case("stone-through-a-crystal", through_a_crystal(), coarse.clone()),
        case("crystals-in-contact", in_contact(), RenderSettings { threshold: 2e-2, ..coarse.clone() }),
        case("crystal-in-a-bezel", in_a_bezel(), coarse.clone()),
        case("crystal-depth-limit", one(48, brilliant(calcite(), tilted)), leftover(Leftover::Exit)),
        case("crystal-depth-limit-dropped", one(48, brilliant(peridot(), tilted)), leftover(Leftover::Drop)),
        case("eye-in-a-crystal", within_a_crystal(), RenderSettings { max_depth: 6, ..coarse.clone() }),
        case(
            "crystal-jittered-wavelengths",
            one(48, brilliant(dispersive, tilted)),
            RenderSettings { samples: 3, jitter: true, ..coarse },
        ),
    ]
}

fn block(low: f64, high: f64) -> Arc<spectral_core::mesh::Mesh> {
    cuboid(DVec3::new(low, -2.0, -1.5), DVec3::new(high, 2.0, 1.5))
}

/// The eye in a biaxial block.
fn within_a_crystal() -> Scene {
    let camera =
        Camera { position: DVec3::new(0.3, 0.2, -0.4), look_at: DVec3::new(1.0, 3.0, 0.5), ..view(50.0) };
    let block = lying(stone(block(-2.0, 2.0), crystal(&[1.654, 1.671, 1.689])), [0.5, 0.3, 0.8]);
    scene(camera, 48, studio(), vec![block])
}

/// A brilliant beneath a plate of calcite.
fn through_a_crystal() -> Scene {
    let plate = cuboid(DVec3::new(-4.0, -4.0, 2.0), DVec3::new(4.0, 4.0, 4.0));
    let plate = lying(stone(plate, crystal(&[1.658, 1.486])), [0.6, 0.2, 0.7]);
    scene(view(18.0), 48, studio(), vec![gem("round-brilliant", glass(1.7)), plate])
}

/// Two crystals face to face, an inclusion of a third in one, and of glass in the other.
fn in_contact() -> Scene {
    let stones = vec![
        lying(stone(block(-3.0, 0.0), crystal(&[1.658, 1.486])), [0.5, 0.3, 0.8]),
        lying(stone(block(0.0, 3.0), crystal(&[1.6, 1.65, 1.72])), [0.2, -0.7, 0.5]),
        lying(at(stone(sphere(0.7, 6, 8), crystal(&[1.925, 1.984])), [-1.5, 0.1, 0.2]), [1.0, 0.0, 0.2]),
        at(stone(sphere(0.6, 6, 8), tinted(1.8, 0.2)), [1.4, -0.2, 0.1]),
    ];
    scene(view(16.0), 48, studio(), stones)
}

/// A block of crystal with metal on one face, beside a plate of metal and face to face with glass.
fn in_a_bezel() -> Scene {
    let wall = cuboid(DVec3::new(-3.0, -2.0, -1.5), DVec3::new(-2.0, 2.0, 1.5));
    let glazed = cuboid(DVec3::new(2.0, -2.0, -1.5), DVec3::new(3.0, 2.0, 1.5));
    let tray = cuboid(DVec3::new(-5.0, -5.0, -3.2), DVec3::new(5.0, 5.0, -2.6));
    let stones = vec![
        lying(stone(block(-2.0, 2.0), pleochroic(&[1.6, 1.7, 1.65], &[0.05, 0.2, 0.1])), [0.5, 0.3, 0.8]),
        stone(wall, metal(0.2, 3.4)),
        stone(glazed, glass(1.62)),
        stone(tray, metal(1.4, 7.0)),
    ];
    scene(view(18.0), 48, studio(), stones)
}
