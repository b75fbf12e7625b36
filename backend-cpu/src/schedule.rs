//! Hands pixels out to worker threads and collects them: tiles, progress, cancelling.
//!
//! Each pixel sample is computed by one task alone and added to the film in sample order, so the picture
//! does not depend on the number of threads, the size of the tiles, or the order in which they finish.
//!
//! The calling thread is one of the workers, and looks after progress on the side. If it slept instead, the system would
//! have a processor too many to wake the others on, and two of them could start on one, until it looks again.

use crate::account::Account;
use rayon::ThreadPool;
use spectral_core::{
    Error,
    film::{Film, Missing, PixelSample, Tile, TileSums},
    prepare::{PreparedScene, SpectralTable},
    tracer::{OpenOptions, Progress, TraceFailure, TraceReport, check_call},
};
use std::cell::{Cell, RefCell};
use std::ops::{ControlFlow, Range};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError, mpsc};
use std::time::{Duration, Instant};

/// Computes tiles.
pub(crate) trait TileTracer: Sync {
    /// Some samples of every pixel of a tile; `None` if broken off because `stop` was set.
    fn tile(&self, tile: Tile, samples: Range<u32>, stop: &Stop<'_>) -> Option<Finished>;
}

/// Whether a worker is to give up: to be asked every few microseconds.
pub(crate) type Stop<'a> = dyn Fn() -> bool + 'a;

/// The calling thread, which now and then is told how far work has come.
struct Caller<'a> {
    flag: &'a AtomicBool,
    tell: RefCell<&'a mut dyn FnMut() -> ControlFlow<()>>,
    /// How often it is asked before it looks at the clock again.
    patience: Cell<u32>,
    /// When it did so last.
    looked: Cell<Instant>,
    due: Cell<Instant>,
}

/// Questions between two looks at the clock: one takes as long as a ray.
const PATIENCE: u32 = 64;
/// Where so many questions take longer than this, each is worth a look.
const SLOW: Duration = Duration::from_millis(10);

impl<'a> Caller<'a> {
    fn new(flag: &'a AtomicBool, tell: &'a mut dyn FnMut() -> ControlFlow<()>) -> Self {
        let due = Cell::new(Instant::now() + HEARTBEAT);
        Caller {
            flag,
            tell: RefCell::new(tell),
            patience: Cell::new(0),
            looked: Cell::new(Instant::now()),
            due,
        }
    }

    /// Its [`Stop`].
    fn stops(&self) -> bool {
        match self.patience.get().checked_sub(1) {
            Some(left) => self.patience.set(left),
            None => {
                let now = Instant::now();
                let slow = now - self.looked.replace(now) > SLOW;
                self.patience.set(if slow { 0 } else { PATIENCE });
                self.tell_when_due();
            }
        }
        self.flag.load(Ordering::Relaxed)
    }

