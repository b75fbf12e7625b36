//! The picture in batches, each short enough for a desktop: a [`Tracer`] for every GPU backend.
//!
//! A backend gives a [`Launch`], which has run once over nothing, so that its shaders are compiled, and which runs the
//! kernel over a batch of camera rays once; this module chooses the batches by the time they take, resumes walks that
//! are not over, and keeps the film and the account.

use super::{
    block::{Primary, Seen},
    pack,
};
use crate::{
    Error,
    film::{Film, Missing, PixelSample, Tile, TileSums},
    prepare::PreparedScene,
    tracer::{DeviceInfo, Energy, OpenOptions, Progress, TraceFailure, TraceReport, Tracer, check_call},
};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a dispatch should take: far below the two seconds after which desktop systems end it, far above what its
/// submission costs.
const TARGET: Duration = Duration::from_millis(60);
/// Pixel samples × wavelengths of the first batch, before anything is known of the device.
const FIRST_ITEMS: u32 = 2048;
/// Rays that an invocation of a batch's first dispatch follows.
const BUDGET: u32 = 64;
/// The most samples of a pixel in one pass over the picture: partial pictures are even.
const PASS: u32 = 16;

/// The most memory for the paths of a batch, bytes.
pub const PATH_MEMORY: u64 = 512 << 20;
/// A dispatch that has not ended after this long hangs, unless [`OpenOptions::deadline`] says otherwise: the slowest
/// device that is any use ends it in a hundredth.
pub const DEADLINE: Duration = Duration::from_secs(120);
/// As [`DEADLINE`], where the driver may still be compiling: some do so when a shader first runs, on busy machines for
/// a minute.
pub const COMPILE_DEADLINE: Duration = Duration::from_secs(600);
/// How long a backend waits for its device before it calls `beat`.
pub const HEARTBEAT: Duration = Duration::from_millis(50);

/// What is said of a device that has not ended its work in time.
pub fn overdue(deadline: Duration) -> String {
    format!("the kernel has not ended after {} seconds", deadline.as_secs_f64())
}

/// What a batch gives back.
#[derive(Debug, Clone, Default)]
pub struct Finished {
    /// Each pixel sample.
    pub seen: Vec<Seen>,
    /// Each sample's radiances, wavelengths innermost, where the film keeps them; else empty.
    pub radiance: Vec<f32>,
}

/// A scene's kernel on an open device.
pub trait Launch: Send {
    /// Pixel samples that a batch may hold; 0 where not one fits.
    fn most_samples(&self) -> u32;

    /// Begins a batch: takes its camera rays, at most [`Launch::most_samples`].
    ///
    /// # Errors
    /// [`Error::Device`] where the device refuses memory.
    fn begin(&mut self, rays: &[Primary]) -> Result<(), Error>;

    /// One dispatch over the batch: every invocation follows at most `budget` rays, beginning its walk or resuming
    /// it. Waits for it, calling `beat` every [`HEARTBEAT`], at most for
    /// the deadline it was opened with.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails or hangs.
    fn dispatch(&mut self, budget: u32, resume: bool, beat: &mut dyn FnMut()) -> Result<Finished, Error>;

    /// The error that this device has failed with the given message.
    fn error(&self, message: String) -> Error;
}

/// Renders a scene by launching its kernel.
pub struct KernelTracer<L> {
    device: DeviceInfo,
    launch: L,
    scene: Arc<PreparedScene>,
    /// Pixels that a batch may hold.
    tile: u32,
    /// Work items for a dispatch of [`TARGET`], as measured.
    items: f64,
    /// Reported by the first call.
    build: Option<Duration>,
}

/// The caller's side of a trace.
struct Run<'a> {
    film: &'a mut Film,
    progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    report: TraceReport,
    at: Progress,
    stop: bool,
}

impl Run<'_> {
    fn beat(&mut self) {
        self.stop |= (self.progress)(self.at).is_break();
    }
}

impl<L: Launch> KernelTracer<L> {
    /// A tracer for a scene whose kernel took `build` to make.
    ///
    /// # Errors
    /// [`Error::Device`] where not one pixel sample fits the device.
    pub fn new(
        device: &DeviceInfo,
        launch: L,
        scene: Arc<PreparedScene>,
        options: &OpenOptions,
        build: Duration,
    ) -> Result<Self, Error> {
        if launch.most_samples() == 0 {
            let lines = scene.wavelength_count();
            let message = format!("the paths of {lines} wavelengths do not fit in this device's buffers");
            return Err(launch.error(message));
        }
        let tile = options.tile.map_or(u32::MAX, |edge| edge.clamp(1, 1024).pow(2));
        let (device, items, build) = (device.clone(), f64::from(FIRST_ITEMS), Some(build));
        Ok(KernelTracer { device, launch, scene, tile, items, build })
    }

