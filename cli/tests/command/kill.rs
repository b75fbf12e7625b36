//! Killed at any moment, a batch goes on where it was.

use super::support::Workplace;
use gemtrace::batch::manifest::Event;
use std::collections::HashMap;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Slow enough for a kill to meet a picture in the works.
const SLOW: &[&str] = &["--samples", "64", "--size", "32x32"];

fn begin(place: &Workplace, output: &str) -> Child {
    let mut command = place.gemtrace(&["batch", "sweep.toml", "-o", output, "--backend", "cpu"]);
    command.args(SLOW).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Kills a run (SIGKILL on Unix) once `lines` lines are in its manifest and a little later.
fn kill_after(place: &Workplace, lines: usize, later: Duration) {
    let mut child = begin(place, "out");
    let start = Instant::now();
    let manifest = place.path("out/manifest.jsonl");
    while std::fs::read_to_string(&manifest).map_or(0, |text| text.lines().count()) < lines {
        assert!(start.elapsed() < Duration::from_secs(60), "the run does not get on");
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(later);
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_killed_batch_goes_on_and_renders_nothing_twice_but_what_was_in_flight() {
    let place = Workplace::swept();
    place.batch("calm", SLOW).unwrap();
    for (lines, later) in [(2, 0), (7, 3), (15, 11)] {
        kill_after(&place, lines, Duration::from_millis(later));
    }
    // As if the power had gone in the middle of a line.
    let text = place.text("out/manifest.jsonl") + "{\"status\":\"done\",\"item\":\"step-qu";
    place.write("out/manifest.jsonl", text);

    let report = place.batch("out", SLOW).unwrap();
    assert_eq!(report.failure, None);
    assert!(place.pictures("out") == place.pictures("calm"), "the pictures differ");
    let (mut begun, mut done) = (HashMap::<String, u32>::new(), HashMap::<String, u32>::new());
    for line in place.lines("out") {
        let counts = if matches!(line, Event::Started { .. }) { &mut begun } else { &mut done };
        *counts.entry(line.item().to_owned()).or_default() += 1;
    }
    assert!(done.len() == 12 && done.values().all(|count| *count == 1), "{done:?}");
    let again: u32 = begun.values().map(|count| count - 1).sum();
    assert!(again <= 3, "{again} pictures were begun again after three kills");

    let report = place.batch("out", SLOW).unwrap();
    assert_eq!((&report.json["rendered"], &report.json["kept"]), (&0.into(), &12.into()));
}

#[cfg(unix)]
#[test]
fn a_scheduler_that_asks_to_stop_is_heeded() {
    let place = Workplace::swept();
    let mut child = begin(&place, "out");
    while place.path("out/manifest.jsonl").metadata().map_or(0, |data| data.len()) == 0 {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let begun = |line: &&Event| matches!(line, Event::Started { .. });
    let (lines, done) = (place.lines("out"), place.done("out"));
    assert_eq!(lines.iter().filter(begun).count(), done.len() + 1);
    assert_eq!(place.pictures("out").len(), done.len());
    assert_eq!(place.batch("out", SLOW).unwrap().json["kept"], done.len());
}

#[test]
fn what_a_killed_process_left_half_written_is_cleared_away() {
    let place = Workplace::swept();
    std::fs::create_dir(place.path("out")).unwrap();
    let left = ["step-ruby-top.png", "plan.json", "other.png"]
        .map(|name| format!("out/.gemtrace-{name}-aB3xYz.tmp"));
    left.iter().for_each(|name| place.write(name, "half"));
    place.batch("out", &[]).unwrap();
    // The last belongs to another batch.
    assert_eq!(left.map(|name| place.path(&name).exists()), [false, false, true]);
}

#[test]
fn only_what_is_missing_or_has_changed_is_rendered() {
    let place = Workplace::swept();
    let first = place.batch("out", &[]).unwrap();
    assert_eq!((&first.json["rendered"], &first.json["items"]), (&12.into(), &12.into()));
    let calm = place.pictures("out");
    let again = |place: &Workplace| place.batch("out", &[]).unwrap().json["rendered"].as_u64().unwrap();
    assert_eq!(again(&place), 0);

    std::fs::remove_file(place.path("out/step-ruby-top.png")).unwrap();
    assert_eq!(again(&place), 1);
    place.write("out/step-ruby-side.png", "spoilt");
    assert_eq!(again(&place), 1);
    assert!(place.pictures("out") == calm);

    // Four more pictures of a new material; the others stay.
    let sweep = place.text("sweep.toml");
    place.write("sweep.toml", sweep.replace("\"quartz\"", "\"quartz\", \"topaz\""));
    assert_eq!(again(&place), 4);
    // One material is another one now.
    let own = "{ name = \"topaz\", like = \"topaz\", absorption = \"ink.csv\" }";
    place.write("sweep.toml", sweep.replace("\"quartz\"", &format!("\"quartz\", {own}")));
    place.write("ink.csv", "380, 0.1\n740, 0.2\n");
    assert_eq!(again(&place), 4);
    // A file that scenes name.
    place.write("ink.csv", "380, 0.1\n740, 0.3\n");
    assert_eq!((again(&place), again(&place)), (4, 0));
    // The base scene changes all.
    let base = place.text("base.toml");
    place.write("base.toml", base.replace("0.125", "0.25"));
    assert_eq!(again(&place), 16);
}
