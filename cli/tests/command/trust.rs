//! Files that come from anywhere: what they name, what they say, and how much of it.

use super::support::{SWEEP, Workplace, assert_matches, assert_refused, command};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// The two parts of a picture, which call their output `name`: fourteen characters, as the name that it is written over.
fn parts_naming(name: &str) -> Workplace {
    let place = Workplace::new();
    std::fs::create_dir_all(place.path("a/b")).unwrap();
    let (asked, picture) = ("picture-01.png", place.name("a/b/picture-01.png"));
    for shard in ["1/2", "2/2"] {
        let share =
            ["render", &place.name("tiny.toml"), "-o", &picture, "--shard", shard, "--backend", "cpu"];
        command(&share).unwrap();
        let path = format!("a/b/picture-01.part-{}.exr", shard.replace('/', "-of-"));
        let mut bytes = place.read(&path);
        let at = bytes.windows(asked.len()).position(|window| window == asked.as_bytes()).unwrap();
        assert_eq!(name.len(), asked.len());
        bytes[at..at + asked.len()].copy_from_slice(name.as_bytes());
        place.write(&path, bytes);
    }
    place
}

#[test]
fn a_part_names_files_of_its_own_folder_and_no_others() {
    parts_naming("another-01.png").merge("a/b").unwrap();
    for name in [
        "../../evil.png",
        "/tmp/evil-.png",
        "sub/folder.png",
        "C:evil-001.png",
        "a.part-1-of-1.",
        "evil-name.toml",
    ] {
        let place = parts_naming(name);
        let shown = format!("*part-1-of-2.exr: its output '{name}' is not valid: expected the plain name*");
        assert_refused(place.merge("a/b"), 3, &shown);
        assert_eq!(place.files(), ["a"]);
        assert_eq!(std::fs::read_dir(place.path("a/b")).unwrap().count(), 2, "{name}");
    }
}

#[test]
fn shares_are_of_files_in_one_folder() {
    let place = Workplace::new();
    std::fs::create_dir(place.path("sub")).unwrap();
    let report = place.render(&["a.png", "sub/b.png"], &["--shard", "1/2", "--samples", "65536"]);
    assert_refused(report, 2, "the outputs of a share are files of one folder*b.png is none");
}