    /// Some samples of every pixel, row by row.
    fn pass(&mut self, samples: Range<u32>, run: &mut Run<'_>) -> Result<(), Error> {
        let (width, height) = (self.scene.width, self.scene.height);
        let (mut x, mut y) = (0, 0);
        while y < height {
            run.beat();
            if run.stop {
                return Ok(());
            }
            let tile = next_tile([x, y], [width, height], self.pixels(samples.len() as u32));
            for Missing { tile, samples } in run.film.missing(tile, &samples) {
                let Some(sums) = self.tile(tile, samples, run)? else { return Ok(()) };
                run.film.add(&sums)?;
                run.at.done += sums.samples.len() as u64;
            }
            x += tile.width;
            if x >= width {
                (x, y) = (0, y + tile.height);
            }
        }
        run.beat();
        Ok(())
    }

    /// Pixels of `samples` samples each for the next batch.
    fn pixels(&self, samples: u32) -> u32 {
        let lines = self.scene.wavelength_count() as f64;
        let wanted = (self.items / (lines * f64::from(samples))) as u32;
        wanted.min(self.launch.most_samples() / samples).min(self.tile).max(1)
    }

    /// One batch; `None` if the caller broke it off.
    fn tile(
        &mut self,
        tile: Tile,
        samples: Range<u32>,
        run: &mut Run<'_>,
    ) -> Result<Option<TileSums>, Error> {
        let rays = pack::primaries(&self.scene, tile, samples);
        let lines = self.scene.wavelength_count() as u32;
        self.launch.begin(&rays)?;
        let (mut budget, mut resume) = (BUDGET, false);
        loop {
            let start = Instant::now();
            let finished = self.launch.dispatch(budget, resume, &mut || run.beat())?;
            let ratio = TARGET.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-6);
            if !resume {
                self.items = rays.len() as f64 * f64::from(lines) * ratio.clamp(0.25, 2.0);
            }
            if finished.seen.iter().all(|seen| seen.going == 0) {
                return Ok(Some(sums(tile, finished, lines, &mut run.report)));
            }
            if run.stop {
                return Ok(None);
            }
            // Few walks are left: each may go further in the same time.
            budget = (f64::from(budget) * ratio.clamp(0.25, 4.0)).clamp(1.0, 4096.0) as u32;
            resume = true;
        }
    }
}

impl<L: Launch> Tracer for KernelTracer<L> {
    fn device(&self) -> &DeviceInfo {
        &self.device
    }

    fn trace(
        &mut self,
        samples: Range<u32>,
        film: &mut Film,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<TraceReport, Box<TraceFailure>> {
        check_call(&self.scene, &samples, film)?;
        let start = Instant::now();
        let total = film.missing(film.tile(), &samples).iter().map(Missing::count).sum();
        let report = TraceReport { build: self.build.take().unwrap_or_default(), ..TraceReport::default() };
        let mut run = Run { film, progress, report, at: Progress { done: 0, total }, stop: false };
        let pass = self.launch.most_samples().clamp(1, PASS);
        let mut passes = samples.clone().step_by(pass as usize);
        let outcome = passes
            .try_for_each(|first| self.pass(first..samples.end.min(first.saturating_add(pass)), &mut run));
        let report =
            TraceReport { finished: outcome.is_ok() && !run.stop, trace: start.elapsed(), ..run.report };
        match outcome {
            Ok(()) => Ok(report),
            Err(error) => Err(Box::new(TraceFailure { error, report })),
        }
    }
}

/// The next batch's pixels from (x, y) on, `count` of them if they make a rectangle: whole rows, or part of one.
fn next_tile([x, y]: [u32; 2], [width, height]: [u32; 2], count: u32) -> Tile {
    if x == 0 && count >= width {
        return Tile { x, y, width, height: (count / width).min(height - y) };
    }
    Tile { x, y, width: count.min(width - x), height: 1 }
}

/// A batch's samples for the film, its account for the report.
fn sums(tile: Tile, finished: Finished, lines: u32, report: &mut TraceReport) -> TileSums {
    for seen in &finished.seen {
        let [dropped_depth, dropped_threshold, left_at_limit, lost] = seen.energies.map(f64::from);
        let started = f64::from(lines);
        report.energy += Energy { started, dropped_depth, dropped_threshold, left_at_limit, lost };
        report.rays += u64::from(seen.rays);
    }
    let sample = |seen: &Seen| PixelSample { xyz: seen.xyz, coverage: seen.coverage };
    TileSums { tile, samples: finished.seen.iter().map(sample).collect(), radiance: finished.radiance }
}
