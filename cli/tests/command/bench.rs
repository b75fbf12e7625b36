//! Devices measured against each other.

use super::support::{Interrupt, Workplace, assert_refused, command, command_with, number};
use base64::Engine as _;
use gemtrace::Error;
use serde_json::Value;
use std::time::Duration;

#[test]
fn every_device_is_measured_and_the_processor_agrees_with_itself() {
    let place = Workplace::new();
    let scene = place.name("tiny.toml");
    let report = command(&["bench", &scene, "--size", "32x32", "--samples", "1", "--runs", "2"]).unwrap();
    assert_eq!(report.failure, None, "{}", report.text);
    assert_eq!((&report.json["runs"], &report.json["interrupted"]), (&2.into(), &false.into()));
    let scene = &report.json["scenes"][0];
    assert_eq!((&scene["settings"]["width"], &scene["settings"]["samples"]), (&32.into(), &1.into()));
    let devices = scene["devices"].as_array().unwrap();
    for device in devices {
        let [low, middle, high] = ["min", "median", "max"].map(|key| number(&device["seconds"][key]));
        assert!(0.0 < low && low <= middle && middle <= high, "{device}");
        assert_eq!(device["runs"].as_array().unwrap().len(), 2);
        assert!(number(&device["first_pixel_seconds"]) >= number(&device["open_seconds"]));
        assert!(number(&device["rays"]) > 1e3 && number(&device["rays_per_second"]["median"]) > 0.0);
        assert!(number(&device["speed_against_cpu"]["median"]) > 0.0);
        assert!(number(&device["energy"]["dropped"]) < 0.1);
        assert_eq!((&device["error"], &device["repeats"]), (&Value::Null, &true.into()));
        // The agreement of backends is the business of tests of its own; here, that it is told.
        assert!(number(&device["agreement"]["median"]) < 1e-4, "{device}");
        assert!(report.text.contains(device["label"].as_str().unwrap()));
    }
    let cpu = devices.iter().find(|d| d["label"] == "cpu").unwrap();
    for key in ["median", "off", "mean", "worst"] {
        assert_eq!(number(&cpu["agreement"][key]), 0.0, "{key}");
    }
    assert_eq!(cpu["speed_against_cpu"]["min"], 1.0);
    assert!(devices.iter().all(|d| d["device"]["backend"] != "reference"));
}

#[test]
fn named_backends_alone_are_measured_and_still_held_to_the_processor() {
    let arguments = ["bench", "brilliant", "--size=12x12", "--samples=1", "--runs=1", "--backend=reference"];
    let report = command(&arguments).unwrap();
    let devices = report.json["scenes"][0]["devices"].as_array().unwrap();
    assert_eq!((devices.len(), &devices[0]["label"]), (1, &"reference".into()));
    assert_eq!(devices[0]["speed_against_cpu"], Value::Null);
    let median = number(&devices[0]["agreement"]["median"]);
    assert!(median > 0.0 && median < 1e-5, "{median}");
}

/// Addresses of all pictures of a page, which must be well-formed and load nothing.
fn pictures(page: &str) -> Vec<String> {
    assert!(!page.contains("http://") && !page.contains("https://") && !page.contains("url("));
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(page, options).unwrap();
    let nodes = || document.descendants().filter(roxmltree::Node::is_element);
    for name in ["script", "link", "iframe", "object", "a"] {
        assert!(nodes().all(|n| !n.has_tag_name(name)), "{name}");
    }
    assert!(nodes().filter(|n| n.has_tag_name("svg")).count() == 2);
    nodes().filter_map(|n| n.attribute("src")).map(str::to_owned).collect()
}

#[test]
fn the_page_stands_alone_and_escapes_what_it_quotes() {
    let place = Workplace::new();
    std::fs::rename(place.path("tiny.toml"), place.path("a&b.toml")).unwrap();
    let [scene, page] = ["a&b.toml", "page.html"].map(|name| place.name(name));
    let sizes = ["--size=32x32", "--samples=1", "--runs=1", "--backend=reference", "--backend=cpu"];
    let report = command(&[&["bench", &scene, "-o", &page], &sizes[..]].concat()).unwrap();
    assert_eq!(report.json["page"]["path"], page);
    let text = place.text("page.html");
    assert_eq!(report.json["page"]["bytes"], text.len());
    assert!(text.contains("a&amp;b.toml") && !text.contains("a&b.toml"));
    // Both pictures, and the difference of the reference's.
    let pictures = pictures(&text);
    assert_eq!(pictures.len(), 3);
    for address in pictures {
        let encoded = address.strip_prefix("data:image/png;base64,").unwrap();
        let bytes = base64::engine::general_purpose::STANDARD.decode(encoded).unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        assert_eq!((reader.info().width, reader.info().height), (32, 32));
    }
    assert_eq!(place.files(), ["a&b.toml", "page.html"]);
}

#[test]
fn what_cannot_be_measured_is_refused_before_the_first_ray() {
    for (arguments, code, message) in [
        (&["--backend", "cpuu"][..], 2, "unknown backend 'cpuu'; valid: cpu, wgpu, vulkan, reference"),
        (&["briliant"], 2, "unknown scene 'briliant'; did you mean 'brilliant'?"),
        (&["missing.toml"], 3, "missing.toml: no such file"),
        (&["--output", "page.png"], 4, "the page is HTML; end the name in '.html'"),
        (&["--output", "missing/page.html"], 4, "missing does not exist; create it first"),
        (&["--samples", "0"], 3, "samples: 0 is not valid"),
    ] {
        // More work than anyone would wait for.
        let arguments = [&["bench", "--size", "4096x4096", "--runs", "1000"], arguments].concat();
        assert_refused(command(&arguments), code, &format!("*{message}*"));
    }
}

#[test]
fn the_list_shows_scenes_and_devices_and_measures_nothing() {
    let report = command(&["bench", "--list", "--runs", "1000"]).unwrap();
    let names: Vec<&Value> = report.json["scenes"].as_array().unwrap().iter().map(|s| &s["name"]).collect();
    assert_eq!(names, ["brilliant", "inclusion", "step", "torus"]);
    assert_eq!(report.json["devices"][0]["label"], "cpu");
    assert!(report.text.contains("torus") && report.text.contains("processor"));
}

#[test]
fn an_interrupted_bench_tells_what_is_complete() {
    let place = Workplace::new();
    let scene = place.name("tiny.toml");
    let interrupt = Interrupt::default();
    let arguments = ["bench", &scene, "--size=8x8", "--samples=1", "--runs=1000", "--backend=reference"];
    let report = std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_secs(1));
            interrupt.request();
        });
        command_with(&arguments, &interrupt).0.unwrap()
    });
    assert_eq!((report.failure, &report.json["interrupted"]), (Some(Error::Interrupted), &true.into()));
    let runs = report.json["scenes"][0]["devices"][0]["runs"].as_array().unwrap().len();
    assert!((1..1000).contains(&runs), "{runs}");
}
