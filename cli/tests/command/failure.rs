//! Outputs that fail, and renders that are stopped.

use super::read::{Exr, Png};
use super::support::{
    Cli, Console, Interrupt, Report, SCENE, Workplace, assert_matches, assert_refused, logged,
};
use backend_cpu::CPU;
use clap::Parser as _;
use gemtrace::Error;
use gemtrace_cli::commands::{Command, render};
use spectral_core::film::Film;
use spectral_core::tracer::{Backend, DeviceInfo, Progress, TraceFailure, TraceReport, Tracer};
use std::ops::{ControlFlow, Range};
use std::time::{Duration, Instant};

#[test]
fn outputs_that_cannot_be_written_are_refused_before_rendering() {
    let place = Workplace::new();
    std::fs::create_dir(place.path("folder.png")).unwrap();
    for (output, message) in [
        ("missing/a.png", "missing does not exist; create it first"),
        ("tiny.toml/a.png", "tiny.toml is a file, not a folder"),
        ("tiny.toml/b/a.png", "is a file, not a folder"),
        ("folder.png", "this is a folder; give the name of a file in it"),
        ("a.jpg", "end the name in '.png' or '.exr'"),
        ("a", "end the name in '.png' or '.exr'"),
    ] {
        // More work than anyone would wait for: what is refused must be refused before it.
        let options = ["--samples", "65536", "--size", "2048x2048"];
        let code = if message.starts_with("end") { 2 } else { 4 };
        assert_refused(place.render(&[output], &options), code, &format!("*{message}*"));
    }
    assert_eq!(place.files(), ["folder.png"]);
}

#[test]
fn one_output_twice_is_a_slip() {
    let place = Workplace::new();
    let result = place.render(&["a.png", "b.png", "a.png"], &[]);
    assert_refused(result, 2, "*output 3 is output 1 again*");
}

