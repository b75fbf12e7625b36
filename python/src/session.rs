//! Devices that stay open, and what is rendered on them.

use crate::error::Failure;
use crate::film::Film;
use crate::scene::Scene;
use gemtrace::measure::{Conditions, Hinge, Measurement, Position};
use gemtrace::output::Options;
use gemtrace::scene_file::Override;
use gemtrace::session::Rendered;
use gemtrace::{Error, Watch, output, registry};
use pyo3::prelude::*;
use spectral_core::environment::Pattern;
use spectral_core::film::Film as Samples;
use spectral_core::prepare::PreparedScene;
use spectral_core::settings::{Coverage, Quality};
use spectral_core::tracer::{OpenOptions, Progress};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often Python is asked whether to go on: waiting for the interpreter may take as long as another thread keeps it.
const TICK: Duration = Duration::from_millis(50);

/// A backend and, between renders, the session that is open on it. A render takes the session and puts it back; one that
/// finds none opens another. So no thread waits for another, and a callback may render, too.
#[pyclass(frozen, module = "gemtrace._gemtrace")]
pub struct Session {
    backend: String,
    device: Option<usize>,
    open: OpenOptions,
    /// Whether it is for single pictures, of which `auto` leaves small ones to the processor.
    single: bool,
    idle: Mutex<Option<Opened>>,
}

struct Opened {
    session: gemtrace::Session,
    /// Whether it was opened for a picture that the processor has before a GPU would be ready.
    soon: bool,
}

/// The film, and why it is not finished.
struct Outcome {
    film: Film,
    failure: Option<Error>,
}

#[pymethods]
impl Session {
    #[new]
    fn new(
        backend: String,
        device: Option<usize>,
        threads: Option<usize>,
        single: bool,
    ) -> Result<Self, Failure> {
        registry::known(registry::backends(), &backend)?;
        let open = OpenOptions { threads, ..OpenOptions::default() };
        Ok(Session { backend, device, open, single, idle: Mutex::default() })
    }

    /// Renders; the second is the exception that ended it, if one did.
    #[pyo3(signature = (scene, resolution, quality, coverage, samples, tolerance, progress))]
    #[expect(clippy::too_many_arguments, reason = "those of the package's functions")]
    fn render(
        &self,
        py: Python<'_>,
        scene: &Scene,
        resolution: Option<[u32; 2]>,
        quality: Option<&str>,
        coverage: Option<&str>,
        samples: Option<u32>,
        tolerance: Option<f64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Film, Option<PyErr>)> {
        let quality = quality.map(Quality::by_name).transpose().map_err(Failure::from)?;
        let coverage = coverage.map(Coverage::by_name).transpose().map_err(Failure::from)?;
        let change = Override { size: resolution, quality, coverage, samples, tolerance };
        let mut follower = Follower::new(progress);
        let outcome = py.detach(|| self.fill(scene, &change, &mut follower)).map_err(Failure::from)?;
        let failure = outcome.failure.map(|error| Failure::from(error).into());
        if outcome.film.finished() {
            follower.end(py, outcome.film.total());
        }
        Ok((outcome.film, follower.error.or(failure)))
    }

