//! The numbers of `gemtrace measure`, against closed forms and against GemRay.

use super::support::{Cli, Report, Workplace, assert_matches, assert_refused, command, cut, number};
use clap::Parser as _;
use gemtrace::Error;
use serde_json::Value;

fn measure(design: &str, options: &[&str]) -> Result<Report, Error> {
    command(&[&["measure", design], options].concat())
}

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// The names of a design's figures in GemRay's table, and ours.
const MODELS: [&str; 3] = ["iso", "cos", "sc2"];

/// GemRay's table: design, index and tilt as they stand, and the six figures.
fn gemray() -> impl Iterator<Item = ([&'static str; 3], Vec<f64>)> {
    let lines = include_str!("../data/gemray.csv").lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        ([cells[0], cells[1], cells[2]], cells[3..].iter().map(|cell| cell.parse().unwrap()).collect())
    })
}

/// The largest difference from GemRay's six figures of a position, points.
fn difference(position: &Value, figures: &[f64]) -> f64 {
    let ours = ["stone", "table"].into_iter().flat_map(|part| MODELS.map(|model| &position[part][model]));
    ours.zip(figures).map(|(ours, theirs)| (100.0 * number(ours) - theirs).abs()).fold(0.0, f64::max)
}

#[test]
fn under_its_conditions_brightness_is_gemrays() {
    for design in ["srb_quartz_57.asc", "emerald_step_49.asc", "srb_diamond_57.asc"] {
        // Tilts to both sides have the same figures: the designs are symmetric, and GemRay says so, too.
        let rows: Vec<_> = gemray().filter(|([d, _, t], _)| *d == design && !t.starts_with('-')).collect();
        let tilts = rows.iter().map(|([_, _, tilt], _)| *tilt).collect::<Vec<_>>().join(",");
        let index = rows[0].0[1];
        let report = measure(&cut(design), &["--gemray", "-m", index, "--tilt", &tilts]).unwrap();
        let positions = report.json["positions"].as_array().unwrap();
        assert_eq!((rows.len(), positions.len()), (4, 4));
        for (position, ([_, _, tilt], figures)) in positions.iter().zip(&rows) {
            // GemRay renders symmetric stones in part. Untilted rounds are the ones that are not weighted evenly by
            // it: rays between two octants count in one of them alone.
            let bound = if *tilt == "0" { 0.1 } else { 0.02 };
            let found = difference(position, figures);
            assert!(found < bound, "{design} at {tilt}°: {found} points, {position}");
        }
    }
}

#[test]
fn the_rest_of_a_diamonds_light_is_what_gemray_drops() {
    let ([_, index, tilt], figures) =
        gemray().find(|([design, _, tilt], _)| *design == "srb_diamond_57.asc" && *tilt == "30").unwrap();
    let at = |depth: &str| {
        let arguments = ["--gemray", "-m", index, "--tilt", tilt, "--max-depth", depth, "--threshold", "0"];
        measure(&cut("srb_diamond_57.asc"), &arguments).unwrap().json["positions"][0].clone()
    };
    let [at_limit, beyond] = [at("10"), at("200")];
    assert!(difference(&at_limit, &figures) < 0.02);
    // A tenth of the light is still in the stone after nine hits, and most of it comes out later.
    assert!(number(&at_limit["dropped"]) > 0.09 && number(&beyond["dropped"]) < 1e-3);
    assert!(number(&beyond["stone"]["iso"]) > figures[0] / 100.0 + 0.03, "{beyond}");
}

#[test]
fn all_directions_add_up() {
    let ruby = ["--size=64", "--eye=20", "-m", "ruby", "--width=6"];
    let design = cut("srb_diamond_57.asc");
    let report = measure(&design, &[&ruby, &["--tilt=0,17", "--head=12"][..]].concat()).unwrap();
    for position in report.json["positions"].as_array().unwrap() {
        for part in ["stone", "table"] {
            let figure = |name: &str| number(&position[part][name]);
            let rest = figure("leakage") + figure("missing");
            assert!((figure("iso") + figure("extinction") + rest - 1.0).abs() < 1e-5, "{position}");
            // Green is what the others leave; under a head as wide as blue and red together, ISO sees green alone.
            let zones = figure("aset_blue") + figure("aset_red") + figure("aset_green");
            assert!((zones + rest - 1.0).abs() < 1e-12, "{position}");
            // A ruby absorbs; nothing that matters is dropped.
            assert!(figure("missing") > 0.05 && number(&position["dropped"]) < 1e-2);
        }
    }
    let wide = ["--tilt=17", "--head=45", "--models=iso"];
    let green = measure(&design, &[&ruby, &wide[..]].concat()).unwrap();
    for part in ["stone", "table"] {
        let figures = &green.json["positions"][0][part];
        assert!((number(&figures["iso"]) - number(&figures["aset_green"])).abs() < 1e-5, "{figures}");
    }
}

