//! No panic, and no absurd appetite, on 100 000 mutated scene, cut, mesh and environment files: each goes as far as it
//! gets on its way to a prepared scene.

use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage};
use gemtrace::{import, scene_file};
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Stone;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Builds for debugging are fifty times slower, but check arithmetic: they try fewer.
const MUTANTS: u64 = if cfg!(debug_assertions) { 3_000 } else { 100_000 };
/// Far beyond what any mutant of a small file takes, however busy the machine: only a blow-up gets here.
const PATIENCE: Duration = Duration::from_secs(20);

/// Marsaglia's xorshift64: the same mutants in every run.
struct Dice(u64);

impl Dice {
    fn new(seed: u64) -> Self {
        // Neighbouring seeds are spread out, and the state must not be 0.
        let mut dice = Dice((seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        for _ in 0..8 {
            dice.next();
        }
        dice
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound.max(1) as u64) as usize
    }
}

/// Twenty awkward numbers and sixteen words of the formats, each list separated by `|`.
const NUMBERS: &str = "nan|-nan|inf|-inf|1e999|-0|-0.0|0|1e-320|-1|1|2|4294967296|99999999|-2147483649|\
    18446744073709551616|1e308|0.1|0x7fffffffffffffff|1e9";
const WORDS: &str =
    "[[stone]]|[camera]|[render]|width = 1|like = \"ruby\"|{|}|[|]|\"|\n|a |n G|f 1 2 3\n|v 0 0 0\n|=";

/// One item of such a list.
fn any(list: &'static str, dice: &mut Dice) -> &'static str {
    list.split('|').nth(dice.below(list.split('|').count())).unwrap()
}

/// One change to a file or two, rarely up to four: most mutants should get far before they are refused.
fn mutate(seed: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    let changes = [1, 1, 1, 1, 1, 2, 2, 4][dice.below(8)];
    for _ in 0..changes {
        let at = dice.below(bytes.len());
        let end = (at + 1 + dice.below(20)).min(bytes.len());
        match dice.below(12) {
            0 if at < bytes.len() => bytes[at] ^= 1 << dice.below(8),
            1 if at < bytes.len() => bytes[at] = dice.next() as u8,
            2 => drop(bytes.drain(at.min(end)..end)),
            3 => bytes.truncate(at),
            4 => {
                let part = bytes[at.min(end)..end].to_vec();
                let to = dice.below(bytes.len() + 1);
                bytes.splice(to..to, part);
            }
            5 => drop(bytes.splice(at..at, any(WORDS, dice).bytes())),
            6 => {
                // A stretch of the original over another place: records out of order.
                let from = dice.below(seed.len());
                let part = seed[from..(from + 1 + dice.below(120)).min(seed.len())].to_vec();
                bytes.splice(at.min(end)..end, part);
            }
            _ => replace_number(&mut bytes, at, dice),
        }
    }
    bytes
}

/// The number at or after `at`, if there is one, gives way to an awkward one; binary files get eight bytes of one.
fn replace_number(bytes: &mut Vec<u8>, at: usize, dice: &mut Dice) {
    let awkward = any(NUMBERS, dice);
    if bytes.contains(&0) {
        let value = awkward.parse::<f64>().unwrap_or(f64::MAX).to_le_bytes();
        let end = (at + 8).min(bytes.len());
        bytes.splice(at.min(end)..end, value);
        return;
    }
    let part_of_number = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-');
    let Some(start) = bytes.iter().skip(at).position(part_of_number).map(|p| at + p) else { return };
    let length = bytes[start..].iter().take_while(|b| part_of_number(b)).count();
    bytes.splice(start..start + length, awkward.bytes());
}

/// A file to start from, and where it goes.
struct Seed {
    name: &'static str,
    bytes: Vec<u8>,
}

const SCENE: &str = include_str!("data/seed.toml");

const BOX_CUT: &str = "GemCad 5.0\ng 96 0.0\ny 4 n\nI 1.54\nH a box\na -90.000000 1.0 96 n G 24 48 72 G set size\n\
    a -40 0.8 96 n P1 24\n48 72 G to centre\na 0 0.5 96 n T\nF done\n";

/// A block with a notch: polygons that are not convex, of five and six corners.
const NOTCH: &str = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 1 0\nv 0 2 0\nv 0 0 1\nv 2 0 1\nv 2 2 1\nv 1 1 1\nv 0 2 1\n\
    f 5 4 3 2 1\nf 6 7 8 9 10\nf 1 2 7 6\nf 2 3 8 7\nf 3 4 9 8\nf 4 5 10 9\nf 5 1 6 10\n";

const TETRAHEDRON_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty double y\n\
    property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1.5 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

/// A small gradient as EXR, HDR and PNG.
fn pictures() -> [Seed; 3] {
    let (width, height) = (16, 8);
    let value = |x: usize, y: usize| (x as f32 / 16.0, y as f32, 0.5);
    let mut exr = Cursor::new(Vec::new());
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| value(at.0, at.1));
    let layer = Layer::new((width, height), LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
    Image::from_layer(layer).write().to_buffered(&mut exr).expect("an EXR");
    let texels: Vec<image::Rgb<f32>> = (0..width * height)
        .map(|i| value(i % width, i / width))
        .map(|(r, g, b)| image::Rgb([r, g, b]))
        .collect();
    let mut hdr = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut hdr).encode(&texels, width, height).expect("an HDR");
    let mut png = Cursor::new(Vec::new());
    let image = image::RgbImage::from_fn(16, 8, |x, y| image::Rgb([x as u8 * 16, y as u8 * 32, 128]));
    image.write_to(&mut png, image::ImageFormat::Png).expect("a PNG");
    let seed = |name, bytes| Seed { name, bytes };
    [seed("e.exr", exr.into_inner()), seed("e.hdr", hdr), seed("e.png", png.into_inner())]
}

fn seeds() -> Vec<Seed> {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let mut stl = vec![b' '; 80];
    stl.extend(4u32.to_le_bytes());
    let mut text = "solid t\n".to_owned();
    let mut ply =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
            .to_vec();
    ply.extend(corners.iter().flatten().flat_map(|v| v.to_le_bytes()));
    for face in faces {
        stl.extend([0; 12]);
        stl.extend(face.iter().flat_map(|c| corners[*c]).flat_map(f32::to_le_bytes));
        stl.extend([0; 2]);
        ply.push(3);
        ply.extend(face.iter().flat_map(|c| (*c as u32).to_le_bytes()));
        text += "facet normal 0 0 0\nouter loop\n";
        face.iter().for_each(|c| {
            text += &format!("vertex {} {} {}\n", corners[*c][0], corners[*c][1], corners[*c][2])
        });
        text += "endloop\nendfacet\n";
    }
    text += "endsolid t\n";
    let seed = |name, bytes: &[u8]| Seed { name, bytes: bytes.to_vec() };
    let mut all = vec![
        seed("scene.toml", SCENE.as_bytes()),
        seed("box.asc", BOX_CUT.as_bytes()),
        seed("step.asc", include_bytes!("../../spectral-core/data/cuts/emerald_step_49.asc")),
        seed("step.gem", include_bytes!("../../spectral-core/data/cuts/emerald_step_49.gem")),
        seed("step.gcs", include_bytes!("../../spectral-core/data/cuts/emerald_step_49.gcs")),
        seed("notch.obj", NOTCH.as_bytes()),
        seed("t.stl", &stl),
        seed("t.stl", text.as_bytes()),
        seed("t.ply", &ply),
        seed("t.ply", TETRAHEDRON_PLY.as_bytes()),
    ];
    all.extend(pictures());
    all
}

/// As far as the bytes get; whether they make a scene.
fn attempt(name: &str, bytes: &[u8], frame: &Frame) -> bool {
    let path = Path::new(name);
    if name == "scene.toml" {
        let text = String::from_utf8_lossy(bytes);
        let Ok(loaded) = scene_file::parse(&text, path, frame.folder.path()) else { return false };
        return PreparedScene::new(&loaded.scene, &loaded.settings).is_ok();
    }
    if name.starts_with("e.") {
        return import::environment::read(path, bytes).is_ok();
    }
    let solid = match import::cut::Format::of(path) {
        Some(_) => import::cut::solid(path, bytes),
        None => import::mesh::read(path, bytes),
    };
    let Ok((mesh, _)) = solid else { return false };
    let mut scene = frame.loaded.scene.clone();
    let material = scene.stones[0].material.clone();
    scene.stones = vec![Stone { width: Some(6.5), ..Stone::new("mutant", Arc::new(mesh), material) }];
    PreparedScene::new(&scene, &frame.loaded.settings).is_ok()
}

/// What stands around a mutated cut or mesh, and the files that a mutated scene names.
struct Frame {
    folder: tempfile::TempDir,
    loaded: scene_file::LoadedScene,
}

impl Frame {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in
            [("cube.asc", BOX_CUT), ("notch.obj", NOTCH), ("table.csv", "nm,v\n380,0.1\n780,0.2\n")]
        {
            std::fs::write(folder.path().join(name), text).expect("a temporary file");
        }
        let text = "format = 1\n[camera]\nposition = [0, -20, 20]\nlook_at = [0, 0, 0]\n\
            [film]\nwidth = 8\nheight = 8\n[environment]\nuniform = [1, 1, 1]\n\
            [[stone]]\nmesh = \"notch.obj\"\nmaterial = \"diamond\"\n\
            [render]\nsamples = 1\nwavelengths = { count = 8, jitter = false }\n";
        let loaded = scene_file::parse(text, Path::new("frame.toml"), folder.path()).expect("a sound frame");
        Frame { folder, loaded }
    }
}

