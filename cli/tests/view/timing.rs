//! How long the view takes, by the page's own timings: from an event to the picture of it. A busy machine says nothing about this, so it is
//! measured when asked for: `cargo test --release -p gemtrace-cli --test view -- --ignored --nocapture`.

use super::browser::Page;
use super::place::{Place, SCENE};
use image::codecs::hdr::HdrEncoder;
use std::time::{Duration, Instant};

/// A canvas of 512 × 512 pixels, with bar, status and panel around it.
const SIZE: [u32; 2] = [512 + 320, 512 + 48 + 32];

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Milliseconds of the events that have been answered since it was asked last.
fn answered(page: &Page) -> Vec<f64> {
    let found = page.eval(
        "(e => { performance.clearMeasures('gemtrace'); return e.map(m => m.duration); })(performance.getEntriesByName('gemtrace'))",
    );
    found.as_array().expect("a list").iter().filter_map(serde_json::Value::as_f64).collect()
}

/// Megabytes that a process occupies.
fn resident(process: u32) -> f64 {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).expect("Linux");
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a line");
    line.split_whitespace().next().and_then(|kb| kb.parse::<f64>().ok()).expect("a number") / 1024.0
}

/// A photograph of a sky with lamps, 2048 × 1024 pixels, as Radiance file.
fn photograph() -> Vec<u8> {
    let pixel = |k: usize| {
        let (x, y) = (k % 2048, k / 2048);
        let lamp = x % 256 < 16 && (200..230).contains(&y);
        image::Rgb([0.2, 0.3, 0.5].map(|c| if lamp { 40.0 } else { c * (1.0 - y as f32 / 1100.0) }))
    };
    let pixels: Vec<_> = (0..2048 * 1024).map(pixel).collect();
    let mut file = Vec::new();
    HdrEncoder::new(&mut file).encode(&pixels, 2048, 1024).expect("a picture");
    file
}

/// One figure beside what it must be.
struct Figure {
    what: &'static str,
    value: f64,
    unit: &'static str,
    must: f64,
    /// Whether more is better.
    more: bool,
}

impl Figure {
    /// At most `must`.
    fn new(what: &'static str, value: f64, unit: &'static str, must: f64) -> Self {
        Figure { what, value, unit, must, more: false }
    }

    fn holds(&self) -> bool {
        if self.more { self.value >= self.must } else { self.value <= self.must }
    }
}

/// Turns the stone by the pointer for five seconds: pictures a second, their smallest edge, and the time from event to picture.
fn turning(page: &Page) -> [Figure; 4] {
    page.eval(
        "import(document.querySelector('script[type=module]').src.replace('main.js', 'app.js')).then(({ listen }) => {
           window.seen = []; listen('shown', h => h.stage === 'moving' && seen.push([Math.min(h.width, h.height), h.wavelengths])); })",
    );
    let [x, y] = page.middle("#view-a");
    answered(page);
    page.mouse("mouseMoved", [x, y], 0);
    page.mouse("mousePressed", [x, y], 0);
    let (start, mut last) = (Instant::now(), 0.0_f64);
    while start.elapsed() < Duration::from_secs(5) {
        let at = [x + 100.0 * last.sin(), y + 60.0 * last.cos()];
        let event = serde_json::json!({ "type": "mouseMoved", "x": at[0], "y": at[1], "button": "left", "buttons": 1 });
        page.call("Input.dispatchMouseEvent", event);
        last += 0.05;
        std::thread::sleep(Duration::from_millis(8));
    }
    let seconds = start.elapsed().as_secs_f64();
    let seen = page.eval("seen.splice(0)");
    let of = |k: usize| {
        let all = seen.as_array().into_iter().flatten().filter_map(move |picture| picture[k].as_f64());
        all.collect::<Vec<_>>()
    };
    let drags = answered(page);
    page.mouse("mouseReleased", [x, y], 0);
    let more = |what, value, unit, must| Figure { more: true, ..Figure::new(what, value, unit, must) };
    [
        more("pictures while turning", of(0).len() as f64 / seconds, "/s", 10.0),
        more("their smaller edge, median", median(of(0)), "pixels", 256.0),
        more("wavelengths, the fewest", of(1).into_iter().fold(f64::INFINITY, f64::min), "", 8.0),
        Figure::new("drag to picture", median(drags), "ms", 100.0),
    ]
}

