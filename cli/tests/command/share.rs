//! One picture by many machines.

use super::support::{BASE, Report, Workplace, assert_matches, assert_refused, command};
use gemtrace::Error;

fn render(place: &Workplace, output: &str, options: &[&str]) -> Result<Report, Error> {
    let [scene, png, exr] =
        ["base.toml", &format!("{output}.png"), &format!("{output}.exr")].map(|name| place.name(name));
    let fixed = ["render", &scene, "-o", &png, "-o", &exr, "--backend", "cpu", "--size", "23x37"];
    let samples = if options.contains(&"--samples") { &[][..] } else { &["--samples", "4"] };
    command(&[&fixed, samples, options].concat())
}

fn same(place: &Workplace, options: &[&str], count: u32) {
    let folder = format!("p{count}");
    std::fs::create_dir(place.path(&folder)).unwrap();
    render(place, "one", options).unwrap();
    for shard in 1..=count {
        let (shard, threads) = (format!("{shard}/{count}"), if shard == 1 { "2" } else { "1" });
        let own = ["--shard", &shard, "--threads", threads];
        let report = render(place, &format!("{folder}/one"), &[options, &own].concat()).unwrap();
        let path = report.json["outputs"][0]["path"].as_str().unwrap();
        assert_matches(path, &format!("*one.part-{}.exr", shard.replace('/', "-of-")));
    }
    assert!(!place.path(&folder).join("one.png").exists());
    place.merge(&folder).unwrap();
    for name in ["one.png", "one.exr"] {
        let joined = place.read(&format!("{folder}/{name}"));
        assert!(place.read(name) == joined, "{name} with {options:?} differs");
    }
}

#[test]
fn parts_join_to_the_bits_of_one_machine() {
    let place = Workplace::swept();
    same(&place, &[], 3);
    same(&place, &["--space", "acescg", "--bits", "16", "--exposure", "0.7"], 7);
}

#[test]
fn spectra_and_coverage_are_joined_too() {
    let place = Workplace::swept();
    let scene = BASE.replace("threshold", "spectral = true\nthreshold");
    place.write("base.toml", scene.replace("height = 24", "height = 24\nbackground = \"transparent\""));
    same(&place, &[], 2);
}

#[test]
fn blocks_settle_alike_whoever_renders_their_neighbours() {
    let place = Workplace::swept();
    let settling = ["--samples", "81", "--tolerance", "2"];
    same(&place, &settling, 3);
    // Some did, or this would be the test above.
    let rays = |options: &[&str]| render(&place, "one", options).unwrap().json["rays"].as_u64().unwrap();
    assert!(rays(&settling) < rays(&["--samples", "81", "--tolerance", "0"]));
}

#[test]
fn parts_that_do_not_fit_are_told() {
    let place = Workplace::swept();
    for shard in ["1/3", "3/3"] {
        render(&place, "one", &["--shard", shard]).unwrap();
    }
    let part = "one.part-1-of-3.exr";
    assert_refused(place.merge(part), 5, "*of 'one' these shards are missing: 2/3*");
    let refused = |message: &str| assert_matches(&place.merge(part).unwrap_err().to_string(), message);
    // Of another picture.
    render(&place, "one", &["--shard", "2/3", "--exposure", "1"]).unwrap();
    refused("*one.part-2-of-3.exr: this is of another picture*");
    // Cut short.
    let bytes = place.read("one.part-2-of-3.exr");
    place.write("one.part-2-of-3.exr", &bytes[..bytes.len() / 2]);
    refused("*one.part-2-of-3.exr: not a complete part of a picture*");
    // A picture of no part.
    render(&place, "two", &[]).unwrap();
    place.write("one.part-2-of-3.exr", place.read("two.exr"));
    refused("*it has no attribute 'gemtrace.part'*");
    let message = render(&place, "one", &["--shard", "3/11"]).unwrap_err().to_string();
    assert_matches(&message, "*a picture of 37 rows, 10 blocks of 4, cannot be shared out among 11*");
}
