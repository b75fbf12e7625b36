//! The commands that describe.

use super::support::{
    Cli, Interrupt, SCENE, Workplace, assert_matches, assert_refused, command, command_with, cut, number,
};
use clap::Parser as _;
use serde_json::Value;
use spectral_core::color::Response;
use spectral_core::wavelength::WavelengthGrid;

#[test]
fn diamond_has_its_published_figures() {
    let report = command(&["materials", "diamond"]).unwrap();
    let lines = report.json["lines"].as_array().unwrap();
    let line = |name: &str| lines.iter().find(|l| l["line"] == name).map(|l| number(&l["n"])).unwrap();
    // Peter 1923: n_D = 2.4173, n_G − n_B = 0.0444; V = (n_d − 1)/(n_F − n_C).
    assert!((line("D") - 2.4173).abs() < 1e-4);
    assert!((number(&report.json["dispersion_bg"]) - 0.0444).abs() < 1e-4);
    assert!((number(&report.json["abbe_number"]) - (line("d") - 1.0) / (line("F") - line("C"))).abs() < 1e-9);
    assert_eq!(report.json["colour"]["srgb"], "#ffffff");
    assert!(report.text.contains("2.41726") && report.text.contains("Peter"), "{}", report.text);
}

#[test]
fn the_list_names_every_material_and_colours_them_as_they_are() {
    let report = command(&["materials"]).unwrap();
    let all = report.json["materials"].as_array().unwrap();
    let colour = |name: &str| -> [f64; 3] {
        let material = all.iter().find(|m| m["name"] == name).unwrap();
        std::array::from_fn(|c| number(&material["colour"]["linear_srgb"][c]))
    };
    for (name, channel) in [("ruby", 0), ("emerald", 1), ("sapphire", 2), ("gold", 0)] {
        let rgb = colour(name);
        assert!((0..3).all(|c| c == channel || rgb[c] < rgb[channel]), "{name}: {rgb:?}");
    }
    assert!(all.iter().all(|m| report.text.contains(m["name"].as_str().unwrap())));
}

#[test]
fn a_misspelt_material_is_recognised() {
    let message = "unknown material 'saphire'; did you mean 'sapphire'?";
    assert_refused(command(&["materials", "saphire"]), 3, message);
}

#[test]
fn plots_are_written_where_asked() {
    let place = Workplace::new();
    // A curve for each axis of a crystal.
    let plotted = [
        (&["materials", "ruby"][..], 4),
        (&["materials", "tanzanite"], 6),
        (&["materials", "gold"], 2),
        (&["spectrum", "1", "0.5", "0.1"], 2),
    ];
    for (arguments, curves) in plotted {
        command(&[arguments, &["--svg", &place.name("a.svg")]].concat()).unwrap();
        let text = place.text("a.svg");
        assert!(text.starts_with("<svg") && text.ends_with("</svg>\n") && !text.contains("NaN"));
        assert_eq!(text.matches("<polyline").count(), curves, "{arguments:?}");
    }
    assert_refused(command(&["materials", "ruby", "--svg", &place.name("no/ruby.svg")]), 4, "*");
}

#[test]
fn a_spectrum_shows_its_colour() {
    let report = command(&["spectrum", "1", "0.5", "0.1"]).unwrap();
    let numbers = |key: &str| report.json[key].as_array().unwrap().iter().map(number).collect::<Vec<f64>>();
    let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0).unwrap();
    assert_eq!(numbers("nm"), grid.nm());
    let shown = Response::new(&grid).unwrap().to_linear_srgb(&numbers("radiance"));
    let error: f64 = shown.iter().zip([1.0, 0.5, 0.1]).map(|(a, b)| (a - b).abs()).sum();
    assert!(error <= 1e-6 && (error - number(&report.json["error"])).abs() < 1e-12);
    assert_eq!(report.json["converged"], true);
    assert!(numbers("radiance").iter().all(|v| *v >= 0.0));
    let coarse = command(&["spectrum", "1", "0.5", "0.1", "--tolerance", "0.004"]).unwrap();
    assert!(number(&coarse.json["sweeps"]) < number(&report.json["sweeps"]));
    assert!(number(&coarse.json["error"]) <= 0.004);
}

