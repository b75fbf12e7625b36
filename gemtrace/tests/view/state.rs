//! Changes, undo, two sides, two windows, and pictures that are those of `gemtrace render`.

use crate::support::{Running, SCENE, decoded, rendered};
use serde_json::{Value, json};

/// The settled picture is what the saved scene renders, pixel for pixel, and so does the command. Returns the scene's text.
fn settles_as_rendered(view: &Running, page: &mut crate::support::Page, answers: u64, what: &str) -> String {
    let settled = page.picture("settled", answers);
    assert_eq!(settled.header["format"], "png", "{what}");
    page.ask(json!({ "type": "save", "format": "scene", "side": "A" }));
    let saved = page.wait("saved");
    let path = saved["files"][0].as_str().unwrap_or_else(|| panic!("{what}: {saved}")).to_owned();
    assert!(path.starts_with(view.place("views").to_str().unwrap()), "{path}");
    page.ask(json!({ "type": "command", "side": "A" }));
    let command = page.wait("command")["text"].as_str().unwrap().to_owned();
    assert!(command.starts_with(&format!("gemtrace render --backend cpu {path} -o ")), "{command}");
    let (size, pixels) = decoded(&settled.bytes);
    let (expected_size, expected) = decoded(&rendered(path.as_ref()));
    assert_eq!(size, expected_size, "{what}");
    assert!(pixels == expected, "{what}: the pixels differ");
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn the_settled_picture_is_that_of_render() {
    let hall: &[u8] = include_bytes!("../../../scenes/environments/hall.exr");
    let view = Running::new(&[("lights/hall.exr", hall)]);
    let mut page = view.page();
    settles_as_rendered(&view, &mut page, 0, "as opened");
    let turn = |page: &mut crate::support::Page| {
        page.ask(json!({ "type": "pose", "rotation": [0.2, -0.1, 0.3, 0.927], "done": true }))
    };
    type Change<'a> = (&'a str, &'a dyn Fn(&mut crate::support::Page) -> u64);
    let changes: [Change; 17] = [
        ("a pose", &turn),
        ("a material", &|page| page.set("material", json!("ruby"))),
        ("a light", &|page| page.set("light", json!("file:lights/hall.exr"))),
        ("its rotation", &|page| page.ask(json!({ "type": "lights", "rotation": 40, "done": true }))),
        ("its strength", &|page| page.set("strength", json!(0.5))),
        ("an exposure", &|page| page.set("exposure", json!(-0.7))),
        ("a tone", &|page| page.set("tone", json!("neutral"))),
        ("a background", &|page| page.set("background", json!("#777777"))),
        ("a size", &|page| page.set("size", json!(3.25))),
        ("a distance", &|page| page.ask(json!({ "type": "distance", "factor": 1.2, "done": true }))),
        ("a cut", &|page| page.set("cut", json!("step"))),
        ("an axis", &|page| page.set("axis", json!("x"))),
        ("a mirror", &|page| page.set("ground", json!("mirror"))),
        ("a matt ground", &|page| page.set("ground", json!("matt"))),
        ("a light model", &|page| page.set("light", json!("aset"))),
        ("a transparent background", &|page| page.set("background", json!("transparent"))),
        ("the environment behind", &|page| page.set("background", json!("environment"))),
    ];
    for (what, change) in changes {
        let answers = change(&mut page);
        settles_as_rendered(&view, &mut page, answers, what);
    }
    page.say(json!({ "type": "size", "width": 40, "height": 56 }));
    page.wait("state");
    page.wait_for(|message| message["type"] == "status" && message["stage"] == "settled");
}

#[test]
fn scenes_of_all_kinds_settle_as_rendered() {
    let stone = |keys: &str| format!("[[stone]]\nshape = \"step\"\nwidth = 4.0\n{keys}\n");
    let besides = |text: &str| format!("{SCENE}{text}");
    // Light that goes on between two stones has many ways.
    let draft = |text: &str| besides(text).replace("samples = 9", "quality = \"draft\"");
    let second = stone("material = \"ruby\"\nposition = [5, 0, 0]");
    for (what, text) in [
        ("areas", SCENE.replace("samples = 9", "quality = \"normal\"\nthreshold = 0.05")),
        ("areas by name", SCENE.replace("samples = 9", "samples = 5\ncoverage = \"area\"\nthreshold = 0.05")),
        ("points that settle", SCENE.replace("samples = 9", "samples = 81\ntolerance = 2.0")),
        (
            "a crystal on its side",
            SCENE.replace("\"diamond\"", "\"peridot\"\ncrystal_axes = [[0, 1, 0], [0, 0, 1]]"),
        ),
        ("two stones", draft(&second)),
        ("a stone in another", draft(&stone("material = \"fused-silica\"\nposition = [0, 0, 0.1]"))),
        (
            "a lamp",
            besides(
                "[environment]\nmodel = \"spots\"\nrotation = 30\nscale = 1.5\n[film]\nexposure = -0.5\n",
            ),
        ),
        ("a parallel view", SCENE.replace("[render]", "orthographic = 9.0\n[render]")),
        ("wavelengths of a list", SCENE.replace("samples = 9", "samples = 9\nwavelengths = [450, 550, 650]")),
    ] {
        let view = Running::of("own.toml", &[("own.toml", text.as_bytes())]);
        let mut page = view.page();
        settles_as_rendered(&view, &mut page, 0, what);
        let id = page.ask(json!({ "type": "pose", "rotation": [0.2, -0.1, 0.3, 0.927], "done": true }));
        settles_as_rendered(&view, &mut page, id, what);
        if what == "areas" {
            // Samples and what is left are those of areas, whose error falls faster.
            page.ask(json!({ "type": "set", "path": "exposure", "value": 0.1, "side": "A", "done": true }));
            let status =
                page.wait_for(|message| message["type"] == "status" && message["stage"] == "settled");
            assert_eq!(status["of"], 27, "{status}");
            assert!((status["tolerance"].as_f64().unwrap() - 4.5 / 8.0).abs() < 1e-9, "{status}");
        }
    }
}

#[test]
fn what_is_seen_is_asked_about_while_the_picture_is_refined() {
    let slow = SCENE.replace("samples = 9", "samples = 59049");
    let view = Running::of("slow.toml", &[("slow.toml", slow.as_bytes())]);
    let mut page = view.page();
    page.picture("refining", 0);
    page.ask(json!({ "type": "hover", "side": "A", "x": 30, "y": 20 }));
    let before = page.wait("facet");
    // The pavilion is turned to the eye.
    let id = page.ask(json!({ "type": "pose", "rotation": [1.0, 0, 0, 0.0], "done": true }));
    page.picture("refining", id);
    page.ask(json!({ "type": "hover", "side": "A", "x": 30, "y": 20 }));
    let after = page.wait("facet");
    assert_ne!(before["facet"]["part"], "pavilion", "{before}");
    assert_eq!(after["facet"]["part"], "pavilion", "{after}");
}

#[test]
fn a_cut_alone_gets_a_scene_around_it() {
    let cut: &[u8] = include_bytes!("../../../spectral-core/data/cuts/srb_quartz_57.asc");
    let view = Running::of("design.asc", &[("design.asc", cut)]);
    let mut page = view.page();
    let state = page.wait("state");
    let side = &state["sides"]["A"];
    assert!(
        (side["n"].as_f64().unwrap() - 1.54).abs() < 0.02 && side["facets"].as_u64().unwrap() > 50,
        "{side}"
    );
    assert_eq!((&side["background"], &side["light"]), (&json!("#333333"), &json!("studio")));
    assert!(side["tiers"].as_array().unwrap().len() > 5 && side["edges"].as_array().unwrap().len() > 100);
    page.set("quality", json!("draft"));
    settles_as_rendered(&view, &mut page, 1, "a cut");
}

#[test]
fn every_change_can_be_undone() {
    let view = Running::new(&[]);
    let mut page = view.page();
    let first = page.wait("state");
    assert_eq!((&first["undo"], &first["redo"]), (&Value::Null, &Value::Null));
    for k in 0..4 {
        let a = 0.1 * f64::from(k);
        page.ask(json!({ "type": "pose", "rotation": [a.sin(), 0, 0, a.cos()], "done": k == 3 }));
    }
    let turned = page.wait("state");
    assert_eq!(turned["undo"], "turn");
    page.set("material", json!("emerald"));
    let emerald = page.wait("state");
    assert_eq!(
        (&emerald["undo"], &emerald["sides"]["A"]["material"]),
        (&json!("material Emerald"), &json!("emerald"))
    );
    let mut steps = Vec::new();
    for step in ["undo", "undo", "undo", "redo", "redo", "redo"] {
        page.ask(json!({ "type": step }));
        let state = page.wait("state");
        steps.push((
            state["sides"]["A"]["material"].clone(),
            state["sides"]["A"]["pose"] == turned["sides"]["A"]["pose"],
        ));
    }
    let of = |material: &str, turned: bool| (json!(material), turned);
    let (plain, posed, green) = (of("diamond", false), of("diamond", true), of("emerald", true));
    assert_eq!(steps, [posed.clone(), plain.clone(), plain, posed, green.clone(), green]);
}

#[test]
fn a_value_that_cannot_be_rendered_returns_to_the_old_one() {
    let obj: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let view = Running::new(&[("open.obj", obj)]);
    let mut page = view.page();
    let before = page.wait("state");
    page.set("cut", json!("file:open.obj"));
    let error = page.wait("error");
    assert_eq!((&error["path"], &error["code"]), (&json!("cut"), &json!("scene")), "{error}");
    assert_eq!(page.wait("state")["sides"], before["sides"]);
    let (status, text) = view.drop_file("broken.asc", "A", b"GemCad 5.0\nnonsense");
    assert!(status == 422 && text.contains("broken.asc") && text.contains("unchanged"), "{text}");
}

#[test]
fn a_dropped_cut_and_a_dropped_scene_are_shown() {
    let gem: &[u8] = include_bytes!("../../../scenes/cuts/step.gem");
    let view = Running::new(&[]);
    let mut page = view.page();
    page.picture("settled", 0);
    assert_eq!(view.drop_file("mine.gem", "A", gem).0, 200);
    let state = page.wait_for(|message| message["type"] == "state" && message["undo"] == "open mine.gem");
    assert_eq!(state["sides"]["A"]["name"], "mine.gem");
    let text = settles_as_rendered(&view, &mut page, 0, "a dropped cut");
    assert!(text.contains("cut = \"mine.gem\""), "{text}");
    assert_eq!(std::fs::read(view.place("views/mine.gem")).unwrap(), gem);
    let scene = SCENE.replace("diamond", "spinel");
    assert_eq!(view.drop_file("other.toml", "open", scene.as_bytes()).0, 200);
    let state = page.wait_for(|message| message["type"] == "state" && message["undo"] == "open other.toml");
    assert_eq!(state["sides"]["A"]["material"], "spinel");
    let (status, text) = view.drop_file("bad.toml", "open", scene.replace("width", "widht").as_bytes());
    assert!(status == 422 && text.contains("line 9") && text.contains("did you mean"), "{text}");
}

#[test]
fn two_stones_turn_together() {
    let view = Running::new(&[]);
    let mut page = view.page();
    page.ask(json!({ "type": "compare", "on": true }));
    let state = page.wait_for(|message| message["type"] == "state" && message["compare"] == true);
    assert_eq!(state["sides"]["A"]["material"], state["sides"]["B"]["material"]);
    page.say(json!({ "type": "set", "path": "material", "value": "ruby", "side": "B", "done": true }));
    page.wait("state");
    page.ask(json!({ "type": "pose", "rotation": [0.1, 0, 0, 0.995], "done": true }));
    let state = page.wait_for(|message| message["type"] == "state" && message["undo"] == "turn");
    assert_eq!(state["sides"]["A"]["pose"], state["sides"]["B"]["pose"]);
    page.ask(json!({ "type": "compare", "swap": true }));
    let state =
        page.wait_for(|message| message["type"] == "state" && message["sides"]["A"]["material"] == "ruby");
    assert_eq!(state["sides"]["B"]["material"], "diamond");
    page.ask(json!({ "type": "compare", "on": false }));
    assert_eq!(
        page.wait_for(|message| message["type"] == "state" && message["compare"] == false)["sides"]["B"],
        Value::Null
    );
}

#[test]
fn windows_share_the_session_and_none_ends_it() {
    let view = Running::new(&[]);
    let (mut first, mut second) = (view.page(), view.page());
    second.wait("state");
    let answers = first.set("material", json!("topaz"));
    let seen = second.wait_for(|message| message["type"] == "state" && message["undo"].is_string());
    assert_eq!(seen["sides"]["A"]["material"], "topaz");
    first.picture("settled", answers);
    second.picture("settled", answers);
    drop((first, second));
    // A reload comes back to the same state and to the finished picture.
    let mut third = view.page();
    assert_eq!(third.wait("hello")["protocol"], 1);
    assert_eq!(third.wait("state")["sides"]["A"]["material"], "topaz");
    third.picture("settled", answers);
}

#[test]
fn pictures_are_dropped_and_never_queued() {
    let view = Running::new(&[]);
    let mut page = view.page();
    page.picture("settled", 0);
    // It asks for a hundred poses and takes none of their pictures meanwhile.
    let mut last = 0;
    for k in 0..100 {
        let a = 0.01 * f64::from(k);
        last = page.ask(json!({ "type": "pose", "rotation": [a.sin(), 0, 0, a.cos()], "done": k == 99 }));
        std::thread::sleep(std::time::Duration::from_millis(4));
    }
    let mut pictures = 0;
    loop {
        if let crate::support::News::Picture(picture) = page.next() {
            pictures += 1;
            if picture.header["answers"] == last && picture.header["stage"] == "settled" {
                break;
            }
        }
    }
    assert!(pictures <= 12, "{pictures}");
}
