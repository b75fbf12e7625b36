//! A device that stays open, and the pictures that it makes one after the other.

use crate::Error;
use crate::output::{self, Options, Picture};
use crate::registry::{self, Choice, label};
use crate::scene_file::{Assets, LoadedScene};
use spectral_core::{
    film::{Film, Missing},
    prepare::PreparedScene,
    scene::Scene,
    settings::{Coverage, RenderSettings},
    tracer::{Device, DeviceInfo, OpenOptions, Progress, TraceReport, Tracer},
};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

/// The points at which a picture is first judged; nine is the fewest that any part of it gets. Of areas it is one.
const LEAST: u32 = 3;

/// Someone who follows a render. Every method may be left out; `()` leaves out all, and a closure that takes a
/// [`Progress`] is a watcher, too.
#[allow(unused_variables, reason = "names of arguments are documentation")]
pub trait Watch {
    /// A device is about to be opened for the first time.
    fn chosen(&mut self, choice: &Choice) {}

    /// Pixel samples done, of the whole film; there will be fewer in all where parts of it settle. A break stops the
    /// render.
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// A pass is over: no pixel of the film needs any of its first `samples` samples. The settings are those of the device:
    /// where its samples are areas, their number and tolerance are those of areas.
    fn pass(&mut self, film: &Film, samples: u32, settings: &RenderSettings, traced: &TraceReport) {}

    /// Something went wrong that does not stop the work, such as a device that failed and was replaced; one line.
    fn warning(&mut self, message: &str) {}
}

impl Watch for () {}

impl<F: FnMut(Progress) -> ControlFlow<()>> Watch for F {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self(progress)
    }
}

/// The outcome of a render.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Rendered {
    /// The account of all devices together.
    pub traced: TraceReport,
    /// The scene as the film shows it: its samples are points if a device could not follow areas. `None` where no device was
    /// opened.
    pub scene: Option<Arc<PreparedScene>>,
    /// The devices that added to the film, in order.
    pub devices: Vec<DeviceInfo>,
    /// Why the last device was taken.
    pub reason: String,
    /// Why the film is not finished, unless the watcher broke it off.
    pub failure: Option<Error>,
}

impl Rendered {
    /// The picture of the film that was rendered, finished or not.
    pub fn picture(
        &self,
        film: Film,
        scene: &PreparedScene,
        loaded: &LoadedScene,
        options: Options,
    ) -> Picture {
        Picture::new(film, self.shown(scene), loaded, &self.devices, &self.traced, options)
    }

    /// The scene as the film shows it, of the one that was to be rendered.
    pub fn shown<'a>(&'a self, scene: &'a PreparedScene) -> &'a PreparedScene {
        self.scene.as_deref().unwrap_or(scene)
    }
}

/// Renders scene after scene: on the first of its candidates that can, and on the next from where that one fails.
///
/// ```
/// use gemtrace::Session;
/// use spectral_core::film::Film;
///
/// let [subject, _] = spectral_core::probe::subjects()?;
/// let mut film = Film::new(&subject.scene);
/// let rendered = Session::open("cpu")?.fill(&subject.scene, &mut film, &mut ());
/// assert!(rendered.traced.finished && rendered.devices[0].backend == "cpu");
/// # Ok::<(), gemtrace::Error>(())
/// ```
pub struct Session {
    /// The device that rendered last; it is opened again after it has failed.
    current: Option<(Choice, Option<Box<dyn Device>>)>,
    /// Those that follow if it fails.
    candidates: Box<dyn Iterator<Item = Choice> + Send>,
    options: OpenOptions,
    /// The latest scene, whose parts the next one may share.
    prepared: Option<Arc<PreparedScene>>,
    /// The latest scene that was rendered: as it was asked for, and as it was shown.
    shown: Option<[Arc<PreparedScene>; 2]>,
    /// What the files of the latest scene were decoded to.
    pub assets: Assets,
    /// Colour space, bits, exposure and tone of the pictures.
    pub output: Options,
}

impl Session {
    /// The backend of a name with its first device, or [`AUTO`](registry::AUTO).
    ///
    /// # Errors
    /// As [`registry::choose`].
    pub fn open(backend: &str) -> Result<Self, Error> {
        Ok(Session::new(registry::choose(backend, None)?, OpenOptions::default()))
    }

