//! `sheet sizes`, `sheet axes`, `materials --sheet` and `materials --axes`.

use super::support::{Cli, SCENE, Workplace, assert_refused, command, number};
use clap::Parser as _;
use spectral_core::material::Catalogue;

#[test]
fn a_sheet_of_sizes_has_a_picture_for_each() {
    let place = Workplace::with(&SCENE.replace("diamond", "amethyst"));
    let [scene, sheet] = ["tiny.toml", "sizes.png"].map(|name| place.name(name));
    let options = ["--output", &sheet, "--sizes=2,4,8,12,16", "--backend=cpu", "--samples=1"];
    let report = command(&[&["sheet", "sizes", &scene], &options[..]].concat()).unwrap();
    assert_eq!(report.json["sizes"], serde_json::json!([2.0, 4.0, 8.0, 12.0, 16.0]));
    let png = image::open(&sheet).unwrap().into_rgb8();
    // Four in a row of 24 × 16 pixels, one line of lettering each, a margin of 8.
    assert_eq!(png.dimensions(), (4 * (24 + 8) + 8, 2 * (16 + 20 + 8) + 8));
    // The larger the stone, the less green comes through.
    let light = |column: u32| {
        let pixel = |x: u32, y: u32| u32::from(png.get_pixel(8 + column * 32 + x, 8 + y).0[1]);
        (6..10).flat_map(|y| (10..14).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).sum::<u32>()
    };
    assert!((0..3).all(|column| light(column) > light(column + 1)));
    for bad in ["--sizes=0", "--sizes=2,x"] {
        assert!(Cli::try_parse_from(["gemtrace", "sheet", "sizes", "a.toml", bad]).is_err());
    }
}

/// A crystal that is dark for light along its optic axis' electric field: seen down the axis it is clear.
#[test]
fn a_sheet_of_axes_shows_each_orientation() {
    let crystal = "\n[material.dark]\nindex = 1.6\nextraordinary = { index = 1.62, absorption = [{ constant = 2.0 }] }\n";
    let place = Workplace::with(&(SCENE.replace("diamond", "dark") + crystal));
    let [scene, sheet] = ["tiny.toml", "axes.png"].map(|name| place.name(name));
    let options = ["--output", &sheet, "--backend=reference", "--samples=1"];
    let axes = |more: &[&str]| command(&[&["sheet", "axes", &scene], &options[..], more].concat());
    let report = axes(&["--angles=0,90"]).unwrap();
    let positions = report.json["positions"].as_array().unwrap();
    let figures = |key: &str| positions.iter().map(|p| number(&p[key])).collect::<Vec<f64>>();
    assert_eq!((figures("angle"), figures("azimuth")), (vec![0.0, 90.0, 90.0], vec![0.0, 0.0, 90.0]));
    let lightness: Vec<f64> = positions.iter().map(|p| number(&p["lab"][0])).collect();
    assert!(lightness[0] > lightness[1] + 5.0, "{lightness:?}");
    let apart = figures("delta_e");
    assert!(apart[0] == 0.0 && apart[1] > 5.0 && report.text.contains("90°"), "{}", report.text);
    let png = image::open(&sheet).unwrap().into_rgb8();
    assert_eq!(png.dimensions(), (3 * (24 + 8) + 8, 16 + 2 * 20 + 8 + 8));
    assert_refused(axes(&["--axis=x"]), 3, "axis: x is not valid; a uniaxial crystal has e");
    place.write("tiny.toml", SCENE);
    assert_refused(axes(&[]), 3, "*a sheet of axes needs a crystal; 'diamond', of the first stone, has none");
}

#[test]
fn the_whole_catalogue_is_on_its_sheet() {
    let place = Workplace::new();
    let sheet = place.path("all.png");
    let option = format!("--sheet={}", sheet.display());
    let report = command(&["materials", &option, "--backend=cpu", "--samples=1", "--size=16x12"]).unwrap();
    let count = Catalogue::builtin().materials().count();
    assert_eq!(report.json["materials"], count);
    let png = image::open(&sheet).unwrap().into_rgb8();
    let columns = (1..).find(|n| n * n >= count).unwrap();
    let rows = count.div_ceil(columns);
    assert_eq!((png.width() as usize, png.height() as usize), (columns * 24 + 8, rows * 40 + 8));
}

#[test]
fn the_colours_along_the_axes_are_on_a_sheet() {
    let place = Workplace::new();
    let sheet = place.path("axes.png");
    let report = command(&["materials", &format!("--axes={}", sheet.display()), "--thickness=2"]).unwrap();
    let png = image::open(&sheet).unwrap().into_rgb8();
    // Five in a row of 160 × 80 pixels, two lines of lettering each, a margin of 8.
    assert_eq!((&report.json["materials"], png.width()), (&17.into(), 5 * 168 + 8));
    // Alexandrite is the first: along z it is green by day; along x it is red by lamplight.
    let pixel = |x: u32, y: u32| png.get_pixel(8 + x, 8 + y).0.map(i32::from);
    let [day, lamp] = [pixel(150, 10), pixel(10, 70)];
    assert!(day[1] > day[0] + 20 && lamp[0] > lamp[1] + 20, "{day:?} {lamp:?}");
}