#[test]
fn what_would_be_read_is_not_written() {
    let place = Workplace::swept();
    let tiny = "format = 1\n[camera]\nposition = [0, -9, 9]\nlook_at = [0, 0, 0]\n[environment]\nimage = \"sky.png\"\n\
                [[stone]]\nshape = \"step\"\nwidth = 2\nmaterial = \"quartz\"\n";
    image::RgbImage::new(8, 4).save(place.path("sky.png")).unwrap();
    let sky = place.read("sky.png");
    place.write("scene.toml", tiny);
    place.write("box.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    std::fs::create_dir(place.path("sub")).unwrap();
    let [scene, sky_again, solid] = ["scene.toml", "sub/../sky.png", "box.obj"].map(|name| place.name(name));
    for arguments in [
        &["render", &scene, "-o", &sky_again, "--samples", "65536"][..],
        &["sheet", "sizes", &scene, "-o", &sky_again],
        &["turntable", &scene, "-o", &place.name("frames"), "--apng", &sky_again],
        &["measure", &scene, "--csv", &scene],
        &["cut", &solid, "--mesh", &solid],
    ] {
        assert_refused(command(arguments), 2, "the output * is an input: *; choose another name");
    }
    assert!(
        place.read("sky.png") == sky && place.text("scene.toml") == tiny && place.text("box.obj").len() > 9
    );
    // One of a batch costs itself alone.
    let lights = SWEEP.replace("materials", "lights = [\"out/step-ruby-sky-top.png\"]\nmaterials");
    place.write("sweep.toml", lights);
    std::fs::create_dir(place.path("out")).unwrap();
    std::fs::copy(place.path("sky.png"), place.path("out/step-ruby-sky-top.png")).unwrap();
    let report = place.batch("out", &["--list"]).unwrap();
    assert!(report.text.contains("step-ruby"), "{}", report.text);
}

#[test]
fn a_render_clears_away_what_killed_ones_left() {
    let place = Workplace::new();
    let left = ["a.png", "a.partial.png", "b.png"].map(|name| format!(".gemtrace-{name}-aB3xYz.tmp"));
    left.iter().for_each(|name| place.write(name, "half"));
    place.render(&["a.png"], &["--size", "4x4"]).unwrap();
    // The last belongs to another picture.
    assert_eq!(left.map(|name| place.path(&name).exists()), [false, false, true]);
}

/// Both streams, of which a terminal must obey nothing.
fn told(output: &Output) -> String {
    let text = [&output.stdout[..], &output.stderr].concat();
    let text = String::from_utf8(text).unwrap();
    assert!(text.chars().all(|c| c == '\n' || c == '\t' || !c.is_control()), "{text:?}");
    assert!(!text.contains("panicked"), "{text}");
    text
}

#[test]
fn a_terminal_obeys_no_file() {
    let place = Workplace::new();
    // What TOML lets into its texts: of the control characters those beyond ASCII as they are, the others as escapes.
    let name = "x\\u001b]0;evil\\u0007\u{9b}2J\u{202e}";
    let scene = |stone: &str, more: &str| {
        let head = "format = 1\ncamera = { position = [0, -9, 9], look_at = [0, 0, 0] }\n";
        format!("{head}[[stone]]\nshape = \"step\"\nmaterial = \"quartz\"\nwidth = 2\n{stone}\n{more}")
    };
    for (stone, more) in [
        (format!("name = \"{name}\""), String::new()),
        (format!("\"{name}\" = 1"), String::new()),
        (String::new(), format!("[material.\"{name}\"]\nlike = \"{name}\"")),
        (String::new(), format!("[environment]\nimage = \"{name}.png\"")),
        (String::new(), format!("[environment]\nmodel = \"{name}\"")),
        (String::new(), format!("[film]\nwidth = \"{name}\"")),
    ] {
        place.write("tiny.toml", scene(&stone, &more));
        for json in [&[][..], &["--json"]] {
            let text = told(&place.gemtrace(&[&["check", "tiny.toml"], json].concat()).output().unwrap());
            assert!(text.contains("u001b"), "{text}");
        }
    }
    let cut = "GemCad 5.0\ng 96 0.0\ny 4 n\nI 1.54\nH \u{1b}[2J\na -90 1.0 96 n G\u{1b}[2J 24 48 72\na -40 0.8 96 24 48 72\n\
               a 0 0.5 96\n";
    place.write("evil.asc", cut);
    assert_matches(&told(&place.gemtrace(&["cut", "evil.asc"]).output().unwrap()), "*u001b[2J*G\\u001b[2J*");
}

#[test]
fn a_long_name_is_shown_short() {
    let place = Workplace::new();
    let long = "x".repeat(1_000_000);
    let stone = |line: &str| {
        format!("format = 1\ncamera = {{ position = [0, -9, 9], look_at = [0, 0, 0] }}\n[[stone]]\n{line}\n")
    };
    for line in [
        format!("shape = \"{long}\"\nmaterial = \"quartz\""),
        format!("shape = \"step\"\nmaterial = \"{long}\""),
        format!("mesh = \"{long}.obj\"\nmaterial = \"quartz\""),
        format!("{long} = 1"),
        format!("shape = \"step\"\nmaterial = \"quartz\"\nwidth = \"{long}\""),
        format!("shape = \"step\"\nmaterial = \"quartz\"\nname = \"{long}\""),
    ] {
        place.write("tiny.toml", stone(&line));
        let start = std::time::Instant::now();
        let text = told(&place.gemtrace(&["check", "tiny.toml"]).output().unwrap());
        assert!(text.len() < 4000, "{} bytes", text.len());
        assert!(start.elapsed().as_secs_f64() < 2.0, "{:?}", start.elapsed());
    }
    // A tier's name, which is a cell of a table.
    let cut = format!(
        "GemCad 5.0\ng 96 0.0\ny 4 n\nI 1.54\na -90 1.0 96 n {long} 24 48 72\na -40 0.8 96 24 48 72\na 0 0.5 96\n"
    );
    place.write("long.asc", cut);
    let output = place.gemtrace(&["cut", "long.asc"]).output().unwrap();
    assert!(output.status.success() && told(&output).contains("xx…xx"), "{output:?}");
    assert!(output.stdout.len() < 4000);
}

#[test]
fn time_and_memory_are_in_proportion_to_the_file() {
    let place = Workplace::new();
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\n\
                f 3 4 8 7\nf 4 1 5 8\n";
    // Twenty prisms over polygons of 1,024 corners.
    let corner = |k: usize| std::f64::consts::TAU * k as f64 / 1024.0;
    let mut prisms = String::new();
    for prism in 0..20 {
        for (z, k) in [0, 1].into_iter().flat_map(|z| (0..1024).map(move |k| (z, k))) {
            prisms += &format!("v {} {} {z}\n", 3.0 * f64::from(prism) + corner(k).cos(), corner(k).sin());
        }
        let [low, high] = [0, 1024].map(|from| -> Vec<String> {
            (1..=1024).map(|k| (prism as usize * 2048 + from + k).to_string()).collect()
        });
        let below: Vec<&str> = low.iter().rev().map(String::as_str).collect();
        prisms += &format!("f {}\nf {}\n", below.join(" "), high.join(" "));
        for k in 0..1024 {
            let next = (k + 1) % 1024;
            prisms += &format!("f {} {} {} {}\n", low[k], low[next], high[next], high[k]);
        }
    }
    let continued = |word: &str| format!("{cube}# {}", format!("{word} \\\n").repeat(100_000));
    for (name, text) in [("prisms.obj", prisms), ("a.obj", continued("")), ("b.obj", continued("f 1 2 3"))] {
        place.write(name, text);
        let start = Instant::now();
        let output = place.gemtrace(&["cut", name]).output().unwrap();
        assert!(output.status.success(), "{name}: {}", told(&output));
        assert!(start.elapsed() < Duration::from_secs(5), "{name}: {:?}", start.elapsed());
    }
    // A hundred thousand cubes side by side.
    place.write("cube.obj", cube);
    let at: String = (0..100_000)
        .map(|i| format!("{{ position = [{}, {}, 0] }},\n", 2 * (i % 317), 2 * (i / 317)))
        .collect();
    let scene = LIT.replace("image = \"sky.png\"", "uniform = [1, 1, 1]");
    let scene = scene.replace("shape = \"step\"\nwidth = 2", &format!("mesh = \"cube.obj\"\nat = [\n{at}]"));
    place.write("tiny.toml", scene);
    let start = Instant::now();
    let output = place.gemtrace(&["check", "tiny.toml"]).output().unwrap();
    assert!(output.status.success(), "{}", told(&output));
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    #[cfg(target_os = "linux")]
    assert!(limited(&place, 700_000, "check tiny.toml").status.success());
}

/// A chunk of a PNG.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [kind, data].concat();
    let crc = body.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
    });
    [&(data.len() as u32).to_be_bytes(), &body[..], &(!crc).to_be_bytes()].concat()
}