    /// With these devices, best first.
    pub fn new<C>(candidates: C, options: OpenOptions) -> Self
    where
        C: IntoIterator<Item = Choice>,
        C::IntoIter: Send + 'static,
    {
        let candidates = Box::new(candidates.into_iter());
        Session {
            current: None,
            candidates,
            options,
            prepared: None,
            shown: None,
            assets: Assets::default(),
            output: Options::default(),
        }
    }

    /// The same with a scene that is prepared already, of which the next may share parts.
    #[must_use]
    pub fn with_prepared(mut self, scene: Arc<PreparedScene>) -> Self {
        self.prepared = Some(scene);
        self
    }

    /// Reads a scene file and the files that it names, but for those that the scene before it named.
    ///
    /// # Errors
    /// As [`scene_file::load`](crate::scene_file::load).
    pub fn load(&mut self, path: impl AsRef<Path>) -> Result<LoadedScene, Error> {
        self.assets.load(path.as_ref())
    }

    /// Renders a scene.
    ///
    /// # Errors
    /// [`Error::Core`] for what cannot be rendered; [`Error::Render`] where no device is left.
    pub fn render(&mut self, scene: impl Into<LoadedScene>) -> Result<Picture, Error> {
        self.render_watched(scene, &mut ())
    }

    /// The same, followed by someone who may stop it.
    ///
    /// # Errors
    /// As [`render`](Session::render); [`Error::Interrupted`] where the watcher stopped it.
    pub fn render_watched(
        &mut self,
        scene: impl Into<LoadedScene>,
        watch: &mut dyn Watch,
    ) -> Result<Picture, Error> {
        let mut loaded = scene.into();
        let scene = self.prepare(&loaded.scene, &loaded.settings)?;
        // Prepared, they are not needed any more, and meshes are large.
        loaded.scene.stones = Vec::new();
        let (film, rendered) = self.film(&scene, watch)?;
        Ok(rendered.picture(film, &scene, &loaded, self.output))
    }

    /// Prepares a scene: only what it does not have in common with the one before it.
    ///
    /// # Errors
    /// [`Error::Core`] for what cannot be rendered.
    pub fn prepare(&mut self, scene: &Scene, settings: &RenderSettings) -> Result<Arc<PreparedScene>, Error> {
        let in_points = self.current.as_ref().is_some_and(|(choice, _)| !choice.backend.areas);
        // The device would not be given the optics of areas.
        let settings = &match settings.coverage {
            Coverage::Auto if in_points => RenderSettings { coverage: Coverage::Points, ..settings.clone() },
            _ => settings.clone(),
        };
        let prepared = match self.prepared.take() {
            Some(before) => before.update(scene, settings)?,
            None => PreparedScene::new(scene, settings)?,
        };
        Ok(Arc::clone(self.prepared.insert(Arc::new(prepared))))
    }

    /// The finished film of a scene.
    ///
    /// # Errors
    /// [`Error::Render`] where no device is left; [`Error::Interrupted`] where the watcher stopped it; [`Error::Core`]
    /// where there is not enough memory.
    pub fn film(
        &mut self,
        scene: &Arc<PreparedScene>,
        watch: &mut dyn Watch,
    ) -> Result<(Film, Rendered), Error> {
        output::check_memory(scene)?;
        let mut film = Film::try_new(scene)?;
        let mut rendered = self.fill(scene, &mut film, watch);
        match rendered.failure.take() {
            Some(error) => Err(error),
            None if rendered.traced.finished => Ok((film, rendered)),
            None => Err(Error::Interrupted),
        }
    }

    /// Adds all of a scene's samples to a film, in passes that grow, so that a picture that is broken off is whole if
    /// coarser, and that parts of it whose samples agree are left alone from then on, if the settings say so. Where a
    /// device fails, the next carries on from what is in the film; where none is left, the last is asked again for the
    /// next film: it may have been this scene's fault.
    pub fn fill(&mut self, scene: &Arc<PreparedScene>, film: &mut Film, watch: &mut dyn Watch) -> Rendered {
        let mut rendered = Rendered::default();
        // A film that is carried on goes on as it began.
        if let Some([_, shown]) = self.shown.as_ref().filter(|[asked, _]| Arc::ptr_eq(asked, scene)) {
            rendered.scene = Some(Arc::clone(shown)).filter(|_| film.total_samples() > 0);
        }
        let mut known = self.current.take();
        while let Some((choice, open)) = known.take().or_else(|| self.next(&mut rendered, watch)) {
            rendered.reason.clone_from(&choice.reason);
            match self.trace_on(&choice, open, scene, film, watch, &mut rendered) {
                Ok(device) => {
                    self.current = Some((choice, Some(device)));
                    return rendered;
                }
                Err(error) => {
                    rendered.failure = Some(failure(&choice, error));
                    self.current = Some((choice, None));
                }
            }
        }
        if self.current.is_none() {
            let message = "no device is left".to_owned();
            rendered.failure = Some(Error::Render { device: registry::AUTO.to_owned(), message });
        }
        rendered
    }

