//! The backends that this program was built with, and how one is chosen.

use crate::Error;
use spectral_core::{
    prepare::PreparedScene,
    probe::probe,
    tracer::{Backend, DeviceInfo, OpenOptions},
};
use std::collections::VecDeque;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// Every backend, in the order in which `auto` considers them.
static BACKENDS: &[Backend] = &[
    #[cfg(feature = "cpu")]
    backend_cpu::CPU,
    #[cfg(feature = "wgpu")]
    backend_wgpu::WGPU,
    #[cfg(feature = "vulkan")]
    backend_vulkan::VULKAN,
    #[cfg(feature = "cpu")]
    backend_cpu::REFERENCE,
];

/// The name of the processor's backend, the last that `auto` takes.
const CPU: &str = "cpu";
/// The name of the double-precision reference, which `auto` never takes.
const REFERENCE: &str = "reference";

/// The name that lets the program choose.
pub const AUTO: &str = "auto";

/// What a probe's dispatch may take: it has 192 paths to follow.
const PROBE_DEADLINE: Duration = Duration::from_secs(5);
/// What a whole probe may take; a driver that has never seen the kernel compiles it twice.
const PROBE_PATIENCE: Duration = Duration::from_secs(60);

/// Paths of one convex stone that the processor follows before a GPU is ready: its driver is loaded, its kernel
/// compiled and the probe rendered first.
const SOON: u64 = 1 << 23;

/// Every backend, in the order in which [`choose`] considers them for [`AUTO`].
pub fn backends() -> &'static [Backend] {
    BACKENDS
}

/// A backend and the device to open with it.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The backend.
    pub backend: Backend,
    /// One of its devices.
    pub device: DeviceInfo,
    /// Why this one, in one line: "cpu: wgpu llvmpipe is software; vulkan llvmpipe is software".
    pub reason: String,
}

/// The devices to render with, best first: an iterator of which the first choice is taken, and the next only if that
/// fails.
///
/// A device that was asked for is the only one. For [`AUTO`] they are probed as they come up, never before, and what
/// is found is kept nowhere: drivers change.
#[derive(Debug, Clone)]
pub struct Candidates {
    waiting: VecDeque<(Backend, DeviceInfo)>,
    /// Whether the program chooses.
    auto: bool,
    /// Whether a device that fails has a successor.
    replaced: bool,
    /// Whether GPUs were not asked for, since the processor is done before.
    soon: bool,
    patience: Duration,
}

/// [`choose_among`] the [`backends`] of this program.
///
/// ```
/// let error = gemtrace::registry::choose("gpu", None).unwrap_err();
/// assert_eq!(error.to_string(), "unknown backend 'gpu'; valid: auto, cpu, wgpu, vulkan, reference");
/// assert_eq!(error.exit_code(), 2);
/// ```
///
/// # Errors
/// As [`choose_among`].
pub fn choose(name: &str, device: Option<usize>) -> Result<Candidates, Error> {
    choose_among(BACKENDS, name, device)
}

/// The backend of a name, and of its devices the one at position `device`, the first where none is asked for. Neither
/// is ever replaced by another.
///
/// For [`AUTO`] the devices that are hardware and pass the [probe], in the order of the backends, then the
/// processor; never the reference tracer. Software GPUs are left out, since the processor does the same work with
/// less in between. A `device` then means the first of that number, and that one alone.
///
/// # Errors
/// [`Error::Usage`] for an unknown name or a device number that the backend does not have;
/// [`Error::Render`] for a backend that has no device on this machine.
pub fn choose_among(backends: &[Backend], name: &str, device: Option<usize>) -> Result<Candidates, Error> {
    let Some(backend) = known(backends, name)? else { return automatic(backends, device) };
    let waiting = VecDeque::from([(*backend, device_of(backend, device)?)]);
    Ok(Candidates { waiting, auto: false, replaced: false, soon: false, patience: PROBE_PATIENCE })
}

/// The backend of a name; `None` for [`AUTO`].
///
/// # Errors
/// [`Error::Usage`] for any other name.
pub fn known<'a>(backends: &'a [Backend], name: &str) -> Result<Option<&'a Backend>, Error> {
    if name == AUTO {
        return Ok(None);
    }
    let names = std::iter::once(AUTO).chain(backends.iter().map(|b| b.name));
    backends.iter().find(|b| b.name == name).map(Some).ok_or_else(|| unknown(name, names))
}

/// That no backend has this name. All names are listed, not only the nearest: "gpu" is near to "cpu", and means another.
pub fn unknown<'a>(name: &str, valid: impl Iterator<Item = &'a str>) -> Error {
    Error::Usage(format!("unknown backend '{name}'; valid: {}", valid.collect::<Vec<_>>().join(", ")))
}

/// [`choose_among`], for one picture of a scene: [`AUTO`] leaves a small one of a lone convex stone to the processor
/// without asking for GPUs, whose drivers alone may take as long to load as the picture takes.
///
/// # Errors
/// As [`choose_among`].
pub fn choose_for(
    scene: &PreparedScene,
    backends: &[Backend],
    name: &str,
    device: Option<usize>,
) -> Result<Candidates, Error> {
    let soon = name == AUTO && device.is_none() && is_soon(scene);
    if !soon {
        return choose_among(backends, name, device);
    }
    let processor: Vec<_> = backends.iter().filter(|b| b.name == CPU).copied().collect();
    choose_among(&processor, name, device).map(|candidates| Candidates { soon, ..candidates })
}