    /// Works along with those in the pool, tells of every tile, and waits for the others when nothing is left to do.
    fn shares(&self, pool: Option<&ThreadPool>, work: &(impl Fn(&Stop<'_>, &dyn Fn()) + Sync)) {
        let Some(pool) = pool else { return work(&|| self.stops(), &|| self.tell()) };
        let flag = self.flag;
        pool.in_place_scope(|scope| {
            let (working, others) = mpsc::channel();
            scope.spawn_broadcast(move |_, _| {
                // Dropped when all are done, or have panicked.
                let _: &mpsc::Sender<()> = &working;
                work(&|| flag.load(Ordering::Relaxed), &|| ());
            });
            work(&|| self.stops(), &|| self.tell());
            while others.recv_timeout(HEARTBEAT) == Err(mpsc::RecvTimeoutError::Timeout) {
                self.tell_when_due();
            }
        });
    }

    fn tell_when_due(&self) {
        if self.due.get() <= Instant::now() {
            self.tell();
        }
    }

    fn tell(&self) {
        if (self.tell.borrow_mut())().is_break() {
            self.flag.store(true, Ordering::Relaxed);
        }
        self.due.set(Instant::now() + HEARTBEAT);
    }
}

/// Edge of a tile unless the caller has a wish, pixels.
const TILE: u32 = 16;
/// The most memory one tile's samples take, bytes.
const TILE_BYTES: usize = 4 << 20;
/// The most samples of a pixel in one pass over the picture: partial pictures are even.
const PASS: u32 = 16;
/// How often the caller's progress function is called at least, if no tile is finished.
const HEARTBEAT: Duration = Duration::from_millis(50);

/// A finished tile on its way to the film.
pub(crate) struct Finished {
    pub sums: TileSums,
    pub account: Account,
}

impl Finished {
    /// A tile from the radiances of its pixels' samples, wavelengths innermost, and which of them meet a stone, or what share.
    pub fn new<T: Copy + Into<f64>, C: Copy + Into<f32>>(
        scene: &PreparedScene,
        tile: Tile,
        samples: Range<u32>,
        radiances: Vec<T>,
        covered: &[C],
        account: Account,
    ) -> Self {
        let table = |k: usize| scene.table(samples.start + (k % samples.len()) as u32);
        let pixels = radiances.chunks_exact(scene.wavelength_count()).zip(covered).enumerate();
        let samples =
            pixels.map(|(k, (radiance, covered))| seen(table(k), radiance, (*covered).into())).collect();
        let single = |radiance: T| radiance.into() as f32;
        let radiance =
            if scene.settings.spectral { radiances.into_iter().map(single).collect() } else { Vec::new() };
        Finished { sums: TileSums { tile, samples, radiance }, account }
    }
}

/// The worker threads besides the calling one, if there are to be any.
pub(crate) fn workers(options: &OpenOptions) -> Result<Option<ThreadPool>, Error> {
    let processors = || std::thread::available_parallelism().map_or(1, usize::from);
    let others = options.threads.filter(|&threads| threads > 0).unwrap_or_else(processors) - 1;
    if others == 0 {
        return Ok(None);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(others).build();
    pool.map(Some).map_err(|e| device_error(format!("the worker threads could not be started: {e}")))
}

/// Brings every pixel of `film` up to the end of `samples`.
pub(crate) fn trace<K: TileTracer>(
    kernel: &K,
    scene: &PreparedScene,
    options: &OpenOptions,
    pool: Option<&ThreadPool>,
    samples: Range<u32>,
    film: &mut Film,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<TraceReport, Box<TraceFailure>> {
    check_call(scene, &samples, film)?;
    let start = Instant::now();
    let tile = options.tile.unwrap_or(TILE).clamp(1, 1024);
    let tiles = tiles(scene.width, scene.height, tile);
    let total = film.missing(film.tile(), &samples).iter().map(Missing::count).sum();
    let results = Mutex::new(Results { film, account: Account::default(), done: 0, refused: None });
    let mut run = Run { results, progress, total };
    let pass = samples_a_pass(tile, film_wavelengths(scene));
    let passes = samples.clone().step_by(pass as usize);
    let outcome = run.passes(
        kernel,
        pool,
        &tiles,
        passes.map(|first| first..samples.end.min(first.saturating_add(pass))),
    );
    let account = run.results().account;
    let report = TraceReport {
        finished: outcome.as_ref().is_ok_and(|finished| *finished),
        rays: account.rays(),
        energy: account.energy(),
        trace: start.elapsed(),
        ..TraceReport::default()
    };
    match outcome {
        Ok(_) => Ok(report),
        Err(error) => Err(Box::new(TraceFailure { error, report })),
    }
}

fn film_wavelengths(scene: &PreparedScene) -> usize {
    if scene.settings.spectral { scene.wavelength_count() } else { 0 }
}

fn samples_a_pass(tile: u32, wavelengths: usize) -> u32 {
    let sample = size_of::<PixelSample>() + wavelengths * size_of::<f32>();
    let fit = TILE_BYTES / (tile as usize * tile as usize * sample);
    (fit as u32).clamp(1, PASS)
}

fn tiles(width: u32, height: u32, edge: u32) -> Vec<Tile> {
    let steps = |length: u32| (0..length).step_by(edge as usize).map(move |at| (at, edge.min(length - at)));
    steps(height)
        .flat_map(|(y, height)| steps(width).map(move |(x, width)| Tile { x, y, width, height }))
        .collect()
}

fn device_error(message: String) -> Error {
    Error::Device { device: "cpu".into(), message }
}

/// What finished tiles are added to.
struct Results<'a> {
    film: &'a mut Film,
    account: Account,
    /// Pixel samples.
    done: u64,
    /// Why the film did not take a tile.
    refused: Option<Error>,
}

impl Results<'_> {
    /// Adds tiles; stops the workers when the film refuses one.
    fn add(&mut self, tiles: &mut Vec<Finished>, stop: &AtomicBool) {
        for finished in tiles.drain(..) {
            if let Err(error) = self.film.add(&finished.sums) {
                self.refused = Some(error);
                stop.store(true, Ordering::Relaxed);
                return;
            }
            self.account += finished.account;
            self.done += finished.sums.samples.len() as u64;
        }
    }
}

/// A worker's finished tiles, kept until no other worker holds the lock on the results.
struct Outbox<'a, 'b> {
    results: &'a Mutex<Results<'b>>,
    stop: &'a AtomicBool,
    tiles: Vec<Finished>,
    bytes: usize,
}

impl Outbox<'_, '_> {
    fn put(&mut self, finished: Finished) {
        let TileSums { samples, radiance, .. } = &finished.sums;
        self.bytes += size_of_val(samples.as_slice()) + size_of_val(radiance.as_slice());
        self.tiles.push(finished);
        match self.results.try_lock() {
            Err(TryLockError::WouldBlock) if self.bytes < TILE_BYTES => {}
            Ok(mut results) => results.add(&mut self.tiles, self.stop),
            Err(_) => locked(self.results).add(&mut self.tiles, self.stop),
        }
        if self.tiles.is_empty() {
            self.bytes = 0;
        }
    }
}

impl Drop for Outbox<'_, '_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.stop.store(true, Ordering::Relaxed);
        }
        locked(self.results).add(&mut self.tiles, self.stop);
    }
}

