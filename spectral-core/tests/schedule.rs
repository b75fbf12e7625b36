//! Batches on a device that fails: its finished tiles stay, and a sound one carries on.

use spectral_core::{
    Error,
    film::Film,
    kernel::{
        block::{Primary, Seen},
        schedule::{Finished, KernelTracer, Launch, overdue},
    },
    probe::subjects,
    tracer::{DeviceInfo, OpenOptions, TraceReport, Tracer},
};
use std::ops::ControlFlow;
use std::time::Duration;

/// What happens at a call.
#[derive(Clone, Copy)]
enum Fault {
    None,
    /// No memory for the batch after so many.
    Full(u32),
    /// The dispatch after so many ends with this message.
    Ends(u32, &'static str),
}

/// Shows each camera ray as its own direction.
struct Fake {
    rays: Vec<Primary>,
    begun: u32,
    fault: Fault,
}

impl Launch for Fake {
    fn most_samples(&self) -> u32 {
        64
    }

    fn begin(&mut self, rays: &[Primary]) -> Result<(), Error> {
        if matches!(self.fault, Fault::Full(after) if self.begun == after) {
            return Err(self.error("the stacks: the device has no memory left".into()));
        }
        self.begun += 1;
        self.rays = rays.to_vec();
        Ok(())
    }

    fn dispatch(&mut self, _: u32, _: bool, _: &mut dyn FnMut()) -> Result<Finished, Error> {
        if let Fault::Ends(after, message) = self.fault
            && self.begun > after
        {
            return Err(self.error(message.to_owned()));
        }
        let seen = |ray: &Primary| {
            let bytes = bytemuck::bytes_of(ray);
            let hash = bytes.iter().fold(0u32, |hash, b| hash.wrapping_mul(31).wrapping_add(u32::from(*b)));
            Seen { xyz: [hash as f32, 1.0, 2.0], rays: 3, ..Seen::default() }
        };
        Ok(Finished { seen: self.rays.iter().map(seen).collect(), radiance: Vec::new() })
    }

    fn error(&self, message: String) -> Error {
        Error::Device { device: "fake".into(), message }
    }
}

fn trace(
    film: &mut Film,
    fault: Fault,
    tile: u32,
) -> Result<TraceReport, Box<spectral_core::tracer::TraceFailure>> {
    let [subject, _] = subjects().expect("valid scenes");
    let device = DeviceInfo {
        backend: "fake",
        index: 0,
        name: "fake".into(),
        driver: String::new(),
        memory: 0,
        intersection: "none",
        hardware: false,
    };
    let options = OpenOptions { tile: Some(tile), ..OpenOptions::default() };
    let launch = Fake { rays: Vec::new(), begun: 0, fault };
    let mut tracer = KernelTracer::new(&device, launch, subject.scene, &options, Duration::ZERO)?;
    tracer.trace(0..1, film, &mut |_| ControlFlow::Continue(()))
}

#[test]
fn finished_tiles_stay_and_are_counted_and_another_device_carries_on() {
    let [subject, _] = subjects().expect("valid scenes");
    let mut whole = Film::new(&subject.scene);
    let report = trace(&mut whole, Fault::None, 8).expect("no fault");
    assert!(report.finished && report.rays == 3 * 64 && report.energy.started == 3.0 * 64.0);
    let late = overdue(Duration::from_millis(1500));
    assert_eq!(late, "the kernel has not ended after 1.5 seconds");
    for (fault, message) in [
        (Fault::Full(3), "fake: the stacks: the device has no memory left"),
        (Fault::Ends(3, "the device was lost"), "fake: the device was lost"),
        (Fault::Ends(3, "the kernel has not ended after 1.5 seconds"), &format!("fake: {late}")),
    ] {
        let mut film = Film::new(&subject.scene);
        // Batches of 2 × 2 pixels' number: three of them are done.
        let failure = trace(&mut film, fault, 2).expect_err("a fault");
        assert_eq!(failure.to_string(), message);
        let kept = (0..64).map(|i| film.samples(i % 8, i / 8)).sum::<u32>();
        assert_eq!((kept, failure.report.rays), (12, 36));
        assert!(failure.report.energy.started == 36.0 && !failure.report.finished);
        let rest = trace(&mut film, Fault::None, 3).expect("no fault");
        assert!(rest.finished && rest.rays == 3 * 52 && film == whole);
    }
}
