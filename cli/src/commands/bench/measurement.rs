//! One scene on all entrants, in rounds.

use super::entrant::Entrant;
use crate::console::Interrupt;
use crate::progress::Bar;
use backend_cpu::CPU;
use spectral_core::film::{Agreement, Film};
use spectral_core::prepare::PreparedScene;
use spectral_core::tracer::{Energy, OpenOptions, Progress, TraceReport, Tracer};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::time::Instant;

/// One whole picture.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    /// Wall time of the call, s.
    pub seconds: f64,
    /// Rays by the backend's own count and clock, 1/s.
    pub rays_per_second: f64,
}

/// What was found out about an entrant on a scene.
pub struct Measurement {
    pub entrant: Entrant,
    /// Time to open the device for the scene, s.
    pub open: Option<f64>,
    /// The part of it in which acceleration structures were built and shaders compiled, s.
    pub build: f64,
    /// From the call that opens the device to the first pixels of the warm-up, s.
    pub first_pixel: Option<f64>,
    /// One for each round that was finished.
    pub runs: Vec<Run>,
    /// Rays of one picture.
    pub rays: u64,
    /// Where the energy of one picture went.
    pub energy: Energy,
    /// The picture.
    pub film: Option<Film>,
    /// Whether all rounds gave the same bits.
    pub repeats: bool,
    /// How far the picture is from the CPU backend's.
    pub agreement: Option<Agreement>,
    /// The CPU backend's time over this one's, each round by itself.
    pub speeds: Vec<f64>,
    /// Why this entrant did not finish.
    pub failure: Option<String>,
}

/// Median and range of some measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    pub median: f64,
    pub min: f64,
    pub max: f64,
}

impl Spread {
    /// `None` of nothing.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let (min, max) = (*values.first()?, *values.last()?);
        let middle = values.len() / 2;
        let median =
            if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 };
        Some(Spread { median, min, max })
    }
}

impl Measurement {
    fn new(entrant: Entrant) -> Self {
        Measurement {
            entrant,
            open: None,
            build: 0.0,
            first_pixel: None,
            runs: Vec::new(),
            rays: 0,
            energy: Energy::default(),
            film: None,
            repeats: true,
            agreement: None,
            speeds: Vec::new(),
            failure: None,
        }
    }

    /// Wall times of the runs, s.
    pub fn seconds(&self) -> Option<Spread> {
        Spread::of(self.runs.iter().map(|r| r.seconds))
    }

    /// Rays a second of the runs.
    pub fn rate(&self) -> Option<Spread> {
        Spread::of(self.runs.iter().map(|r| r.rays_per_second))
    }

    /// How many times as fast as the CPU backend, over the rounds.
    pub fn speed(&self) -> Option<Spread> {
        Spread::of(self.speeds.iter().copied())
    }
}

/// Why an entrant stops.
enum Stop {
    /// Someone asked to.
    Interrupted,
    Failed(String),
}

/// An entrant with its open device.
struct Racer {
    measurement: Measurement,
    tracer: Option<Box<dyn Tracer>>,
}

/// The scene, and who watches.
struct Race<'a> {
    scene: &'a Arc<PreparedScene>,
    interrupt: &'a Interrupt,
    bar: Bar,
    /// Pixel samples that are behind us.
    done: u64,
}

/// Opens every entrant that the scene suits, warms it up with one sample a pixel, and then lets each render the
/// picture once in every round. Who begins changes from round to round, so that whatever drifts (heat, other
/// programs) meets all alike.
///
/// On a request to stop, what belongs to rounds that were not finished by an entrant is left out.
pub fn measure(
    scene: &Arc<PreparedScene>,
    entrants: &[Entrant],
    rounds: usize,
    interrupt: &Interrupt,
    quiet: bool,
) -> Vec<Measurement> {
    let mut racers: Vec<Racer> = entrants
        .iter()
        .filter(|entrant| entrant.enters(scene))
        .map(|entrant| Racer { measurement: Measurement::new(entrant.clone()), tracer: None })
        .collect();
    let pictures = (racers.len() * rounds) as u64;
    let bar = Bar::new(pictures * samples(scene, &(0..scene.settings.samples)), quiet);
    let mut race = Race { scene, interrupt, bar, done: 0 };
    // An interrupted race is compared as far as it went.
    let _ = race.run(&mut racers, rounds);
    race.compare(&mut racers);
    let mut measurements: Vec<_> = racers.into_iter().map(|racer| racer.measurement).collect();
    compare_speeds(&mut measurements);
    measurements
}