/// 8 × 4 texels of one colour of a palette, with more chunks before them.
fn png(chunks: &[Vec<u8>]) -> Vec<u8> {
    let head = chunk(b"IHDR", &[0, 0, 0, 8, 0, 0, 0, 4, 8, 3, 0, 0, 0]);
    // A zlib stream of one stored block of 36 zeros, and its Adler sum.
    let stored = [&[0x78, 0x01, 1, 36, 0, 219, 255][..], &[0; 36], &[0, 36, 0, 1]].concat();
    let ends = [chunk(b"IDAT", &stored), chunk(b"IEND", &[])].concat();
    [&b"\x89PNG\r\n\x1a\n"[..], &head, &chunks.concat(), &ends].concat()
}

/// Runs `gemtrace` with as many kilobytes of memory at most.
fn limited(place: &Workplace, kilobytes: u32, arguments: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_gemtrace");
    let command = format!("ulimit -v {kilobytes} && exec '{program}' {arguments}");
    Command::new("sh").args(["-c", &command]).current_dir(place.folder.path()).output().unwrap()
}

const LIT: &str = "format = 1\n[camera]\nposition = [0, -9, 9]\nlook_at = [0, 0, 0]\n[film]\nwidth = 8\nheight = 8\n\
                   [environment]\nimage = \"sky.png\"\n[[stone]]\nshape = \"step\"\nwidth = 2\nmaterial = \"quartz\"\n";

#[test]
fn a_palette_of_broken_colours_is_refused() {
    let place = Workplace::with(LIT);
    for (palette, message) in
        [(58, "its palette has 58 bytes"), (0, "*"), (1, "its palette has 1 "), (771, "its palette has 771")]
    {
        place.write("sky.png", png(&[chunk(b"PLTE", &vec![9; palette])]));
        let output = place.gemtrace(&["check", "tiny.toml"]).output().unwrap();
        assert_matches(&told(&output), &format!("error: tiny.toml, line *: sky.png: *{message}*"));
        assert_eq!(output.status.code(), Some(3));
    }
    place.write("sky.png", png(&[chunk(b"PLTE", &[9; 57])]));
    assert!(place.gemtrace(&["check", "tiny.toml"]).status().unwrap().success());
}

