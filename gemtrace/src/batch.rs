//! Many pictures from one command: a plan of scenes, rendered one by one, each remembered once it is on the disk.
//!
//! ```text
//! sweep file ──► sweep ──► Plan ──► run: scene_file ► session ► output ──► pictures, manifest
//!  turntable ──────────────┘          (a shard of it)                          └► merge ► page
//! ```
//!
//! * [`Plan`]: what is to be rendered, a list of named scenes with the options of their pictures. [`sweep`] makes one
//!   of a sweep file; any other list will do.
//! * [`run`] renders what is missing or has changed, and nothing else. It may be killed at any moment.
//! * [`manifest`]: what has been rendered, one line an item, from which the next run knows where to go on.
//! * A [`Shard`](crate::shard::Shard) of a plan is for one of several machines, which share nothing but the output folder.
//! * [`merge`] finds out whether all is there and whole; [`page`] shows it.

pub mod entry;
pub mod manifest;
pub mod merge;
pub mod page;
mod plan;
mod runner;
pub mod sweep;

pub(crate) use plan::plain;
pub use plan::{Item, Pictures, Plan};
pub use runner::{Observer, Place, Summary, run};
