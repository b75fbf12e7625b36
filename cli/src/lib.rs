//! The `gemtrace` program but for its entry point.
//!
//! [`commands`] holds one module a command of the command line; each takes its parsed arguments and returns a report, so
//! that everything but parsing can be called and tested without a process. All that is no command line is the
//! library, the package `gemtrace`.

#![forbid(unsafe_code)]

mod arguments;
pub mod commands;
pub mod console;
pub mod progress;
