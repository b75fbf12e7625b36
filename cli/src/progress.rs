//! How far a render is: progress bars, and who follows a render at a console.

use crate::console::Console;
use gemtrace::Watch;
use gemtrace::registry::Choice;
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use spectral_core::tracer::Progress;
use std::io::IsTerminal as _;
use std::ops::ControlFlow;

/// A progress bar on the standard error, or nothing where that is no terminal.
#[derive(Debug)]
pub struct Bar(ProgressBar);

impl Bar {
    /// A bar for `total` steps; hidden if `quiet` or where the standard error is no terminal.
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

/// Two bars for many pictures: all of them, and the current one. Hidden where the standard error is no terminal.
#[derive(Debug)]
pub struct Board {
    bars: MultiProgress,
    visible: bool,
    whole: ProgressBar,
    picture: ProgressBar,
}

impl Board {
    /// For `total` pictures, of which some are there already; hidden if `quiet` or where the standard error is no terminal.
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

    /// Whether it is shown.
    pub fn is_visible(&self) -> bool {
        self.visible
    }

    /// A picture is begun.
    pub fn begin(&self, name: &str) {
        self.picture.set_message(name.to_owned());
        self.picture.set_position(0);
    }

    /// How far the current picture is.
    pub fn set(&self, done: u64, total: u64) {
        self.picture.set_length(total);
        self.picture.set_position(done);
    }

    /// The current picture is done. Returns its place among all: `"[3/200]"`.
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

/// Someone at a console who follows pictures: sees warnings and a bar, and may press Ctrl-C.
pub struct Onlooker<'a, 'b> {
    console: &'a mut Console<'b>,
    bar: Bar,
    /// Whether to say which device is taken.
    announce: bool,
    /// The pictures that the bar counts.
    count: u64,
    /// Those of them that are done.
    done: u64,
    /// What was warned of.
    pub warnings: Vec<String>,
}

impl<'a, 'b> Onlooker<'a, 'b> {
    /// For this many pictures of one size; `announce`: say which device is taken.
    pub fn new(console: &'a mut Console<'b>, count: usize, announce: bool) -> Self {
        let bar = Bar::new(1, console.quiet);
        Onlooker { console, bar, announce, count: count as u64, done: 0, warnings: Vec::new() }
    }

    /// The next picture is begun.
    pub fn next(&mut self) {
        self.done += 1;
    }
}

impl Watch for Onlooker<'_, '_> {
    fn chosen(&mut self, choice: &Choice) {
        if self.announce {
            self.console.say(&choice.reason);
        }
    }

    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self.console.interrupt.heed();
        self.bar.set_total(progress.total * self.count);
        self.bar.set(progress.total * self.done + progress.done);
        self.console.interrupt.flow()
    }

    fn warning(&mut self, message: &str) {
        self.console.warn(message);
        self.warnings.push(message.to_owned());
    }
}