#[test]
fn many_colours_come_from_a_file() {
    let place = Workplace::new();
    let list = place.name("colours.txt");
    place.write("colours.txt", "# three\n1 0.5 0.1\n0.2, 0.3, 0.4\n\n0 0 1\n");
    let report = command(&["spectrum", "--list", &list]).unwrap();
    let colours = report.json["colours"].as_array().unwrap();
    let alone = command(&["spectrum", "1", "0.5", "0.1"]).unwrap();
    assert_eq!((colours.len(), &colours[0]["radiance"]), (3, &alone.json["radiance"]));
    assert_eq!(colours[1]["rgb"], serde_json::json!([0.2, 0.3, 0.4]));
    for (text, line) in [("1 1 1\n0.5 0.5\n", 2), ("1 1 1\n# x\n1 red 1\n", 3), ("-1 0 0\n", 1)] {
        place.write("colours.txt", text);
        assert_refused(command(&["spectrum", "--list", &list]), 3, &format!("*line {line}*"));
    }
}

#[test]
fn a_material_has_its_figures_at_any_wavelength() {
    let report = command(&["materials", "ruby", "--nm", "450,560.5"]).unwrap();
    let lines = report.json["lines"].as_array().unwrap();
    let ruby = spectral_core::material::Catalogue::builtin().get("ruby").unwrap();
    for (line, nm) in lines.iter().zip([450.0, 560.5]) {
        assert_eq!((number(&line["nm"]), number(&line["n"])), (nm, ruby.index(nm)));
        assert_eq!(number(&line["absorption_per_mm"]), ruby.absorption(nm));
    }
    assert!(lines.len() == 2 && report.text.contains("560.50"), "{}", report.text);
    assert_refused(command(&["materials", "ruby", "--nm", "560,450"]), 3, "*");
}

/// Tanzanite by its handbook figures: n 1.692, 1.693, 1.700, biaxial positive; violet, blue, and blue again.
#[test]
fn a_crystal_is_described_along_its_axes() {
    let report = command(&["materials", "tanzanite", "--nm", "589.3", "--thickness=3"]).unwrap();
    let crystal = &report.json["crystal"];
    assert_eq!((&crystal["form"], &crystal["sign"]), (&"biaxial".into(), &"+".into()));
    assert!((number(&crystal["birefringence"]) - 0.008).abs() < 1e-5);
    assert!((number(&crystal["two_v_deg"]) - 41.6).abs() < 0.1);
    let axes = crystal["axes"].as_array().unwrap();
    for (axis, (name, n)) in axes.iter().zip([("x", 1.692), ("y", 1.693), ("z", 1.700)]) {
        assert_eq!(axis["axis"], name);
        assert!((number(&axis["lines"][0]["n"]) - n).abs() < 1e-5);
    }
    let views = crystal["dichroscope"]["views"].as_array().unwrap();
    assert_eq!((views.len(), number(&crystal["dichroscope"]["thickness_mm"])), (3, 3.0));
    // Along y one window shows x, violet, the other z, blue.
    let windows = &views[1]["windows"];
    assert_eq!((&windows[0]["axis"], &windows[1]["axis"]), (&"x".into(), &"z".into()));
    let red_over_green = |window: &Value| {
        let [red, green] = [0, 1].map(|c| number(&window["d65"]["linear_srgb"][c]));
        red / green
    };
    assert!(red_over_green(&windows[0]) > 1.4 && red_over_green(&windows[1]) < 0.9);
    for part in ["biaxial +, birefringence 0.0080, 2V 42°", "along y", "1.69300", "dichroscope, 3 mm"] {
        assert!(report.text.contains(part), "{part}: {}", report.text);
    }

    let ruby = command(&["materials", "ruby"]).unwrap();
    let views = ruby.json["crystal"]["dichroscope"]["views"].as_array().unwrap();
    let axes = views.iter().flat_map(|view| view["windows"].as_array().unwrap()).map(|w| &w["axis"]);
    assert_eq!(axes.collect::<Vec<_>>(), ["o", "o", "o", "e"]);
    assert!(
        ruby.text.contains("uniaxial −, birefringence 0.0081") && ruby.text.contains("along the optic axis")
    );
    let quartz = command(&["materials", "quartz"]).unwrap();
    assert!(quartz.text.contains("uniaxial +") && !quartz.text.contains("dichroscope"), "{}", quartz.text);
    assert_eq!(command(&["materials", "diamond"]).unwrap().json["crystal"], Value::Null);
    assert!(Cli::try_parse_from(["gemtrace", "materials", "ruby", "--thickness=0"]).is_err());
}

