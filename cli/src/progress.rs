//! How far a render is, and whether someone wants it to stop.

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
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

/// Two bars for many pictures: all of them, and the one in the works. Nothing where the standard error is no terminal.
#[derive(Debug)]
pub struct Board {
    bars: MultiProgress,
    visible: bool,
    whole: ProgressBar,
    picture: ProgressBar,
}

impl Board {
    /// For `total` pictures, of which some are there already; invisible if `quiet` or where nobody sees it.
    pub fn new(total: u64, there: u64, quiet: bool) -> Self {
        let visible = !quiet && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bars = MultiProgress::with_draw_target(target);
        // What was there before says nothing about how long the rest will take.
        let whole = bars.add(ProgressBar::new(total).with_position(there));
        whole.reset_eta();
        let picture = bars.add(ProgressBar::new(1));
        for (bar, template) in [
            (&whole, "{bar:40} {pos} of {len} pictures  {elapsed} elapsed, {eta} left"),
            (&picture, "{bar:40} {percent:>3} %  {msg}"),
        ] {
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
        }
        Board { bars, visible, whole, picture }
    }

    /// Whether anybody sees it.
    pub fn is_visible(&self) -> bool {
        self.visible
    }

    /// A picture is in the works.
    pub fn begin(&self, name: &str) {
        self.picture.set_message(name.to_owned());
        self.picture.set_position(0);
    }

    /// How far the picture in the works is.
    pub fn set(&self, done: u64, total: u64) {
        self.picture.set_length(total);
        self.picture.set_position(done);
    }

    /// The picture in the works is over. Returns its place among all: `"[3/200]"`.
    pub fn end(&self) -> String {
        self.whole.inc(1);
        self.current()
    }

    /// How many pictures are over: `"[3/200]"`.
    pub fn current(&self) -> String {
        format!("[{}/{}]", self.whole.position(), self.whole.length().unwrap_or_default())
    }

    /// Does something that writes to the standard error without tearing the bars.
    pub fn aside(&self, write: impl FnOnce()) {
        self.bars.suspend(write);
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.picture.finish_and_clear();
        self.whole.finish_and_clear();
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
