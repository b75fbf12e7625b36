//! A film filled by the first device that can, and carried on by the next if that one fails.

use crate::{
    Error,
    registry::{Choice, label},
};
use spectral_core::{
    film::{Film, Missing},
    prepare::PreparedScene,
    settings::RenderSettings,
    tracer::{DeviceInfo, OpenOptions, Progress, TraceReport, Tracer},
};
use std::ops::ControlFlow;
use std::sync::Arc;

/// The samples at which a picture is first judged; nine is the fewest that any part of it gets.
const LEAST: u32 = 3;

/// Someone who follows a render. Every method may be left out; `()` leaves out all, and a closure that takes a
/// [`Progress`] is a watcher, too.
#[allow(unused_variables, reason = "names of arguments are documentation")]
pub trait Watch {
    /// A device is about to be opened.
    fn chosen(&mut self, choice: &Choice) {}

    /// Pixel samples done, of the whole film; there will be fewer in all where parts of it settle. A break stops the
    /// render.
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Something went wrong that does not stop the work, such as a device that failed and was replaced; one line.
    fn warning(&mut self, message: &str) {}
}

impl Watch for () {}

impl<F: FnMut(Progress) -> ControlFlow<()>> Watch for F {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self(progress)
    }
}

/// What became of a render.
#[derive(Debug, Clone, Default)]
pub struct Rendered {
    /// The account of all devices together.
    pub traced: TraceReport,
    /// The devices that added to the film, in order.
    pub devices: Vec<DeviceInfo>,
    /// Why the last device was taken.
    pub reason: String,
    /// Why the film is not finished, unless the watcher broke it off.
    pub failure: Option<Error>,
}

/// Adds all of a scene's samples to a film, in passes that double, so that a picture that is broken off is whole if
/// coarser, and that parts of it whose samples agree are left alone from then on, if the settings say so. The first of `candidates` begins; where one fails, the next carries on from what is in the film.
///
/// ```
/// use gemtrace::{registry, rendering};
/// use spectral_core::{film::Film, tracer::OpenOptions};
///
/// let [subject, _] = spectral_core::probe::subjects()?;
/// let mut film = Film::new(&subject.scene);
/// let candidates = registry::choose("cpu", None)?;
/// let rendered = rendering::render(candidates, &subject.scene, &mut film, &OpenOptions::default(), &mut ());
/// assert!(rendered.traced.finished && rendered.devices[0].backend == "cpu");
/// # Ok::<(), gemtrace::Error>(())
/// ```
pub fn render(
    candidates: impl IntoIterator<Item = Choice>,
    scene: &Arc<PreparedScene>,
    film: &mut Film,
    options: &OpenOptions,
    watch: &mut dyn Watch,
) -> Rendered {
    let mut rendered = Rendered::default();
    for choice in candidates {
        if let Some(error) = rendered.failure.take() {
            watch.warning(&format!("{error}; {} carries on", label(&choice.backend, &choice.device)));
        }
        watch.chosen(&choice);
        rendered.reason.clone_from(&choice.reason);
        let outcome = choice
            .backend
            .tracer(&choice.device, Arc::clone(scene), options)
            .and_then(|mut tracer| passes(&mut *tracer, scene, film, watch, &mut rendered));
        match outcome {
            Ok(()) => return rendered,
            Err(error) => rendered.failure = Some(failure(&choice, error)),
        }
    }
    rendered
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
        if tolerance > 0.0 && first >= LEAST {
            film.settle(first, tolerance);
        }
    }
    Ok(())
}

fn failure(choice: &Choice, error: spectral_core::Error) -> Error {
    let message = match error {
        spectral_core::Error::Device { message, .. } => message,
        other => other.to_string(),
    };
    Error::Render { device: label(&choice.backend, &choice.device), message }
}
