//! One picture by many machines.

use super::support::{BASE, Workplace, command};
use gemtrace::Error;
use gemtrace_cli::console::Report;

fn render(place: &Workplace, output: &str, options: &[&str]) -> Result<Report, Error> {
    let path = |name: String| place.path(&name).display().to_string();
    let (scene, png, exr) =
        (path("base.toml".into()), path(format!("{output}.png")), path(format!("{output}.exr")));
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
        let report = render(
            place,
            &format!("{folder}/one"),
            &[options, &["--shard", &shard, "--threads", threads]].concat(),
        )
        .unwrap();
        let path = report.json["outputs"][0]["path"].as_str().unwrap().to_owned();
        assert!(path.ends_with(&format!("one.part-{}.exr", shard.replace('/', "-of-"))), "{path}");
    }
    let message = |name: &str| format!("{name} with {options:?} differs");
    assert!(!place.path(&folder).join("one.png").exists());
    place.merge(&[&folder]).unwrap();
    for name in ["one.png", "one.exr"] {
        let [whole, joined] = [name.to_owned(), format!("{folder}/{name}")]
            .map(|name| std::fs::read(place.path(&name)).unwrap());
        assert!(whole == joined, "{}", message(name));
    }
}

#[test]
fn parts_join_to_the_bits_of_one_machine() {
    let place = Workplace::new();
    same(&place, &[], 3);
    same(&place, &["--space", "acescg", "--bits", "16", "--exposure", "0.7"], 7);
}

#[test]
fn spectra_and_coverage_are_joined_too() {
    let place = Workplace::new();
    let scene = BASE.replace("threshold", "spectral = true\nthreshold");
    place.write("base.toml", &scene.replace("height = 24", "height = 24\nbackground = \"transparent\""));
    same(&place, &[], 2);
}

#[test]
fn blocks_settle_alike_whoever_renders_their_neighbours() {
    let place = Workplace::new();
    let settling = ["--samples", "81", "--tolerance", "2"];
    same(&place, &settling, 3);
    // Some did, or this would be the test above.
    let rays = |options: &[&str]| render(&place, "one", options).unwrap().json["rays"].as_u64().unwrap();
    assert!(rays(&settling) < rays(&["--samples", "81", "--tolerance", "0"]));
}

#[test]
fn parts_that_do_not_fit_are_told() {
    let place = Workplace::new();
    for shard in ["1/3", "3/3"] {
        render(&place, "one", &["--shard", shard]).unwrap();
    }
    let part = "one.part-1-of-3.exr";
    let error = place.merge(&[part]).unwrap_err();
    let message = error.to_string();
    assert!(
        error.exit_code() == 5 && message.contains("of 'one' these shards are missing: 2/3"),
        "{message}"
    );
    // Of another picture.
    render(&place, "one", &["--shard", "2/3", "--exposure", "1"]).unwrap();
    let message = place.merge(&[part]).unwrap_err().to_string();
    assert!(message.contains("one.part-2-of-3.exr: this is of another picture"), "{message}");
    // Cut short.
    let path = place.path("one.part-2-of-3.exr");
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let message = place.merge(&[part]).unwrap_err().to_string();
    assert!(message.contains("one.part-2-of-3.exr: not a complete part of a picture"), "{message}");
    // A picture of no part.
    render(&place, "two", &[]).unwrap();
    std::fs::copy(place.path("two.exr"), &path).unwrap();
    let message = place.merge(&[part]).unwrap_err().to_string();
    assert!(message.contains("it has no attribute 'gemtrace.part'"), "{message}");
    let message = render(&place, "one", &["--shard", "3/11"]).unwrap_err().to_string();
    assert!(
        message.contains("a picture of 37 rows, 10 blocks of 4, cannot be shared out among 11"),
        "{message}"
    );
}
