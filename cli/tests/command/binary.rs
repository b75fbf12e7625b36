//! The program as a process: exit codes, streams, signals.

use super::support::Workplace;
use serde_json::Value;
use std::process::{Command, Output, Stdio};

fn gemtrace(place: &Workplace, arguments: &[&str]) -> Output {
    place.gemtrace(arguments).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn a_render_ends_with_one_line_that_says_where_the_files_are() {
    let place = Workplace::new();
    let output = gemtrace(&place, &["render", "tiny.toml"]);
    assert_eq!(code(&output), 0);
    // Why `auto` took the device that it took.
    let reason = text(&output.stderr);
    assert!(reason.lines().count() == 1 && reason.contains(": ") && !reason.contains("warning"), "{reason}");
    assert_eq!(place.files(), ["tiny.exr", "tiny.png"]);
    let line = text(&output.stdout);
    assert_eq!(line.lines().count(), 1);
    assert!(line.starts_with("wrote tiny.png, tiny.exr – ") && line.contains(" rays in "), "{line}");
    assert!(line.contains(" % of the energy dropped") && !line.contains('\u{1b}'), "{line}");
}

#[test]
fn json_is_one_object_even_for_failures() {
    let place = Workplace::new();
    for arguments in [
        &["render", "tiny.toml", "--size", "4x4"][..],
        &["check", "tiny.toml"],
        &["materials"],
        &["materials", "ruby"],
        &["spectrum", "0.2", "0.4", "0.8"],
        &["devices"],
    ] {
        let output = gemtrace(&place, &[arguments, &["--json"]].concat());
        assert_eq!(code(&output), 0, "{arguments:?}: {}", text(&output.stderr));
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(json.is_object() && json.get("failure").is_none());
    }
    let output = gemtrace(&place, &["render", "missing.toml", "--json"]);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((code(&output), &json["failure"]["exit_code"]), (3, &Value::from(3)));
    assert!(text(&output.stderr).starts_with("error: missing.toml: "));
}

#[test]
fn every_kind_of_failure_has_its_exit_code() {
    let place = Workplace::new();
    for (arguments, wanted, message) in [
        (&["render"][..], 2, "<SCENE>"),
        (&["render", "tiny.toml", "--backend", "cpuu"], 2, "did you mean 'cpu'?"),
        (&["render", "tiny.toml", "--device", "7"], 2, "has no device 7; it has only device 0"),
        (&["render", "tiny.toml", "--size", "0x5"], 2, "800x600"),
        (&["bench", "--runs", "0"], 2, "0 is not in 1..=1000"),
        (&["render", "tiny.toml", "--space", "rgb"], 2, "unknown colour space 'rgb'"),
        (&["render", "missing.toml"], 3, "missing.toml: no such file"),
        (&["cut", "missing.asc"], 3, "missing.asc: no such file"),
        (&["render", "tiny.toml", "-o", "no/a.png"], 4, "does not exist"),
    ] {
        let output = gemtrace(&place, arguments);
        let log = text(&output.stderr);
        assert!(code(&output) == wanted && log.contains(message), "{arguments:?}: {log}");
        assert!(!log.contains("panicked"));
    }
    assert!(place.files().is_empty());
}

#[test]
fn quiet_is_silent_and_help_documents_the_exit_codes() {
    let place = Workplace::new();
    let output = gemtrace(&place, &["render", "tiny.toml", "--quiet", "--size", "4x4"]);
    assert_eq!((code(&output), text(&output.stdout), text(&output.stderr)), (0, "", ""));
    let help = gemtrace(&place, &["--help"]);
    let help = text(&help.stdout);
    for code in ["0 ", "1 ", "2 ", "3 ", "4 ", "130 "] {
        assert!(help.lines().any(|line| line.trim_start().starts_with(code)), "{help}");
    }
}

#[cfg(unix)]
#[test]
fn control_c_writes_what_is_finished_within_a_second() {
    let place = Workplace::new();
    let mut command = place.gemtrace(&["render", "tiny.toml", "--samples", "65536", "--json"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_secs(3));
    let asked = std::time::Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert!(asked.elapsed().as_secs_f64() < 1.0, "{:?}", asked.elapsed());
    assert_eq!(code(&output), 130);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["partial"], &json["failure"]["exit_code"]), (&Value::Bool(true), &Value::from(130)));
    assert_eq!(place.files(), ["tiny.partial.exr", "tiny.partial.png"]);
}
