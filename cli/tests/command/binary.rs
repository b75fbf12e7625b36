//! The program as a process: exit codes, streams, signals.

use super::support::{SCENE, Workplace, assert_matches};
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
        assert!(json["format"] == 1 && json["warnings"].is_array() && json.get("failure").is_none());
    }
    let output = gemtrace(&place, &["render", "missing.toml", "--json"]);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((code(&output), &json["failure"]["exit_code"]), (3, &Value::from(3)));
    let log: Value = serde_json::from_slice(&output.stderr).unwrap();
    assert!(log["error"].as_str().unwrap().starts_with("missing.toml: "));
}

/// A script reads no sentence that is not JSON.
#[test]
fn with_json_remarks_and_refused_command_lines_are_json_too() {
    let place = Workplace::with(&SCENE.replace("max_depth", "# max_depth"));
    let refused = gemtrace(&place, &["render", "tiny.toml", "--quality", "best", "--json"]);
    let json: Value = serde_json::from_slice(&refused.stdout).unwrap();
    assert_eq!((code(&refused), &json["failure"]["exit_code"], &json["format"]), (2, &2.into(), &1.into()));
    let message = json["failure"]["message"].as_str().unwrap();
    assert!(message.contains("'best'") && message.contains("draft, normal, final"), "{message}");
    assert!(!message.contains("--help") && refused.stderr.is_empty());
    // After `--` it is a file's name.
    assert!(text(&gemtrace(&place, &["render", "--", "a", "--json"]).stderr).starts_with("error: "));
    let remarks = gemtrace(&place, &["render", "tiny.toml", "--space", "xyz", "--json"]);
    let log: Vec<Value> =
        text(&remarks.stderr).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(
        log[0]["warning"].as_str().unwrap().contains("xyz is for EXR only") && log[1]["note"].is_string()
    );
    let json: Value = serde_json::from_slice(&remarks.stdout).unwrap();
    assert_eq!(json["warnings"], Value::Array(vec![log[0]["warning"].clone()]));
    let help = gemtrace(&place, &["render", "--help", "--json"]);
    assert!(code(&help) == 0 && text(&help.stdout).contains("Usage: gemtrace render"));
}

#[test]
fn completions_and_manual_pages_know_the_options_and_their_values() {
    let place = Workplace::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = gemtrace(&place, &["completions", shell]);
        let script = text(&output.stdout);
        assert!(code(&output) == 0 && script.contains("quality"), "{shell}");
        // These list values beside the options.
        if ["bash", "zsh", "fish"].contains(&shell) {
            assert!(["draft", "acescg", "16"].iter().all(|value| script.contains(value)), "{shell}");
        }
    }
    assert!(text(&gemtrace(&place, &["completions", "csh"]).stderr).contains("possible values: bash"));
    for (command, expected) in [
        (&["man"][..], ".TH gemtrace 1"),
        (&["man", "render"], ".TH gemtrace-render 1"),
        (&["man", "sheet", "sizes"], "SYNOPSIS"),
    ] {
        let output = gemtrace(&place, command);
        assert!(code(&output) == 0 && text(&output.stdout).contains(expected), "{}", text(&output.stdout));
    }
    let output = gemtrace(&place, &["man", "rendr"]);
    assert!(code(&output) == 2 && text(&output.stderr).contains("did you mean 'render'?"));
}

/// Colours are asked for here, since no terminal is there to ask for them.
#[test]
fn no_color_means_no_colours() {
    let place = Workplace::new();
    let colours = |name: &str| {
        let mut command = place.gemtrace(&["render", "--help"]);
        text(
            &command
                .env_remove("NO_COLOR")
                .env("CLICOLOR_FORCE", "1")
                .env(name, "1")
                .output()
                .unwrap()
                .stdout,
        )
        .contains('\u{1b}')
    };
    assert_eq!(["OTHER", "NO_COLOR"].map(colours), [true, false]);
}

#[test]
fn every_kind_of_failure_has_its_exit_code() {
    let place = Workplace::new();
    for (arguments, wanted, message) in [
        (&["render"][..], 2, "<SCENE>"),
        (&["render", "tiny.toml", "--backend", "gpu"], 2, "valid: auto, cpu, wgpu, vulkan, reference"),
        (&["render", "tiny.toml", "-o", "x.jpg"], 2, "'.png' or '.exr'"),
        (&["measure", "tiny.toml", "--size", "30x20"], 2, "300x300"),
        (&["render", "tiny.toml", "--device", "7"], 2, "has no device 7; it has only device 0"),
        (&["render", "tiny.toml", "--size", "0x5"], 2, "800x600"),
        (&["bench", "--runs", "0"], 2, "0 is not in 1..=1000"),
        (&["render", "tiny.toml", "--space", "rgb"], 2, "possible values: srgb"),
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
fn every_scene_ends_within_a_second() {
    let place = Workplace::new();
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    for name in
        ["brilliant", "cookbook/gold", "pair", "quartz", "ring", "ruby", "sapphire", "tray", "transparent"]
    {
        let scene = scenes.join(name).with_extension("toml").display().to_string();
        let mut command = place.gemtrace(&[
            "render",
            &scene,
            "--backend",
            "cpu",
            "--samples",
            "65536",
            "-o",
            "a.png",
            "-q",
        ]);
        let mut child = command.stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(700));
        let asked = std::time::Instant::now();
        assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{name}");
        assert!(asked.elapsed().as_secs_f64() < 1.0, "{name}: {:?}", asked.elapsed());
    }
    assert!(place.files().iter().all(|name| name == "a.partial.png"), "{:?}", place.files());
}

/// What overlaps by the hundred is refused at once; what may overlap ends within a second of SIGTERM.
#[cfg(unix)]
#[test]
fn stones_in_each_other_by_the_hundred_end_at_once() {
    let scene = |step: f64, stones: usize| {
        let places: Vec<_> =
            (0..stones).map(|k| format!("{{ position = [{}, 0, 0] }}", step * k as f64)).collect();
        format!(
            "format = 1\n[camera]\nposition = [1, -34, 17]\nlook_at = [1, 0, 0]\n[[stone]]\nshape = \"round-brilliant\"\n\
             width = 4.0\nmaterial = \"ruby\"\nat = [{}]\n",
            places.join(",")
        )
    };
    let place = Workplace::holding(&[("heap.toml", &scene(0.0, 1000)), ("row.toml", &scene(0.8, 300))]);
    let begun = std::time::Instant::now();
    let heap =
        gemtrace(&place, &["render", "heap.toml", "--backend", "cpu", "--size", "4x4", "--samples", "1"]);
    assert_eq!(code(&heap), 3);
    assert_matches(text(&heap.stderr), "*at most 6 may overlap at one point, but these do: stone 1 (shape)*");
    assert!(begun.elapsed().as_secs_f64() < 2.0, "{:?}", begun.elapsed());
    for size in ["4x4", "200x100"] {
        let mut row = place.gemtrace(&["render", "row.toml", "--backend", "cpu", "--size", size]);
        let mut child =
            row.args(["--samples", "65536", "-o", "a.png", "-q"]).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(1500));
        let asked = std::time::Instant::now();
        assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{size}");
        assert!(asked.elapsed().as_secs_f64() < 1.0, "{size}: {:?}", asked.elapsed());
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