    /// The next candidate, which carries on where one has failed.
    fn next(
        &mut self,
        rendered: &mut Rendered,
        watch: &mut dyn Watch,
    ) -> Option<(Choice, Option<Box<dyn Device>>)> {
        let choice = self.candidates.next()?;
        if let Some(error) = rendered.failure.take() {
            watch.warning(&format!("{error}; {} carries on", label(&choice.device)));
        }
        watch.chosen(&choice);
        Some((choice, None))
    }

    /// All passes on one device, which is opened if need be.
    fn trace_on(
        &mut self,
        choice: &Choice,
        open: Option<Box<dyn Device>>,
        scene: &Arc<PreparedScene>,
        film: &mut Film,
        watch: &mut dyn Watch,
        rendered: &mut Rendered,
    ) -> Result<Box<dyn Device>, spectral_core::Error> {
        let mut device = open.map_or_else(|| (choice.backend.open)(&choice.device, &self.options), Ok)?;
        let shown = self.as_shown(choice, scene, film, rendered, watch)?;
        rendered.scene = Some(Arc::clone(&shown));
        self.shown = Some([Arc::clone(scene), Arc::clone(&shown)]);
        passes(&mut *device.load(Arc::clone(&shown))?, &shown, film, watch, rendered)?;
        Ok(device)
    }

    /// The scene as a device is to show it: in points if it cannot follow areas, or if the film has points already.
    fn as_shown(
        &self,
        choice: &Choice,
        scene: &Arc<PreparedScene>,
        film: &Film,
        rendered: &Rendered,
        watch: &mut dyn Watch,
    ) -> Result<Arc<PreparedScene>, spectral_core::Error> {
        let begun = rendered.scene.as_ref().filter(|_| film.total_samples() > 0);
        let shown = begun.unwrap_or(scene);
        if shown.silhouette.is_none() || choice.backend.areas {
            return Ok(Arc::clone(shown));
        }
        if begun.is_some() {
            let message = "it cannot carry on a picture whose samples are areas".to_owned();
            return Err(spectral_core::Error::Device { device: label(&choice.device), message });
        }
        let points = shown.in_points(self.shown.as_ref().map(|[_, before]| &**before))?;
        points.warnings[shown.warnings.len()..].iter().for_each(|remark| watch.warning(&remark.message));
        Ok(Arc::new(points))
    }
}

/// All passes on one device; those that the film has already take no time.
fn passes(
    tracer: &mut dyn Tracer,
    scene: &PreparedScene,
    film: &mut Film,
    watch: &mut dyn Watch,
    rendered: &mut Rendered,
) -> Result<(), spectral_core::Error> {
    let RenderSettings { samples, tolerance, .. } = scene.settings;
    // Samples are nested by threes where parts of the picture may stop early.
    let factor = if tolerance > 0.0 { 3 } else { 2 };
    let mut first = 0;
    while first < samples {
        let pass = first..first.saturating_mul(factor).clamp(first + 1, samples);
        first = pass.end;
        let before = film.total_samples();
        let total = before + film.missing(film.tile(), &(0..samples)).iter().map(Missing::count).sum::<u64>();
        let mut progress =
            |progress: Progress| watch.progress(Progress { done: before + progress.done, total });
        let (report, error) = match tracer.trace(pass, film, &mut progress) {
            Ok(report) => (report, None),
            Err(failure) => (failure.report, Some(failure.error)),
        };
        if report.energy.started > 0.0 && rendered.devices.last() != Some(tracer.device()) {
            rendered.devices.push(tracer.device().clone());
        }
        rendered.traced += report;
        error.map_or(Ok(()), Err)?;
        if !rendered.traced.finished {
            break;
        }
        if tolerance > 0.0 && (first >= LEAST || scene.silhouette.is_some()) {
            film.settle(first, tolerance, scene.settings.block());
        }
        watch.pass(film, first, &scene.settings, &rendered.traced);
    }
    Ok(())
}

fn failure(choice: &Choice, error: spectral_core::Error) -> Error {
    let message = match error {
        spectral_core::Error::Device { message, .. } => message,
        other => other.to_string(),
    };
    Error::Render { device: label(&choice.device), message }
}