/// Pixel samples of a call.
fn samples(scene: &PreparedScene, range: &Range<u32>) -> u64 {
    u64::from(scene.width) * u64::from(scene.height) * range.len() as u64
}

impl Race<'_> {
    fn run(&mut self, racers: &mut [Racer], rounds: usize) -> ControlFlow<()> {
        for racer in &mut *racers {
            let result = self.open(racer);
            racer.settle(result)?;
        }
        for round in 0..rounds {
            for k in 0..racers.len() {
                let racer = &mut racers[(k + round) % racers.len()];
                let result = self.render(racer);
                racer.settle(result)?;
            }
        }
        ControlFlow::Continue(())
    }

    fn open(&self, racer: &mut Racer) -> Result<(), Stop> {
        self.heed()?;
        let Racer { measurement, tracer } = racer;
        let entrant = &measurement.entrant;
        let start = Instant::now();
        let opened = entrant
            .backend
            .tracer(&entrant.device, Arc::clone(self.scene), &OpenOptions::default())
            .map_err(|e| Stop::Failed(e.to_string()))?;
        measurement.open = Some(start.elapsed().as_secs_f64());
        let mut film = Film::new(self.scene);
        let mut first = None;
        let report = self.trace(tracer.insert(opened).as_mut(), 0..1, &mut film, &mut |progress| {
            if progress.done > 0 {
                first.get_or_insert_with(|| start.elapsed());
            }
        })?;
        measurement.first_pixel = Some(first.unwrap_or_else(|| start.elapsed()).as_secs_f64());
        measurement.build = report.build.as_secs_f64();
        Ok(())
    }

    fn render(&mut self, racer: &mut Racer) -> Result<(), Stop> {
        let Racer { measurement, tracer } = racer;
        let range = 0..self.scene.settings.samples;
        let before = self.done;
        self.done += samples(self.scene, &range);
        let Some(tracer) = tracer else { return Ok(()) };
        let mut film = Film::new(self.scene);
        let start = Instant::now();
        let report = self.trace(tracer.as_mut(), range, &mut film, &mut |p| self.bar.set(before + p.done))?;
        let seconds = start.elapsed().as_secs_f64();
        let rays_per_second = report.rays as f64 / report.trace.as_secs_f64().max(f64::MIN_POSITIVE);
        measurement.runs.push(Run { seconds, rays_per_second });
        measurement.rays = report.rays;
        measurement.energy = report.energy;
        measurement.repeats &= measurement.film.as_ref().is_none_or(|earlier| *earlier == film);
        measurement.film.get_or_insert(film);
        Ok(())
    }

    /// One call, watched.
    fn trace(
        &self,
        tracer: &mut dyn Tracer,
        range: Range<u32>,
        film: &mut Film,
        watch: &mut dyn FnMut(Progress),
    ) -> Result<TraceReport, Stop> {
        self.heed()?;
        let mut heed = |progress: Progress| {
            watch(progress);
            if self.interrupt.is_requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let report = tracer.trace(range, film, &mut heed).map_err(|e| Stop::Failed(e.to_string()))?;
        if report.finished { Ok(report) } else { Err(Stop::Interrupted) }
    }

    fn heed(&self) -> Result<(), Stop> {
        self.interrupt.heed();
        if self.interrupt.is_requested() { Err(Stop::Interrupted) } else { Ok(()) }
    }

    /// Holds every picture to the CPU backend's, which is made for it where that backend does not take part.
    fn compare(&self, racers: &mut [Racer]) {
        let own = racers.iter().find(|r| r.measurement.entrant.is_yardstick());
        let Some(expected) = own.and_then(|r| r.measurement.film.clone()).or_else(|| self.yardstick()) else {
            return;
        };
        for Racer { measurement, .. } in racers {
            let found = measurement.film.as_ref();
            // The films of one scene have one size.
            measurement.agreement = found.and_then(|film| Agreement::of(&expected, film).ok());
        }
    }

    fn yardstick(&self) -> Option<Film> {
        let device = (CPU.devices)().into_iter().next()?;
        let mut tracer = CPU.tracer(&device, Arc::clone(self.scene), &OpenOptions::default()).ok()?;
        let mut film = Film::new(self.scene);
        self.trace(tracer.as_mut(), 0..self.scene.settings.samples, &mut film, &mut |_| ()).ok()?;
        Some(film)
    }
}

