//! Renders gemstones spectrally, without noise: from scene files, or from scenes built in code, to pictures and numbers.
//!
//! ```text
//! scene file ──► scene_file ──► PreparedScene ──► rendering: Tracers ──► Film ──► output
//!      import ──┘                                                                 PNG, EXR
//! ```
//!
//! [`scene_file`] and [`import`] read, [`output`] and [`plot`] write, [`registry`] knows the
//! backends, [`rendering`] fills a film with them, [`measure`] makes numbers of
//! films. [`batch`] renders many scenes, which [`sequence`] makes of one;
//! [`share`] renders one scene on many machines.
//!
//! Each backend is a feature of this package: `cpu`, `wgpu`, `vulkan`; all are on by default.

#![forbid(unsafe_code)]

pub mod batch;
mod error;
pub mod import;
pub mod measure;
pub mod output;
pub mod plot;
pub mod quantity;
pub mod registry;
pub mod rendering;
pub mod scene_file;
pub mod sequence;
pub mod shade;
pub mod share;
pub mod sheet;

pub use error::Error;
