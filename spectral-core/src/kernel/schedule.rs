//! The picture in batches, each short enough for a desktop: a [`Tracer`] for every GPU backend.
//!
//! A backend gives a [`Launch`], which has run once over nothing, so that its shaders are compiled. It takes a batch of
//! pixels at a time without waiting for it, and is asked later whether the batch is done. This module chooses the batches
//! by the time they take, keeps several under way, resumes walks that are not over, and keeps the film and the account.

use super::{
    block::{Batch, Tally},
    plan::Plan,
};
use crate::{
    Error,
    film::{Film, Missing},
    prepare::PreparedScene,
    tracer::{
        DeviceInfo, Energy, OpenOptions, Progress, TraceFailure, TraceReport, Tracer, check_call,
        check_points,
    },
};
use std::collections::VecDeque;
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::time::Duration;
use web_time::Instant;

/// What a batch should take: far below the two seconds after which desktop systems end it, far above what its
/// submission costs.
const TARGET: Duration = Duration::from_millis(60);
/// Pixel samples × wavelengths of the first batch, before anything is known of the device.
const FIRST_ITEMS: f64 = 2048.0;
/// Rays that an invocation follows in a batch's first dispatch; chains are followed to their ends.
const BUDGET: u32 = 256;
/// The fewest samples of a pixel that a batch takes, if there are so many.
const FEWEST: u32 = 16;

/// A dispatch that has not ended after this long hangs, unless [`OpenOptions::deadline`] says otherwise: the slowest
/// device that is any use ends it in a hundredth.
pub const DEADLINE: Duration = Duration::from_secs(120);
/// As [`DEADLINE`], where the driver may still be compiling: some do so when a shader first runs, on busy machines for
/// a minute.
pub const COMPILE_DEADLINE: Duration = Duration::from_secs(600);
/// How long a backend waits for its device before it returns to the caller.
pub const HEARTBEAT: Duration = Duration::from_millis(50);

/// The message about a device that has not ended its work in time.
pub fn overdue(deadline: Duration) -> String {
    format!("the kernel has not ended after {} seconds", deadline.as_secs_f64())
}

/// What a batch takes from the host.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// Its constants.
    pub batch: Batch,
    /// Pixel numbers, row by row in the picture.
    pub pixels: &'a [u32],
    /// XYZ and coverage of each pixel so far; empty where [`Batch::fresh`] says that there is none.
    pub sums: &'a [[f32; 4]],
    /// Radiances of each pixel so far, wavelengths innermost, where the film keeps them and the pixels are not fresh.
    pub radiances: &'a [f32],
}

/// What a batch gives back.
#[derive(Debug, Clone, Default)]
pub struct Finished {
    /// XYZ and coverage of each pixel, the sums over all its samples so far.
    pub sums: Vec<[f32; 4]>,
    /// Sums of each pixel's radiances, wavelengths innermost, where the film keeps them; else empty.
    pub radiances: Vec<f32>,
    /// The account of the batch in parts.
    pub tallies: Vec<Tally>,
}

/// A scene's kernel on an open device.
pub trait Launch: Send {
    /// How large batches may be.
    fn plan(&self) -> &Plan;

