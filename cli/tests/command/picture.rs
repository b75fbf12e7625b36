//! What `render` writes.

use super::read::{Exr, Png};
use super::support::{SCENE, Workplace};
use spectral_core::color::{RgbSpace, matrix::apply, srgb_encode};

/// The environment of the test scene.
const LIGHT: [f32; 3] = [0.5, 0.25, 0.125];

fn close(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}

#[test]
fn the_environment_seen_directly_keeps_its_colour() {
    let place = Workplace::new();
    place.render(&["a.exr"], &[]).unwrap();
    let [r, g, b, a] = Exr::open(&place.path("a.exr")).pixel(0);
    assert!(close(r, LIGHT[0], 1e-6) && close(g, LIGHT[1], 1e-6) && close(b, LIGHT[2], 1e-6), "{r} {g} {b}");
    assert_eq!(a, 1.0);
}

#[test]
fn png_is_the_exr_encoded() {
    let place = Workplace::new();
    for (bits, top) in [("8", 255.0), ("16", 65_535.0)] {
        place.render(&["a.exr", "a.png"], &["--bits", bits]).unwrap();
        let (exr, png) = (Exr::open(&place.path("a.exr")), Png::open(&place.path("a.png")));
        assert_eq!((png.width, png.height, png.samples.len()), (24, 16, 24 * 16 * 4));
        for (i, sample) in png.samples.iter().enumerate() {
            let value = f64::from(exr.pixel(i / 4)[i % 4]);
            let wanted = if i % 4 == 3 { value } else { srgb_encode(value.clamp(0.0, 1.0)) };
            assert_eq!(f64::from(*sample), (wanted * top).round(), "{bits} bits, sample {i}");
        }
    }
}

#[test]
fn a_transparent_background_leaves_coverage() {
    let place = Workplace::with(&SCENE.replace("height = 16", "height = 16\nbackground = \"transparent\""));
    place.render(&["a.exr", "a.png"], &["--bits", "16"]).unwrap();
    let (exr, png) = (Exr::open(&place.path("a.exr")), Png::open(&place.path("a.png")));
    assert_eq!(exr.pixel(0), [0.0; 4]);
    assert_eq!(exr.pixel(8 * 24 + 12)[3], 1.0);
    let edges: Vec<usize> = (0..24 * 16).filter(|&i| (0.01..0.99).contains(&exr.pixel(i)[3])).collect();
    assert!(!edges.is_empty());
    for i in edges {
        // Premultiplied in the EXR, straight in the PNG.
        let [r, _, _, a] = exr.pixel(i).map(f64::from);
        let wanted = (srgb_encode((r / a).clamp(0.0, 1.0)) * 65_535.0).round();
        assert_eq!(
            [png.samples[4 * i], png.samples[4 * i + 3]],
            [wanted as u16, (a * 65_535.0).round() as u16]
        );
    }
}

#[test]
fn spectral_pictures_carry_a_channel_for_each_wavelength() {
    let scene = SCENE
        .replace("threshold", "spectral = true\njitter = false\nthreshold")
        .replace("uniform = [0.5, 0.25, 0.125]", "uniform = [0.5, 0.5, 0.5]\nilluminant = \"E\"");
    let place =
        Workplace::with(&scene.replace("{ count = 8, range = [380.0, 740.0] }", "[450.0, 550.5, 600.0]"));
    place.render(&["a.exr"], &[]).unwrap();
    let exr = Exr::open(&place.path("a.exr"));
    let names: Vec<&String> = exr.channels.keys().collect();
    assert_eq!(names, ["A", "B", "G", "R", "S0.450nm", "S0.550,5nm", "S0.600nm"]);
    for name in ["S0.450nm", "S0.550,5nm", "S0.600nm"] {
        assert!(close(exr.channels[name][0], 0.5, 1e-6), "{name}: {}", exr.channels[name][0]);
    }
    assert_eq!(exr.attributes["spectralLayoutVersion"], "1.0");
    assert_eq!(exr.attributes["emissiveUnits"], "W.m^-2.sr^-1");
}

