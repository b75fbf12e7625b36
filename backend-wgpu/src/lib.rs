//! The portable GPU backend: the WGSL kernel of `spectral_core::kernel` through wgpu, on any adapter that computes
//! (Vulkan, Metal, Direct3D 12, OpenGL).
//!
//! * `device`: adapters, their limits, and what they say when they fail.
//! * `environment`: the light as a texture.
//! * `pipeline`: a prepared scene as buffers and compiled shaders.
//! * `batch`: batches on the device.
//! * `tracer`: an open adapter, and its `Launch`, which `spectral_core::kernel::schedule` makes a picture of.
//!
//! Rays find surfaces by the facet planes of one convex stone, else by the SBVH of `accel`, both in compute shaders.
//! All arithmetic is single precision; the same scene gives the same picture as the CPU backend but for rounding.

mod batch;
mod device;
mod environment;
mod pipeline;
mod tracer;

use spectral_core::{kernel::facets::Guess, tracer::Backend};

/// The wgpu backend.
pub const WGPU: Backend = Backend {
    name: "wgpu",
    about: "any GPU through wgpu (Vulkan, Metal, Direct3D 12, OpenGL), single precision",
    devices: device::devices,
    unusable: device::unusable,
    areas: false,
    open: tracer::open,
};

/// The wgpu backend held to one form of meeting one convex stone: only the devices that have it.
///
/// ```
/// use spectral_core::kernel::facets::Guess;
/// let all = (backend_wgpu::WGPU.devices)().len();
/// assert_eq!((backend_wgpu::guessing(Guess::Start).devices)().len(), all);
/// assert!((backend_wgpu::guessing(Guess::Subgroup).devices)().len() <= all);
/// ```
pub fn guessing(guess: Guess) -> Backend {
    match guess {
        Guess::Nothing => {
            Backend { open: |device, options| open_guessing(Guess::Nothing, device, options), ..WGPU }
        }
        Guess::Start => {
            Backend { open: |device, options| open_guessing(Guess::Start, device, options), ..WGPU }
        }
        Guess::Subgroup => Backend {
            devices: device::devices_with_subgroups,
            open: |device, options| open_guessing(Guess::Subgroup, device, options),
            ..WGPU
        },
    }
}

pub use device::{Gpu, adapters};
pub use environment::{Light, upload};
pub use tracer::{open_guessing, open_on};
