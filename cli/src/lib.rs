//! The `gemtrace` program as a library: scene files, imports, the commands and their pictures.
//!
//! ```text
//! scene file ──► scene_file ──► PreparedScene ──► rendering: Tracers ──► Film ──► output
//!      import ──┘                                                                 PNG, EXR
//! ```
//!
//! [`commands`] holds one module a command of the command line; each takes its parsed arguments and
//! returns a report, so that everything but parsing can be called and tested without a process.
//! [`scene_file`] and [`import`] read, [`output`] and [`plot`] write, [`registry`] knows the
//! backends, [`rendering`] fills a film with them, [`measure`] makes numbers of
//! films. [`batch`] renders many scenes, which [`sequence`] makes of one;
//! [`share`] renders one scene on many machines.

pub mod batch;
pub mod commands;
pub mod effort;
mod error;
pub mod import;
pub mod measure;
pub mod output;
pub mod plot;
pub mod progress;
pub mod registry;
pub mod rendering;
pub mod scene_file;
pub mod sequence;
pub mod shade;
pub mod share;
pub mod sheet;

pub use error::Error;
