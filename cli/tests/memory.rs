//! How much memory large scenes take, for each triangle and for each texel, while they are read, prepared and traced.
//!
//! `scripts/memory.sh` holds full-sized scenes against 4 GiB, which takes too long here. What it would find is seen in
//! small: the peak grows in proportion to the scene, so a copy too many shows as bytes too many. The peak is the
//! process's own, as Linux counts it, so this is one test and a process of its own.
#![cfg(target_os = "linux")]

#[path = "../examples/large_scene/globe.rs"]
mod globe;
#[path = "../examples/large_scene/sky.rs"]
mod sky;

use gemtrace_cli::commands::{Cli, run};
use gemtrace_cli::console::{Console, Interrupt};
use globe::Globe;
use sky::Sky;
use std::fs::{File, read_to_string, write};
use std::io::BufWriter;
use std::path::Path;

/// Three floats.
const BYTES_A_TEXEL: f64 = 12.0;
/// What 4 GiB leave to each of ten million triangles beside an environment of 16,384 × 8,192 texels: 268.
const BYTES_A_TRIANGLE: f64 = ((4_u64 << 30) as f64 - BYTES_A_TEXEL * 16_384.0 * 8192.0) / 1e7;

/// What sets the size from which on the allocator asks the system.
const TIDY: &str = "MALLOC_MMAP_THRESHOLD_";

/// A figure of `/proc/self/status`, bytes.
fn status(key: &str) -> f64 {
    let status = read_to_string("/proc/self/status").expect("Linux tells of each process");
    let line = status.lines().find_map(|line| line.strip_prefix(key)).expect("a figure that Linux gives");
    let kibibytes: f64 = line.trim_matches([':', '\t', ' ', 'k', 'B']).parse().expect("a number of kB");
    kibibytes * 1024.0
}

fn render(folder: &Path, name: &str, light: &str, stone: &str) {
    let scene = format!(
        "format = 1\n[camera]\nposition = [0.0, -8.0, 3.0]\nlook_at = [0.0, 0.0, 0.0]\nfov = 20.0\n\
         [film]\nwidth = 8\nheight = 8\n[environment]\n{light}\n[[stone]]\n{stone}\nmaterial = \"diamond\"\n\
         [render]\nsamples = 1\nwavelengths = {{ count = 4 }}\nmax_depth = 4\n"
    );
    let [scene_file, picture] = ["toml", "png"].map(|kind| folder.join(name).with_extension(kind));
    write(&scene_file, scene).expect("a writable folder");
    let arguments = ["gemtrace", "render", "--backend", "cpu", "--threads", "2", "-o"].map(Into::into);
    let files = [picture.into_os_string(), scene_file.into_os_string()];
    let cli = <Cli as clap::Parser>::parse_from(arguments.into_iter().chain(files));
    let (mut log, interrupt) = (std::io::sink(), Interrupt::default());
    let mut console = Console { quiet: true, ..Console::new(&mut log, &interrupt) };
    run(&cli.command, &mut console).expect("a picture");
}

/// Runs the test again in a process whose allocator (that of the GNU C library) gives back what is freed from 64 KiB on:
/// by default it keeps arrays of up to 32 MiB, which here is nearly all, and nothing where it counts.
fn again_with_a_tidy_allocator() {
    let test = std::env::current_exe().expect("this program");
    let arguments = ["--exact", "memory_grows_by_little_more_than_what_is_kept", "--nocapture"];
    let run =
        std::process::Command::new(test).args(arguments).env(TIDY, "65536").output().expect("a process");
    let told = String::from_utf8_lossy(&run.stdout);
    println!("{told}");
    assert!(run.status.success(), "{told}{}", String::from_utf8_lossy(&run.stderr));
}

#[test]
fn memory_grows_by_little_more_than_what_is_kept() {
    if std::env::var_os(TIDY).is_none() {
        return again_with_a_tidy_allocator();
    }
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let create = |name: &str| BufWriter::new(File::create(folder.join(name)).expect("a file"));

    let mut peaks = Vec::new();
    for (count, name) in [(100_000, "few.stl"), (300_000, "many.stl"), (600_000, "more.ply")] {
        let globe = Globe::new(count, 0.08);
        if name.ends_with("stl") { globe.write_stl(create(name)) } else { globe.write_ply(create(name)) }
            .expect("a mesh");
        render(folder, name, "uniform = [0.5, 0.5, 0.5]", &format!("mesh = \"{name}\""));
        peaks.push((count as f64, status("VmHWM")));
    }
    for pair in peaks.windows(2) {
        let slope = (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
        println!("{slope:.0} bytes a triangle");
        assert!(slope < BYTES_A_TRIANGLE, "{slope:.0} bytes a triangle");
    }

    // Larger than all of that, so that the peak is theirs.
    let sky = Sky { width: 5120, height: 2560 };
    let texels = (sky.width * sky.height) as f64;
    sky.write_exr(&folder.join("sky.exr")).expect("an environment");
    sky.write_hdr(create("sky.hdr")).expect("an environment");
    for name in ["sky.exr", "sky.hdr"] {
        let file = folder.join(name).metadata().expect("a file").len() as f64;
        let before = status("VmRSS");
        render(folder, name, &format!("image = \"{name}\""), "shape = \"round-brilliant\"\nwidth = 2.0");
        let bytes = (status("VmHWM") - before - file) / texels;
        println!("{name}: {bytes:.1} bytes a texel beside the file");
        assert!(bytes < 1.1 * BYTES_A_TEXEL, "{name}: {bytes:.1} bytes a texel beside the file");
    }
}
