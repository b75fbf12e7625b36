//! Batches on a device that fails: finished pixels are kept, and another device completes the picture.

use spectral_core::{
    Error,
    film::Film,
    kernel::{
        block::Tally,
        pack,
        plan::Plan,
        schedule::{Finished, Job, KernelTracer, Launch},
    },
    probe::subjects,
    tracer::{DeviceInfo, OpenOptions, TraceReport, Tracer},
};
use std::ops::ControlFlow;
use std::time::Duration;

/// The fault of a device.
#[derive(Clone, Copy)]
enum Fault {
    None,
    /// The device has no memory for the next batch after this many.
    Full(u32),
    /// The next batch after this many ends with this message.
    Ends(u32, &'static str),
    /// The next batch after this many never ends.
    Hangs(u32),
}

/// Gives each pixel its number as colour. A batch is finished when it is asked for the second time.
struct Fake {
    plan: Plan,
    under_way: Vec<Option<(Vec<u32>, u32)>>,
    begun: u32,
    asked: u32,
    fault: Fault,
}

impl Launch for Fake {
    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn submit(&mut self, slot: usize, job: &Job<'_>) -> Result<(), Error> {
        if matches!(self.fault, Fault::Full(after) if self.begun == after) {
            return Err(self.error("the stacks: the device has no memory left".into()));
        }
        self.begun += 1;
        let before = self.under_way[slot].replace((job.pixels.to_vec(), job.batch.count));
        assert_eq!(before, None, "one batch a slot");
        Ok(())
    }

    fn poll(&mut self, slot: usize, _: Duration, finished: &mut Finished) -> Result<bool, Error> {
        self.asked += 1;
        match self.fault {
            Fault::Ends(after, message) if self.begun > after => return Err(self.error(message.to_owned())),
            Fault::Hangs(after) if self.begun > after => return Ok(false),
            _ if self.asked % 2 == 1 => return Ok(false),
            _ => {}
        }
        let (pixels, count) = self.under_way[slot].take().expect("a batch under way");
        finished.sums = pixels.iter().map(|&pixel| [pixel as f32, 1.0, 2.0, 0.0]).collect();
        finished.tallies = vec![Tally { rays: [3 * count * pixels.len() as u32, 0], ..Tally::default() }];
        Ok(true)
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
        api: "",
        memory: 0,
        intersection: "none",
        hardware: false,
    };
    let deadline = matches!(fault, Fault::Hangs(_)).then_some(Duration::from_millis(20));
    let options = OpenOptions { tile: Some(tile), deadline, ..OpenOptions::default() };
    let plan = Plan::new(&subject.scene, pack::form(&subject.scene), true, 1 << 20);
    assert_eq!(plan.slots(), 3);
    let launch = Fake { plan, under_way: vec![None; 3], begun: 0, asked: 0, fault };
    let mut tracer = KernelTracer::new(&device, launch, subject.scene, &options, Duration::ZERO)?;
    tracer.trace(0..1, film, &mut |_| ControlFlow::Continue(()))
}

#[test]
fn finished_pixels_are_kept_and_counted_and_another_device_completes_the_picture() {
    let [subject, _] = subjects().expect("valid scenes");
    let mut whole = Film::new(&subject.scene);
    let report = trace(&mut whole, Fault::None, 8).expect("no fault");
    assert!(report.finished && report.rays == 3 * 64 && report.energy.started == 3.0 * 64.0);
    for (fault, message) in [
        (Fault::Full(3), "fake: the stacks: the device has no memory left"),
        (Fault::Ends(3, "the device was lost"), "fake: the device was lost"),
        (Fault::Hangs(3), "fake: the kernel has not ended after 0.02 seconds"),
    ] {
        let mut film = Film::new(&subject.scene);
        // Batches of four pixels: one by itself, then three in flight, of which the last one fails.
        let failure = trace(&mut film, fault, 2).expect_err("a fault");
        assert_eq!(failure.to_string(), message);
        let kept = film.total_samples();
        assert!((kept, failure.report.rays) == (4, 12) && !failure.report.finished, "{kept} pixels");
        assert_eq!(failure.report.energy.started, 12.0);
        let rest = trace(&mut film, Fault::None, 3).expect("no fault");
        assert!(rest.finished && rest.rays == 3 * 60 && film == whole);
    }
}
