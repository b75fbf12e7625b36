//! The backends that this program was built with, and how one is chosen.

use crate::Error;
use spectral_core::tracer::{Backend, DeviceInfo};

/// Every backend, in the order in which `auto` considers them.
static BACKENDS: [Backend; 4] =
    [backend_cpu::CPU, backend_wgpu::WGPU, backend_vulkan::VULKAN, backend_cpu::REFERENCE];

/// The name that lets the program choose.
pub const AUTO: &str = "auto";

/// Every backend, in the order in which [`choose`] considers them for [`AUTO`].
pub fn backends() -> &'static [Backend] {
    &BACKENDS
}

/// A backend and the device to open with it.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The backend.
    pub backend: &'static Backend,
    /// One of its devices.
    pub device: DeviceInfo,
}

/// The backend of a name, or for [`AUTO`] the first that has a device; and of its devices the one at
/// position `device`, the first where none is asked for.
///
/// `auto` never takes the reference tracer, and a backend or device that is named is never replaced by
/// another.
///
/// ```
/// let error = gemtrace::registry::choose("cpi", None).unwrap_err();
/// assert_eq!(error.to_string(), "unknown backend 'cpi'; did you mean 'cpu'?");
/// assert_eq!(error.exit_code(), 2);
/// ```
///
/// # Errors
/// [`Error::Usage`] for an unknown name or a device number that the backend does not have;
/// [`Error::Render`] for a backend that has no device on this machine.
pub fn choose(name: &str, device: Option<usize>) -> Result<Choice, Error> {
    if name == AUTO {
        let candidates = BACKENDS.iter().filter(|b| b.name != backend_cpu::REFERENCE.name);
        let first = candidates.map(|backend| device_of(backend, device)).find(Result::is_ok);
        return first.unwrap_or_else(|| device_of(&backend_cpu::CPU, device));
    }
    let names = || std::iter::once(AUTO).chain(BACKENDS.iter().map(|b| b.name));
    let unknown = || Error::Usage(spectral_core::Error::unknown("backend", name, names()).to_string());
    device_of(BACKENDS.iter().find(|b| b.name == name).ok_or_else(unknown)?, device)
}

fn device_of(backend: &'static Backend, device: Option<usize>) -> Result<Choice, Error> {
    let mut devices = (backend.devices)();
    let count = devices.len();
    let index = device.unwrap_or(0);
    if index < count {
        return Ok(Choice { backend, device: devices.swap_remove(index) });
    }
    if count == 0 {
        let message = "this backend finds no device on this machine; 'gemtrace devices' lists all".to_owned();
        return Err(Error::Render { device: backend.name.to_owned(), message });
    }
    let has = if count == 1 { "only device 0".to_owned() } else { format!("devices 0 to {}", count - 1) };
    Err(Error::Usage(format!("backend '{}' has no device {index}; it has {has}", backend.name)))
}