    /// Measures the one stone of a scene at one angle after another: for each the share that was dropped and the figures by
    /// their names, of the stone and of its table.
    #[expect(clippy::too_many_arguments, reason = "those of the package's function")]
    #[expect(clippy::type_complexity, reason = "it is unpacked at once")]
    fn measure(
        &self,
        py: Python<'_>,
        scene: &Scene,
        tilts: Vec<f64>,
        models: Vec<String>,
        head: f64,
        eye: Option<f64>,
        rays: u32,
        about: &str,
        experimental: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<(f64, usize, Vec<(&'static str, f64)>, Option<Vec<(&'static str, f64)>>)>> {
        let models: Result<Vec<_>, _> = models.iter().map(|name| Pattern::by_name(name)).collect();
        let models = models.map_err(Failure::from)?;
        let hinge = Hinge::ALL.into_iter().find(|hinge| hinge.name() == about);
        let hinge =
            hinge.ok_or_else(|| Failure::from(spectral_core::Error::unknown("axis", about, ["x", "y"])))?;
        let settings = scene.loaded.settings.clone();
        let conditions = Conditions {
            models,
            head,
            eye,
            size: rays,
            hinge,
            experimental,
            settings,
            ..Conditions::default()
        };
        let mut follower = Follower::new(progress);
        let positions = py.detach(|| self.positions(scene, &tilts, &conditions, &mut follower));
        let positions = match (positions, follower.error) {
            (_, Some(error)) => return Err(error),
            (positions, None) => positions.map_err(Failure::from)?,
        };
        let row = |p: Position| {
            let table = p.table.map(|figures| figures.named(&conditions.models));
            (p.dropped, p.stone.rays, p.stone.named(&conditions.models), table)
        };
        Ok(positions.into_iter().map(row).collect())
    }

    /// Gives the device back.
    fn close(&self) {
        *self.idle() = None;
    }
}

impl Session {
    fn idle(&self) -> std::sync::MutexGuard<'_, Option<Opened>> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn fill(&self, scene: &Scene, change: &Override, follower: &mut Follower) -> Result<Outcome, Error> {
        let mut loaded = scene.loaded.clone();
        change.apply(&mut loaded);
        let taken = self.idle().take();
        let (prepared, mut opened) = match taken {
            Some(mut opened) => match opened.session.prepare(&loaded.scene, &loaded.settings) {
                Ok(prepared) if !opened.soon || registry::is_soon(&prepared) => (prepared, opened),
                Ok(prepared) => self.open(prepared)?,
                Err(error) => {
                    *self.idle() = Some(opened);
                    return Err(error);
                }
            },
            None => self.open(Arc::new(PreparedScene::new(&loaded.scene, &loaded.settings)?))?,
        };
        output::check_memory(&prepared)?;
        let mut samples = Samples::try_new(&prepared)?;
        let mut rendered = opened.session.fill(&prepared, &mut samples, follower);
        *self.idle() = Some(opened);
        let failure = rendered.failure.take();
        let mut warnings: Vec<String> =
            loaded.warnings.iter().chain(&prepared.warnings).map(ToString::to_string).collect();
        warnings.append(&mut follower.warnings);
        let picture = rendered.picture(samples, &prepared, &loaded, Options::default());
        let Rendered { traced, reason, .. } = rendered;
        Ok(Outcome { film: Film::new(picture, traced, reason, warnings, scene.inputs()), failure })
    }

    /// A session for a scene that is prepared.
    fn open(&self, prepared: Arc<PreparedScene>) -> Result<(Arc<PreparedScene>, Opened), Error> {
        let (backends, name) = (registry::backends(), self.backend.as_str());
        let soon =
            self.single && name == registry::AUTO && self.device.is_none() && registry::is_soon(&prepared);
        let candidates = match self.single {
            true => registry::choose_for(&prepared, backends, name, self.device)?,
            false => registry::choose(name, self.device)?,
        };
        let session = gemtrace::Session::new(candidates, self.open).with_prepared(Arc::clone(&prepared));
        Ok((prepared, Opened { session, soon }))
    }

    fn positions(
        &self,
        scene: &Scene,
        tilts: &[f64],
        conditions: &Conditions,
        follower: &mut Follower,
    ) -> Result<Vec<Position>, Error> {
        let [stone] = scene.loaded.scene.stones.as_slice() else {
            let count = scene.loaded.scene.stones.len();
            return Err(Error::Usage(format!("a scene of one stone can be measured; this one has {count}")));
        };
        let mut session = gemtrace::Session::new(registry::choose(&self.backend, self.device)?, self.open);
        let mut measurement = Measurement::new(stone, conditions, &mut session)?;
        tilts.iter().map(|&tilt| measurement.at(tilt, follower)).collect()
    }
}

/// Asks Python, now and then, whether to go on.
struct Follower {
    progress: Option<Py<PyAny>>,
    asked: Instant,
    /// The exception that ended the work.
    error: Option<PyErr>,
    stopped: bool,
    warnings: Vec<String>,
}

impl Follower {
    fn new(progress: Option<Py<PyAny>>) -> Self {
        Follower { progress, asked: Instant::now(), error: None, stopped: false, warnings: Vec::new() }
    }

    /// Ctrl-C, then the callback, which may say `False` to stop, or raise.
    fn ask(&mut self, py: Python<'_>, done: u64, total: u64) -> PyResult<()> {
        py.check_signals()?;
        if let Some(progress) = &self.progress {
            let answer = progress.bind(py).call1((done, total))?;
            self.stopped |= answer.extract::<bool>().is_ok_and(|go_on| !go_on);
        }
        Ok(())
    }

    /// Says that all is done.
    fn end(&mut self, py: Python<'_>, total: u64) {
        self.error = self.error.take().or(self.ask(py, total, total).err());
    }
}

impl Watch for Follower {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        if self.error.is_none() && !self.stopped && self.asked.elapsed() >= TICK {
            let asked = Python::try_attach(|py| self.ask(py, progress.done, progress.total));
            // The interpreter is about to end.
            self.stopped |= asked.is_none();
            self.error = asked.and_then(Result::err);
            self.asked = Instant::now();
        }
        if self.error.is_some() || self.stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn warning(&mut self, message: &str) {
        self.warnings.push(message.to_owned());
    }
}
