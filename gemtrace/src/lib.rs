#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

#[cfg(feature = "batch")]
pub mod batch;
mod error;
pub mod import;
pub mod measure;
pub mod output;
#[cfg(feature = "batch")]
pub mod part;
pub mod plot;
pub mod quantity;
pub mod registry;
pub mod scene_file;
#[cfg(feature = "batch")]
pub mod sequence;
pub mod session;
pub mod shade;
pub mod shard;
#[cfg(feature = "batch")]
pub mod sheet;
pub mod tier;
#[cfg(feature = "view")]
pub mod view;

pub use error::Error;
pub use session::{Session, Watch};
/// The scenes, materials and numbers that this library is built on.
pub use spectral_core;
