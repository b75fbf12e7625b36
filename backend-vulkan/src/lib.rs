//! The Vulkan backend: the WGSL kernel of `spectral_core::kernel`, compiled by naga, with the device's own ray tracing.
//!
//! * `physical`: the loader, physical devices, and what they offer or lack.
//! * `device`: an open device.
//! * `submission`: commands that the device works on while the host goes on.
//! * `memory`: buffers and images.
//! * `acceleration_structure`: the driver's hierarchy over our triangles.
//! * `shader`: WGSL to SPIR-V.
//! * `pipeline`: a compiled entry point, and what is bound to it.
//! * `binding_table`: the shaders of a ray-tracing pipeline, as rays find them.
//! * `kernel`: a prepared scene on the device.
//! * `tracer`: an open device that shows scene after scene, and its batches.
//!
//! Rays find surfaces in one of the forms of [`Intersection`], the best that the device offers unless one is asked for
//! ([`Intersection::backend`], [`open_with`]). A device needs Vulkan 1.3. The loader is found at run time: without one there are no devices.
//!
//! # Unsafe code
//! Every call of the API is unsafe. What they ask for falls into a few rules, which the comments refer to:
//! * **alive**: handles passed were created from the same device and are destroyed by the `Drop` of the value that
//!   owns them. Whatever owns one holds its `Gpu` too, so the device goes last.
//! * **idle**: what the host writes, reads or destroys is used by no submission that may still be under way: uploads are
//!   waited for, and what a batch has for itself is touched only before it is sent and after it has ended. A `Submission`
//!   waits for its end when it is dropped, and stands before what it uses. If a wait fails or the device hangs, the
//!   device counts as failed for good and what it may still use is leaked.
//! * **valid**: structures are filled as the specification asks, with lifetimes that the borrow checker sees.

mod acceleration_structure;
mod binding_table;
mod device;
mod kernel;
mod memory;
mod physical;
mod pipeline;
mod shader;
mod submission;
mod tracer;

pub use tracer::{open_guessing, open_with};

use spectral_core::{kernel::facets::Guess, tracer::Backend};

/// The Vulkan backend.
pub const VULKAN: Backend = Backend {
    name: "vulkan",
    about: "GPUs through Vulkan 1.3, with their ray tracing where they have it, single precision",
    devices: physical::devices,
    unusable: physical::unusable,
    areas: false,
    open: tracer::open,
};

/// The Vulkan backend held to one form of meeting one convex stone by its planes: only the devices that have it.
///
/// ```
/// use spectral_core::kernel::facets::Guess;
/// let all = (backend_vulkan::VULKAN.devices)().len();
/// assert_eq!((backend_vulkan::guessing(Guess::Start).devices)().len(), all);
/// assert!((backend_vulkan::guessing(Guess::Subgroup).devices)().len() <= all);
/// ```
pub fn guessing(guess: Guess) -> Backend {
    match guess {
        Guess::Nothing => {
            Backend { open: |device, options| open_guessing(Guess::Nothing, device, options), ..VULKAN }
        }
        Guess::Start => {
            Backend { open: |device, options| open_guessing(Guess::Start, device, options), ..VULKAN }
        }
        Guess::Subgroup => Backend {
            devices: physical::devices_with_subgroups,
            open: |device, options| open_guessing(Guess::Subgroup, device, options),
            ..VULKAN
        },
    }
}

/// How rays find surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Intersection {
    /// Ray queries from a compute shader.
    RayQuery,
    /// A ray-tracing pipeline, whose ray-generation shader follows the paths.
    Pipeline,
    /// The SBVH of `accel`, traversed in a compute shader.
    Software,
}

impl Intersection {
    /// Every form, the best first.
    pub const ALL: [Intersection; 3] =
        [Intersection::RayQuery, Intersection::Pipeline, Intersection::Software];

    /// The Vulkan backend held to this form: only the devices that offer it, and used whatever the scene.
    ///
    /// ```
    /// use backend_vulkan::Intersection;
    /// for device in (Intersection::RayQuery.backend().devices)() {
    ///     assert_eq!(device.intersection, "ray query");
    /// }
    /// ```
    pub fn backend(self) -> Backend {
        match self {
            Intersection::RayQuery => Backend {
                devices: || physical::devices_with(Intersection::RayQuery),
                open: |device, options| open_with(Intersection::RayQuery, device, options),
                ..VULKAN
            },
            Intersection::Pipeline => Backend {
                devices: || physical::devices_with(Intersection::Pipeline),
                open: |device, options| open_with(Intersection::Pipeline, device, options),
                ..VULKAN
            },
            Intersection::Software => Backend {
                devices: || physical::devices_with(Intersection::Software),
                open: |device, options| open_with(Intersection::Software, device, options),
                ..VULKAN
            },
        }
    }

    /// Its name, for people.
    pub fn name(self) -> &'static str {
        match self {
            Intersection::RayQuery => "ray query",
            Intersection::Pipeline => "ray-tracing pipeline",
            Intersection::Software => "software BVH in compute",
        }
    }
}