#[cfg(target_os = "linux")]
#[test]
fn a_colour_profile_takes_no_more_memory_than_its_picture() {
    let place = Workplace::with(LIT);
    let mut info = png::Info::with_size(8, 4);
    (info.color_type, info.bit_depth) = (png::ColorType::Rgb, png::BitDepth::Eight);
    info.icc_profile = Some(vec![0; 512 << 20].into());
    let mut bytes = Vec::new();
    let mut writer = png::Encoder::with_info(&mut bytes, info).unwrap().write_header().unwrap();
    writer.write_image_data(&[128; 96]).unwrap();
    writer.finish().unwrap();
    assert!(bytes.len() < 4 << 20, "{}", bytes.len());
    place.write("sky.png", bytes);
    // Whether it is ignored or refused.
    let output = limited(&place, 400_000, "check tiny.toml");
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", told(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_outgrows_its_limit_is_not_there() {
    let place = Workplace::new();
    // Blocks of 512 or 1024 bytes, as the shell has it.
    let program = env!("CARGO_BIN_EXE_gemtrace");
    let render = format!("ulimit -f 2 && exec '{program}' render tiny.toml --backend cpu --size 64x64");
    let temporary = place.name("temporary");
    std::fs::create_dir(&temporary).unwrap();
    let mut command = Command::new("sh");
    command.args(["-c", &render]).current_dir(place.folder.path()).env("TMPDIR", &temporary);
    let output = command.output().unwrap();
    assert_matches(&told(&output), "*error: tiny.png: cannot be written (File too large*");
    assert_eq!(output.status.code(), Some(4), "{output:?}");
    assert_eq!(
        (place.files(), std::fs::read_dir(&temporary).unwrap().count()),
        (vec!["temporary".into()], 0)
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_lack_of_memory_is_told_before_the_work() {
    let place = Workplace::new();
    let output = limited(&place, 300_000, "render tiny.toml --backend cpu --size 8192x8192");
    assert_matches(
        &told(&output),
        "error: not enough memory: a picture of 8192 × 8192 pixels needs 7.0 GiB\n",
    );
    assert_eq!((output.status.code(), place.files()), (Some(1), vec![]));
}

#[test]
fn a_part_of_a_size_that_its_bytes_cannot_hold_is_refused() {
    let place = parts_naming("another-01.png");
    let path = "a/b/picture-01.part-1-of-2.exr";
    let mut bytes = place.read(path);
    let name = b"dataWindow\0box2i\0";
    let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4 + 8;
    for corner in [[500_000_000; 2], [i32::MAX - 1; 2], [99, i32::MAX - 1], [100_000, 9], [-5, 7]] {
        bytes[at..at + 8].copy_from_slice(&corner.map(i32::to_le_bytes).concat());
        place.write(path, &bytes);
        assert_refused(place.merge("a/b"), 3, "*part-1-of-2.exr: not a complete part of a picture: *");
    }
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_not_waited_for() {
    let place = Workplace::swept();
    let fifo = |name: &str| assert!(Command::new("mkfifo").arg(place.path(name)).status().unwrap().success());
    for name in ["a.part-1-of-2.exr", "a.part-2-of-2.exr", "f.toml", "f.asc", "f.obj", "sky.png"] {
        fifo(name);
    }
    place.write("lit.toml", LIT);
    std::fs::create_dir(place.path("out")).unwrap();
    ["out/plan.json", "out/manifest-1-of-2.jsonl"].into_iter().for_each(fifo);
    for arguments in [
        &["merge", "a.part-1-of-2.exr"][..],
        &["merge", "out"],
        &["render", "f.toml"],
        &["check", "lit.toml"],
        &["batch", "f.toml"],
        &["cut", "f.asc"],
        &["cut", "f.obj"],
        &["measure", "f.asc"],
    ] {
        let start = Instant::now();
        let output = place.gemtrace(arguments).output().unwrap();
        assert_matches(&told(&output), "error: *this is not a regular file*");
        assert_eq!(output.status.code(), Some(3), "{arguments:?}");
        assert!(start.elapsed() < Duration::from_secs(5), "{arguments:?}");
    }
}
