//! Measures every GPU of this machine: `scripts/gpu.sh` runs it.
//!
//! `gpu FOLDER [small]` writes `gpu.json` and `gpu.md` to the folder. A failure is a line of the report, and the other steps
//! continue. With `small`, all pictures are tiny, for trials on a software driver.

use backend_cpu::CPU;
use backend_wgpu::{Gpu, adapters};
use gemtrace_tests::{
    agreement::Comparison,
    cases::cases,
    device::{Target, targets},
    gpu::{Row, map, row},
    scene::{eye, gem, material, scene},
};
use glam::DVec3;
use serde_json::{Value, json};
use spectral_core::{
    environment::{Environment, LatLong},
    film::Film,
    kernel::facets::Guess,
    prepare::PreparedScene,
    scene::Scene,
    settings::{Quality, RenderSettings},
    tracer::{Device, DeviceInfo, OpenOptions, TraceReport},
    wavelength::WavelengthGrid,
};
use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// A step that takes longer is abandoned.
const PATIENCE: Duration = Duration::from_secs(60);
/// Multiply-adds of a surface event, counted: Fresnel, Stokes and directions, without searches.
const EVENT: f64 = 224.0;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, rest @ ..] = arguments.as_slice() else { panic!("gpu FOLDER [small]") };
    let small = rest.iter().any(|word| word == "small");
    let mut report = Report { lines: Vec::new(), values: Vec::new() };
    let entrants: Vec<Entrant> =
        measured().iter().filter_map(|target| Entrant::new(target, &mut report)).collect();
    agreement(&entrants, &mut report);
    speed(&entrants, small, &mut report);
    for adapter in adapters() {
        let name = adapter.get_info().name;
        report.step("multiply-adds a second", &name, move || {
            let gpu = Gpu::of(&adapter)?;
            Ok(json!({ "giga_multiply_adds_per_second": (peak(&gpu, small) * 1e-9).round() }))
        });
    }
    report.write(Path::new(folder));
}

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// An open device with one form of intersection.
#[derive(Clone)]
struct Entrant {
    name: String,
    device: Arc<Mutex<Box<dyn Device>>>,
}

impl Entrant {
    /// Opens a target, or reports why not.
    fn new(target: &Target, report: &mut Report) -> Option<Self> {
        let (place, opened) = (Arc::new(Mutex::new(None)), target.clone());
        let device = place.clone();
        report.step("device", &target.name, move || {
            let start = Instant::now();
            let mut open = (opened.backend.open)(&opened.device, &OpenOptions::default())?;
            open.load(prepared(&diamond([8, 8]), &settings(8, 1)))?;
            *device.lock().expect("a device of its own") = Some(open);
            let DeviceInfo { name, driver, .. } = opened.device;
            Ok(json!({ "name": name, "driver": driver, "open_ms": start.elapsed().as_millis() as u64 }))
        });
        let device = place.try_lock().ok()?.take()?;
        Some(Entrant { name: target.name.clone(), device: Arc::new(Mutex::new(device)) })
    }
}

struct Report {
    lines: Vec<String>,
    values: Vec<Value>,
}