/// The results, even if a thread panicked while it held them: tiles are added whole or refused.
fn locked<'a, 'b>(results: &'a Mutex<Results<'b>>) -> MutexGuard<'a, Results<'b>> {
    results.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The caller's side of a trace.
struct Run<'a> {
    results: Mutex<Results<'a>>,
    progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    total: u64,
}

impl<'a> Run<'a> {
    fn results(&mut self) -> &mut Results<'a> {
        self.results.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// Pass after pass over all tiles; false if the caller broke it off.
    fn passes<K: TileTracer>(
        &mut self,
        kernel: &K,
        pool: Option<&ThreadPool>,
        tiles: &[Tile],
        passes: impl Iterator<Item = Range<u32>>,
    ) -> Result<bool, Error> {
        for samples in passes {
            let film = &self.results().film;
            let pieces: Vec<_> = tiles.iter().flat_map(|&tile| film.missing(tile, &samples)).collect();
            if !self.pass(kernel, pool, &pieces)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// One pass; false if the caller broke it off.
    fn pass<K: TileTracer>(
        &mut self,
        kernel: &K,
        pool: Option<&ThreadPool>,
        pieces: &[Missing],
    ) -> Result<bool, Error> {
        let (flag, next, telling) = (&AtomicBool::new(false), &AtomicUsize::new(0), Cell::new(false));
        let Run { results, progress, total } = self;
        let results = &*results;
        let mut tell = || {
            telling.set(true);
            let done = locked(results).done;
            let told = progress(Progress { done, total: *total });
            telling.set(false);
            told
        };
        let work = |stop: &Stop<'_>, tell: &dyn Fn()| {
            let mut outbox = Outbox { results, stop: flag, tiles: Vec::new(), bytes: 0 };
            while let Some(piece) = pieces.get(next.fetch_add(1, Ordering::Relaxed)) {
                if stop() {
                    return;
                }
                if let Some(finished) = kernel.tile(piece.tile, piece.samples.clone(), stop) {
                    outbox.put(finished);
                    tell();
                }
            }
        };
        let caller = Caller::new(flag, &mut tell);
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| caller.shares(pool, &work))) {
            if telling.get() {
                resume_unwind(panic);
            }
            return Err(device_error("a worker thread panicked".into()));
        }
        let Results { done, refused, .. } = self.results();
        let done = *done;
        if let Some(error) = refused.take() {
            return Err(error);
        }
        let stopped = flag.load(Ordering::Relaxed);
        let last = (self.progress)(Progress { done, total: self.total });
        Ok(!stopped && last.is_continue())
    }
}

