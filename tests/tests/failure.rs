//! Devices that fail: what is finished stays, and another carries on to the same film, bit for bit.
//!
//! The failing backends here trace on the processor, so that only their failures differ from it.

use backend_cpu::CPU;
use backend_vulkan::VULKAN;
use backend_wgpu::{Gpu, WGPU, adapters};
use gemtrace::registry::{self, Choice, choose_among};
use gemtrace::session::{Rendered, Session, Watch};
use gemtrace_tests::{
    render::render,
    scene::{eye, gem, glass, scene, settings},
};
use glam::DVec3;
use spectral_core::{
    Error,
    environment::{Environment, LatLong},
    film::Film,
    prepare::PreparedScene,
    scene::Scene,
    settings::RenderSettings,
    tracer::{Backend, Device, DeviceInfo, OpenOptions, Progress, TraceFailure, TraceReport, Tracer},
};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::time::Duration;

fn view() -> (Scene, RenderSettings) {
    let stones = vec![gem("round-brilliant", glass(2.417))];
    let scene =
        scene(eye(DVec3::new(4.0, -12.0, 22.0), 18.0), 40, Environment::image(LatLong::studio()), stones);
    (scene, RenderSettings { samples: 6, threshold: 1e-3, ..settings(&[450.0, 550.0, 650.0]) })
}

fn prepared() -> Arc<PreparedScene> {
    let (scene, settings) = view();
    Arc::new(PreparedScene::new(&scene, &settings).expect("a valid scene"))
}

fn undisturbed() -> gemtrace_tests::render::Picture {
    let (scene, settings) = view();
    render(&CPU, &scene, &settings)
}

/// Traces on the processor until a number of pixel samples is done, then is lost.
struct Lost {
    cpu: Box<dyn Tracer>,
    device: DeviceInfo,
    after: u64,
}

impl Tracer for Lost {
    fn device(&self) -> &DeviceInfo {
        &self.device
    }

    fn trace(
        &mut self,
        samples: Range<u32>,
        film: &mut Film,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<TraceReport, Box<TraceFailure>> {
        let after = self.after;
        let report = self.cpu.trace(samples, film, &mut |at| {
            if at.done >= after { ControlFlow::Break(()) } else { progress(at) }
        })?;
        if report.finished {
            return Ok(report);
        }
        let error = Error::Device { device: self.device.name.clone(), message: "the device was lost".into() };
        Err(Box::new(TraceFailure { error, report }))
    }
}

fn fake(backend: &'static str) -> Vec<DeviceInfo> {
    vec![DeviceInfo { backend, name: format!("{backend} card (rev 2)"), ..(CPU.devices)().remove(0) }]
}

/// A device that traces on the processor what `change` makes of a scene.
fn on_cpu(
    device: &DeviceInfo,
    after: u64,
    options: &OpenOptions,
    change: fn(&DeviceInfo, Arc<PreparedScene>) -> Result<Arc<PreparedScene>, Error>,
) -> Result<Box<dyn Device>, Error> {
    let options = OpenOptions { tile: Some(5), ..*options };
    let (device, mut cpu) = (device.clone(), (CPU.open)(&(CPU.devices)()[0], &options)?);
    Ok(Box::new(move |scene| {
        let cpu = cpu.load(change(&device, scene)?)?;
        Ok(Box::new(Lost { cpu, device: device.clone(), after }) as Box<dyn Tracer>)
    }))
}

/// Passes the probe (64 pixels) and is lost in anything larger.
const FLAKY: Backend = Backend {
    name: "flaky",
    about: "lost midway",
    devices: || fake("flaky"),
    unusable: Vec::new,
    areas: false,
    open: |device, options| on_cpu(device, 400, options, |_, scene| Ok(scene)),
};

const CLOSED: Backend = Backend {
    name: "closed",
    about: "passes the probe and has no room for anything larger",
    devices: || fake("closed"),
    unusable: Vec::new,
    areas: false,
    open: |device, options| {
        on_cpu(device, u64::MAX, options, |device, scene| match scene.width {
            0..=8 => Ok(scene),
            _ => Err(Error::Device {
                device: device.name.clone(),
                message: "the device has no memory left".into(),
            }),
        })
    },
};

const LIAR: Backend = Backend {
    name: "liar",
    about: "shows every scene in light that is twice as bright",
    devices: || fake("liar"),
    unusable: Vec::new,
    areas: false,
    open: |device, options| {
        on_cpu(device, u64::MAX, options, |_, scene| {
            let mut scene = (*scene).clone();
            scene.environment = Arc::new(Environment::uniform([2.0; 3]));
            Ok(Arc::new(scene))
        })
    },
};

const HANGING: Backend = Backend {
    name: "hanging",
    about: "never opens",
    devices: || fake("hanging"),
    unusable: Vec::new,
    areas: false,
    open: |_, _| {
        std::thread::sleep(Duration::from_secs(3600));
        Err(Error::Device { device: String::new(), message: String::new() })
    },
};

const SOFTWARE: Backend = Backend {
    name: "software",
    about: "a software GPU",
    devices: || vec![DeviceInfo { hardware: false, ..fake("software").remove(0) }],
    unusable: Vec::new,
    areas: false,
    open: CPU.open,
};

#[derive(Default)]
struct Log {
    chosen: Vec<String>,
    replaced: Vec<String>,
    last: Option<Progress>,
}

impl Watch for Log {
    fn chosen(&mut self, choice: &Choice) {
        self.chosen.push(choice.reason.clone());
    }

    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self.last = Some(progress);
        ControlFlow::Continue(())
    }

