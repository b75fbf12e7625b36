//! Who follows a render for the pages: pictures after every pass, the account, and whether something newer waits.

use super::display::{self, Caption};
use super::hub::Hub;
use super::inbox::Inbox;
use super::message::Letter;
use super::side::Side;
use crate::Watch;
use crate::registry::{Choice, label};
use crate::scene_file::LoadedScene;
use serde_json::json;
use spectral_core::film::Film;
use spectral_core::settings::{Coverage, RenderSettings};
use spectral_core::tracer::{Progress, TraceReport};
use std::ops::ControlFlow;
use std::time::Duration;

/// How long other work rests where pictures are rendered.
const REST: Duration = Duration::from_millis(5);

/// Follows work that lets pictures go first, and ends where nobody wants it any more.
pub struct Patience<'a> {
    pub busy: &'a dyn Fn() -> bool,
    pub over: &'a dyn Fn() -> bool,
}

impl Watch for Patience<'_> {
    fn progress(&mut self, _: Progress) -> ControlFlow<()> {
        while (self.busy)() && !(self.over)() {
            std::thread::sleep(REST);
        }
        if (self.over)() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Follows one side.
pub struct Onlooker<'a> {
    hub: &'a Hub,
    inbox: &'a Inbox,
    side: Letter,
    answers: u64,
    loaded: LoadedScene,
    device: String,
    /// The settings of the picture, as its device has them; `None` before that is known.
    settings: Option<RenderSettings>,
    /// What earlier renders of this picture traced.
    before: TraceReport,
}

impl<'a> Onlooker<'a> {
    pub fn new(hub: &'a Hub, inbox: &'a Inbox, letter: Letter, answers: u64, side: &Side) -> Self {
        Onlooker {
            hub,
            inbox,
            side: letter,
            answers,
            loaded: side.loaded.clone(),
            device: side.device.as_ref().map(label).unwrap_or_default(),
            settings: side.settings.clone(),
            before: side.rendered.traced.clone(),
        }
    }

    /// Shows a film, and says how far it is.
    pub fn show(&self, film: &Film, stage: &'static str, samples: u32, wavelengths: usize) {
        let size = [film.width(), film.height()];
        let rgba = display::rgba(film, &self.loaded);
        let (side, answers, format) = (self.side, self.answers, "rgba");
        let caption = Caption { side, size, answers, stage, samples, wavelengths, format };
        self.hub.picture(side, display::message(&caption, &rgba));
    }

    /// Tells how far a picture is.
    pub fn status(&self, stage: &str, samples: u32, change: Option<f64>, traced: &TraceReport) {
        let settings = self.settings.as_ref();
        let (change, tolerance) = settings.map_or((None, None), |settings| {
            let tolerance = Some(settings.tolerance).filter(|tolerance| *tolerance > 0.0);
            (change.map(|change| left(change, settings)), tolerance.map(|change| left(change, settings)))
        });
        let seconds = traced.trace.as_secs_f64();
        let rays = (seconds > 0.0).then(|| traced.rays as f64 / seconds);
        let dropped = (traced.energy.started > 0.0).then(|| traced.energy.dropped_share());
        self.hub.status(
            self.side,
            &json!({
                "type": "status", "side": self.side.name(), "stage": stage, "samples": samples,
                "of": settings.map(|settings| settings.samples), "delta_e": change, "tolerance": tolerance, "rays_per_second": rays,
                "dropped": dropped, "device": self.device, "answers": self.answers,
            }),
        );
    }
}

impl Watch for Onlooker<'_> {
    fn chosen(&mut self, choice: &Choice) {
        self.device = label(&choice.device);
    }

    fn progress(&mut self, _: Progress) -> ControlFlow<()> {
        if self.inbox.is_waiting() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn pass(&mut self, film: &Film, samples: u32, settings: &RenderSettings, traced: &TraceReport) {
        // What an earlier call has done already takes no time, and has been shown.
        if traced.rays == 0 {
            return;
        }
        let mut all = self.before.clone();
        all += traced.clone();
        self.settings = Some(settings.clone());
        if samples < settings.samples {
            self.show(film, "refining", samples, settings.wavelengths.len());
        }
        self.status("refining", samples, film.change(), &all);
    }

    fn warning(&mut self, message: &str) {
        self.hub.tell(&json!({ "type": "notice", "text": message }));
    }
}

/// The error that is left, ΔE00, after the last change, by three times as many samples: that of areas falls with the square
/// of their number, that of points with its power ⅔.
fn left(change: f64, settings: &RenderSettings) -> f64 {
    let power = if settings.coverage == Coverage::Area { 2.0 } else { 2.0 / 3.0 };
    change / (3_f64.powf(power) - 1.0)
}
