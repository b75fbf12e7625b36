//! `sheet sizes` and `materials --sheet`.

use super::support::{Cli, SCENE, Workplace, command};
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
