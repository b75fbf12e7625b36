//! How fast the live view answers, by the clock of a page: medians of what docs/view.md promises.
//!
//!     cargo bench -p gemtrace --features view --bench view
//!
//! With `-- --test` each is done once.

#[path = "../tests/view/support.rs"]
mod support;

use serde_json::json;
use std::time::{Duration, Instant};
use support::{News, Page, Running};

fn main() {
    let test = std::env::args().any(|argument| argument == "--test");
    let rounds = if test { 1 } else { 15 };
    let hall: &[u8] = include_bytes!("../../scenes/environments/hall.exr");
    let lobby: &[u8] = include_bytes!("../../scenes/environments/lobby.exr");
    let files = [("hall.exr", hall), ("lobby.exr", lobby)];
    let begun = Instant::now();
    let view = Running::of("scene.toml", &files);
    let mut page = large(&view);
    page.picture("moving", 0);
    println!("start of the server to the first picture: {} ms", begun.elapsed().as_millis());
    page.set("quality", json!("normal"));
    page.picture("settled", 1);

    let turned: Vec<Duration> = (0..rounds).map(|k| moved(&mut page, k)).collect();
    println!("a drag at rest to its picture: {} ms", median(turned));
    let (frames, size, seconds) = drag(&mut page, if test { 10 } else { 120 });
    println!(
        "pictures while dragging: {:.1} a second, mostly {} × {}",
        frames as f64 / seconds,
        size[0],
        size[1]
    );
    for (path, values) in [
        ("material", ["ruby", "diamond", "peridot", "emerald"]),
        ("cut", ["step", "round-brilliant", "portuguese", "round-brilliant"]),
        ("light", ["file:hall.exr", "studio", "file:lobby.exr", "aset"]),
    ] {
        page.set("material", json!("diamond"));
        let changes = (0..rounds).map(|k| changed(&mut page, path, values[k % values.len()]));
        println!("another {path} to its first picture: {} ms", median(changes.collect()));
    }
    let before = memory();
    let count = if test { 100 } else { 10_000 };
    let warm = if test { 10 } else { 1000 };
    let mut after_warm = 0;
    for k in 0..count {
        let a = 0.001 * k as f64;
        page.ask(json!({ "type": "pose", "rotation": [a.sin(), 0, 0, a.cos()], "done": k % 7 == 0 }));
        if k % 50 == 0 {
            page.set("material", json!(["ruby", "diamond", "spinel"][k / 50 % 3]));
            page.next();
        }
        if k == warm {
            after_warm = memory();
        }
    }
    let last = page.set("material", json!("yag"));
    page.picture("settled", last);
    println!("memory: {before} kB, after {warm} changes {after_warm} kB, after {count} {} kB", memory());
}

/// A page of 512 × 512 pixels.
fn large(view: &Running) -> Page {
    let mut page = Page::connect(&view.host, &view.token, None).unwrap();
    page.hello([512, 512]);
    page
}

/// From a drag to the first picture that shows it.
fn moved(page: &mut Page, k: usize) -> Duration {
    std::thread::sleep(Duration::from_millis(300));
    let a = 0.05 * (k + 1) as f64;
    let start = Instant::now();
    let id = page.ask(json!({ "type": "pose", "rotation": [0.0, a.sin(), 0.0, a.cos()], "done": true }));
    page.picture("moving", id);
    start.elapsed()
}

/// From another choice to the first picture that shows it.
fn changed(page: &mut Page, path: &str, value: &str) -> Duration {
    std::thread::sleep(Duration::from_millis(300));
    let start = Instant::now();
    let id = page.set(path, json!(value));
    page.picture("moving", id);
    start.elapsed()
}

/// Pictures of a drag of so many messages, 60 a second: their number, their usual size, the time.
fn drag(page: &mut Page, messages: u64) -> (usize, [u64; 2], f64) {
    let mut sizes = Vec::new();
    let start = Instant::now();
    let mut last = 0;
    for k in 0..messages {
        let a = 0.01 * k as f64;
        last = page.ask(
            json!({ "type": "pose", "rotation": [a.sin(), 0.0, 0.0, a.cos()], "done": k + 1 == messages }),
        );
        let due = start + Duration::from_millis(16 * (k + 1));
        while let Some(left) = due.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if let Some(News::Picture(picture)) = page.next_within(left) {
                sizes
                    .push([&picture.header["width"], &picture.header["height"]].map(|v| v.as_u64().unwrap()));
            }
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    page.picture("settled", last);
    sizes.sort_unstable();
    (sizes.len(), sizes.get(sizes.len() / 2).copied().unwrap_or_default(), seconds)
}

/// The median, ms.
fn median(mut times: Vec<Duration>) -> u128 {
    times.sort();
    times[times.len() / 2].as_millis()
}

/// The memory of this process, kB; 0 where the system does not say.
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok()).unwrap_or(0)
}