impl Report {
    /// Runs a step in a thread of its own, which is abandoned if it hangs.
    fn step(&mut self, what: &str, who: &str, run: impl FnOnce() -> Result<Value, Failure> + Send + 'static) {
        let (sender, receiver) = mpsc::channel();
        let thread = std::thread::spawn(move || {
            let _ = sender.send(run().map_err(|e| e.to_string()));
        });
        let outcome = match receiver.recv_timeout(PATIENCE) {
            Ok(outcome) => outcome,
            Err(mpsc::RecvTimeoutError::Timeout) => Err(format!("not done after {} s", PATIENCE.as_secs())),
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                let panic = thread.join().err();
                Err(panic.and_then(|p| p.downcast::<String>().ok()).map_or("a panic".into(), |text| *text))
            }
        };
        let value = outcome.unwrap_or_else(|error| json!({ "error": error }));
        let figures = value.as_object().into_iter().flatten().map(|(key, value)| format!("{key} {value}"));
        let line = format!("| {what} | {who} | {} |", figures.collect::<Vec<_>>().join(", "));
        println!("{line}");
        self.lines.push(line);
        self.values.push(json!({ "what": what, "who": who, "found": value }));
    }

    fn write(&self, folder: &Path) {
        std::fs::create_dir_all(folder).expect("a folder to write to");
        let mut page = String::from("| what | who | found |\n|---|---|---|\n");
        self.lines.iter().for_each(|line| writeln!(page, "{line}").expect("a string takes any text"));
        std::fs::write(folder.join("gpu.md"), page).expect("a folder to write to");
        let json = serde_json::to_string_pretty(&self.values).expect("plain values");
        std::fs::write(folder.join("gpu.json"), json).expect("a folder to write to");
    }
}

/// Every target except the processor, and every form of guessing facets.
fn measured() -> Vec<Target> {
    let mut all: Vec<Target> =
        targets().0.into_iter().filter(|target| target.backend.name != CPU.name).collect();
    for (name, guessing) in [
        ("wgpu", backend_wgpu::guessing as fn(Guess) -> spectral_core::tracer::Backend),
        ("vulkan", backend_vulkan::guessing),
    ] {
        for guess in Guess::ALL {
            let backend = guessing(guess);
            let named =
                |device| Target { name: format!("{name}, guessing {}", guess.name()), backend, device };
            all.extend((backend.devices)().into_iter().map(named));
        }
    }
    all
}

fn processor() -> Entrant {
    let device = (CPU.open)(&(CPU.devices)()[0], &OpenOptions::default()).expect("the processor opens");
    Entrant { name: "cpu".into(), device: Arc::new(Mutex::new(device)) }
}

fn prepared(scene: &Scene, settings: &RenderSettings) -> Arc<PreparedScene> {
    Arc::new(PreparedScene::new(scene, settings).expect("a valid scene"))
}

fn diamond([width, height]: [u32; 2]) -> Scene {
    let stone = gem("round-brilliant", material("diamond"));
    let light = Environment::image(LatLong::studio());
    let scene = scene(eye(DVec3::new(0.0, -20.0, 26.2), 14.0), 8, light, vec![stone]);
    Scene { width, height, ..scene }
}

fn settings(lines: usize, samples: u32) -> RenderSettings {
    let wavelengths = WavelengthGrid::midpoints([380.0, 740.0], lines).expect("a valid grid");
    let settings = RenderSettings::default().at(Quality::Normal).with_samples(samples);
    RenderSettings { wavelengths, ..settings }
}

/// Renders once to warm up, then `runs` times: the median time, the last report and film.
fn timed(
    entrant: &Entrant,
    scene: &Arc<PreparedScene>,
    runs: usize,
) -> Result<(f64, TraceReport, Film), Failure> {
    let mut device = entrant.device.try_lock().map_err(|_| "an earlier step still has the device")?;
    let mut tracer = device.load(scene.clone())?;
    let mut times = Vec::new();
    let mut last = None;
    for _ in 0..=runs {
        let mut film = Film::new(scene);
        let start = Instant::now();
        let samples = 0..scene.settings.samples;
        let report = tracer.trace(samples, &mut film, &mut |_| ControlFlow::Continue(()))?;
        times.push(start.elapsed().as_secs_f64());
        last = Some((report, film));
    }
    times.remove(0);
    times.sort_by(f64::total_cmp);
    let (report, film) = last.expect("at least one run");
    Ok((times[times.len() / 2], report, film))
}