#[test]
fn a_cube_seen_straight_on_has_its_closed_form() {
    // Every ray stays on its line: R of it goes back at each face. Up comes 2R/(1 + R), from the head's direction.
    let place = Workplace::holding(&[("cube.obj", CUBE)]);
    let glass = |options: &[&str]| {
        let common = ["-m", "1.5", "--size=20", "--threshold=0"];
        measure(&place.name("cube.obj"), &[&common, options].concat()).unwrap().json
    };
    let report = glass(&["--head=5"]);
    let r = 0.04;
    for part in ["stone", "table"] {
        let figure = |name: &str| number(&report["positions"][0][part][name]);
        for (name, exact) in [
            ("extinction", 2.0 * r / (1.0 + r)),
            ("leakage", (1.0 - r) / (1.0 + r)),
            ("aset_blue", 2.0 * r / (1.0 + r)),
            ("iso", 0.0),
            ("contrast", 0.0),
            ("missing", 0.0),
        ] {
            assert!((figure(name) - exact).abs() < 1e-6, "{name}: {} and {exact}", figure(name));
        }
    }
    let without = glass(&["--head=0", "--models=iso,cos,sc2"]);
    let figures = &without["positions"][0]["stone"];
    for (name, exact) in [("iso", 2.0 * r / (1.0 + r)), ("cos", 2.0 * r / (1.0 + r)), ("extinction", 0.0)] {
        assert!((number(&figures[name]) - exact).abs() < 1e-6, "{name}: {figures}");
    }
    // The zenith's row is the mean over a ring of 0.02°.
    assert!(number(&figures["sc2"]) < 1e-4);
}

#[test]
fn fire_needs_dispersion() {
    let fire = |material: &str| {
        let arguments = ["-m", material, "--size=48", "--experimental", "--wavelengths=8"];
        let report = measure(&cut("srb_diamond_57.asc"), &arguments).unwrap();
        let stone = &report.json["positions"][0]["stone"];
        let scintillation = number(&stone["experimental_scintillation"]);
        assert!(scintillation > 0.01 && scintillation < 1.0, "{scintillation}");
        number(&stone["experimental_fire"])
    };
    assert!(fire("2.417") < 1e-5);
    assert!(fire("diamond") > 0.01);
}

#[test]
fn numbers_are_written_as_csv_and_svg() {
    let place = Workplace::new();
    let [csv, svg] = ["a.csv", "a.svg"].map(|name| place.name(name));
    let options = ["--size=24", "--tilt=-10..10:10", "--models=iso,aset", "--csv", &csv, "--svg", &svg];
    let report = measure(&cut("srb_quartz_57.asc"), &options).unwrap();
    let text = place.text("a.csv");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 4);
    let names: Vec<&str> = lines[0].split(',').collect();
    assert_eq!(names[..4], ["tilt", "stone_iso", "stone_aset", "stone_leakage"]);
    let cells: Vec<f64> = lines[1].split(',').map(|cell| cell.parse().unwrap()).collect();
    assert_eq!((cells.len(), cells[0]), (names.len(), -10.0));
    assert!((cells[1] - 100.0 * number(&report.json["positions"][0]["stone"]["iso"])).abs() < 1e-4);
    let svg = place.text("a.svg");
    let document = roxmltree::Document::parse(&svg).unwrap();
    let count = |name| document.descendants().filter(|node| node.has_tag_name(name)).count();
    // Two models, leakage and extinction, over the stone and over the table.
    assert_eq!(count(("http://www.w3.org/2000/svg", "polyline")), 8);
    assert!(svg.contains("tilt, degrees") && !svg.contains("NaN"));
    // Designed for 1.544, and measured so.
    assert_eq!(report.json["material"], "n = 1.544");
}

