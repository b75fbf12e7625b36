//! One side of a view while it is rendered: coarse frames while it moves, then the whole picture, pass by pass.

use super::document::Setup;
use super::pace::{Frame, LIMIT, Pace};
use crate::output::{Options, Picture};
use crate::scene_file::{Assets, LoadedScene};
use crate::session::Rendered;
use crate::{Error, Session, Watch};
use spectral_core::film::Film;
use spectral_core::prepare::PreparedScene;
use spectral_core::settings::{Quality, RenderSettings};
use spectral_core::tracer::{DeviceInfo, Progress};
use spectral_core::wavelength::WavelengthGrid;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Wavelengths of a frame while something moves.
const WAVELENGTHS: usize = 8;

/// A scene that is shown.
pub struct Side {
    session: Session,
    pace: Pace,
    /// What is shown, and what was read for it.
    pub setup: Setup,
    pub loaded: LoadedScene,
    /// For frames, and for the picture.
    moving: Arc<PreparedScene>,
    still: Option<Arc<PreparedScene>>,
    film: Option<Film>,
    /// The settings of the picture as its device has them, points or areas; `None` before that is known.
    pub settings: Option<RenderSettings>,
    /// The account of the picture so far.
    pub rendered: Rendered,
    pub size: [u32; 2],
    /// What renders it, once that is known.
    pub device: Option<DeviceInfo>,
    /// Whether a frame of it has yet to be shown, and whether its picture is done or cannot be.
    pub fresh: bool,
    pub rests: bool,
    /// Whether its ground is shaded for frames only.
    pub coarse: bool,
}

impl Side {
    /// A scene that is new here.
    ///
    /// # Errors
    /// As [`Draft::load`](crate::scene_file::Draft::load); [`Error::Core`] for what cannot be rendered.
    pub fn new(session: Session, setup: &Setup, size: [u32; 2], assets: &mut Assets) -> Result<Self, Error> {
        let loaded = coarsely(setup, size, assets)?;
        let pace = Pace::default();
        let moving = Arc::new(framed(&loaded, &pace.frame(size, 1.0), None)?);
        Ok(Side {
            session,
            pace,
            setup: setup.clone(),
            coarse: loaded.scene.environment.ground.is_some(),
            loaded,
            moving,
            still: None,
            film: None,
            settings: None,
            rendered: Rendered::default(),
            size,
            device: None,
            fresh: true,
            rests: false,
        })
    }

    /// Shows another scene, if it can be.
    ///
    /// # Errors
    /// As [`new`](Self::new); the scene before it then stays.
    pub fn change(&mut self, setup: &Setup, size: [u32; 2], assets: &mut Assets) -> Result<(), Error> {
        let loaded = coarsely(setup, size, assets)?;
        let moving = framed(&loaded, &self.pace.frame(size, 1.0), Some(&self.moving))?;
        self.pace.expect(&moving);
        let alone = |scene: &PreparedScene| scene.lone_convex_stone().is_some();
        if loaded.settings != self.loaded.settings || alone(&moving) != alone(&self.moving) {
            self.settings = None;
        }
        self.coarse = loaded.scene.environment.ground.is_some();
        (self.setup, self.loaded, self.size, self.moving) = (setup.clone(), loaded, size, Arc::new(moving));
        (self.fresh, self.rests) = (true, false);
        Ok(())
    }

    /// The scene of the frames, which is that of the picture but for its size and settings.
    pub fn prepared(&self) -> &Arc<PreparedScene> {
        &self.moving
    }

    /// A coarse picture in `share` of the time of a frame. `None` where it is broken off, since `hurry` says that
    /// something newer waits, and where the device fails.
    pub fn frame(&mut self, share: f64, hurry: &dyn Fn() -> bool, watch: &mut dyn Watch) -> Option<Film> {
        for attempt in 0..3 {
            let frame = self.pace.frame(self.size, share);
            let scene = Arc::new(framed(&self.loaded, &frame, Some(&self.moving)).ok()?);
            self.moving = Arc::clone(&scene);
            let mut film = Film::try_new(&scene).ok()?;
            let start = Instant::now();
            let late = |took: Duration| took > LIMIT && (attempt == 0 || hurry());
            let mut clock = Clock { start, done: 0, late: &late, watch: &mut *watch };
            let rendered = self.session.fill(&scene, &mut film, &mut clock);
            let done = if rendered.traced.finished { film.total_samples() } else { clock.done };
            self.pace.learn(done, start.elapsed());
            if rendered.traced.finished {
                self.fresh = false;
                self.device(&rendered);
                return Some(film);
            }
            if rendered.failure.is_some() {
                self.fresh = false;
                return None;
            }
            if hurry() && attempt > 0 {
                return None;
            }
        }
        None
    }

