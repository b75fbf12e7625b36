//! An open adapter that shows scene after scene.

use crate::{
    batch::Batches,
    device::Gpu,
    pipeline::{Kernel, Parts},
};
use spectral_core::{
    Error,
    kernel::{
        facets::Guess,
        plan::Plan,
        schedule::{Finished, Job, KernelTracer, Launch},
    },
    prepare::PreparedScene,
    tracer::{Device, DeviceInfo, OpenOptions, Tracer},
};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Opens an adapter.
pub(crate) fn open(info: &DeviceInfo, options: &OpenOptions) -> Result<Box<dyn Device>, Error> {
    Ok(open_on(Gpu::open(info)?, info, options))
}

/// Opens an adapter; one convex stone is met in this way, whatever suits the device.
///
/// # Errors
/// [`Error::Device`] where it is no longer there, refuses, or has no subgroups that are asked for.
pub fn open_guessing(
    guess: Guess,
    info: &DeviceInfo,
    options: &OpenOptions,
) -> Result<Box<dyn Device>, Error> {
    let gpu = Gpu::open(info)?;
    if guess == Guess::Subgroup && !gpu.subgroups {
        return Err(gpu.error("this device has no subgroup operations"));
    }
    Ok(start(gpu, guess, info, options))
}

/// The device that `info` describes, which is open already: for callers that keep a hand on it.
pub fn open_on(gpu: Gpu, info: &DeviceInfo, options: &OpenOptions) -> Box<dyn Device> {
    let guess = Guess::by_default(gpu.subgroups);
    start(gpu, guess, info, options)
}

fn start(gpu: Gpu, guess: Guess, info: &DeviceInfo, options: &OpenOptions) -> Box<dyn Device> {
    Box::new(WgpuDevice { gpu: Arc::new(gpu), guess, info: info.clone(), options: *options, parts: None })
}

struct WgpuDevice {
    gpu: Arc<Gpu>,
    guess: Guess,
    info: DeviceInfo,
    options: OpenOptions,
    /// Of the scene before.
    parts: Option<Parts>,
}

impl Device for WgpuDevice {
    fn load(&mut self, scene: Arc<PreparedScene>) -> Result<Box<dyn Tracer>, Error> {
        let start = Instant::now();
        let gpu = self.gpu.clone();
        let parts = Parts::new(&gpu, &scene, self.guess, self.parts.take())?;
        let kernel = Kernel::new(&gpu, &scene, &parts)?;
        let plan = Plan::new(&scene, kernel.form, parts.chain(), gpu.largest_buffer());
        self.parts = Some(parts);
        let batches = Batches::new(&gpu, &kernel, &plan)?;
        batches.warm_up(&gpu, &kernel)?;
        let launch = WgpuLaunch { gpu, kernel, plan, batches };
        Ok(Box::new(KernelTracer::new(&self.info, launch, scene, &self.options, start.elapsed())?))
    }
}

struct WgpuLaunch {
    gpu: Arc<Gpu>,
    kernel: Kernel,
    plan: Plan,
    batches: Batches,
}

impl Launch for WgpuLaunch {
    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn submit(&mut self, slot: usize, job: &Job<'_>) -> Result<(), Error> {
        self.batches.submit(&self.gpu, &self.kernel, &self.plan, slot, job)
    }

    fn poll(&mut self, slot: usize, patience: Duration, finished: &mut Finished) -> Result<bool, Error> {
        self.batches.poll(&self.gpu, &self.plan, slot, patience, finished)
    }

    fn error(&self, message: String) -> Error {
        self.gpu.error(message)
    }
}
