//! Every way in which this machine can render, as trials see it.
//!
//! `REQUIRE_BACKENDS=cpu,wgpu,vulkan` makes it a failure if a backend named has no device here; else it is left out,
//! and said so. A Vulkan device need not have every form of intersection: `vulkan/ray-query`,
//! `vulkan/ray-tracing-pipeline` and `vulkan/software` demand that some device has that form.

use backend_cpu::CPU;
use backend_vulkan::{Intersection, VULKAN};
use backend_wgpu::WGPU;
use libtest_mimic::Trial;
use spectral_core::tracer::{Backend, DeviceInfo};

/// A device by one way to find surfaces.
#[derive(Clone)]
pub struct Way {
    /// "cpu", "wgpu/llvmpipe", "vulkan/llvmpipe/ray-query"; "vulkan/llvmpipe" where the scene decides on the form.
    pub name: String,
    /// Opens it.
    pub backend: Backend,
    /// The device.
    pub device: DeviceInfo,
}

/// The devices of every backend and form of intersection but the oracle; and for each of these that has none a trial
/// which fails if it is required, and is ignored if not.
pub fn ways() -> (Vec<Way>, Vec<Trial>) {
    let required = std::env::var("REQUIRE_BACKENDS").unwrap_or_default();
    let demanded = |name: &str| required.split(',').any(|wanted| wanted.trim() == name);
    let formless = (VULKAN.devices)().is_empty() && demanded(VULKAN.name);
    let vulkan = Intersection::ALL.map(|form| (form.backend(), demand(form), Some(form.name()), formless));
    let plain = [CPU, WGPU, VULKAN].map(|backend| (backend, backend.name, None, false));
    let (mut present, mut absent) = (Vec::new(), Vec::new());
    for (backend, name, form, missing) in plain.into_iter().chain(vulkan) {
        let devices = (backend.devices)();
        if devices.is_empty() {
            let missing = missing || demanded(name);
            let none =
                Trial::test(format!("[{name}] has a device"), || Err("no device on this machine".into()));
            absent.push(none.with_ignored_flag(!missing));
        }
        present.extend(devices.into_iter().map(|device| Way { name: short(&device, form), backend, device }));
    }
    (present, absent)
}

/// How `REQUIRE_BACKENDS` names a form.
fn demand(form: Intersection) -> &'static str {
    match form {
        Intersection::RayQuery => "vulkan/ray-query",
        Intersection::Pipeline => "vulkan/ray-tracing-pipeline",
        Intersection::Software => "vulkan/software",
    }
}

fn short(device: &DeviceInfo, form: Option<&str>) -> String {
    let mut name = device.backend.to_owned();
    if device.backend != CPU.name {
        let word = device.name.split_whitespace().next().unwrap_or("?");
        name = format!("{name}/{word}");
    }
    form.map_or(name.clone(), |form| format!("{name}/{}", form.replace(' ', "-")))
}
