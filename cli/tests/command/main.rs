//! The commands: through the library, where figures are checked, and through the binary, where exit
//! codes, streams and signals are. From `kill` to `troubles`: batches.

mod bench;
mod binary;
mod facts;
mod failure;
mod measure;
mod mesh;
mod motion;
mod picture;
mod read;
mod setting;
mod sheet;
mod trust;

mod kill;
mod merge;
mod share;
mod sweep;
mod troubles;

#[path = "../../../gemtrace/tests/support/mod.rs"]
mod messages;
mod support;
