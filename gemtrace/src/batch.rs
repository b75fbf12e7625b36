//! Many pictures from one command: a plan of scenes, rendered one by one, each remembered once it is on the disk.
//!
//! ```text
//! sweep file ──► sweep ──► Plan ──► run: scene_file ► rendering ► output ──► pictures, manifest
//!  turntable ──────────────┘          (a shard of it)                            └► merge ► sheet
//! ```
//!
//! * [`Plan`]: what is to be rendered, a list of named scenes with the options of their pictures. [`sweep`] makes one
//!   of a sweep file; any other list will do.
//! * [`run`] renders what is missing or has changed, and nothing else. It may be killed at any moment.
//! * [`manifest`]: what has been rendered, one line an item, from which the next run knows where to go on.
//! * [`Shard`]: a share of a plan for one of several machines, which have nothing in common but the output folder.
//! * [`merge`] finds out whether all is there and whole; [`sheet`] shows it.

pub mod manifest;
pub mod merge;
mod plan;
mod runner;
pub mod shard;
pub mod sheet;
pub mod sweep;

pub(crate) use plan::plain;
pub use plan::{Item, Pictures, Plan};
pub use runner::{Observer, Place, Summary, run};
pub use shard::{Portion, Shard};
