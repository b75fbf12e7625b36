//! The devices of this machine on which trials run.
//!
//! `REQUIRE_BACKENDS=cpu,wgpu,vulkan` makes a missing device of a named backend a failure; otherwise its trial is ignored.
//! A Vulkan device need not support every form of intersection: `vulkan/ray-query`, `vulkan/ray-tracing-pipeline` and
//! `vulkan/software` require that some device supports that form.

use backend_cpu::CPU;
use backend_vulkan::{Intersection, VULKAN};
use backend_wgpu::WGPU;
use libtest_mimic::Trial;
use spectral_core::tracer::{Backend, DeviceInfo};

/// A device with one form of intersection.
#[derive(Clone)]
pub struct Target {
    /// "cpu", "wgpu/llvmpipe", "vulkan/llvmpipe/ray-query"; "vulkan/llvmpipe" if the scene decides on the form.
    pub name: String,
    /// The backend.
    pub backend: Backend,
    /// The device.
    pub device: DeviceInfo,
}

/// The devices of every backend and form of intersection except the reference. For each of these without a device there
/// is a trial, which fails if the device is required and is ignored otherwise.
pub fn targets() -> (Vec<Target>, Vec<Trial>) {
    let without_device = (VULKAN.devices)().is_empty() && is_required(VULKAN.name);
    let vulkan = Intersection::ALL
        .map(|form| (form.backend(), required_name(form), Some(form.name()), without_device));
    let plain = [CPU, WGPU, VULKAN].map(|backend| (backend, backend.name, None, false));
    let (mut present, mut absent) = (Vec::new(), Vec::new());
    for (backend, name, form, missing) in plain.into_iter().chain(vulkan) {
        let devices = (backend.devices)();
        if devices.is_empty() {
            let missing = missing || is_required(name);
            let none =
                Trial::test(format!("[{name}] has a device"), || Err("no device on this machine".into()));
            absent.push(none.with_ignored_flag(!missing));
        }
        present.extend(devices.into_iter().map(|device| Target {
            name: short(&device, form),
            backend,
            device,
        }));
    }
    (present, absent)
}

/// Whether `REQUIRE_BACKENDS` names a backend or form.
pub fn is_required(name: &str) -> bool {
    let required = std::env::var("REQUIRE_BACKENDS").unwrap_or_default();
    required.split(',').any(|wanted| wanted.trim() == name)
}

/// The name of a form in `REQUIRE_BACKENDS`.
fn required_name(form: Intersection) -> &'static str {
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