#[test]
fn check_states_the_optics_of_every_axis() {
    let crystal = "material = \"peridot\"\ncrystal_axes = [[0, 0, 1], [1, 0, 0]]";
    let place = Workplace::with(&SCENE.replace("material = \"diamond\"", crystal));
    let report = command(&["check", &place.name("tiny.toml")]).unwrap();
    let peridot = spectral_core::material::Catalogue::builtin().get("peridot").unwrap();
    let nm = number(&report.json["settings"]["wavelengths"][2]);
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        let axis = &report.json["stones"][0]["axes"][k];
        assert_eq!((axis["axis"].as_str(), number(&axis["n"][2])), (Some(name), peridot.indices(nm)[k]));
        assert_eq!(number(&axis["absorption_per_mm"][2]), peridot.absorptions(nm)[k]);
    }
    assert!(report.text.contains("peridot (at 589.3 nm x 1.6540, "), "{}", report.text);
    let warnings = report.json["warnings"].to_string();
    assert!(!warnings.contains("axes"), "{warnings}");
}

#[test]
fn a_cut_leaves_its_mesh() {
    let place = Workplace::new();
    let mesh = place.name("step.obj");
    let design = command(&["cut", &cut("emerald_step_49.asc"), "--mesh", &mesh]).unwrap();
    let found = command(&["cut", &mesh]).unwrap();
    for key in ["facets", "triangles", "volume", "width"] {
        let (a, b) = (number(&design.json["solid"][key]), number(&found.json["solid"][key]));
        assert!((a - b).abs() < 1e-12, "{key}: {a} and {b}");
    }
    assert_refused(command(&["cut", &mesh, "--mesh", &place.name("no/x.obj")]), 4, "*");
}

#[test]
fn a_colour_that_no_light_has_is_refused() {
    assert_refused(command(&["spectrum", "-1", "-0.5", "-2"]), 3, "*");
    assert!(command(&["spectrum", "nan", "0", "0"]).is_err());
    assert_eq!(command(&["spectrum", "0", "0", "0"]).unwrap().json["sweeps"], 0);
}

#[test]
fn the_sample_brilliant_has_the_proportions_in_its_title() {
    for format in ["asc", "gem", "gcs"] {
        let report = command(&["cut", &cut(&format!("srb_diamond_57.{format}"))]).unwrap();
        let solid = &report.json["solid"];
        assert_eq!((&report.json["closed"], &solid["convex"]), (&Value::Bool(true), &Value::Bool(true)));
        assert_eq!(report.json["facets"], 73);
        let figures = ["table_percent", "crown_angle", "pavilion_angle", "girdle_percent"];
        for (key, wanted) in figures.into_iter().zip([57.0, 34.5, 40.75, 3.0]) {
            assert!((number(&solid[key]) - wanted).abs() < 1e-2, "{format}: {key} {}", solid[key]);
        }
        let tiers = report.json["tiers"].as_array().unwrap();
        let mut counts: Vec<u64> = tiers.iter().map(|t| t["facets"].as_u64().unwrap()).collect();
        counts.sort_unstable();
        assert_eq!(counts, [1, 8, 8, 8, 16, 16, 16], "{format}");
    }
}

#[test]
fn a_cut_that_does_not_close_is_still_described() {
    let place = Workplace::new();
    let text = std::fs::read_to_string(cut("srb_diamond_57.asc")).unwrap();
    let open: String = text.lines().filter(|l| !l.starts_with("a -")).map(|l| format!("{l}\n")).collect();
    place.write("open.asc", open);
    let report = command(&["cut", &place.name("open.asc")]).unwrap();
    assert_eq!(report.json["closed"], false);
    let failure = report.failure.unwrap();
    assert_eq!(failure.exit_code(), 3);
    assert_matches(&failure.to_string(), "*open.asc*does not close*");
    assert!(report.text.contains("34.50°"), "{}", report.text);
}

#[test]
fn meshes_are_measured_too() {
    let place = Workplace::new();
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    place.write("t.obj", tetrahedron);
    let report = command(&["cut", &place.name("t.obj")]).unwrap();
    assert_eq!(report.json["closed"], true);
    assert_eq!(report.json["solid"]["facets"], 4);
    assert!((number(&report.json["solid"]["volume"]) - 1.0 / 6.0).abs() < 1e-12);
}