#[test]
fn a_scene_of_one_stone_is_measured_as_it_says() {
    let scene = "format = 1\n[camera]\nposition = [0, 0, 60]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n\
                 [[stone]]\nshape = \"step\"\nwidth = 6\nrotation = [0, 0, 90]\nposition = [5, 0, 0]\n\
                 material = \"emerald\"\n[render]\nwavelengths = { count = 4 }\nmax_depth = 12\n";
    let place = Workplace::with(scene);
    let report = measure(&place.name("tiny.toml"), &["--size=24", "--tilt=10"]).unwrap();
    let conditions = &report.json["conditions"];
    assert_eq!((&conditions["eye_mm"], &conditions["max_depth"]), (&60.0.into(), &12.into()));
    assert_eq!(report.json["material"], "emerald");
    place.write("tiny.toml", format!("{scene}[[stone]]\nshape = \"step\"\nmaterial = \"ruby\"\n"));
    let message = measure(&place.name("tiny.toml"), &[]).unwrap_err().to_string();
    assert_matches(&message, "*a scene of one stone can be measured; this one has 2");
}

#[test]
fn what_cannot_be_measured_is_told() {
    let place = Workplace::holding(&[("cube.obj", CUBE)]);
    let (quartz, cube) = (cut("srb_quartz_57.asc"), place.name("cube.obj"));
    for (design, option, message) in [
        (&*quartz, "-m0.5", "material: 0.5 is not valid; an index of refraction above 1"),
        (&quartz, "-mquarz", "unknown material 'quarz'; did you mean 'quartz'?"),
        (&quartz, "--head=95", "head: 95 is not valid; a half-angle in degrees, from 0"),
        (&quartz, "--eye=0.5", "eye: 0.5 is not valid; a distance in mm beyond the stone's farthest corner"),
        (&quartz, "--threshold=2", "threshold: 2 is not valid"),
        (&cube, "--size=512", "cube.obj: it names no index of refraction; give --material"),
        ("no.asc", "--size=512", "no.asc: no such file"),
    ] {
        assert_refused(measure(design, &[option]), 3, &format!("*{message}*"));
    }
    for (option, message) in [
        ("--models=iso,sc3", "invalid value 'sc3' for '--models*sc2"),
        ("--tilt=5..1", "'5..1' goes nowhere"),
        ("--about=z", "invalid value 'z' for '--about*x, y"),
    ] {
        let error = Cli::try_parse_from(["gemtrace", "measure", "a.asc", option]).unwrap_err();
        assert_matches(&error.to_string(), &format!("*{message}*"));
    }
}

/// A crystal is tilted and turned with its stone, and nothing of its light is lost.
#[test]
fn crystals_are_turned_with_their_stones() {
    let place = Workplace::new();
    let figures = |[backend, threshold]: [&str; 2], material: &str, stone: &str| {
        place.write(
            "crystal.toml",
            format!(
                "format = 1\n[camera]\nposition = [0, 0, 30]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n\
                 [[stone]]\nshape = \"round-brilliant\"\nwidth = 5\nmaterial = \"dark\"\n{stone}\n\
                 [material.dark]\n{material}\n[render]\nwavelengths = [550]\nmax_depth = 16\nthreshold = {threshold}\nsplit = 0.0\n"
            ),
        );
        let backend = format!("--backend={backend}");
        let options = [&backend, "--size=10", "--tilt=25", "--models=iso", "--head=0"];
        let report = measure(&place.name("crystal.toml"), &options).unwrap();
        let stone = &report.json["positions"][0]["stone"];
        ["iso", "leakage", "missing"].map(|key| number(&stone[key]))
    };
    let clear = "index = 1.65\nextraordinary = { index = 1.7 }";
    let [iso, leakage, missing] = figures(["cpu", "1e-5"], clear, "optic_axis = [1, 0, 0]");
    assert!((iso + leakage + missing - 1.0).abs() < 1e-4 && missing < 5e-3, "{iso} {leakage} {missing}");
    // Absorbing along one axis only: a brilliant turned by a right angle is the same stone but for its crystal.
    let dark = "index = 1.65\nextraordinary = { index = 1.7, absorption = [{ constant = 0.5 }] }";
    let exact = ["reference", "1e-3"];
    let [across, turned, along] = [
        figures(exact, dark, "optic_axis = [0, 1, 0]")[2],
        figures(exact, dark, "optic_axis = [1, 0, 0]\nrotation = [0, 0, 90]")[2],
        figures(exact, dark, "optic_axis = [1, 0, 0]")[2],
    ];
    assert!((across - turned).abs() < 1e-6 && (across - along).abs() > 3e-3, "{across} {turned} {along}");
}
