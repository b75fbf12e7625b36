//! How far a render is, and whether someone wants it to stop.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal as _;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A request to stop, shared with whoever may make it (the handler of Ctrl-C).
///
/// While a render runs, a request makes it stop and write what is finished. At any other time there is
/// nothing to save, and whoever asks may end the process at once.
#[derive(Debug, Default)]
pub struct Interrupt {
    requested: AtomicBool,
    heeded: AtomicBool,
}

impl Interrupt {
    /// Asks to stop. Returns whether something will heed it; if not, or on a second request, the caller
    /// may end the process.
    pub fn request(&self) -> bool {
        !self.requested.swap(true, Relaxed) && self.heeded.load(Relaxed)
    }

    /// Whether someone has asked to stop.
    pub fn is_requested(&self) -> bool {
        self.requested.load(Relaxed)
    }

    /// From now on requests are looked at.
    pub fn heed(&self) {
        self.heeded.store(true, Relaxed);
    }
}

/// A progress bar on the standard error, or nothing where that is no terminal.
#[derive(Debug)]
pub struct Bar(ProgressBar);

impl Bar {
    /// A bar for `total` steps; invisible if `quiet` or where nobody sees it.
    pub fn new(total: u64, quiet: bool) -> Self {
        let visible = !quiet && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(total), target);
        if let Ok(style) =
            ProgressStyle::with_template("{bar:40} {percent:>3} %  {elapsed} elapsed, {eta} left")
        {
            bar.set_style(style);
        }
        Bar(bar)
    }

    /// Shows that `done` steps of the total are done.
    pub fn set(&self, done: u64) {
        self.0.set_position(done);
    }

    /// Shows another total.
    pub fn set_total(&self, total: u64) {
        self.0.set_length(total);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
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
    }
}
