//! Batches: sweeps, runs that are killed and go on, items that fail, shards and their merging.

mod kill;
mod merge;
mod share;
mod support;
mod sweep;
mod troubles;