    /// Shades the ground as the picture has it.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn shade(&mut self, assets: &mut Assets) -> Result<(), Error> {
        self.loaded = self.setup.sized(self.size).load(assets)?;
        self.coarse = false;
        Ok(())
    }

    /// Goes on with the picture itself; `watch` is told of every pass and may break it off.
    ///
    /// # Errors
    /// [`Error::Render`] where no device is left; [`Error::Core`] for what cannot be rendered.
    pub fn refine(&mut self, watch: &mut dyn Watch) -> Result<Option<Picture>, Error> {
        let still = self.still.as_deref();
        let base = still.unwrap_or(&self.moving);
        let next = base.update(&self.loaded.scene, &self.loaded.settings)?;
        let (scene, mut film) = match (self.still.take(), self.film.take()) {
            (Some(same), Some(film)) if shows_the_same(&same, &next) => (same, film),
            _ => {
                self.rendered = Rendered::default();
                let next = Arc::new(next);
                crate::output::check_memory(&next)?;
                let film = Film::try_new(&next)?;
                (next, film)
            }
        };
        let rendered = self.session.fill(&scene, &mut film, watch);
        let finished = rendered.traced.finished;
        self.settings = Some(rendered.shown(&scene).settings.clone());
        self.note(&rendered);
        let picture =
            finished.then(|| self.rendered.picture(film.clone(), &scene, &self.loaded, Options::default()));
        (self.still, self.film) = (Some(scene), Some(film));
        self.rests = finished || rendered.failure.is_some();
        rendered.failure.map_or(Ok(picture), Err)
    }

    /// Notes what renders.
    fn device(&mut self, rendered: &Rendered) {
        if let Some(device) = rendered.devices.last() {
            self.device = Some(device.clone());
        }
    }

    /// Adds what was traced of the picture in one go.
    fn note(&mut self, rendered: &Rendered) {
        self.device(rendered);
        self.rendered.scene.clone_from(&rendered.scene);
        self.rendered.traced += rendered.traced.clone();
        for device in &rendered.devices {
            if self.rendered.devices.last() != Some(device) {
                self.rendered.devices.push(device.clone());
            }
        }
    }
}

/// A scene whose ground is shaded for frames.
fn coarsely(setup: &Setup, size: [u32; 2], assets: &mut Assets) -> Result<LoadedScene, Error> {
    assets.shade_coarsely(true);
    let loaded = setup.sized(size).load(assets);
    assets.shade_coarsely(false);
    loaded
}

/// The scene as a frame shows it.
fn framed(
    loaded: &LoadedScene,
    frame: &Frame,
    before: Option<&PreparedScene>,
) -> Result<PreparedScene, Error> {
    let mut scene = loaded.scene.clone();
    [scene.width, scene.height] = frame.size;
    let range = loaded.settings.wavelengths.range();
    let wavelengths = match loaded.settings.wavelengths.len() {
        0..=WAVELENGTHS => loaded.settings.wavelengths.clone(),
        _ => WavelengthGrid::midpoints(range, WAVELENGTHS)?,
    };
    let settings = RenderSettings {
        wavelengths,
        jitter: false,
        spectral: false,
        polarized: loaded.settings.polarized,
        leftover: loaded.settings.leftover,
        ..loaded.settings.clone().at(Quality::Draft).with_samples(frame.samples)
    };
    Ok(match before {
        Some(before) => before.update(&scene, &settings)?,
        None => PreparedScene::new(&scene, &settings)?,
    })
}

/// Whether the samples of one scene are those of another.
fn shows_the_same(a: &PreparedScene, b: &PreparedScene) -> bool {
    Arc::ptr_eq(&a.geometry, &b.geometry)
        && Arc::ptr_eq(&a.environment, &b.environment)
        && Arc::ptr_eq(&a.optics, &b.optics)
        && (&a.view, a.width, a.height, a.background) == (&b.view, b.width, b.height, b.background)
        && a.settings == b.settings
}

/// Looks at the time that a frame takes.
struct Clock<'a> {
    start: Instant,
    done: u64,
    late: &'a dyn Fn(Duration) -> bool,
    watch: &'a mut dyn Watch,
}

impl Watch for Clock<'_> {
    fn chosen(&mut self, choice: &crate::registry::Choice) {
        self.watch.chosen(choice);
    }

    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self.done = progress.done;
        if (self.late)(self.start.elapsed()) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn warning(&mut self, message: &str) {
        self.watch.warning(message);
    }
}