#[test]
fn the_command_line_overrides_size_and_samples() {
    let place = Workplace::new();
    let report = place.render(&["a.png"], &["--size", "7x5", "--samples", "1"]).unwrap();
    let png = Png::open(&place.path("a.png"));
    assert_eq!((png.width, png.height), (7, 5));
    assert_eq!(report.json["settings"]["samples"], 1);
    assert_eq!(png.provenance["settings"], report.json["settings"]);
}

#[test]
fn the_same_scene_is_the_same_file() {
    let place = Workplace::new();
    let files = || ["a.png", "a.exr"].map(|name| place.read(name));
    place.render(&["a.png", "a.exr"], &["--threads", "1"]).unwrap();
    let first = files();
    place.render(&["a.png", "a.exr"], &["--threads", "3"]).unwrap();
    assert!(first == files());
}

#[test]
fn every_space_shows_the_same_light() {
    let place = Workplace::new();
    place.render(&["srgb.exr"], &[]).unwrap();
    let srgb = Exr::open(&place.path("srgb.exr"));
    for space in RgbSpace::ALL {
        let name = format!("{}.exr", space.name());
        place.render(&[&name], &["--space", space.name()]).unwrap();
        let exr = Exr::open(&place.path(&name));
        for i in 0..24 * 16 {
            let [r, g, b, _] = srgb.pixel(i).map(f64::from);
            let wanted = apply(&space.from_linear_srgb(), [r, g, b]);
            let found = exr.pixel(i);
            assert!(
                (0..3).all(|c| close(found[c], wanted[c] as f32, 1e-5)),
                "{name} {i}: {found:?} {wanted:?}"
            );
        }
        let [red, _, _, white] = exr.chromaticities;
        assert_eq!(red.map(f64::from).map(|v| (v * 1e4).round() / 1e4), space.primaries()[0]);
        if space == RgbSpace::Xyz {
            assert!(close(white[0], 1.0 / 3.0, 1e-6) && close(white[1], 1.0 / 3.0, 1e-6));
        }
        assert_eq!(exr.attributes["gemtrace.space"], space.name());
    }
}

#[test]
fn png_says_which_primaries_it_has() {
    let place = Workplace::new();
    for (space, primaries) in [("srgb", None), ("p3", Some(12)), ("rec2020", Some(9)), ("acescg", None)] {
        let report = place.render(&["a.png"], &["--space", space]).unwrap();
        assert_eq!(Png::open(&place.path("a.png")).primaries, primaries, "{space}");
        let told = report.json["warnings"].as_array().unwrap();
        assert_eq!(told.iter().any(|w| w.as_str().unwrap().contains("is in sRGB")), space == "acescg");
    }
}

#[test]
fn exposure_brightens_the_png_alone() {
    let place = Workplace::new();
    place.render(&["a.exr", "a.png"], &["--exposure", "-1.5"]).unwrap();
    let (exr, png) = (Exr::open(&place.path("a.exr")), Png::open(&place.path("a.png")));
    assert!(close(exr.pixel(0)[0], LIGHT[0], 1e-6));
    let wanted = LIGHT.map(|c| (srgb_encode(f64::from(c) * (-1.5f64).exp2()) * 255.0).round() as u16);
    assert_eq!(png.samples[..3], wanted);
}

#[test]
fn the_header_says_how_the_picture_was_made() {
    let place = Workplace::new();
    let report = place.render(&["a.exr"], &["--backend", "reference"]).unwrap();
    let attributes = Exr::open(&place.path("a.exr")).attributes;
    let fact = |key: &str| attributes[&format!("gemtrace.{key}")].clone();
    assert_eq!(fact("version"), env!("CARGO_PKG_VERSION"));
    assert_eq!((fact("scene").as_str(), fact("backend").as_str()), ("tiny.toml", "reference"));
    assert_eq!(fact("partial"), "false");
    assert_eq!(fact("scene_hash").len(), 64);
    assert_eq!(fact("rays"), report.json["rays"].to_string());
    let settings: serde_json::Value = serde_json::from_str(&fact("settings")).unwrap();
    assert_eq!(settings, report.json["settings"]);
    let energy: serde_json::Value = serde_json::from_str(&fact("energy")).unwrap();
    assert!(energy["dropped"].as_f64().unwrap() > 0.0);
}
