//! How a command and a person exchange remarks, a report, and a request to stop.

use gemtrace::Error;
use serde_json::{Value, json};
use spectral_core::{printable, shown_lines};
use std::io::Write;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// A request to stop, shared with the handler of Ctrl-C.
///
/// While a render runs, a request makes it stop and write what is finished. At any other time there is
/// nothing to save, and the handler may end the process at once; it may do so, too, where the work does not hear.
#[derive(Debug, Default)]
pub struct Interrupt {
    requested: AtomicBool,
    heeded: AtomicBool,
    heard: AtomicBool,
}

impl Interrupt {
    /// Asks to stop. Returns whether something will heed it; if not, or on a second request, the caller
    /// may end the process.
    pub fn request(&self) -> bool {
        !self.requested.swap(true, Relaxed) && self.heeded.load(Relaxed)
    }

    /// Whether someone has asked to stop; who asks is taken to act on it.
    pub fn is_requested(&self) -> bool {
        let requested = self.requested.load(Relaxed);
        if requested {
            self.heard.store(true, Relaxed);
        }
        requested
    }

    /// Waits until the work hears of the request; returns whether it did so within `patience`.
    pub fn is_heard_within(&self, patience: Duration) -> bool {
        let start = Instant::now();
        while !self.heard.load(Relaxed) {
            if start.elapsed() > patience {
                return false;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        true
    }

    /// [`ControlFlow::Break`] once someone has asked to stop.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.is_requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// From now on requests are looked at.
    pub fn heed(&self) {
        self.heeded.store(true, Relaxed);
    }
}

/// What a command has to say.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// For people, without a final line break.
    pub text: String,
    /// The same facts for scripts.
    pub json: Value,
    /// A failure, where there is a report all the same.
    pub failure: Option<Error>,
}

impl Report {
    /// The report of a command that did all it was asked to.
    pub fn new(text: impl Into<String>, json: Value) -> Self {
        Report { text: text.into(), json, failure: None }
    }
}

/// Where a command's remarks go while it runs, and how it is stopped.
pub struct Console<'a> {
    /// Remarks, one a line.
    pub log: &'a mut dyn Write,
    /// No remarks and no progress bar.
    pub quiet: bool,
    /// Whether a remark is a JSON object: `{"warning": "…"}`.
    pub json: bool,
    /// A request to stop.
    pub interrupt: &'a Interrupt,
    /// What was warned of.
    pub warnings: Vec<String>,
}

impl<'a> Console<'a> {
    /// Remarks go to `log` as text.
    pub fn new(log: &'a mut dyn Write, interrupt: &'a Interrupt) -> Self {
        Console { log, quiet: false, json: false, interrupt, warnings: Vec::new() }
    }

    /// Tells a person what is being done.
    pub fn say(&mut self, message: impl std::fmt::Display) {
        self.remark("note", "", &message.to_string());
    }

    /// Tells what someone waits for while the command runs on, even where nothing else is to be said.
    pub fn announce(&mut self, address: &str) {
        let line = if self.json { json!({ "address": address }).to_string() } else { address.to_owned() };
        writeln!(self.log, "{line}").and_then(|()| self.log.flush()).ok();
    }

    /// Tells a person of something that does not stop the work.
    pub fn warn(&mut self, message: impl std::fmt::Display) {
        let message = message.to_string();
        self.remark("warning", "warning: ", &message);
        self.warnings.push(message);
    }

    fn remark(&mut self, kind: &str, prefix: &str, message: &str) {
        if self.quiet {
            return;
        }
        let message = shown_lines(message);
        let line = if self.json {
            printable(&json!({ kind: message }).to_string())
        } else {
            format!("{prefix}{message}")
        };
        // If the standard error is closed, there is nowhere to report it.
        writeln!(self.log, "{line}").ok();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_first_request_to_a_running_render_is_heeded() {
        let idle = Interrupt::default();
        assert!(!idle.request() && idle.is_requested());
        let running = Interrupt::default();
        running.heed();
        assert!(running.request() && !running.request());
        assert!(!running.is_heard_within(Duration::from_millis(20)));
        assert!(running.flow().is_break() && running.is_heard_within(Duration::ZERO));
    }
}
