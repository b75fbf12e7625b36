//! How long the view takes, by the page's own timings: from an event to the picture of it. A busy machine says nothing about this, so it is
//! measured when asked for: `cargo test --release -p gemtrace-cli --test view -- --ignored --nocapture`.

use super::browser::Page;
use super::place::Place;
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

#[test]
#[ignore = "measures"]
fn timings() {
    let start = Instant::now();
    let Some(place) = Place::new() else { return };
    println!("browser and program started    {:6.0} ms", start.elapsed().as_secs_f64() * 1e3);
    let page = place.browser.page(SIZE, false);
    let start = Instant::now();
    page.open(&place.address);
    page.wait("document.querySelector('#view-a canvas')?.width > 1");
    println!("address to first picture       {:6.0} ms", start.elapsed().as_secs_f64() * 1e3);
    page.settle();
    let [x, y] = page.middle("#view-a");
    answered(&page);
    page.mouse("mouseMoved", [x, y], 0);
    page.mouse("mousePressed", [x, y], 0);
    let (start, mut last) = (Instant::now(), 0.0);
    let moved = |k: f64| {
        let event = serde_json::json!({ "type": "mouseMoved", "x": x + 100.0 * k.sin(), "y": y + 60.0 * k.cos(), "button": "left", "buttons": 1 });
        page.call("Input.dispatchMouseEvent", event);
    };
    while start.elapsed() < Duration::from_secs(5) {
        moved(last);
        last += 0.05;
        std::thread::sleep(Duration::from_millis(8));
    }
    let seconds = start.elapsed().as_secs_f64();
    let drags = answered(&page);
    println!("pictures a second while turning {:5.1}", drags.len() as f64 / seconds);
    println!("drag to picture, median        {:6.0} ms", median(drags));
    page.mouse("mouseReleased", [x, y], 0);
    page.settle();
    for (what, selector, values) in [
        ("material", "#swatches input[value=VALUE]", ["ruby", "diamond", "emerald", "quartz", "sapphire"]),
        ("cut", "#cut", ["step", "portuguese", "round-brilliant", "step", "portuguese"]),
        ("light", "#light", ["iso", "aset", "studio", "cos", "dome"]),
    ] {
        answered(&page);
        let mut times = Vec::new();
        for value in values {
            page.eval(&format!(
                "(n => {{ if (n.matches('select')) {{ n.value = '{value}'; n.dispatchEvent(new Event('change')); }} else n.click(); }})
                 (document.querySelector('{}'))",
                selector.replace("VALUE", value)
            ));
            page.wait("performance.getEntriesByName('gemtrace').length > 0");
            times.extend(answered(&page).first());
            page.settle();
        }
        println!("{what:8} to picture, median    {:6.0} ms", median(times));
    }
    let before = resident(place.process());
    page.eval(
        "(async () => { const { pose } = await import(document.querySelector('script[type=module]').src.replace('main.js', 'gesture.js'));
           for (let i = 0; i < 10000; i++) { const a = i / 50; pose([0, 0, Math.sin(a), Math.cos(a)], i % 10 === 9);
             await new Promise(r => setTimeout(r, 4)); } })()",
    );
    page.settle();
    println!("memory after 10,000 changes    {:6.1} MB, before {before:.1} MB", resident(place.process()));
}
