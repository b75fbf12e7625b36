//! Spectral maths for gemstones.

pub mod absorption;
pub mod cie;
pub mod color;
pub mod dispersion;
mod error;
pub mod fresnel;
pub mod material;
mod real;
pub mod spectrum;
pub mod stokes;
pub mod upsample;
mod warning;
pub mod wavelength;

#[cfg(feature = "render")]
pub mod camera;
#[cfg(feature = "render")]
pub mod cut;
#[cfg(feature = "render")]
pub mod environment;
#[cfg(feature = "render")]
pub mod film;
#[cfg(feature = "render")]
pub mod mesh;
#[cfg(feature = "render")]
pub mod prepare;
#[cfg(feature = "render")]
pub mod scene;
#[cfg(feature = "render")]
pub mod settings;
#[cfg(feature = "render")]
pub mod shape;
#[cfg(feature = "render")]
pub mod tracer;

pub use error::{Error, nearest_name};
pub use real::Real;
pub use warning::Warning;