    fn warning(&mut self, message: &str) {
        self.replaced.push(message.to_owned());
    }
}

fn rendered(backends: &[Backend], name: &str) -> (Film, Rendered, Log) {
    let scene = prepared();
    let (mut film, mut log) = (Film::new(&scene), Log::default());
    let candidates = choose_among(backends, name, None).expect("a device");
    let candidates = candidates.with_patience(Duration::from_secs(2));
    let rendered = Session::new(candidates, OpenOptions::default()).fill(&scene, &mut film, &mut log);
    (film, rendered, log)
}

#[test]
fn auto_passes_on_what_fails_and_the_processor_completes_the_same_film() {
    let backends = [CPU, SOFTWARE, LIAR, HANGING, CLOSED, FLAKY];
    let (film, rendered, log) = rendered(&backends, registry::AUTO);
    let whole = undisturbed();
    assert!(film == whole.film, "the film depends on who made it");
    assert_eq!(rendered.failure, None);
    assert!(rendered.traced.finished);
    assert_eq!(rendered.traced.rays, whole.report.rays);
    assert_eq!(rendered.traced.energy.started, whole.report.energy.started);
    let names: Vec<_> = rendered.devices.iter().map(|device| device.backend).collect();
    assert_eq!(names, ["flaky", "cpu"]);
    let [first, second, third] = log.chosen.as_slice() else { panic!("{:?}", log.chosen) };
    assert!(first.starts_with("closed closed card: it is hardware and passes the probe"), "{first}");
    for part in [
        "software software card is software",
        "liar liar card fails: the probe, a stone alone, comes out wrong in 64 of 64 pixels",
        "hanging hanging card fails: the probe has not ended after 2 seconds",
    ] {
        assert!(first.contains(part), "{first}");
    }
    assert_eq!(second, "flaky flaky card: it is hardware and passes the probe");
    assert_eq!(third, "cpu: no other device is left");
    assert_eq!(
        log.replaced,
        [
            "closed closed card: the device has no memory left; flaky flaky card carries on",
            "flaky flaky card: the device was lost; cpu carries on"
        ]
    );
    assert_eq!(log.last, Some(Progress { done: 40 * 40 * 6, total: 40 * 40 * 6 }));
}

#[test]
fn a_picture_that_the_processor_finishes_before_a_gpu_is_ready_is_its_own() {
    let reason = |settings: &RenderSettings, name| {
        let scene = PreparedScene::new(&view().0, settings).expect("a valid scene");
        let mut candidates = registry::choose_for(&scene, &[CPU, CLOSED], name, None).expect("a device");
        candidates.next().expect("a device").reason
    };
    let small = view().1;
    let large = RenderSettings { samples: 3_000, ..small.clone() };
    assert_eq!(reason(&small, registry::AUTO), "cpu: it is done before a GPU would be ready");
    assert_eq!(reason(&large, registry::AUTO), "closed closed card: it is hardware and passes the probe");
    assert_eq!(reason(&small, "closed"), "closed closed card: as asked for");
}

#[test]
fn software_is_never_preferred_to_the_processor() {
    let (_, rendered, log) = rendered(&[CPU, SOFTWARE], registry::AUTO);
    assert_eq!(log.chosen, ["cpu: software software card is software"]);
    assert_eq!(rendered.devices[0].backend, "cpu");
}

