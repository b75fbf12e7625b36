//! What sweep files say.

use super::messages::cases;
use super::support::{SWEEP, Workplace, assert_matches, command};
use gemtrace::batch::{Plan, sweep};

fn plan(text: &str) -> Result<Plan, gemtrace::Error> {
    let base = "\n[base]\nformat = 1\ncamera = { position = [0, -20, 20], look_at = [0, 0, 0] }\n\
                stone = [{ shape = \"step\", material = \"diamond\" }]\n";
    sweep::parse(&format!("format = 1\n{text}{base}"), "s.toml".as_ref(), ".".as_ref())
}

fn names(text: &str) -> Vec<String> {
    plan(text).unwrap().items().iter().map(|item| item.name.clone()).collect()
}

#[test]
fn names_come_from_a_template_or_from_the_choices() {
    let axes = "materials = [\"diamond\", \"ruby\"]\nsizes = [2, 6.5]\n";
    assert_eq!(names(axes), ["diamond-2", "diamond-6.5", "ruby-2", "ruby-6.5"]);
    let template = "name = \"{material}/{number:2}-{size}mm\"\n";
    assert_eq!(
        names(&format!("{axes}{template}")),
        ["diamond/01-2mm", "diamond/02-6.5mm", "ruby/03-2mm", "ruby/04-6.5mm"]
    );
    assert_eq!(
        names(
            "lights = [\"studio\", \"sky/hall.exr\", { uniform = [1, 1, 1] }, { name = \"a b\", rotation = 9 }, \"iso\"]\n"
        ),
        ["studio", "hall", "light-3", "a-b", "iso"]
    );
    assert_eq!(names("views = [{ azimuth = 30 }, { position = [0, 0, 9] }]\n"), ["az30-el90", "view-2"]);
    assert_eq!(
        names("cuts = [\"a.asc\", \"b.stl\", { shape = { name = \"step\" }, rotation = [0, 0, 9] }]\n"),
        ["a", "b", "step"]
    );
}

#[test]
fn any_list_will_do() {
    let text = r#"
        materials = ["ruby", { name = "ink", like = "quartz" }]
        views = [{ name = "top", elevation = 90 }]
        item = [
            { name = "hero", material = "ink", size = 8, view = "top", set = { film = { width = 64 } } },
            { material = "emerald", cut = "b.asc" },
        ]
    "#;
    let plan = plan(text).unwrap();
    let [hero, other] = plan.items() else { panic!("two items") };
    assert_eq!((hero.name.as_str(), other.name.as_str()), ("hero", "b-emerald"));
    assert_eq!(hero.scene["film"]["width"].as_integer(), Some(64));
    assert_eq!(hero.scene["material"]["ink"]["like"].as_str(), Some("quartz"));
    assert_eq!(hero.scene["stone"][0]["width"].as_float(), Some(8.0));
    assert_eq!(other.scene["stone"][0]["cut"].as_str(), Some("b.asc"));
    assert!(other.scene["stone"][0].get("shape").is_none());
}

#[test]
fn slips_have_a_line() {
    for (text, message) in cases(include_str!("../data/refused-sweeps.txt")) {
        assert_matches(&plan(&text).unwrap_err().to_string(), message);
    }
    let place = Workplace::swept_by("format = 1\nbase = \"bsae.toml\"\nsizes = [1]");
    let message = place.batch("out", &[]).unwrap_err().to_string();
    assert_matches(&message, "*sweep.toml, line 2: *did you mean 'base.toml'?*");
}

#[test]
fn a_sweep_can_be_looked_at_before() {
    let place = Workplace::swept();
    let report = place.batch("out", &["--list"]).unwrap();
    assert_eq!(report.json["items"].as_array().unwrap().len(), 12);
    assert!(report.text.lines().last().unwrap().ends_with("step-quartz-side"));
    // The scene that is shown is a scene file, which renders to the same pixels.
    let report = place.batch("out", &["--show", "step-ruby-side"]).unwrap();
    place.write("alone.toml", &report.text);
    let message = place.batch("out", &["--show", "step-ruby-sied"]).unwrap_err().to_string();
    assert_matches(&message, "*did you mean 'step-ruby-side'?*");
    assert!(!place.path("out").exists());
    place.batch("out", &[]).unwrap();
    let [scene, png, other] =
        ["alone.toml", "alone.png", "out/step-ruby-side.png"].map(|name| place.name(name));
    command(&["render", &scene, "-o", &png, "--backend", "cpu"]).unwrap();
    let [alone, batch] = [png, other].map(|path| image::open(path).unwrap());
    assert_eq!(alone.to_rgba8(), batch.to_rgba8());
}

#[test]
fn options_hold_for_all_pictures() {
    let sweep = format!("{}\nfiles = [\"png\", \"exr\"]\nbits = 16\nexposure = 1.0", SWEEP);
    let place = Workplace::swept_by(&sweep);
    place.batch("out", &["--size", "6x4", "--samples", "1"]).unwrap();
    assert_eq!(place.pictures("out").len(), 24);
    let png = image::open(place.path("out/step-ruby-top.png")).unwrap();
    assert_eq!((png.width(), png.height(), png.color()), (6, 4, image::ColorType::Rgba16));
    let done = &place.done("out")[0];
    assert_eq!((done.outputs.len(), &done.settings["samples"]), (2, &1.into()));
}

#[test]
fn the_sheet_is_well_formed_and_shows_every_picture() {
    let place = Workplace::swept_by(&SWEEP.replace("base =", "title = \"a < b\"\nbase ="));
    place.batch("out", &[]).unwrap();
    let page = place.text("out/index.html");
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..roxmltree::ParsingOptions::default() };
    let page = page.replace("<!DOCTYPE html>", "");
    let document = roxmltree::Document::parse_with_options(&page, options).unwrap();
    let all =
        |tag: &str| document.descendants().filter(move |node| node.has_tag_name(tag)).collect::<Vec<_>>();
    assert_eq!(all("title")[0].text(), Some("a < b"));
    assert_eq!((all("li").len(), all("img").len()), (12, 12));
    assert!(all("img").iter().all(|img| img.attribute("src").unwrap().starts_with("data:image/png;base64,")));
    let card = all("li")[7];
    assert_eq!(
        (card.attribute("data-v-cut"), card.attribute("data-v-material")),
        (Some("step"), Some("diamond"))
    );
    // Whatever can be sorted by is there in every card.
    for button in all("button") {
        let key = format!("data-{}", button.attribute("data-key").unwrap());
        assert!(all("li").iter().all(|card| card.attribute(key.as_str()).is_some()), "{key}");
    }
}
