//! One answer from every backend: each scene of the gallery, on each device of this machine, against the
//! double-precision oracle.
//!
//! Samples and wavelengths are the same everywhere, so pictures are compared pixel by pixel. At the edges of facets
//! two sound renderers may fall on different sides, hence the share of pixels that may be off.
//!
//! `REQUIRE_BACKENDS=cpu,wgpu,vulkan` makes it a failure if a backend named has no device here; else it is left out,
//! and said so. A Vulkan device need not have every form of intersection: `vulkan/ray-query`,
//! `vulkan/ray-tracing-pipeline` and `vulkan/software` demand that some device has that form.

use backend_cpu::{CPU, REFERENCE};
use backend_vulkan::{Intersection, VULKAN};
use backend_wgpu::WGPU;
use gemtrace_tests::{
    agreement::Agreement,
    gallery::{Exhibit, gallery},
};
use libtest_mimic::{Arguments, Failed, Trial};
use spectral_core::{
    film::Film,
    prepare::PreparedScene,
    tracer::{Backend, DeviceInfo, OpenOptions},
};
use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

/// A scene with the oracle's picture of it, made once.
struct Case {
    exhibit: Exhibit,
    expected: OnceLock<Film>,
}

fn main() {
    let arguments = Arguments::from_args();
    let cases: Vec<_> =
        gallery().into_iter().map(|exhibit| Arc::new(Case { exhibit, expected: OnceLock::new() })).collect();
    let required = std::env::var("REQUIRE_BACKENDS").unwrap_or_default();
    let mut trials = Vec::new();
    let demanded = |name: &str| required.split(',').any(|wanted| wanted.trim() == name);
    let formless = (VULKAN.devices)().is_empty() && demanded(VULKAN.name);
    let vulkan = Intersection::ALL.map(|form| (form.backend(), demand(form), formless));
    let plain = [CPU, WGPU].map(|backend| (backend, backend.name, false));
    for (backend, name, missing) in plain.into_iter().chain(vulkan) {
        let devices = (backend.devices)();
        if devices.is_empty() {
            let missing = missing || demanded(name);
            let none =
                Trial::test(format!("[{name}] has a device"), || Err("no device on this machine".into()));
            trials.push(none.with_ignored_flag(!missing));
        }
        for device in devices {
            for case in &cases {
                let name = format!("[{}] {}", short(&device), case.exhibit.name);
                let (case, device) = (case.clone(), device.clone());
                trials.push(Trial::test(name, move || agree(&case, &backend, &device)));
            }
        }
    }
    libtest_mimic::run(&arguments, trials).exit();
}

/// How `REQUIRE_BACKENDS` names a form.
fn demand(form: Intersection) -> &'static str {
    match form {
        Intersection::RayQuery => "vulkan/ray-query",
        Intersection::Pipeline => "vulkan/ray-tracing-pipeline",
        Intersection::Software => "vulkan/software",
    }
}

/// "cpu", "wgpu/llvmpipe", "vulkan/llvmpipe/ray-query".
fn short(device: &DeviceInfo) -> String {
    let word = device.name.split_whitespace().next().unwrap_or("?");
    let mut name = device.backend.to_owned();
    if device.backend != CPU.name {
        name = format!("{name}/{word}");
    }
    if device.backend == VULKAN.name {
        name = format!("{name}/{}", device.intersection.replace(' ', "-"));
    }
    name
}

fn render(backend: &Backend, device: &DeviceInfo, exhibit: &Exhibit) -> Result<Film, Failed> {
    let prepared = Arc::new(PreparedScene::new(&exhibit.scene, &exhibit.settings)?);
    let mut film = Film::new(&prepared);
    let mut tracer = (backend.open)(device, prepared, &OpenOptions::default())?;
    let report = tracer.trace(0..exhibit.settings.samples, &mut film, &mut |_| ControlFlow::Continue(()))?;
    // Of the stones here none is damaged: no light may leave by a surface that rounding hid.
    let lost = report.energy.lost / report.energy.started;
    if report.finished && lost < 1e-6 { Ok(film) } else { Err(format!("{report:?}").into()) }
}

fn agree(case: &Case, backend: &Backend, device: &DeviceInfo) -> Result<(), Failed> {
    let exhibit = &case.exhibit;
    let expected = match case.expected.get() {
        Some(film) => film,
        None => {
            let film = render(&REFERENCE, &(REFERENCE.devices)()[0], exhibit)?;
            case.expected.get_or_init(|| film)
        }
    };
    let found = render(backend, device, exhibit)?;
    let agreement = Agreement::of(exhibit, expected, &found);
    let trial = format!("[{}] {}", short(device), exhibit.name);
    eprintln!("{trial}: {agreement}");
    if agreement.holds() {
        return Ok(());
    }
    let folder = agreement.keep(&trial, expected, &found)?;
    Err(format!("{agreement}; see {}", folder.display()).into())
}
