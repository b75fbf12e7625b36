//! What takes part: every device, and every form of intersection that it offers.

use backend_vulkan::{Intersection, VULKAN};
use gemtrace::{Error, registry};
use spectral_core::prepare::PreparedScene;
use spectral_core::tracer::{Backend, DeviceInfo};

/// A device with the way in which its rays find surfaces.
#[derive(Debug, Clone)]
pub struct Entrant {
    pub backend: Backend,
    pub device: DeviceInfo,
    /// The backend's name, with the device's number where there may be several: `"vulkan 0"`.
    pub label: String,
    /// Whether the backend was held to a form of intersection; else it chooses by the scene.
    pub held: bool,
}

/// The entrants of the backends named; of all but the reference where none is.
///
/// A Vulkan device enters once as the backend chooses, and once for each [`Intersection`] that it offers.
///
/// # Errors
/// [`Error::Usage`] for a name that no backend has; [`Error::Render`] for a named backend without a device.
pub fn entrants(names: &[String]) -> Result<Vec<Entrant>, Error> {
    let all = registry::backends();
    for name in names {
        if !all.iter().any(|b| b.name == name) {
            return Err(registry::unknown(name, all.iter().map(|b| b.name)));
        }
    }
    let mut entrants = Vec::new();
    for backend in all {
        let named = names.iter().any(|name| name == backend.name);
        if named || (names.is_empty() && backend.name != backend_cpu::REFERENCE.name) {
            let found = of_backend(backend);
            if named && found.is_empty() {
                let message = "this backend finds no device on this machine; 'gemtrace devices' lists all";
                return Err(Error::Render { device: backend.name.to_owned(), message: message.to_owned() });
            }
            entrants.extend(found);
        }
    }
    Ok(entrants)
}

fn of_backend(backend: &Backend) -> Vec<Entrant> {
    let entrant = |backend: &Backend, device: DeviceInfo, held| Entrant {
        label: if runs_on_processor(&device) {
            backend.name.to_owned()
        } else {
            format!("{} {}", backend.name, device.index)
        },
        backend: *backend,
        device,
        held,
    };
    let mut all: Vec<_> = (backend.devices)().into_iter().map(|d| entrant(backend, d, false)).collect();
    if backend.name == VULKAN.name {
        for form in Intersection::ALL.map(Intersection::backend) {
            all.extend((form.devices)().into_iter().map(|d| entrant(&form, d, true)));
        }
        all.sort_by_key(|e| e.device.index);
    }
    all
}

/// Whether a device is the processor itself, by one of the backends made for it.
fn runs_on_processor(device: &DeviceInfo) -> bool {
    [backend_cpu::CPU.name, backend_cpu::REFERENCE.name].contains(&device.backend)
}

impl Entrant {
    /// Whether this is the backend that the others are compared with.
    pub fn is_yardstick(&self) -> bool {
        self.backend.name == backend_cpu::CPU.name
    }

    /// Whether this only stands for a GPU: a driver that computes on the processor.
    pub fn is_software(&self) -> bool {
        !self.device.hardware
    }

    /// `"GPU"`, `"software"` or `"processor"`.
    pub fn kind(&self) -> &'static str {
        if self.is_software() {
            "software"
        } else if runs_on_processor(&self.device) {
            "processor"
        } else {
            "GPU"
        }
    }

    /// How rays find the surfaces of a scene.
    pub fn intersection(&self, scene: &PreparedScene) -> &'static str {
        let reference = self.backend.name == backend_cpu::REFERENCE.name;
        if self.held || reference {
            self.device.intersection
        } else if scene.lone_convex_stone().is_some() {
            "facet planes"
        } else {
            "SBVH"
        }
    }

    /// Whether there is anything to learn from this entrant on a scene: what a Vulkan device chooses where facet
    /// planes do not apply is one of its forms, which enters by itself.
    pub fn enters(&self, scene: &PreparedScene) -> bool {
        self.backend.name != VULKAN.name || self.held || scene.lone_convex_stone().is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_but_the_reference_enter_unless_named() {
        let names = |asked: &[&str]| -> Vec<_> {
            let asked: Vec<String> = asked.iter().map(ToString::to_string).collect();
            entrants(&asked).unwrap().iter().map(|e| e.label.clone()).collect()
        };
        assert!(names(&[]).contains(&"cpu".to_owned()) && !names(&[]).contains(&"reference".to_owned()));
        assert_eq!(names(&["reference", "cpu", "cpu"]), ["cpu", "reference"]);
        let error = entrants(&["vulcan".to_owned()]).unwrap_err();
        assert_eq!(error.to_string(), "unknown backend 'vulcan'; valid: cpu, wgpu, vulkan, reference");
    }
}