#[test]
fn a_named_device_that_is_lost_keeps_its_tiles_and_has_no_successor() {
    let (film, rendered, log) = rendered(&[CPU, FLAKY], "flaky");
    let kept: u64 = (0..40 * 40).map(|i| u64::from(film.samples(i % 40, i / 40))).sum();
    assert!(kept >= 400 && !film.is_complete(6), "{kept}");
    assert_eq!(rendered.traced.energy.started, 3.0 * kept as f64);
    assert_eq!(rendered.failure.expect("lost").to_string(), "flaky flaky card: the device was lost");
    assert!(!rendered.traced.finished && log.replaced.is_empty());
    assert_eq!(log.chosen, ["flaky flaky card: as asked for"]);
}

/// Breaks off on one tile size, again on another, and ends on a third.
#[test]
fn a_trace_that_is_broken_off_twice_ends_with_the_same_bits() {
    let (scene, whole) = (prepared(), undisturbed());
    let mut film = Film::new(&scene);
    let mut report = TraceReport::default();
    for (tile, until) in [(7, 300), (16, 2000), (3, u64::MAX)] {
        let options = OpenOptions { tile: Some(tile), ..OpenOptions::default() };
        let mut tracer = CPU.tracer(&(CPU.devices)()[0], scene.clone(), &options).expect("the processor");
        let mut watch = |at: Progress| {
            if at.done >= until { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        report += tracer.trace(0..6, &mut film, &mut watch).expect("no failure");
        assert_eq!(report.finished, until == u64::MAX);
    }
    assert!(film == whole.film);
    assert_eq!(report.rays, whole.report.rays);
    assert_eq!(report.energy.started, whole.report.energy.started);
}

#[test]
fn a_dispatch_past_its_deadline_is_an_error_that_says_so() {
    let (mut scene, settings) = view();
    (scene.width, scene.height) = (256, 256);
    let scene = Arc::new(PreparedScene::new(&scene, &settings).expect("a valid scene"));
    let options = OpenOptions { deadline: Some(Duration::from_millis(1)), ..OpenOptions::default() };
    for backend in [WGPU, VULKAN] {
        for device in (backend.devices)().into_iter().filter(|device| !device.hardware) {
            let mut tracer = backend.tracer(&device, scene.clone(), &options).expect("opens");
            let mut film = Film::new(&scene);
            let failure = tracer
                .trace(0..6, &mut film, &mut |_| ControlFlow::Continue(()))
                .expect_err("no software does this in a millisecond");
            let message = failure.to_string();
            assert!(message.contains("the kernel has not ended after 0.001 seconds"), "{message}");
            assert!(matches!(failure.error, Error::Device { .. }) && !failure.report.finished);
        }
    }
}

#[test]
fn a_wgpu_device_that_is_destroyed_midway_keeps_its_tiles_for_the_processor() {
    let scene = prepared();
    for (adapter, info) in adapters().iter().zip((WGPU.devices)()) {
        let gpu = Gpu::of(adapter).expect("opens");
        let device = gpu.device.clone();
        let options = OpenOptions { tile: Some(8), ..OpenOptions::default() };
        let mut tracer = backend_wgpu::open_on(gpu, &info, &options).load(scene.clone()).expect("opens");
        let mut film = Film::new(&scene);
        let failure = tracer
            .trace(0..6, &mut film, &mut |at| {
                if at.done >= 600 {
                    device.destroy();
                }
                ControlFlow::Continue(())
            })
            .expect_err("the device is gone");
        println!("{failure}");
        assert!(matches!(failure.error, Error::Device { .. }));
        let kept: u64 = (0..40 * 40).map(|i| u64::from(film.samples(i % 40, i / 40))).sum();
        assert!(kept >= 600 && failure.report.energy.started == 3.0 * kept as f64, "{kept}");
        let mut cpu = CPU.tracer(&(CPU.devices)()[0], scene.clone(), &options).expect("the processor");
        let rest =
            cpu.trace(0..6, &mut film, &mut |_| ControlFlow::Continue(())).expect("the processor works");
        assert!(rest.finished && film.is_complete(6));
        assert_eq!(failure.report.energy.started + rest.energy.started, 3.0 * 6.0 * 1600.0);
    }
}

#[test]
fn a_light_beyond_the_device_is_refused_when_it_is_opened() {
    let (mut scene, settings) = view();
    // No device has images wider than 32768.
    let (image, _) = LatLong::new(40_000, 1, vec![[1.0; 3]; 40_000]).expect("a valid image");
    scene.environment = Environment::image(image);
    let scene = Arc::new(PreparedScene::new(&scene, &settings).expect("a valid scene"));
    for backend in [WGPU, VULKAN] {
        for device in (backend.devices)() {
            let error =
                backend.tracer(&device, scene.clone(), &OpenOptions::default()).err().expect("too wide");
            let message = error.to_string();
            assert!(matches!(error, Error::Device { .. }) && message.contains("40000"), "{message}");
        }
    }
}
