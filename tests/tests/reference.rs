//! The picture of an independent renderer, reproduced from its scene file; see `data/reference/README.md`.

use gemtrace::scene_file::{LoadedScene, load};
use gemtrace_tests::{image::read_channels, prelude::*};
use spectral_core::{cie::Illuminant, color::RgbSpace};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The first kept pixel of the reference; every fourth is kept.
const KEPT: [usize; 2] = [1, 2];
const STEP: usize = 4;
const SIZE: usize = 512;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/reference").join(name)
}

/// The reference's planes by channel name.
fn reference() -> HashMap<String, Vec<f64>> {
    read_channels(&data("diamond.exr")).1
}

/// The kept pixels that show the stone, as indices of the kept image.
fn stone(reference: &HashMap<String, Vec<f64>>) -> Vec<usize> {
    let stone: Vec<usize> = (0..reference["stone"].len()).filter(|&i| reference["stone"][i] > 0.5).collect();
    assert_eq!(stone.len(), 8342);
    stone
}

/// The index of a kept pixel in the whole image.
fn place(kept: usize) -> usize {
    let side = SIZE / STEP;
    let [x, y] = [KEPT[0] + STEP * (kept % side), KEPT[1] + STEP * (kept / side)];
    y * SIZE + x
}

fn scene() -> LoadedScene {
    load(&data("brilliant_diamond.toml")).expect("the reference's scene")
}

fn compare_spectral(picture: &Picture, nm: &[f64]) {
    let reference = reference();
    let (stone, radiances) = (stone(&reference), picture.radiances());
    for (line, nm) in nm.iter().enumerate() {
        let plane = &reference[&format!("S0.{nm}nm")];
        let pairs =
            |pixels: &[usize]| Difference::of(pixels.iter().map(|&i| (plane[i], radiances[place(i)][line])));
        let difference = pairs(&stone);
        println!("{nm} nm: {difference}");
        assert!(difference.median < 1e-4, "{nm} nm: {difference}");
        assert!(difference.over_1_percent < 5e-3, "{nm} nm: {difference}");
        let background: Vec<usize> = (0..plane.len()).filter(|i| !stone.contains(i)).collect();
        let beside = pairs(&background);
        assert!(beside.median < 1e-6 && beside.over_1_percent < 1e-3, "background at {nm} nm: {beside}");
    }
}

#[test]
fn spectral_radiance() {
    let LoadedScene { scene, settings, warnings, .. } = scene();
    assert!(settings.spectral && !settings.polarized && settings.samples == 1);
    println!("{warnings:?}");
    compare_spectral(&render(&CPU, &scene, &settings), settings.wavelengths.nm());
}

#[test]
fn spectral_radiance_through_the_hierarchy() {
    let LoadedScene { scene, settings, .. } = scene();
    let grid = WavelengthGrid::list(vec![460.0, 650.0]).expect("ascending");
    let settings = RenderSettings { wavelengths: grid, ..settings };
    compare_spectral(&render(&CPU, &with_speck(&scene), &settings), settings.wavelengths.nm());
}

#[test]
fn colour_under_daylight() {
    let LoadedScene { mut scene, settings, .. } = scene();
    scene.environment.illuminant = Illuminant::D65;
    let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0).expect("81 wavelengths");
    let settings = RenderSettings { wavelengths: grid, spectral: false, ..settings };
    let found = render(&CPU, &scene, &settings).film.to_space(RgbSpace::Srgb);
    let reference = reference();
    let rgb = ["R", "G", "B"].map(|c| &reference[c]);
    let stone = stone(&reference);
    // Relative to the largest component of the pixel: components near 0 have no significant digits.
    let errors = |i: usize| {
        let (expected, found) = (rgb.map(|plane| plane[i]), found[place(i)]);
        let most = expected.into_iter().fold(1e-6, f64::max);
        [0, 1, 2].map(|c| (f64::from(found[c]) - expected[c]).abs() / most)
    };
    let mut all: Vec<f64> = stone.iter().flat_map(|&i| errors(i)).collect();
    all.sort_by(f64::total_cmp);
    let median = all[all.len() / 2];
    let within =
        stone.iter().filter(|&&i| errors(i).iter().all(|e| *e < 0.01)).count() as f64 / stone.len() as f64;
    let mean = |of: &dyn Fn(usize) -> f64| stone.iter().map(|&i| of(i)).sum::<f64>();
    let ratios = [0, 1, 2].map(|c| mean(&|i| f64::from(found[place(i)][c])) / mean(&|i| rgb[c][i]));
    println!("median {median:.1e}, {:.2} % of the pixels within 1 %, means {ratios:?}", 100.0 * within);
    assert!(median < 1e-4 && within > 0.95, "median {median:e}, {within} within 1 %");
    assert!(ratios.iter().all(|r| (r - 1.0).abs() < 1e-3), "{ratios:?}");
}