#[test]
fn check_describes_a_scene_and_refuses_a_bad_one() {
    let place = Workplace::new();
    let scene = place.name("tiny.toml");
    let report = command(&["check", &scene]).unwrap();
    assert_eq!(report.json["settings"]["width"], 24);
    let stone = &report.json["stones"][0];
    assert_eq!(stone["material"], "diamond");
    let nm = number(&report.json["settings"]["wavelengths"][2]);
    let diamond = spectral_core::material::Catalogue::builtin().get("diamond").unwrap();
    assert_eq!((number(&stone["n"][2]), number(&stone["absorption_per_mm"][2])), (diamond.index(nm), 0.0));
    assert_eq!(report.json["film_bytes"], 24 * 16 * 32);
    assert!(report.text.starts_with("24 × 16 pixels, 4 samples each, 8 wavelengths from 380 to 740 nm"));
    place.write("tiny.toml", "format = 1\n[film]\nwidht = 3\n");
    assert_refused(command(&["check", &scene]), 3, "*");
}

#[test]
fn backends_are_listed_and_warnings_go_to_the_log() {
    let report = command(&["devices"]).unwrap();
    let names: Vec<&Value> =
        report.json["backends"].as_array().unwrap().iter().map(|b| &b["backend"]).collect();
    for title in ["backend", "device", "name", "driver", "memory", "kind", "intersection"] {
        assert!(report.text.lines().next().is_some_and(|line| line.contains(title)), "{}", report.text);
    }
    assert!(report.text.lines().all(|line| !line.contains("llvmpipe") || line.contains("software")));
    // Between them stand as many GPU devices as the machine happens to have.
    assert_eq!((names[0], names[names.len() - 1]), (&Value::from("cpu"), &Value::from("reference")));
    let place = Workplace::with(&SCENE.replace("width = 6.5\n", ""));
    let scene = place.name("tiny.toml");
    let (result, log) = command_with(&["check", &scene], &Interrupt::default());
    assert!(log.starts_with("warning: ") && log.lines().count() == 1, "{log}");
    assert_eq!(result.unwrap().json["warnings"].as_array().unwrap().len(), 1);
    assert_eq!(command_with(&["check", &scene, "--quiet"], &Interrupt::default()).1, "");
}

/// Whoever reads `--json` finds each of its keys in docs/json.md.
#[test]
fn every_key_of_json_is_documented() {
    fn undocumented(value: &Value, page: &str, found: &mut Vec<String>) {
        match value {
            Value::Object(entries) => entries.iter().for_each(|(key, value)| {
                found.extend((!page.contains(&format!("`{key}`"))).then(|| key.clone()));
                // The axes of a sweep have the names that the sweep gives them.
                if key != "values" {
                    undocumented(value, page, found);
                }
            }),
            Value::Array(list) => list.iter().for_each(|value| undocumented(value, page, found)),
            _ => (),
        }
    }
    let page = include_str!("../../../docs/json.md");
    let place = Workplace::swept();
    place.write("tiny.toml", SCENE);
    let [scene, sweep, output, png, svg] =
        ["tiny.toml", "sweep.toml", "batch", "a.png", "a.svg"].map(|name| place.name(name));
    let design = cut("srb_quartz_57.asc");
    let small = ["--backend", "cpu", "--size", "4x4"];
    let mut found = Vec::new();
    for (arguments, options) in [
        (&["render", &scene, "-o", &png][..], &small[..]),
        (&["batch", &sweep, "-o", &output], &small),
        (&["batch", &sweep, "--list"], &[]),
        (&["batch", &sweep, "--show", "step-ruby-side"], &[]),
        (&["merge", &output], &[]),
        (&["tilt", &scene, "--frames", "2", "-o", &output], &small),
        (&["sheet", "sizes", &scene, "-o", &png], &small),
        (&["materials"], &[]),
        (&["materials", "gold"], &[]),
        (&["materials", "--sheet", &png], &["--backend", "cpu", "--size", "8x8", "--quality", "draft"]),
        (&["spectrum", "0.1", "0.2", "0.3", "--svg", &svg], &[]),
        (&["cut", &design], &[]),
        (&["check", &scene], &[]),
        (&["devices"], &[]),
        (&["measure", &design, "--size", "9", "--experimental", "--models", "iso,cos,sc2"], &[]),
        (&["bench", &scene, "--runs", "1"], &small),
        (&["bench", "--list"], &[]),
        (&["completions", "bash"], &[]),
        (&["man"], &[]),
    ] {
        let report = command(&[arguments, options].concat()).unwrap_or_else(|e| panic!("{arguments:?}: {e}"));
        undocumented(&report.json, page, &mut found);
    }
    assert!(found.is_empty(), "docs/json.md lacks {found:?}");
}
