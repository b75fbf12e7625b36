//! The CPU backend of gemtrace, and the oracle that all backends are held to.
//!
//! * [`CPU`]: single precision, rayon over tiles. One convex stone is traced against its facet planes, sixteen
//!   wavelengths at a time in the best [`Instructions`] that the machine has (`chain`), one convex crystal any sixteen rays at a
//!   time (`stream`); anything else through the SBVH of `accel` (`tree`).
//! * [`REFERENCE`]: double precision, every triangle tested for every ray, nothing clever. Slow, simple, and
//!   what the others are compared with.
//!
//! Both give the same bits for any number of threads and any tile size.

#![forbid(unsafe_code)]

mod account;
mod basis;
mod beam;
mod block;
mod chain;
mod crystal;
mod entry;
mod environment;
mod incidence;
#[cfg(feature = "measure")]
pub mod measure;
mod medium;
mod planes;
mod reference;
mod schedule;
mod stream;
mod sums;
mod surface;
mod throughput;
mod tracer;
mod tree;

pub use accel::Instructions;
pub use reference::heaviest::{Chain, Event, Kind, first_facet, heaviest};
use spectral_core::tracer::{Backend, DeviceInfo};

/// The CPU backend.
pub const CPU: Backend = Backend {
    name: "cpu",
    about: "this machine's processor, single precision",
    devices: || vec![device("cpu", "SBVH, or facet planes for one convex stone")],
    unusable: Vec::new,
    areas: true,
    open: tracer::open,
};

/// The oracle: double precision and brute force.
pub const REFERENCE: Backend = Backend {
    name: "reference",
    about: "double precision, every surface tested: slow, the others are held to it",
    devices: || vec![device("reference", "every triangle, double precision")],
    unusable: Vec::new,
    areas: true,
    open: reference::open,
};

/// [`CPU`] confined to an instruction set; on a machine without it, to the portable one. For tests and benchmarks:
/// `CPU` itself takes [`Instructions::best`].
pub fn cpu_in(instructions: Instructions) -> Backend {
    let open = match instructions {
        Instructions::Avx512 => tracer::open_avx512,
        Instructions::Avx2 => tracer::open_avx2,
        Instructions::Portable => tracer::open_portable,
    };
    Backend { open, ..CPU }
}

fn device(backend: &'static str, intersection: &'static str) -> DeviceInfo {
    DeviceInfo {
        backend,
        index: 0,
        // Without the number of threads: a scheduler may allow this process fewer than the machine has, and the name
        // goes into pictures, which are the same for any number.
        name: format!("{} CPU", std::env::consts::ARCH),
        driver: String::new(),
        api: "",
        memory: 0,
        intersection,
        hardware: true,
    }
}