/// Whether the processor has a picture of a scene before a GPU would be ready.
pub fn is_soon(scene: &PreparedScene) -> bool {
    let paths = u64::from(scene.width) * u64::from(scene.height) * u64::from(scene.settings.samples);
    let paths = paths.saturating_mul(scene.wavelength_count() as u64);
    paths <= SOON && scene.lone_convex_stone().is_some()
}

fn automatic(backends: &[Backend], device: Option<usize>) -> Result<Candidates, Error> {
    let gpus = backends.iter().filter(|b| b.name != CPU && b.name != REFERENCE);
    let mut waiting: VecDeque<_> = gpus
        .flat_map(|backend| (backend.devices)().into_iter().map(|device| (*backend, device)))
        .filter(|(_, found)| device.is_none_or(|index| found.index == index))
        .collect();
    if let Some(cpu) = backends.iter().chain(BACKENDS).find(|b| b.name == CPU) {
        match device_of(cpu, device) {
            Ok(found) => waiting.push_back((*cpu, found)),
            Err(error) if waiting.is_empty() => return Err(error),
            Err(_) => {}
        }
    }
    let replaced = device.is_none();
    Ok(Candidates { waiting, auto: true, replaced, soon: false, patience: PROBE_PATIENCE })
}

fn device_of(backend: &Backend, device: Option<usize>) -> Result<DeviceInfo, Error> {
    let mut devices = (backend.devices)();
    let count = devices.len();
    let index = device.unwrap_or(0);
    if index < count {
        return Ok(devices.swap_remove(index));
    }
    if count == 0 {
        let message = "this backend finds no device on this machine; 'gemtrace devices' says why".to_owned();
        return Err(Error::Render { device: backend.name.to_owned(), message });
    }
    let has = if count == 1 { "only device 0".to_owned() } else { format!("devices 0 to {}", count - 1) };
    Err(Error::Usage(format!("backend '{}' has no device {index}; it has {has}", backend.name)))
}

impl Candidates {
    /// The same, with so long for a probe in place of a minute.
    #[must_use]
    pub fn with_patience(self, patience: Duration) -> Self {
        Candidates { patience, ..self }
    }

    /// Why a device is not for `auto`.
    fn refuse(&self, backend: &Backend, device: &DeviceInfo) -> Option<String> {
        if backend.name == CPU {
            return None;
        }
        let fault = if device.hardware {
            sound(*backend, device, self.patience).err()?
        } else {
            "is software".to_owned()
        };
        Some(format!("{} {fault}", label(device)))
    }
}

impl Iterator for Candidates {
    type Item = Choice;

    fn next(&mut self) -> Option<Choice> {
        let mut remarks = Vec::new();
        while let Some((backend, device)) = self.waiting.pop_front() {
            if self.auto
                && let Some(remark) = self.refuse(&backend, &device)
            {
                remarks.push(remark);
                continue;
            }
            let why = match (self.auto, device.hardware && backend.name != CPU) {
                (false, _) => "as asked for".to_owned(),
                (true, true) => "it is hardware and passes the probe".to_owned(),
                (true, false) if self.soon => "it is done before a GPU would be ready".to_owned(),
                (true, false) if remarks.is_empty() => "no other device is left".to_owned(),
                (true, false) => String::new(),
            };
            let why: Vec<_> = std::iter::once(why).filter(|why| !why.is_empty()).chain(remarks).collect();
            let reason = format!("{}: {}", label(&device), why.join("; "));
            if !self.replaced {
                self.waiting.clear();
            }
            return Some(Choice { backend, device, reason });
        }
        None
    }
}

/// What a device is: "processor", "GPU" or "software GPU".
pub fn kind(device: &DeviceInfo) -> &'static str {
    match device.backend {
        CPU | REFERENCE => "processor",
        _ if device.hardware => "GPU",
        _ => "software GPU",
    }
}

/// "cpu", "vulkan llvmpipe", "wgpu llvmpipe through OpenGL": what drivers add to a name in brackets is left out.
pub fn label(device: &DeviceInfo) -> String {
    let DeviceInfo { backend, api, name, .. } = device;
    if *backend == CPU {
        return CPU.to_owned();
    }
    let name = name.split(" (").next().unwrap_or_default();
    if api.is_empty() || api.eq_ignore_ascii_case(backend) {
        return format!("{backend} {name}");
    }
    format!("{backend} {name} through {api}")
}

/// Probes a device, in a thread of its own, which is left behind if the driver never returns.
fn sound(backend: Backend, device: &DeviceInfo, patience: Duration) -> Result<(), String> {
    let (sender, receiver) = mpsc::channel();
    let device = device.clone();
    std::thread::spawn(move || {
        let options = OpenOptions { deadline: Some(PROBE_DEADLINE.min(patience)), ..OpenOptions::default() };
        // The receiver is gone when its patience is.
        let _ = sender.send(probe(&backend, &device, &options));
    });
    match receiver.recv_timeout(patience) {
        Ok(Ok(())) => Ok(()),
        Ok(Err(spectral_core::Error::Device { message, .. })) => Err(format!("fails: {message}")),
        Ok(Err(error)) => Err(format!("fails: {error}")),
        Err(RecvTimeoutError::Timeout) => {
            Err(format!("fails: the probe has not ended after {} seconds", patience.as_secs_f64()))
        }
        Err(RecvTimeoutError::Disconnected) => Err("fails: the probe panicked".to_owned()),
    }
}