#[test]
fn absurd_sizes_are_refused_with_the_memory_they_would_need() {
    let place = Workplace::new();
    let render = |option: &str, value: &str| place.render(&["a.png"], &[option, value]);
    assert_refused(render("--size", "4294967295x4294967295"), 3, "*GiB*");
    assert_refused(render("--samples", "70000"), 3, "*samples: 70000 is not valid*");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_costs_one_picture_and_not_the_other() {
    let place = Workplace::new();
    for name in ["a.png", "a.exr"] {
        std::os::unix::fs::symlink("/dev/full", place.path(name)).unwrap();
        let other = if name == "a.png" { "b.exr" } else { "b.png" };
        let report = place.render(&[name, other], &[]).unwrap();
        let failure = report.failure.unwrap();
        assert_eq!(failure.exit_code(), 4);
        let message = failure.to_string();
        let rescued = report.json["outputs"][0]["path"].as_str().unwrap();
        assert_matches(&message, &format!("*No space left on device*saved as {rescued} instead*"));
        assert!(report.text.contains(rescued) && std::fs::metadata(rescued).unwrap().len() > 100);
        std::fs::remove_file(rescued).unwrap();
        assert!(std::fs::metadata(place.path(other)).unwrap().len() > 100);
    }
    assert_eq!(place.files(), ["a.exr", "a.png", "b.exr", "b.png"]);
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link_and_its_file_is_replaced() {
    let place = Workplace::new();
    place.write("real.png", "old");
    std::os::unix::fs::symlink("real.png", place.path("a.png")).unwrap();
    place.render(&["a.png"], &[]).unwrap();
    assert!(place.path("a.png").is_symlink());
    assert_eq!(Png::open(&place.path("real.png")).width, 24);
}

/// Renders far too many samples and asks to stop after `wait`.
fn stopped(place: &Workplace, wait: Duration) -> (Result<Report, Error>, Duration) {
    let interrupt = Interrupt::default();
    let asked = std::thread::scope(|scope| {
        let asker = scope.spawn(|| {
            std::thread::sleep(wait);
            assert!(interrupt.request(), "the render heeds the request");
            Instant::now()
        });
        let result = place.render_with(&["a.png", "a.exr"], &["--samples", "65536"], &interrupt);
        (result, asker.join().unwrap())
    });
    (asked.0, asked.1.elapsed())
}

#[test]
fn what_is_finished_is_written_and_marked_as_partial() {
    let place = Workplace::with(&SCENE.replace("threshold", "jitter = false\nthreshold"));
    place.write("a.png", "yesterday's picture");
    let (result, delay) = stopped(&place, Duration::from_secs(2));
    let report = result.unwrap();
    assert_eq!(report.failure, Some(Error::Interrupted));
    assert_eq!(report.json["partial"], true);
    assert!(report.text.starts_with("wrote what was finished"), "{}", report.text);
    assert_eq!(place.files(), ["a.partial.exr", "a.partial.png", "a.png"]);
    assert_eq!(place.read("a.png"), b"yesterday's picture");
    let exr = Exr::open(&place.path("a.partial.exr"));
    assert_eq!(exr.attributes["gemtrace.partial"], "true");
    assert_eq!(Png::open(&place.path("a.partial.png")).provenance["partial"], true);
    // The passes double, so by now every pixel has had its first samples.
    assert!((0..24 * 16).all(|i| exr.pixel(i)[3] == 1.0));
    assert!(delay < Duration::from_secs(1), "stopping took {delay:?}");
}

#[test]
fn a_render_stopped_before_its_first_sample_writes_nothing() {
    let place =
        Workplace::with(&SCENE.replace("width = 24", "width = 2048").replace("height = 16", "height = 2048"));
    let interrupt = Interrupt::default();
    interrupt.request();
    match place.render_with(&["a.png"], &[], &interrupt) {
        Err(error) => {
            assert_eq!(error, Error::Interrupted);
            assert!(place.files().is_empty());
        }
        // Some tiles were done when the request was looked at.
        Ok(report) => {
            assert_eq!(report.failure, Some(Error::Interrupted));
            assert_eq!(place.files(), ["a.partial.png"]);
        }
    }
}

/// The processor, lost in the second call.
struct Lost(Box<dyn Tracer>);

impl Tracer for Lost {
    fn device(&self) -> &DeviceInfo {
        self.0.device()
    }

    fn trace(
        &mut self,
        samples: Range<u32>,
        film: &mut Film,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<TraceReport, Box<TraceFailure>> {
        if samples.start == 0 {
            return self.0.trace(samples, film, progress);
        }
        let (device, message) = ("card".to_owned(), "the device was lost".to_owned());
        Err(spectral_core::Error::Device { device, message }.into())
    }
}

#[test]
fn a_named_device_that_is_lost_leaves_a_partial_picture_and_exit_code_1() {
    let card = Backend {
        name: "card",
        devices: || vec![DeviceInfo { backend: "card", name: "card".into(), ..(CPU.devices)().remove(0) }],
        open: |device, options| {
            let mut cpu = (CPU.open)(device, options)?;
            Ok(Box::new(move |scene| Ok(Box::new(Lost(cpu.load(scene)?)) as Box<dyn Tracer>)))
        },
        ..CPU
    };
    let place = Workplace::new();
    let [scene, output] = ["tiny.toml", "a.exr"].map(|name| place.name(name));
    let cli =
        Cli::try_parse_from(["gemtrace", "render", &scene, "-o", &output, "--backend", "card"]).unwrap();
    let Command::Render(args) = &cli.command else { unreachable!("render was asked for") };
    let (report, _) = logged(|log| {
        let interrupt = Interrupt::default();
        let mut console = Console::new(log, &interrupt);
        render::run_among(&[CPU, card], args, &mut console).unwrap()
    });
    let failure = report.failure.unwrap();
    assert_eq!((failure.to_string().as_str(), failure.exit_code()), ("card card: the device was lost", 1));
    assert_eq!((place.files(), &report.json["partial"]), (vec!["a.partial.exr".to_owned()], &true.into()));
    assert_eq!(Exr::open(&place.path("a.partial.exr")).attributes["gemtrace.device"], "card");
    assert_eq!(report.json["choice"], "card card: as asked for");
}
