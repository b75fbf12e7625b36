//! Many pictures with the same means: what sheets are made of.

use super::{Console, render};
use crate::Error;
use crate::effort::Effort;
use crate::output;
use crate::progress::Bar;
use crate::registry::{self, Candidates, Choice};
use crate::rendering::{self, Watch};
use crate::scene_file::LoadedScene;
use spectral_core::film::Film;
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Background;
use spectral_core::tracer::{OpenOptions, Progress};
use std::ops::ControlFlow;
use std::sync::Arc;

/// What all pictures of a sequence or a sheet are taken with.
#[derive(Debug, Clone, clap::Args)]
pub struct Means {
    /// What renders: auto, or a name that `gemtrace devices` lists.
    #[arg(long, value_name = "NAME", default_value = registry::AUTO)]
    pub backend: String,
    /// Which of the backend's devices, counted from 0.
    #[arg(long, value_name = "N")]
    pub device: Option<usize>,
    /// How much work each is worth.
    #[command(flatten)]
    pub effort: Effort,
    /// Size of each picture in pixels, in place of the scene's.
    #[arg(long, value_name = "WxH", value_parser = render::parse_size)]
    pub size: Option<[u32; 2]>,
    /// Worker threads [default: one a core]; the pictures are the same for any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Brighten what is shown by this many stops, the same for all pictures; EXRs keep the scene's own values.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = render::parse_stops)]
    pub exposure: f64,
}

/// Takes one picture after the other with the device that took the last.
pub struct Studio<'a> {
    means: &'a Means,
    /// The device that works.
    current: Option<Choice>,
    /// Those that follow if it fails.
    rest: Candidates,
    announced: bool,
}

/// A finished picture.
pub struct Still {
    /// The samples.
    pub film: Film,
    /// What was rendered.
    pub scene: Arc<PreparedScene>,
    backdrop: Option<[f64; 3]>,
}

impl<'a> Studio<'a> {
    /// # Errors
    /// As [`registry::choose`].
    pub fn new(means: &'a Means) -> Result<Self, Error> {
        let rest = registry::choose(&means.backend, means.device)?;
        Ok(Studio { means, current: None, rest, announced: false })
    }

    /// Prepares a scene with the size and samples that were asked for.
    ///
    /// # Errors
    /// [`Error::Core`] for what cannot be rendered.
    pub fn prepare(&self, loaded: &mut LoadedScene) -> Result<PreparedScene, Error> {
        if let Some([width, height]) = self.means.size {
            (loaded.scene.width, loaded.scene.height) = (width, height);
        }
        loaded.settings = self.means.effort.over(&loaded.settings);
        Ok(PreparedScene::new(&loaded.scene, &loaded.settings)?)
    }

    /// Renders a scene; `bar` shows the whole, of which `before` pictures of this size are done.
    ///
    /// # Errors
    /// [`Error`] of the scene or the last device; [`Error::Interrupted`] where someone has asked to stop.
    pub fn take(
        &mut self,
        mut loaded: LoadedScene,
        console: &mut Console,
        bar: &Bar,
        before: u32,
    ) -> Result<Still, Error> {
        let scene = Arc::new(self.prepare(&mut loaded)?);
        loaded.scene.stones = Vec::new();
        let mut film = Film::new(&scene);
        let options =
            OpenOptions { threads: self.means.threads.map(|n| n as usize), ..OpenOptions::default() };
        let tell = self.means.backend == registry::AUTO && !self.announced;
        self.announced = true;
        let mut onlooker = Onlooker { console, bar, before, tell, choice: None };
        let candidates = self.current.take().into_iter().chain(&mut self.rest);
        let rendered = rendering::render(candidates, &scene, &mut film, &options, &mut onlooker);
        self.current = onlooker.choice;
        if !rendered.traced.finished {
            return Err(rendered.failure.unwrap_or(Error::Interrupted));
        }
        Ok(Still { film, scene, backdrop: loaded.backdrop })
    }
}

impl Still {
    /// Encoded sRGB with straight alpha, row by row.
    pub fn rgba(&self, exposure: f64) -> Vec<[u8; 4]> {
        let transparent = self.scene.background == Background::Transparent;
        output::rgba(&self.film, transparent, self.backdrop, exposure)
    }
}

/// A bar for `count` pictures like this.
pub fn bar(scene: &PreparedScene, count: u32, quiet: bool) -> Bar {
    Bar::new(picture_steps(scene.width, scene.height, scene.settings.samples) * u64::from(count), quiet)
}

fn picture_steps(width: u32, height: u32, samples: u32) -> u64 {
    u64::from(width) * u64::from(height) * u64::from(samples)
}

struct Onlooker<'a, 'b> {
    console: &'a mut Console<'b>,
    bar: &'a Bar,
    before: u32,
    /// Whether to say which device was chosen.
    tell: bool,
    choice: Option<Choice>,
}

impl Watch for Onlooker<'_, '_> {
    fn chosen(&mut self, choice: &Choice) {
        if self.tell {
            self.console.say(&choice.reason);
        }
        self.choice = Some(choice.clone());
    }

    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self.console.interrupt.heed();
        self.bar.set(progress.total * u64::from(self.before) + progress.done);
        if self.console.interrupt.is_requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn replaced(&mut self, message: &str) {
        self.console.warn(message);
    }
}
