//! The portable GPU backend: the WGSL kernel of `spectral_core::kernel` through wgpu, on any adapter that computes
//! (Vulkan, Metal, Direct3D 12, OpenGL).
//!
//! * `device`: adapters, their limits, and what they say when they fail.
//! * `environment`: the light as a texture.
//! * `pipeline`: a prepared scene as buffers and compiled shaders.
//! * `batch`: one stretch of pixel samples on the device.
//! * `tracer`: the whole as a `Launch`, which `spectral_core::kernel::schedule` makes a picture of.
//!
//! Rays find surfaces by the facet planes of one convex stone, else by the SBVH of `accel`, both in compute shaders.
//! All arithmetic is single precision; the same scene gives the same picture as the CPU backend but for rounding.

mod batch;
mod device;
mod environment;
mod pipeline;
mod tracer;

use spectral_core::tracer::Backend;

/// The wgpu backend.
pub const WGPU: Backend = Backend {
    name: "wgpu",
    about: "any GPU through wgpu (Vulkan, Metal, Direct3D 12, OpenGL), single precision",
    devices: device::devices,
    unusable: device::unusable,
    open: tracer::open,
};

pub use device::{Gpu, adapters};
pub use environment::{Light, upload};
pub use tracer::open_on;