impl Racer {
    /// A device that fails is out of the race, and its memory is given back; a request to stop ends the race.
    fn settle(&mut self, result: Result<(), Stop>) -> ControlFlow<()> {
        match result {
            Ok(()) => ControlFlow::Continue(()),
            Err(Stop::Interrupted) => ControlFlow::Break(()),
            Err(Stop::Failed(message)) => {
                self.measurement.failure = Some(message);
                self.tracer = None;
                ControlFlow::Continue(())
            }
        }
    }
}

/// Ratios are taken within a round, where both met the same machine.
fn compare_speeds(measurements: &mut [Measurement]) {
    let yardstick = measurements.iter().find(|m| m.entrant.is_yardstick());
    let Some(times) = yardstick.map(|m| m.runs.iter().map(|r| r.seconds).collect::<Vec<_>>()) else { return };
    for m in measurements {
        m.speeds = times.iter().zip(&m.runs).map(|(cpu, run)| cpu / run.seconds).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::super::entrant::entrants;
    use super::super::scene::Subject;
    use super::*;
    use crate::console::Console;
    use gemtrace::scene_file::Override;
    use spectral_core::Error;
    use spectral_core::tracer::Backend;

    /// The processor twice: once as it is, once with a driver that fails.
    fn sound_and_broken() -> [Entrant; 2] {
        let cpu = entrants(&["cpu".to_owned()]).unwrap().remove(0);
        let broken = Backend {
            name: "broken",
            open: |device, _| {
                Err(Error::Device { device: device.name.clone(), message: "on fire".to_owned() })
            },
            ..CPU
        };
        [Entrant { backend: broken, ..cpu.clone() }, cpu]
    }

    fn brilliant(interrupt: &Interrupt) -> Arc<PreparedScene> {
        let change = Override { size: Some([12, 12]), samples: Some(1), ..Override::default() };
        let mut log = std::io::sink();
        let mut console = Console { quiet: true, ..Console::new(&mut log, interrupt) };
        Subject::new("brilliant", change, &mut console).unwrap().prepared
    }

    #[test]
    fn a_device_that_fails_costs_the_others_nothing() {
        let interrupt = Interrupt::default();
        let scene = brilliant(&interrupt);
        let found = measure(&scene, &sound_and_broken(), 3, &interrupt, true);
        assert!(found[0].failure.as_ref().unwrap().contains("on fire") && found[0].runs.is_empty());
        let sound = &found[1];
        assert_eq!((sound.runs.len(), sound.speeds.as_slice(), sound.repeats), (3, &[1.0; 3][..], true));
        assert_eq!(sound.agreement.unwrap().worst, 0.0);
        assert!(sound.first_pixel > sound.open && sound.rays > 0);
    }

    #[test]
    fn a_request_to_stop_ends_the_race() {
        let interrupt = Interrupt::default();
        let scene = brilliant(&interrupt);
        interrupt.request();
        let found = measure(&scene, &sound_and_broken(), 3, &interrupt, true);
        assert!(found.iter().all(|m| m.runs.is_empty() && m.failure.is_none() && m.agreement.is_none()));
    }

    #[test]
    fn the_median_is_the_middle_or_between_the_two_middles() {
        assert_eq!(Spread::of([]), None);
        assert_eq!(Spread::of([3.0, 1.0, 10.0]), Some(Spread { median: 3.0, min: 1.0, max: 10.0 }));
        assert_eq!(Spread::of([4.0, 1.0, 2.0, 9.0]).unwrap().median, 3.0);
    }
}
