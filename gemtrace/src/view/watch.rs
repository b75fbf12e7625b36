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
use spectral_core::tracer::{Progress, TraceReport};
use std::ops::ControlFlow;

/// Follows one side.
pub struct Onlooker<'a> {
    hub: &'a Hub,
    inbox: &'a Inbox,
    side: Letter,
    answers: u64,
    loaded: LoadedScene,
    tone: &'static str,
    device: String,
    /// The most samples that a pixel gets.
    of: u32,
    /// What earlier renders of this picture traced.
    before: TraceReport,
}

impl<'a> Onlooker<'a> {
    pub fn new(hub: &'a Hub, inbox: &'a Inbox, letter: Letter, answers: u64, side: &Side) -> Self {
        let of = side.of();
        let (loaded, tone, device) = (side.loaded.clone(), side.tone, side.device.clone());
        Onlooker {
            hub,
            inbox,
            side: letter,
            answers,
            loaded,
            tone,
            device,
            of,
            before: side.rendered.traced.clone(),
        }
    }

    /// Shows a film, and says how far it is.
    pub fn show(&self, film: &Film, stage: &'static str, samples: u32) {
        let size = [film.width(), film.height()];
        let rgba = display::rgba(film, &self.loaded, self.tone);
        let (side, answers, format) = (self.side, self.answers, "rgba");
        let caption = Caption { side, size, answers, stage, samples, format };
        self.hub.picture(side, display::message(&caption, &rgba));
    }

    /// Tells how far a picture is.
    pub fn status(&self, stage: &str, samples: u32, change: Option<f64>, traced: &TraceReport) {
        let settings = &self.loaded.settings;
        let seconds = traced.trace.as_secs_f64();
        let rays = (seconds > 0.0).then(|| traced.rays as f64 / seconds);
        let dropped = (traced.energy.started > 0.0).then(|| traced.energy.dropped_share());
        let tolerance = (settings.tolerance > 0.0).then_some(settings.tolerance);
        self.hub.status(
            self.side,
            &json!({
                "type": "status", "side": self.side.name(), "stage": stage, "samples": samples,
                "of": self.of, "delta_e": change, "tolerance": tolerance, "rays_per_second": rays,
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

    fn pass(&mut self, film: &Film, samples: u32, of: u32, traced: &TraceReport) {
        // What an earlier call has done already takes no time, and has been shown.
        if traced.rays == 0 {
            return;
        }
        let mut all = self.before.clone();
        all += traced.clone();
        self.of = of;
        if samples < of {
            self.show(film, "refining", samples);
        }
        self.status("refining", samples, film.change(), &all);
    }

    fn warning(&mut self, message: &str) {
        self.hub.tell(&json!({ "type": "notice", "text": message }));
    }
}
