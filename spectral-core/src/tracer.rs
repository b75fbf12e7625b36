//! The seam between scenes and backends.
//!
//! A backend offers [`Backend::devices`]. Opening one gives a [`Device`], which shows scene after scene: loading a
//! [`PreparedScene`] gives a [`Tracer`], which adds samples to a [`Film`]. Nothing above these traits knows which backend
//! it talks to.

use crate::{Error, film::Film, prepare::PreparedScene};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::time::Duration;

/// What a device is, for people and for choosing one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceInfo {
    /// The backend's name: `"cpu"`, `"reference"`, `"wgpu"`, `"vulkan"`.
    pub backend: &'static str,
    /// Position in the backend's list, as `--device` counts.
    pub index: usize,
    /// The device's own name.
    pub name: String,
    /// Driver and version, empty where there is none.
    pub driver: String,
    /// The system's interface that it is reached through ("Vulkan", "OpenGL"), empty where there is none.
    pub api: &'static str,
    /// Memory that the device can use, bytes; 0 if unknown.
    pub memory: u64,
    /// How rays find surfaces here.
    pub intersection: &'static str,
    /// Whether this is hardware of its own (a software GPU is not).
    pub hardware: bool,
}

/// How to open a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OpenOptions {
    /// Worker threads on the CPU, the calling one included; `None` takes one a core. Never changes the picture.
    pub threads: Option<usize>,
    /// Edge of the square tiles, pixels; `None` lets the backend choose. Never changes the picture.
    pub tile: Option<u32>,
    /// How long a GPU may take for one dispatch, which is planned to take a twentieth of a second, before it counts
    /// as hung; `None` takes [`DEADLINE`](crate::kernel::schedule::DEADLINE). No bound on what the driver does at
    /// its first dispatch, when it may still be compiling.
    pub deadline: Option<Duration>,
}

/// A device, or a part of the system, that a backend cannot use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unusable {
    /// What it is.
    pub name: String,
    /// What it lacks, and what would be needed.
    pub reason: String,
}

/// A way to render: its devices, and how to open one.
#[derive(Debug, Clone, Copy)]
pub struct Backend {
    /// Name on the command line.
    pub name: &'static str,
    /// One line for a person choosing.
    pub about: &'static str,
    /// What this machine offers; empty where the backend cannot run.
    pub devices: fn() -> Vec<DeviceInfo>,
    /// What this machine has that this backend cannot use, for people who look for a device in vain.
    pub unusable: fn() -> Vec<Unusable>,
    /// Whether it can follow areas: scenes with a [`silhouette`](PreparedScene::silhouette). The others are given
    /// [`PreparedScene::in_points`], and refuse such a scene.
    pub areas: bool,
    /// Opens one of [`Backend::devices`].
    pub open: OpenDevice,
}

/// The type of [`Backend::open`].
pub type OpenDevice = fn(&DeviceInfo, &OpenOptions) -> Result<Box<dyn Device>, Error>;

impl Backend {
    /// Opens a device and loads one scene.
    ///
    /// # Errors
    /// Those of [`Backend::open`] and [`Device::load`].
    pub fn tracer(
        &self,
        info: &DeviceInfo,
        scene: Arc<PreparedScene>,
        options: &OpenOptions,
    ) -> Result<Box<dyn Tracer>, Error> {
        (self.open)(info, options)?.load(scene)
    }
}

/// An open device. It keeps what its last scene was made of, and what it has compiled: a scene that shares parts with the
/// last one costs what is new of it.
pub trait Device: Send {
    /// Makes the device ready to render a scene. Tracers of earlier scenes go on working.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails or has too little memory; [`Error::Value`] for a scene that it cannot
    /// hold.
    fn load(&mut self, scene: Arc<PreparedScene>) -> Result<Box<dyn Tracer>, Error>;
}

impl<Load> Device for Load
where
    Load: FnMut(Arc<PreparedScene>) -> Result<Box<dyn Tracer>, Error> + Send,
{
    fn load(&mut self, scene: Arc<PreparedScene>) -> Result<Box<dyn Tracer>, Error> {
        self(scene)
    }
}

/// How far a call of [`Tracer::trace`] has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Pixel samples finished in this call.
    pub done: u64,
    /// Pixel samples that this call will do.
    pub total: u64,
}

/// Renders one prepared scene.
pub trait Tracer: Send {
    /// The device this runs on.
    fn device(&self) -> &DeviceInfo;