#[test]
fn every_seed_makes_a_scene() {
    let frame = Frame::new();
    for seed in seeds() {
        assert!(attempt(seed.name, &seed.bytes, &frame), "{}", seed.name);
    }
}

#[test]
fn no_mutant_makes_the_program_panic_or_hang() {
    let frame = Frame::new();
    let seeds = seeds();
    let (sound, faults) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()) as u64;
    let trial = |number: u64| {
        // The scene is the richest in ways to go wrong: it takes a third of the mutants.
        let seed = &seeds[if number.is_multiple_of(3) { 0 } else { number as usize % seeds.len() }];
        let bytes = mutate(&seed.bytes, &mut Dice::new(number));
        let start = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| attempt(seed.name, &bytes, &frame)));
        match outcome {
            Ok(true) => drop(sound.fetch_add(1, Ordering::Relaxed)),
            Ok(false) if start.elapsed() < PATIENCE => {}
            _ => {
                let text = String::from_utf8_lossy(&bytes).into_owned();
                let fault = if outcome.is_err() { "panic" } else { "hang" };
                faults
                    .lock()
                    .expect("no panic outside")
                    .push(format!("{fault}: mutant {number} of {}:\n{text}", seed.name));
            }
        }
    };
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let trial = &trial;
            scope.spawn(move || (thread..MUTANTS).step_by(threads as usize).for_each(trial));
        }
    });
    let faults = faults.into_inner().expect("no panic outside");
    assert!(faults.is_empty(), "{} faults, the first:\n{}", faults.len(), faults[0]);
    // Mutants must get all the way often enough to try everything, and be refused often enough, too.
    let sound = sound.into_inner() as u64;
    println!("{sound} of {MUTANTS} mutants make a scene");
    assert!((MUTANTS / 20..MUTANTS * 19 / 20).contains(&sound), "{sound} of {MUTANTS} mutants make a scene");
}
