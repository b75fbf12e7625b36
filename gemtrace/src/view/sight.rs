//! What is seen at a moment, for questions that are answered elsewhere than on the thread that renders.

use super::display::{self, Caption};
use super::document::Setup;
use super::hub::{Hub, locked};
use super::message::Letter;
use super::side::Side;
use crate::Error;
use crate::output::Picture;
use crate::scene_file::{Draft, LoadedScene};
use spectral_core::color::RgbSpace;
use spectral_core::prepare::PreparedScene;
use spectral_core::tracer::DeviceInfo;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

/// How long a first picture may take where a question waits for it.
const PATIENCE: Duration = Duration::from_secs(2);

/// One side at a moment.
#[derive(Clone)]
pub struct Sight {
    pub setup: Setup,
    pub loaded: LoadedScene,
    /// In the size and the settings of a frame.
    pub prepared: Arc<PreparedScene>,
    /// The finished picture, once it is.
    pub picture: Option<Arc<Picture>>,
    /// Whether it cannot be finished.
    pub failed: bool,
    /// What renders it, once that is known.
    pub device: Option<DeviceInfo>,
    /// The newest change that is seen.
    pub answers: u64,
}

impl Sight {
    pub fn new(side: &Side, answers: u64) -> Self {
        Sight {
            setup: side.setup.clone(),
            loaded: side.loaded.clone(),
            prepared: Arc::clone(side.prepared()),
            picture: None,
            failed: false,
            device: side.device.clone(),
            answers,
        }
    }

    /// The scene that is seen.
    pub fn draft(&self) -> Draft {
        self.setup.sized([self.loaded.scene.width, self.loaded.scene.height])
    }

    /// Whether another sight is of the same picture.
    fn is_of(&self, other: &Sight) -> bool {
        let size = |sight: &Sight| [sight.loaded.scene.width, sight.loaded.scene.height];
        self.setup == other.setup && size(self) == size(other)
    }
}

/// Both sides.
#[derive(Default)]
pub struct Sights {
    now: Mutex<[Option<Arc<Sight>>; 2]>,
    news: Condvar,
}

impl Sights {
    pub fn set(&self, side: Letter, sight: Sight) -> Arc<Sight> {
        let sight = Arc::new(sight);
        locked(&self.now)[side as usize] = Some(Arc::clone(&sight));
        self.news.notify_all();
        sight
    }

    /// What is seen of a side now; where nothing is yet, soon.
    ///
    /// # Errors
    /// [`Error::Usage`] where there is no such side.
    pub fn get(&self, side: Letter) -> Result<Arc<Sight>, Error> {
        let now = locked(&self.now);
        let none = |now: &mut [Option<Arc<Sight>>; 2]| now[side as usize].is_none();
        let (now, _) =
            self.news.wait_timeout_while(now, PATIENCE, none).unwrap_or_else(PoisonError::into_inner);
        now[side as usize].clone().ok_or_else(|| Error::Usage(format!("there is no side {}", side.name())))
    }

    /// The finished picture of a sight, once it is; `None` if it will not be, because something else is seen now.
    pub fn wait(&self, side: Letter, wanted: &Sight) -> Option<Arc<Picture>> {
        let mut now = locked(&self.now);
        loop {
            let sight = now[side as usize].as_ref().filter(|sight| sight.is_of(wanted) && !sight.failed)?;
            if let Some(picture) = &sight.picture {
                return Some(Arc::clone(picture));
            }
            now = self.news.wait(now).unwrap_or_else(PoisonError::into_inner);
        }
    }

    pub fn forget(&self, side: Letter) {
        locked(&self.now)[side as usize] = None;
        self.news.notify_all();
    }

    /// Sends a finished picture, encoded beside the thread that renders, unless something newer is seen by then.
    pub fn settle(self: &Arc<Self>, side: Letter, sight: &Arc<Sight>, hub: &Arc<Hub>) {
        let (sights, sight, hub) = (Arc::clone(self), Arc::clone(sight), Arc::clone(hub));
        std::thread::spawn(move || {
            let Some(picture) = &sight.picture else { return };
            let (bytes, format) = match picture.png() {
                Ok(png) => (png, "png"),
                Err(_) => (display::rgba(&picture.film, &sight.loaded), "rgba"),
            };
            let size = [picture.film.width(), picture.film.height()];
            let samples = most_samples(picture);
            let wavelengths = sight.loaded.settings.wavelengths.len();
            let caption = Caption {
                side,
                size,
                answers: sight.answers,
                stage: "settled",
                samples,
                wavelengths,
                format,
            };
            let message = display::message(&caption, &bytes);
            let now = locked(&sights.now);
            if now[side as usize].as_ref().is_some_and(|now| Arc::ptr_eq(now, &sight)) {
                hub.picture(side, message);
            }
        });
    }

    /// Whether a picture is still being rendered.
    pub fn is_busy(&self) -> bool {
        locked(&self.now).iter().flatten().any(|sight| sight.picture.is_none() && !sight.failed)
    }

    /// Stops with which the bright parts of a side's picture are nearly white.
    pub fn exposure(&self, side: Letter) -> f64 {
        let Some(sight) = locked(&self.now)[side as usize].clone() else { return 0.0 };
        let Some(picture) = &sight.picture else { return sight.loaded.exposure };
        let pixels = picture.film.to_space(RgbSpace::Srgb).into_iter();
        let stones = pixels.filter(|pixel| pixel[3] > 0.5);
        let mut bright: Vec<f32> =
            stones.map(|[r, g, b, _]| r.max(g).max(b)).filter(|v| v.is_finite()).collect();
        if bright.is_empty() {
            return 0.0;
        }
        let place = (bright.len() * 98 / 100).min(bright.len() - 1);
        let (_, value, _) = bright.select_nth_unstable_by(place, f32::total_cmp);
        let stops = (0.9 / f64::from(value.max(1e-6))).log2().clamp(-16.0, 16.0);
        (stops * 20.0).round() / 20.0
    }
}

/// The samples of the pixel that has most.
fn most_samples(picture: &Picture) -> u32 {
    let film = &picture.film;
    (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| film.samples(x, y))).max().unwrap_or(0)
}
