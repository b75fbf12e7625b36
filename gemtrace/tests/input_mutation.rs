//! No panic, and no absurd appetite, on mutants of everything that the program reads: 100 000 of scenes, cuts, meshes and
//! environments, and 100 000 of what batches and shares of pictures leave. Each goes as far as it gets.

#[path = "../../fuzz/src/attempt.rs"]
mod attempt;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Builds for debugging are fifty times slower, but check arithmetic: they try fewer.
const MUTANTS: u64 = if cfg!(debug_assertions) { 3_000 } else { 100_000 };
/// Far beyond what any mutant of a small file takes, however busy the machine: only a blow-up gets here.
const PATIENCE: Duration = Duration::from_secs(20);
/// What all of them together may take of memory, bytes.
#[cfg(target_os = "linux")]
const MEMORY: u64 = 200_000_000;

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

/// A file of a kind.
struct Sample {
    kind: &'static str,
    name: String,
    bytes: Vec<u8>,
}

/// The corpus of the fuzz targets.
fn corpus(kinds: &[&'static str]) -> Vec<Sample> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus");
    let of_kind = |kind: &&'static str| {
        let files = std::fs::read_dir(folder.join(kind)).expect("a folder for every kind");
        let mut paths: Vec<_> = files.map(|file| file.expect("a file").path()).collect();
        paths.sort();
        let kind = *kind;
        paths.into_iter().map(move |path| Sample {
            kind,
            name: path.display().to_string(),
            bytes: std::fs::read(path).expect("a sample"),
        })
    };
    kinds.iter().flat_map(of_kind).collect()
}

/// What a batch or a share of a picture leaves; all before is what scenes are made of.
const BATCH: usize = 9;

#[test]
fn every_sample_is_read() {
    for sample in corpus(&attempt::KINDS) {
        // What fuzzing has found is refused.
        let sound = !sample.name.contains("refused");
        assert_eq!(attempt::run(sample.kind, &sample.bytes), sound, "{}", sample.name);
    }
}

#[test]
fn no_mutant_of_a_scene_or_what_it_names_makes_the_program_panic_or_hang() {
    let samples = corpus(&attempt::KINDS[..BATCH]);
    // The scene is the richest in ways to go wrong: it takes a third of the mutants.
    let scene = samples.iter().position(|sample| sample.kind == "scene").expect("a scene");
    try_all(
        &samples,
        |number| if number.is_multiple_of(3) { scene } else { number as usize % samples.len() },
    );
}

#[test]
fn no_mutant_of_a_part_a_sweep_or_a_manifest_makes_the_program_panic_or_hang() {
    let samples = corpus(&attempt::KINDS[BATCH..]);
    try_all(&samples, |number| number as usize % samples.len());
}

fn try_all(samples: &[Sample], which: impl Fn(u64) -> usize + Sync) {
    let (sound, faults) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get()) as u64;
    let trial = |number: u64| {
        let sample = &samples[which(number)];
        let bytes = mutate(&sample.bytes, &mut Dice::new(number));
        let start = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| attempt::run(sample.kind, &bytes)));
        match outcome {
            Ok(true) => drop(sound.fetch_add(1, Ordering::Relaxed)),
            Ok(false) if start.elapsed() < PATIENCE => {}
            _ => {
                let text = String::from_utf8_lossy(&bytes).into_owned();
                let fault = if outcome.is_err() { "panic" } else { "hang" };
                let fault = format!("{fault}: mutant {number} of {}:\n{text}", sample.name);
                faults.lock().expect("no panic outside").push(fault);
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
    println!("{sound} of {MUTANTS} mutants are sound");
    assert!((MUTANTS / 20..MUTANTS * 19 / 20).contains(&sound), "{sound} of {MUTANTS} mutants are sound");
    #[cfg(target_os = "linux")]
    assert!(peak() < MEMORY, "{} bytes", peak());
}

/// The most memory that this process has had, bytes.
#[cfg(target_os = "linux")]
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux tells of each process");
    let line =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("a figure that Linux gives");
    let kibibytes: u64 = line.trim().trim_end_matches(" kB").parse().expect("a number of kB");
    kibibytes * 1024
}