/// From a choice to its first picture.
fn choosing(page: &Page, what: &'static str, selector: &str, values: &[&str]) -> Figure {
    // Each is chosen once before: files are decoded once.
    let times = values.iter().chain(values).map(|value| {
        answered(page);
        page.eval(&format!(
            "(n => {{ if (n.matches('select')) {{ n.value = '{value}'; n.dispatchEvent(new Event('change')); }} else n.click(); }})
             (document.querySelector('{}'))",
            selector.replace("VALUE", value)
        ));
        page.wait("performance.getEntriesByName('gemtrace').length > 0");
        let time = answered(page).first().copied().unwrap_or(f64::NAN);
        std::thread::sleep(Duration::from_millis(300));
        time
    });
    let times: Vec<f64> = times.collect();
    println!("{what}: first {:.0} ms", times[0]);
    Figure::new(what, median(times[values.len()..].to_vec()), "ms", 200.0)
}

/// Megabytes by which the program has grown after so many changes of pose, material, cut and light.
fn growth(page: &Page, process: u32) -> Figure {
    let change = |count: usize| {
        page.eval(&format!(
            "(async () => {{
               const at = document.querySelector('script[type=module]').src;
               const {{ pose }} = await import(at.replace('main.js', 'gesture.js')), {{ set }} = await import(at.replace('main.js', 'link.js'));
               const others = [['material', ['ruby', 'diamond', 'peridot']], ['cut', ['step', 'round-brilliant']], ['light', ['aset', 'studio', 'file:sky.hdr']]];
               for (let i = 0; i < {count}; i++) {{
                 const a = i / 50, [path, values] = others[(i / 20 | 0) % 3];
                 if (i % 20) pose([0, 0, Math.sin(a), Math.cos(a)], i % 10 === 9); else set(path, values[(i / 60 | 0) % values.length]);
                 await new Promise(r => setTimeout(r, 4)); }} }})()"
        ));
        page.settle();
        resident(process)
    };
    let before = change(1000);
    let after = change(10_000);
    println!("memory: {before:.1} MB, then {after:.1} MB");
    Figure::new("growth by 10,000 changes", after - before, "MB", 0.05 * before)
}

#[test]
#[ignore = "measures"]
fn timings() {
    let scene = SCENE.replace("quality = \"draft\"", "quality = \"normal\"");
    let Some(place) = Place::of(&scene, &[("sky.hdr", photograph())]) else { return };
    let page = place.browser.page(SIZE, false);
    page.open(&place.address);
    page.wait("document.querySelector('#view-a canvas')?.width > 1");
    let start = place.started.elapsed().as_secs_f64() * 1e3;
    let mut figures = vec![Figure::new("program's start to first picture", start, "ms", 1000.0)];
    page.settle();
    figures.extend(turning(&page));
    page.settle();
    for (what, selector, values) in [
        (
            "material to picture",
            "#swatches input[value=VALUE]",
            ["ruby", "emerald", "quartz", "sapphire", "diamond"],
        ),
        ("cut to picture", "#cut", ["step", "portuguese", "file:brilliant.asc", "step", "round-brilliant"]),
        ("light to picture", "#light", ["file:sky.hdr", "iso", "aset", "file:sky.hdr", "studio"]),
    ] {
        figures.push(choosing(&page, what, selector, &values));
    }
    figures.push(growth(&page, place.process()));
    let loaded: u64 =
        page.loaded().iter().filter(|(address, _)| !address.contains("/swatch/")).map(|(_, n)| n).sum();
    figures.push(Figure::new("bytes of the page", loaded as f64 / 1e3, "kB", 300.0));
    for Figure { what, value, unit, must, more } in &figures {
        println!(
            "{what:34} {value:7.1} {unit:6} must be {} {must:.1}",
            if *more { "at least" } else { "at most" }
        );
    }
    let failed: Vec<_> = figures.iter().filter(|figure| !figure.holds()).map(|figure| figure.what).collect();
    assert!(failed.is_empty(), "{failed:?}");
}