/// A pixel sample from the radiances of its wavelengths.
fn seen<T: Copy + Into<f64>>(table: &SpectralTable, radiance: &[T], coverage: f32) -> PixelSample {
    let mut xyz = [0.0; 3];
    for (weight, value) in table.response.iter().zip(radiance) {
        let value: f64 = (*value).into();
        for c in 0..3 {
            xyz[c] += weight[c] * value;
        }
    }
    PixelSample { xyz: xyz.map(|v| v as f32), coverage }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::tests::chain;

    /// Black tiles, but for what one of them does.
    struct Black<'a, F> {
        scene: &'a PreparedScene,
        first: F,
    }

    impl<F: Fn() + Sync> TileTracer for Black<'_, F> {
        fn tile(&self, tile: Tile, samples: Range<u32>, stop: &Stop<'_>) -> Option<Finished> {
            if (tile.x, tile.y) == (0, 0) {
                (self.first)();
                while !stop() {
                    std::thread::yield_now();
                }
                return None;
            }
            let count = tile.width as usize * tile.height as usize * samples.len();
            let radiances = vec![0.0; count * self.scene.wavelength_count()];
            let (covered, account) = (vec![false; count], Account::default());
            Some(Finished::new(self.scene, tile, samples, radiances, &covered, account))
        }
    }

    fn traced(
        threads: usize,
        first: impl Fn() + Sync,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> (Result<TraceReport, Box<TraceFailure>>, u64) {
        let (_, scene) = chain("round-brilliant");
        let options = OpenOptions { threads: Some(threads), tile: Some(1), deadline: None };
        let pool = workers(&options).expect("threads");
        let mut film = Film::new(&scene);
        let kernel = Black { scene: &scene, first };
        let report = trace(&kernel, &scene, &options, pool.as_ref(), 0..1, &mut film, progress);
        (report, film.total_samples())
    }

    #[test]
    fn a_worker_that_panics_stops_the_others_and_is_an_error() {
        for threads in 1..=3 {
            let go_on = &mut |_| ControlFlow::Continue(());
            let (report, _) = traced(threads, || panic!("on purpose"), go_on);
            let failure = report.expect_err("a failure");
            assert!(failure.to_string().contains("a worker thread panicked"), "{threads}: {failure}");
        }
    }

    #[test]
    fn a_caller_that_has_had_enough_is_heard_while_tiles_take_for_ever() {
        for threads in 1..=3 {
            let (caller, mut calls) = (std::thread::current().id(), 0);
            let (report, done) = traced(threads, || (), &mut |progress| {
                assert_eq!(std::thread::current().id(), caller);
                calls += 1;
                // The others have done all that there is.
                let enough = calls > 3 && (threads == 1 || progress.done + 1 == progress.total);
                if enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            assert!(!report.expect("no failure").finished);
            assert_eq!(done == 0, threads == 1, "{threads}: {done}");
        }
    }

    #[test]
    #[should_panic(expected = "the caller's own")]
    fn what_the_caller_panics_with_is_its_own() {
        let _ = traced(2, || (), &mut |_| panic!("the caller's own"));
    }
}
