//! A scene's kernel on an open adapter.

use crate::{
    batch::{Batch, most_samples},
    device::Gpu,
    pipeline::Kernel,
};
use spectral_core::{
    Error,
    kernel::{
        block::Primary,
        facets::Guess,
        schedule::{Finished, KernelTracer, Launch, PATH_MEMORY},
    },
    prepare::PreparedScene,
    tracer::{DeviceInfo, OpenOptions, Tracer},
};
use std::sync::Arc;
use std::time::Instant;

/// Opens an adapter for a scene.
pub(crate) fn open(
    device: &DeviceInfo,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    open_on(Gpu::open(device)?, device, scene, options)
}

/// Opens an adapter for a scene; one convex stone is met in this way, whatever suits the device.
///
/// # Errors
/// As [`open_on`], and [`Error::Device`] where the device has no subgroups that are asked for.
pub fn open_guessing(
    guess: Guess,
    device: &DeviceInfo,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    start(Gpu::open(device)?, Some(guess), device, scene, options)
}

/// Opens a scene on a device that is open already, which `device` describes: for callers that keep a hand on it.
///
/// # Errors
/// [`Error::Device`] where the device fails or has too little memory; [`Error::Value`] for a scene beyond the kernel's
/// number formats.
pub fn open_on(
    gpu: Gpu,
    device: &DeviceInfo,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    start(gpu, None, device, scene, options)
}

fn start(
    gpu: Gpu,
    guess: Option<Guess>,
    device: &DeviceInfo,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    let start = Instant::now();
    let mut gpu = gpu;
    gpu.deadline = options.deadline.unwrap_or(gpu.deadline);
    let kernel = Kernel::new(&gpu, &scene, guess)?;
    let lines = scene.wavelength_count() as u32;
    let spectral = scene.settings.spectral;
    let batch = Batch::new(&gpu, &kernel, 1, lines, spectral)?;
    batch.warm_up(&gpu, &kernel)?;
    let most = most_samples(&gpu, &kernel, lines, PATH_MEMORY);
    let launch = WgpuLaunch { gpu, kernel, lines, spectral, most, batch, rays: 0 };
    Ok(Box::new(KernelTracer::new(device, launch, scene, options, start.elapsed())?))
}

struct WgpuLaunch {
    gpu: Gpu,
    kernel: Kernel,
    /// Wavelengths a pixel sample.
    lines: u32,
    spectral: bool,
    /// Pixel samples that a batch may hold.
    most: u32,
    /// Grows with the batches.
    batch: Batch,
    /// Camera rays in the batch.
    rays: u32,
}

impl Launch for WgpuLaunch {
    fn most_samples(&self) -> u32 {
        self.most
    }

    fn begin(&mut self, rays: &[Primary]) -> Result<(), Error> {
        self.rays = rays.len() as u32;
        if self.batch.samples < self.rays {
            self.batch = Batch::new(&self.gpu, &self.kernel, self.rays, self.lines, self.spectral)?;
        }
        self.batch.begin(&self.gpu, rays);
        Ok(())
    }

    fn dispatch(&mut self, budget: u32, resume: bool, beat: &mut dyn FnMut()) -> Result<Finished, Error> {
        self.batch.dispatch(&self.gpu, &self.kernel, self.rays, budget, resume, beat)
    }

    fn error(&self, message: String) -> Error {
        self.gpu.error(message)
    }
}