/// Every entrant against the processor on all cases: one line for each entrant.
fn agreement(entrants: &[Entrant], report: &mut Report) {
    let cpu = processor();
    let scenes: Vec<_> = cases().into_iter().map(|e| (prepared(&e.scene, &e.settings), e)).collect();
    let films: Vec<_> =
        scenes.iter().map(|(s, _)| timed(&cpu, s, 1).expect("the processor works").2).collect();
    let films = Arc::new(scenes.into_iter().zip(films).collect::<Vec<_>>());
    for entrant in entrants.iter().cloned() {
        let films = films.clone();
        report.step("agreement with the processor", &entrant.name.clone(), move || {
            let (mut off, mut worst) = (Vec::new(), 0.0f64);
            for ((scene, case), expected) in films.iter() {
                let (_, _, found) = timed(&entrant, scene, 1)?;
                let comparison = Comparison::of(case, expected, &found);
                worst = worst.max(comparison.found.median);
                if !comparison.holds() {
                    off.push(format!("{}: {comparison}", case.name));
                }
            }
            Ok(json!({ "scenes": films.len(), "largest_median": worst, "off": off }))
        });
    }
}

fn speed(entrants: &[Entrant], small: bool, report: &mut Report) {
    let sizes = if small { [[24, 16], [32, 24]] } else { [[512, 512], [1920, 1080]] };
    let cpu = processor();
    let [little, large] = sizes;
    let empty = |size| Scene { stones: Vec::new(), ..diamond(size) };
    let subjects = [
        ("512² × 8 λ × 1", diamond(little), settings(8, 1)),
        ("512² × 32 λ × 1", diamond(little), settings(32, 1)),
        ("1920 × 1080 × 32 λ × 1", diamond(large), settings(32, 1)),
        ("1920 × 1080 × 32 λ × 4", diamond(large), settings(32, 4)),
        ("camera rays alone, 1920 × 1080 × 1 λ × 16", empty(large), settings(1, 16)),
    ];
    for (what, scene, settings) in subjects {
        let scene = prepared(&scene, &settings);
        for entrant in std::iter::once(&cpu).chain(entrants).cloned() {
            let scene = scene.clone();
            report.step(what, &entrant.name.clone(), move || {
                let (seconds, report, _) = timed(&entrant, &scene, 3)?;
                let samples =
                    f64::from(scene.width) * f64::from(scene.height) * f64::from(scene.settings.samples);
                Ok(json!({
                    "ms": (seconds * 1e5).round() / 1e2,
                    "mega_rays_per_second": (report.rays as f64 / seconds * 1e-6).round(),
                    "mega_samples_per_second": (samples / seconds * 1e-4).round() / 1e2,
                    "giga_multiply_adds_per_second": (EVENT / 2.0 * report.rays as f64 / seconds * 1e-9).round(),
                    "batches": report.batches,
                }))
            });
        }
    }
}

/// Multiply-adds a second in a kernel that does nothing else: eight independent chains for each invocation.
fn peak(gpu: &Gpu, small: bool) -> f64 {
    let turns = if small { 16 } else { 1 << 20 };
    let rows: Vec<Row> = vec![row(&[1.0, 0.5]); if small { 64 } else { 1 << 18 }];
    let body = format!(
        "var a = vec4(in[0]); var b = vec4(in[1]); let c = vec4(in[0] * 0.9999); let d = vec4(in[1]);
        for (var i = 0u; i < {turns}u; i++) {{ a = fma(a, c, d); b = fma(b, c, d); a = fma(a, c, d); b = fma(b, c, d); }}
        out[0] = dot(a, b);"
    );
    let run = |rows: &[Row]| {
        let start = Instant::now();
        map(gpu, "", &body, &[], rows);
        start.elapsed().as_secs_f64()
    };
    run(&rows[..64]);
    // Both include the time of uploading and reading back.
    let (short, long) = (run(&rows[..rows.len() / 2]), run(&rows));
    rows.len() as f64 / 2.0 * f64::from(turns) * 16.0 / (long - short).max(1e-9)
}
