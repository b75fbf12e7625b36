//! The commands: through the library, where figures are checked, and through the binary, where exit
//! codes, streams and signals are.

mod bench;
mod binary;
mod facts;
mod failure;
mod motion;
mod picture;
mod read;
mod setting;
mod sheet;
mod support;
