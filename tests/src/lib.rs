//! Shared by the whole-renderer tests: solids and lights with known answers, one way to render on every device, and the
//! statistics by which pictures are compared.
//!
//! The tests themselves are in `tests/`. Each states the equation that it checks.

#![forbid(unsafe_code)]

pub mod agreement;
pub mod cases;
pub mod compare;
pub mod crystals;
pub mod device;
pub mod gpu;
pub mod image;
pub mod light;
pub mod mitsuba;
pub mod render;
pub mod scene;
pub mod solid;

/// What most tests use.
pub mod prelude {
    pub use crate::{compare::Difference, light::*, render::*, scene::*, solid::*};
    pub use backend_cpu::{CPU, REFERENCE};
    pub use glam::{DMat3, DVec3};
    pub use spectral_core::{
        Error,
        camera::{Camera, Projection},
        environment::{Environment, LatLong},
        film::Film,
        prepare::PreparedScene,
        scene::{Background, Scene, Stone},
        settings::{Leftover, RenderSettings},
        tracer::{Backend, DeviceInfo, OpenOptions, Progress, TraceReport, Tracer},
        wavelength::WavelengthGrid,
    };
    pub use std::{ops::ControlFlow, sync::Arc};
}
