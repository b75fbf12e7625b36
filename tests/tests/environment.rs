//! Photographs seen directly are reproduced: RGB texel → spectrum → XYZ → RGB.

use gemtrace::import::environment;
use gemtrace_tests::prelude::*;
use spectral_core::{color::RgbSpace, settings::pixel_offset};
use std::path::Path;

const PHOTOGRAPHS: [&str; 4] = ["apartment.exr", "hall.exr", "lobby.exr", "studio.exr"];

/// Largest summed error, as a share of the colour's largest component. The requirement is 4e-3. With bases that are exact
/// on the renderer's own wavelengths, only the rounding of the film is left.
const ALLOWED: f64 = 1e-5;
const SIZE: u32 = 160;

fn photograph(name: &str) -> Environment {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/environments").join(name);
    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let (image, warnings): (LatLong, _) = environment::read(&path, &bytes).expect("a lat-long image");
    // Compression artefacts beside the lamps: some components are negative, too few for anyone to see.
    assert!(warnings.is_empty(), "{warnings:?}");
    Environment { rotation: 25.0, scale: 1.0, ..Environment::image(image) }
}

/// Six views that show every direction.
fn views() -> [Camera; 6] {
    [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z].map(|look_at| Camera {
        position: DVec3::ZERO,
        look_at,
        up: if look_at.z == 0.0 { DVec3::Z } else { DVec3::Y },
        projection: Projection::Perspective { fov: 90.0 },
    })
}

/// The worst summed error of any pixel, as a share of its largest component.
fn worst(backend: &Backend, light: &Environment, camera: &Camera, settings: &RenderSettings) -> f64 {
    let scene = scene(camera.clone(), SIZE, light.clone(), vec![]);
    let view = camera.view(SIZE, SIZE).expect("a camera");
    let found = render(backend, &scene, settings).film.to_space(RgbSpace::Srgb);
    let mut worst = 0.0_f64;
    for (i, found) in found.iter().enumerate() {
        let (x, y) = (i as u32 % SIZE, i as u32 / SIZE);
        let mut expected = [0.0; 3];
        for sample in 0..settings.samples {
            let [dx, dy] = pixel_offset(sample, settings.samples);
            let rgb = light.rgb(view.ray(f64::from(x) + dx, f64::from(y) + dy).direction);
            (0..3).for_each(|c| expected[c] += rgb[c] / f64::from(settings.samples));
        }
        let error: f64 = (0..3).map(|c| (f64::from(found[c]) - expected[c]).abs()).sum();
        let most = expected.into_iter().fold(0.0, f64::max);
        worst = worst.max(if most > 0.0 { error / most } else { error });
        assert_eq!(found[3], 0.0, "there is no stone to cover a pixel");
    }
    worst
}

fn is_reproduced(backend: &Backend, what: &str, settings: &RenderSettings, views: &[Camera]) {
    for name in PHOTOGRAPHS {
        let light = photograph(name);
        let worst = views.iter().map(|view| worst(backend, &light, view, settings)).fold(0.0, f64::max);
        println!("{}, {name}, {what}: worst summed error {worst:.1e}", backend.name);
        assert!(worst <= ALLOWED, "{}, {name}, {what}: summed error {worst:e}", backend.name);
    }
}

fn on(wavelengths: WavelengthGrid, samples: u32) -> RenderSettings {
    RenderSettings { wavelengths, samples, jitter: samples > 1, spectral: false, ..settings(&[550.0]) }
}

#[test]
fn on_the_default_grid() {
    is_reproduced(&CPU, "32 wavelengths", &on(WavelengthGrid::default(), 1), &views());
    is_reproduced(&REFERENCE, "32 wavelengths", &on(WavelengthGrid::default(), 1), &views()[..2]);
}

#[test]
fn on_jittered_grids() {
    let eight = WavelengthGrid::midpoints([380.0, 740.0], 8).expect("a valid grid");
    is_reproduced(&CPU, "4 samples of 8 wavelengths", &on(eight, 4), &views());
}

#[test]
fn on_the_grid_of_published_tables() {
    let eighty_one = WavelengthGrid::stepped(380.0, 780.0, 5.0).expect("a valid grid");
    is_reproduced(&CPU, "81 wavelengths", &on(eighty_one, 1), &views()[..3]);
}