    /// Brings every pixel of `film` up to the end of `samples`: a pixel that has k samples gets those from the
    /// greater of k and the start on. Blocks. May be called again with the next samples to refine, and with the
    /// same ones to carry on after a cancel or a failure, on this device or another: the film comes out as if
    /// nothing had happened, bit for bit where both devices calculate alike. Ranges follow one another; those that
    /// leave a gap make a film whose samples nobody can tell apart.
    ///
    /// `progress` is called on the calling thread, at least every tenth of a second; on
    /// [`ControlFlow::Break`] work stops, what is finished stays in the film, and the report says so.
    ///
    /// # Errors
    /// [`TraceFailure`] of [`Error::Device`] when the device fails, of [`Error::Value`] for a film of another size
    /// or samples beyond those prepared. What was finished before is in the film and in the failure's report.
    fn trace(
        &mut self,
        samples: Range<u32>,
        film: &mut Film,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<TraceReport, Box<TraceFailure>>;
}

/// A call of [`Tracer::trace`] that did not come to its end.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{error}")]
pub struct TraceFailure {
    /// Why.
    pub error: Error,
    /// The account of the tiles that are in the film.
    pub report: TraceReport,
}

impl From<Error> for Box<TraceFailure> {
    /// A call that failed before it did anything.
    fn from(error: Error) -> Self {
        Box::new(TraceFailure { error, report: TraceReport::default() })
    }
}

impl From<Box<TraceFailure>> for Error {
    fn from(failure: Box<TraceFailure>) -> Self {
        failure.error
    }
}

/// Refuses a call of [`Tracer::trace`] for a film of another scene or samples that were not prepared; for
/// backends to begin with.
///
/// # Errors
/// [`Error::Value`].
pub fn check_call(scene: &PreparedScene, samples: &Range<u32>, film: &Film) -> Result<(), Error> {
    let wavelengths = if scene.settings.spectral { scene.wavelength_count() } else { 0 };
    if (film.width(), film.height(), film.wavelength_count()) != (scene.width, scene.height, wavelengths) {
        let found =
            format!("{} × {} with {} wavelengths", film.width(), film.height(), film.wavelength_count());
        return Err(Error::value("film", found, "the film of this scene, from Film::new"));
    }
    if samples.end > scene.settings.samples {
        let expected = format!("samples within the {} prepared", scene.settings.samples);
        return Err(Error::value("samples", format!("{samples:?}"), expected));
    }
    Ok(())
}

/// Refuses a scene of areas; for backends that cannot follow them.
///
/// # Errors
/// [`Error::Value`].
pub fn check_points(scene: &PreparedScene) -> Result<(), Error> {
    match scene.silhouette {
        None => Ok(()),
        Some(_) => {
            let expected = "points, from PreparedScene::in_points: this backend cannot follow areas";
            Err(Error::value("coverage", scene.settings.coverage.name(), expected))
        }
    }
}

/// What a call of [`Tracer::trace`] did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TraceReport {
    /// Whether every sample asked for is in the film (false after a cancel or a failure).
    pub finished: bool,
    /// Segments traced: one for each ray and wavelength between two surfaces or out to the environment.
    pub rays: u64,
    /// Where the energy went.
    pub energy: Energy,
    /// Batches that were sent to a GPU; 0 on a processor.
    pub batches: u64,
    /// Time to build what the backend builds (acceleration structures), the first call only.
    pub build: Duration,
    /// Time spent tracing.
    pub trace: Duration,
}

/// An account of throughput, summed over pixel samples and wavelengths: each starts with 1.
///
/// What is not listed here reached the environment or was absorbed in stones and metals.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Throughput that started: pixel samples × wavelengths.
    pub started: f64,
    /// Dropped because the path met the depth limit under [`Leftover::Drop`](crate::settings::Leftover).
    pub dropped_depth: f64,
    /// Dropped because it fell below the threshold.
    pub dropped_threshold: f64,
    /// Left the stone at the depth limit under [`Leftover::Exit`](crate::settings::Leftover): kept, but
    /// sent along an approximate direction.
    pub left_at_limit: f64,
    /// Left through a surface that rounding hid; kept, sent straight on. Zero but for damaged meshes.
    pub lost: f64,
}

impl Energy {
    /// The share of the started throughput that was dropped, for whatever reason.
    pub fn dropped_share(&self) -> f64 {
        if self.started == 0.0 { 0.0 } else { (self.dropped_depth + self.dropped_threshold) / self.started }
    }
}

impl std::ops::AddAssign for Energy {
    fn add_assign(&mut self, other: Self) {
        self.started += other.started;
        self.dropped_depth += other.dropped_depth;
        self.dropped_threshold += other.dropped_threshold;
        self.left_at_limit += other.left_at_limit;
        self.lost += other.lost;
    }
}

impl std::ops::AddAssign for TraceReport {
    /// Joins the report of a later call over the same film.
    fn add_assign(&mut self, other: Self) {
        self.finished = other.finished;
        self.rays += other.rays;
        self.energy += other.energy;
        self.batches += other.batches;
        self.build += other.build;
        self.trace += other.trace;
    }
}
