//! Questions: a pixel, a facet, a curve, files, the command.

use crate::support::{Running, decoded};
use serde_json::{Value, json};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn a_pixel_has_a_spectrum_a_colour_and_a_way() {
    let cut: &[u8] = include_bytes!("../../../spectral-core/data/cuts/srb_quartz_57.asc");
    let view = Running::of("design.asc", &[("design.asc", cut)]);
    let mut page = view.page();
    page.picture("moving", 0);
    let id = page.ask(json!({ "type": "inspect", "side": "A", "x": 32.4, "y": 24.6 }));
    let pixel = page.wait("pixel");
    assert_eq!((&pixel["id"], &pixel["x"], &pixel["y"]), (&json!(id), &json!(32.0), &json!(24.0)));
    assert_eq!((numbers(&pixel["wavelengths"]).len(), numbers(&pixel["radiance"]).len()), (32, 32));
    assert!(pixel["colour"].as_str().unwrap().len() == 7 && numbers(&pixel["chromaticity"]).len() == 2);
    let facet = &pixel["facet"];
    assert!(facet["name"].is_string() && facet["angle"].as_f64().unwrap() <= 90.0, "{facet}");
    let events = pixel["path"]["events"].as_array().unwrap();
    assert!(events.len() >= 2 && events[0]["event"] == "in", "{events:?}");
    let left: Vec<f64> = events.iter().map(|event| event["left"].as_f64().unwrap()).collect();
    assert!(left.windows(2).all(|pair| pair[1] <= pair[0] * (1.0 + 1e-12)), "{left:?}");
    assert!(pixel["path"]["length"].as_f64().unwrap() > 1.0 && pixel["source"].is_string());
    assert_eq!(pixel["section"]["points"].as_array().unwrap().len(), events.len());
    assert!(pixel["section"]["outline"].as_array().unwrap().len() > 5);
    // Each point lies on the plane of its facet: on the hull or within.
    page.ask(json!({ "type": "hover", "side": "A", "x": 32.4, "y": 24.6 }));
    let hover = page.wait("facet");
    assert_eq!((&hover["facet"], &hover["outline"]), (&pixel["facet"], &pixel["outline"]));
    page.ask(json!({ "type": "inspect", "side": "A", "x": 0, "y": 0 }));
    let beside = page.wait("pixel");
    assert_eq!((&beside["facet"], beside["path"]["events"].as_array().unwrap().len()), (&Value::Null, 0));
    assert_eq!(beside["colour"], "#333333");
}

#[test]
fn a_facet_has_its_index_on_the_gear() {
    let cut: &[u8] = include_bytes!("../../../spectral-core/data/cuts/srb_quartz_57.asc");
    let view = Running::of("design.asc", &[("design.asc", cut)]);
    let mut page = view.page();
    page.picture("moving", 0);
    let mut indices = Vec::new();
    for k in 0..12 {
        page.ask(json!({ "type": "hover", "side": "A", "x": 12 + 4 * k, "y": 14 }));
        let found = page.wait("facet");
        if let Some(index) = found["facet"]["index"].as_f64() {
            indices.push(index);
        }
    }
    assert!(
        indices.len() > 3 && indices.iter().all(|index| (index - index.round()).abs() < 1e-9 && *index > 0.0),
        "{indices:?}"
    );
}

#[test]
fn light_return_is_measured_over_the_tilt() {
    let view = Running::new(&[]);
    let mut page = view.page();
    page.picture("settled", 0);
    let id = page.ask(json!({ "type": "curve", "side": "A" }));
    let curve = page.wait("curve");
    assert_eq!(curve["id"], id);
    let values = numbers(&curve["values"]);
    assert_eq!((values.len(), numbers(&curve["tilts"])[6]), (13, 0.0));
    assert!(values.iter().all(|v| (20.0..100.0).contains(v)), "{values:?}");
    // A round brilliant looks the same from both sides.
    assert!((values[0] - values[12]).abs() < 2.0, "{values:?}");
    // The pose does not matter.
    page.ask(json!({ "type": "pose", "rotation": [0.2, 0.1, 0, 0.974], "done": true }));
    page.wait("state");
    page.picture("settled", 2);
    page.ask(json!({ "type": "curve", "side": "A" }));
    let again = numbers(&page.wait("curve")["values"]);
    assert!(again.iter().zip(&values).all(|(a, b)| (a - b).abs() < 0.5), "{again:?}");
}

#[test]
fn pictures_and_scenes_are_saved_and_downloaded() {
    let view = Running::new(&[]);
    let mut page = view.page();
    let settled = page.picture("settled", 0);
    for (format, name) in [
        ("png", "scene.png"),
        ("exr", "scene.exr"),
        ("spectral-exr", "scene-spectral.exr"),
        ("scene", "scene.toml"),
    ] {
        page.ask(json!({ "type": "save", "format": format, "side": "A" }));
        let saved = page.wait("saved");
        assert_eq!(saved["files"], json!([view.place("views").join(name)]), "{saved}");
        assert!(view.place("views").join(name).exists());
        let bytes = view.body(&format!("/save?format={format}&side=A"));
        assert!(bytes.len() > 100, "{format}");
    }
    let png = std::fs::read(view.place("views/scene.png")).unwrap();
    assert_eq!(decoded(&png), decoded(&settled.bytes));
    assert_eq!(decoded(&view.body("/save?format=png&side=A")), decoded(&settled.bytes));
    // Nothing is overwritten.
    page.ask(json!({ "type": "save", "format": "png", "side": "A" }));
    assert!(page.wait("saved")["files"][0].as_str().unwrap().ends_with("scene-2.png"));
    page.ask(json!({ "type": "save", "format": "png", "side": "B" }));
    assert!(page.wait("saved")["error"]["why"].as_str().unwrap().contains("no side B"));
}

#[test]
fn a_picture_of_a_moment_ago_is_saved_although_the_stone_has_turned() {
    let view = Running::new(&[]);
    let mut page = view.page();
    page.wait("state");
    page.ask(json!({ "type": "save", "format": "png", "side": "A" }));
    page.ask(json!({ "type": "pose", "rotation": [0.1, 0, 0, 0.995], "done": true }));
    let saved = page.wait("saved");
    assert!(std::fs::metadata(saved["files"][0].as_str().unwrap()).unwrap().len() > 500, "{saved}");
}

#[test]
fn the_command_renders_what_is_seen() {
    let view = Running::new(&[]);
    let mut page = view.page();
    page.picture("settled", 0);
    page.ask(json!({ "type": "command", "side": "A" }));
    let text = page.wait("command")["text"].as_str().unwrap().to_owned();
    let words: Vec<&str> = text.split(' ').collect();
    assert_eq!(words[..4], ["gemtrace", "render", "--backend", "cpu"], "{text}");
    assert!(std::path::Path::new(words[4]).exists() && words[6].ends_with(".png"), "{text}");
}

#[test]
fn a_turn_is_an_animated_picture() {
    let view = Running::new(&[]);
    let mut page = view.page();
    page.picture("settled", 0);
    page.ask(json!({ "type": "save", "format": "turn", "side": "A" }));
    // It says how far it is.
    let last = page.wait_for(|message| message["type"] == "saving" && message["done"] == 35);
    assert_eq!(last["of"], 36);
    let saved = page.wait("saved");
    let bytes = std::fs::read(saved["files"][0].as_str().unwrap()).unwrap();
    assert_eq!(view.body("/saved/scene-turn.png"), bytes);
    let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    assert_eq!(reader.info().animation_control().unwrap().num_frames, 36);
}
