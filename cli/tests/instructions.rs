//! How many instructions a picture takes, against a figure that is kept here: time means nothing on a shared machine.
//!
//! Callgrind counts them; it knows no AVX-512, so this is the AVX2 form, in one thread. Installed by `test.sh`.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use std::path::Path;
use std::process::Command;

/// For `scenes/brilliant.toml` at draft quality, 512 × 512 pixels, by rustc 1.95. Of the last change, 0.9 %, four fifths are
/// room for crystals in what kernels are compiled from, and the rest is the larger catalogue, which is read at the start.
const INSTRUCTIONS: f64 = 5.300e9;
/// Compilers and the C library differ by less; what changes more is a change of ours, to be looked at and noted here.
const ALLOWED: f64 = 0.02;

/// The instructions of a picture of a scene, counted by Callgrind; `None` where that is missing and not required.
fn count(scene: &Path, quality: &str, size: &str) -> Option<f64> {
    if std::env::var_os("REQUIRE_VALGRIND").is_none()
        && Command::new("valgrind").arg("--version").output().is_err()
    {
        eprintln!("valgrind is not installed: nothing was counted");
        return None;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(env!("CARGO_BIN_EXE_gemtrace"))
        .args([
            "render",
            "--quality",
            quality,
            "--size",
            size,
            "--backend",
            "cpu",
            "--threads",
            "1",
            "-q",
            "-o",
        ])
        .arg(folder.path().join("a.exr"))
        .arg(scene)
        .output()
        .expect("valgrind starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let collected = said.lines().find_map(|line| line.split_once("Collected : ")).expect("a count").1;
    Some(collected.trim().parse().expect("a number"))
}

#[test]
fn the_first_picture_takes_as_many_instructions_as_it_did() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/brilliant.toml");
    let Some(found) = count(&scene, "draft", "512x512") else { return };
    let ratio = found / INSTRUCTIONS;
    println!("{found} instructions, {ratio:.4} of {INSTRUCTIONS}");
    assert!((ratio - 1.0).abs() <= ALLOWED, "{found} instructions, {ratio:.4} of the {INSTRUCTIONS} noted");
}

/// A crystal takes at most eight times as many instructions as the same stone with one index, the start of the program apart: at
/// the default quality, with pixels as small as those of a picture of 512².
#[test]
fn a_crystal_takes_few_times_as_many_as_one_index() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = |crystal: bool| {
        let text = format!(
            "format = 1\n[camera]\nposition = [0.0, -12.0, 27.0]\nlook_at = [0.0, 0.0, -0.45]\nfov = 0.82\n[[stone]]\n\
             shape = \"round-brilliant\"\nwidth = 6.5\nmaterial = \"zircon\"\ncrystal = {crystal}\n"
        );
        let axis = if crystal { "optic_axis = [0.5, 0.3, 0.8]\n" } else { "" };
        let path = folder.path().join(format!("{crystal}.toml"));
        std::fs::write(&path, text + axis).expect("a scene is written");
        path
    };
    let (zircon, twin) = (scene(true), scene(false));
    let counts = [(&zircon, "30x30"), (&twin, "30x30"), (&twin, "1x1")]
        .map(|(scene, size)| count(scene, "normal", size));
    let [Some(crystal), Some(one_index), Some(start)] = counts else { return };
    let ratio = (crystal - start) / (one_index - start);
    println!("{crystal} instructions for {one_index}, of which {start} to start: {ratio:.2} times as many");
    assert!(ratio < 8.0, "{ratio}");
}

/// The program's code, or `None` where objdump is missing.
fn code() -> Option<String> {
    let mut objdump = Command::new("objdump");
    let objdump = objdump.args(["-d", "--demangle", "--no-show-raw-insn", env!("CARGO_BIN_EXE_gemtrace")]);
    let output = objdump.output().inspect_err(|error| eprintln!("objdump is not installed: {error}")).ok()?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// What a closure computes with SIMD lanes is compiled without the instruction set that the function around it has: each
/// operation becomes a call. It gives the same picture, slowly.
#[test]
fn no_vector_operation_is_a_call() {
    let Some(code) = code() else { return };
    let (mut function, mut calls, mut functions) = ("", Vec::new(), 0);
    for line in code.lines() {
        if line.ends_with(">:") {
            (function, functions) = (line, functions + 1);
        } else if line.contains("core_arch::x86") && line.contains("_mm") {
            calls.push((function, line));
        }
    }
    // The reader of colour profiles is compiled without optimisation, since it is not needed twice.
    calls.retain(|(function, _)| !function.contains("core_arch::x86") && !function.contains("moxcms"));
    assert!(functions > 1000 && calls.is_empty(), "{calls:#?}");
}

/// A masked store takes some twenty operations on AMD's Zen 2 and Zen 3; LLVM makes them of selections, see
/// `accel::lanes`.
#[test]
fn no_selection_is_a_masked_store() {
    let Some(code) = code() else { return };
    // From a register to memory; the other way it is a load, which is cheap.
    let stores: Vec<&str> =
        code.lines().filter(|line| line.contains("vmaskmovps %") && line.trim_end().ends_with(')')).collect();
    assert!(code.contains("vblendv") || code.contains("vpblendv"), "there is no code of AVX2");
    assert!(stores.is_empty(), "{stores:#?}");
}