    /// Sends a batch to the device and returns at once. `slot` is less than [`Plan::slots`], and nothing is under way
    /// there.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails.
    fn submit(&mut self, slot: usize, job: &Job<'_>) -> Result<(), Error>;

    /// Whether the batch in a slot is done, waiting for it for at most `patience`; what it has come to is then put in
    /// place of `finished`.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails.
    fn poll(&mut self, slot: usize, patience: Duration, finished: &mut Finished) -> Result<bool, Error>;

    /// The device hangs: nothing that it may still use may be freed.
    fn abandon(&mut self) {}

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
    deadline: Duration,
    /// Work items for a batch of [`TARGET`], as measured; none before the first.
    items: Option<f64>,
    /// Reported by the first call.
    build: Option<Duration>,
    /// Of the last batch; its memory is used again.
    finished: Finished,
}

/// A batch under way.
struct Flight {
    slot: usize,
    batch: Batch,
    /// Which of the round's pixels.
    pixels: Range<usize>,
    begun: Instant,
}

/// The caller's side of a trace.
struct Run<'a> {
    film: &'a mut Film,
    progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    report: TraceReport,
    at: Progress,
    stop: bool,
    flights: VecDeque<Flight>,
    /// When the last batch was done.
    ended: Instant,
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
        if launch.plan().samples == 0 {
            let lines = scene.wavelength_count();
            let message = format!("the paths of {lines} wavelengths do not fit in this device's buffers");
            return Err(launch.error(message));
        }
        let tile = options.tile.map_or(u32::MAX, |edge| edge.clamp(1, 1024).pow(2));
        let deadline = options.deadline.unwrap_or(DEADLINE);
        Ok(KernelTracer {
            device: device.clone(),
            launch,
            scene,
            tile,
            deadline,
            items: None,
            build: Some(build),
            finished: Finished::default(),
        })
    }

    /// Some samples of every pixel in a list, all of which have the same number.
    fn round(&mut self, samples: Range<u32>, pixels: &[u32], run: &mut Run<'_>) -> Result<(), Error> {
        let mut next = 0;
        loop {
            run.beat();
            while !run.stop && next < pixels.len() && run.flights.len() < self.slots() {
                let end = pixels.len().min(next + self.pixels(samples.len() as u32));
                self.begin(samples.clone(), pixels, next..end, run)?;
                next = end;
            }
            let Some(flight) = run.flights.front() else { return Ok(()) };
            let patience = HEARTBEAT.min(self.deadline);
            if self.launch.poll(flight.slot, patience, &mut self.finished)? {
                self.end(pixels, run)?;
            } else if flight.begun.max(run.ended).elapsed() > self.deadline {
                self.launch.abandon();
                return Err(self.launch.error(overdue(self.deadline)));
            }
        }
    }

    /// Batches that may be under way: one until the device's speed is known.
    fn slots(&self) -> usize {
        if self.items.is_some() { self.launch.plan().slots() } else { 1 }
    }

    /// Samples of each pixel for the next round, of so many that are missing.
    fn samples(&self, missing: u32) -> u32 {
        let plan = self.launch.plan();
        let quick = (self.items.unwrap_or(FIRST_ITEMS) / f64::from(plan.lines)) as u32;
        missing.min(quick.max(FEWEST)).min(plan.samples)
    }

    /// Pixels of `samples` samples each for the next batch.
    fn pixels(&self, samples: u32) -> usize {
        let plan = self.launch.plan();
        let wanted = (self.items.unwrap_or(FIRST_ITEMS) / f64::from(plan.lines * samples)) as u32;
        wanted.min(plan.samples / samples).min(plan.pixels).min(self.tile).max(1) as usize
    }

    fn begin(
        &mut self,
        samples: Range<u32>,
        pixels: &[u32],
        part: Range<usize>,
        run: &mut Run<'_>,
    ) -> Result<(), Error> {
        let batch = Batch {
            pixels: part.len() as u32,
            first: samples.start,
            count: samples.len() as u32,
            budget: BUDGET,
            resume: 0,
            spectral: u32::from(self.launch.plan().spectral),
            fresh: u32::from(samples.start == 0),
            padding: 0,
        };
        let slots = self.launch.plan().slots();
        let slot = run.flights.back().map_or(0, |last| (last.slot + 1) % slots);
        let flight = Flight { slot, batch, pixels: part, begun: Instant::now() };
        self.send(&flight, pixels, run)?;
        run.report.batches += 1;
        run.flights.push_back(flight);
        Ok(())
    }

    fn send(&mut self, flight: &Flight, pixels: &[u32], run: &Run<'_>) -> Result<(), Error> {
        let pixels = &pixels[flight.pixels.clone()];
        let (sums, radiances) =
            if flight.batch.fresh == 0 { run.film.carried(pixels) } else { Default::default() };
        let job = Job { batch: flight.batch, pixels, sums: &sums, radiances: &radiances };
        self.launch.submit(flight.slot, &job)
    }

    /// The oldest batch is done: its pixels go to the film, or its walks are resumed.
    fn end(&mut self, pixels: &[u32], run: &mut Run<'_>) -> Result<(), Error> {
        let mut flight = run.flights.pop_front().expect("a batch that was asked for");
        let took = flight.begun.max(run.ended).elapsed().as_secs_f64().max(1e-6);
        let ratio = TARGET.as_secs_f64() / took;
        run.ended = Instant::now();
        if flight.batch.resume == 0 {
            let lines = self.launch.plan().lines;
            let items = f64::from(flight.batch.pixels) * f64::from(flight.batch.count) * f64::from(lines);
            // The last batch of a round may be too small to tell.
            if ratio < 1.0 || self.items.is_none_or(|known| 2.0 * items >= known) {
                self.items = Some(items * ratio.clamp(0.25, 8.0));
            }
        }
        if self.finished.tallies.iter().any(|tally| tally.going != 0) {
            if !run.stop {
                // Few walks are left: each may go further in the same time.
                let budget = f64::from(flight.batch.budget) * ratio.clamp(0.25, 4.0);
                flight.batch = Batch { budget: budget.clamp(1.0, 4096.0) as u32, resume: 1, ..flight.batch };
                flight.begun = run.ended;
                self.send(&flight, pixels, run)?;
                run.flights.push_front(flight);
            }
            return Ok(());
        }
        self.keep(&pixels[flight.pixels.clone()], flight.batch.count, run)
    }

    /// A batch's pixels into the film, its account into the report.
    fn keep(&self, pixels: &[u32], count: u32, run: &mut Run<'_>) -> Result<(), Error> {
        let Finished { sums, radiances, tallies } = &self.finished;
        run.film.carry(pixels, count, sums, radiances)?;
        for tally in tallies {
            let [dropped_depth, dropped_threshold, left_at_limit, lost] = tally.energies.map(f64::from);
            run.report.energy +=
                Energy { started: 0.0, dropped_depth, dropped_threshold, left_at_limit, lost };
            run.report.rays += u64::from(tally.rays[0]) + (u64::from(tally.rays[1]) << 32);
        }
        let samples = u64::from(count) * pixels.len() as u64;
        run.report.energy.started += samples as f64 * f64::from(self.launch.plan().lines);
        run.at.done += samples;
        Ok(())
    }

    fn rounds(&mut self, lists: Vec<(Range<u32>, Vec<u32>)>, run: &mut Run<'_>) -> Result<(), Error> {
        for (mut samples, pixels) in lists {
            while !samples.is_empty() && !run.stop {
                let middle = samples.start + self.samples(samples.len() as u32);
                self.round(samples.start..middle, &pixels, run)?;
                samples.start = middle;
            }
        }
        Ok(())
    }
}

