//! Many pictures with the same means: what sheets are made of.

use super::Console;
use crate::arguments::{Rendering, parse_stops};
use crate::progress::Bar;
use gemtrace::Error;
use gemtrace::output;
use gemtrace::registry::{self, Candidates, Choice};
use gemtrace::rendering::{self, Watch};
use gemtrace::scene_file::LoadedScene;
use spectral_core::film::Film;
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Background;
use spectral_core::tracer::Progress;
use std::ops::ControlFlow;
use std::sync::Arc;

/// What all pictures of a sequence or a sheet are taken with.
#[derive(Debug, Clone, clap::Args)]
pub struct Means {
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub rendering: Rendering,
    /// Brighten what is shown by this many stops, the same for all pictures; EXRs keep the scene's own values.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_stops)]
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
        let rest = means.rendering.candidates()?;
        Ok(Studio { means, current: None, rest, announced: false })
    }

    /// Prepares a scene with the size and samples that were asked for.
    ///
    /// # Errors
    /// [`Error::Core`] for what cannot be rendered.
    pub fn prepare(&self, loaded: &mut LoadedScene) -> Result<PreparedScene, Error> {
        self.means.rendering.overrides().apply(loaded);
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
        let options = self.means.rendering.options();
        let tell = self.means.rendering.backend == registry::AUTO && !self.announced;
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

    fn warning(&mut self, message: &str) {
        self.console.warn(message);
    }
}