/// The pixels that lack samples, in lists of those that lack the same.
fn lists(film: &Film, samples: &Range<u32>) -> Vec<(Range<u32>, Vec<u32>)> {
    let mut lists: Vec<(Range<u32>, Vec<u32>)> = Vec::new();
    for Missing { tile, samples } in film.missing(film.tile(), samples) {
        let at = lists.iter().position(|(same, _)| *same == samples).unwrap_or_else(|| {
            lists.push((samples, Vec::new()));
            lists.len() - 1
        });
        let row = |y| y * film.width() + tile.x..y * film.width() + tile.x + tile.width;
        lists[at].1.extend((tile.y..tile.y + tile.height).flat_map(row));
    }
    lists.iter_mut().for_each(|(_, pixels)| pixels.sort_unstable());
    lists
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
        check_points(&self.scene)?;
        check_call(&self.scene, &samples, film)?;
        let start = Instant::now();
        let lists = lists(film, &samples);
        let total = lists.iter().map(|(samples, pixels)| samples.len() as u64 * pixels.len() as u64).sum();
        let report = TraceReport { build: self.build.take().unwrap_or_default(), ..TraceReport::default() };
        let (at, flights) = (Progress { done: 0, total }, VecDeque::new());
        let mut run = Run { film, progress, report, at, stop: false, flights, ended: start };
        let outcome = self.rounds(lists, &mut run);
        run.beat();
        let report =
            TraceReport { finished: outcome.is_ok() && !run.stop, trace: start.elapsed(), ..run.report };
        match outcome {
            Ok(()) => Ok(report),
            Err(error) => Err(Box::new(TraceFailure { error, report })),
        }
    }
}
