//! Batches of camera rays through the kernel.

use crate::{
    Intersection,
    device::{Gpu, WORKGROUP},
    kernel::Kernel,
    memory::Buffer,
    pipeline::{Resource, Stage, barrier},
};
use bytemuck::{bytes_of, cast_slice};
use spectral_core::{
    Error,
    kernel::{
        block::{Gathering, Primary, Seen, Work, ray_bytes, walk_bytes},
        facets::Guess,
        schedule::{DEADLINE, Finished, KernelTracer, Launch, PATH_MEMORY},
    },
    prepare::PreparedScene,
    tracer::{DeviceInfo, OpenOptions, Tracer},
};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Opens a device for a scene, by the best form of intersection: the planes of a lone convex stone, else the first
/// of [`Intersection::ALL`] that the device offers.
pub(crate) fn open(
    device: &DeviceInfo,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    start(device, Asked::Nothing, scene, options)
}

/// What a caller says of how surfaces are found.
#[derive(Clone, Copy)]
enum Asked {
    Nothing,
    /// For every scene.
    Intersection(Intersection),
    /// For one convex stone.
    Guess(Guess),
}

/// Opens one of [`VULKAN`](crate::VULKAN)'s devices for a scene; one convex stone is met by its planes in this way,
/// whatever suits the device.
///
/// # Errors
/// [`Error::Device`] where the device has no subgroups that are asked for, or fails.
pub fn open_guessing(
    guess: Guess,
    device: &DeviceInfo,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    start(device, Asked::Guess(guess), scene, options)
}

/// Opens one of [`VULKAN`](crate::VULKAN)'s devices for a scene, with a form of intersection that is used whatever
/// the scene.
///
/// # Errors
/// [`Error::Device`] where the device does not offer it, or fails.
pub fn open_with(
    intersection: Intersection,
    device: &DeviceInfo,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    start(device, Asked::Intersection(intersection), scene, options)
}

fn start(
    device: &DeviceInfo,
    asked: Asked,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    let start = Instant::now();
    let held = match asked {
        Asked::Intersection(intersection) => Some(intersection),
        Asked::Nothing | Asked::Guess(_) => None,
    };
    let (gpu, intersection) = Gpu::open(device, held)?;
    let lone = match asked {
        Asked::Nothing => Some(Guess::by_default(gpu.limits.subgroups)),
        Asked::Intersection(_) => None,
        Asked::Guess(guess) => Some(guess),
    };
    let kernel = Kernel::new(&gpu, &scene, intersection, lone)?;
    let lines = scene.wavelength_count() as u32;
    let spectral = scene.settings.spectral;
    let buffers = Buffers::new(&gpu, &kernel, 1, lines, spectral)?;
    let trace = kernel.trace(&gpu, &buffers.traced())?;
    let gather = kernel.gather(&gpu, &buffers.gathered())?;
    let deadline = options.deadline.unwrap_or(DEADLINE);
    let launch = VulkanLaunch { gpu, kernel, trace, gather, buffers, samples: 0, lines, spectral, deadline };
    launch.warm_up()?;
    let device = DeviceInfo { intersection: intersection.name(), ..device.clone() };
    Ok(Box::new(KernelTracer::new(&device, launch, scene, options, start.elapsed())?))
}

struct VulkanLaunch {
    gpu: Arc<Gpu>,
    kernel: Kernel,
    trace: Stage,
    gather: Stage,
    buffers: Buffers,
    /// Pixel samples of the batch.
    samples: u32,
    /// Wavelengths of a sample.
    lines: u32,
    spectral: bool,
    /// How long a dispatch may take.
    deadline: Duration,
}

/// Buffers for batches of up to a number of pixel samples.
struct Buffers {
    samples: u32,
    work: Buffer,
    gathering: Buffer,
    primaries: Buffer,
    walks: Buffer,
    stack: Buffer,
    seen: Buffer,
    radiances: Buffer,
    /// The host's end of `primaries`.
    upload: Buffer,
    /// The host's end of `seen` and `radiances`.
    readback: Buffer,
}

/// Bytes of a work item's stack.
fn stack_bytes(kernel: &Kernel) -> u64 {
    ray_bytes(kernel.form.polarized) * u64::from(kernel.form.stack)
}

impl Buffers {
    fn new(gpu: &Arc<Gpu>, kernel: &Kernel, samples: u32, lines: u32, spectral: bool) -> Result<Self, Error> {
        let items = u64::from(samples) * u64::from(lines);
        let each = |size: usize| u64::from(samples) * size as u64;
        let kept = if spectral { items * size_of::<f32>() as u64 } else { 0 };
        Ok(Buffers {
            samples,
            work: Buffer::uniform(gpu, "a dispatch", size_of::<Work>() as u64)?,
            gathering: Buffer::uniform(gpu, "a dispatch", size_of::<Gathering>() as u64)?,
            primaries: Buffer::storage(gpu, "the camera rays", each(size_of::<Primary>()))?,
            walks: Buffer::storage(gpu, "the paths", items * walk_bytes(kernel.form.polarized))?,
            stack: Buffer::storage(gpu, "the stacks", items * stack_bytes(kernel))?,
            seen: Buffer::storage(gpu, "the samples", each(size_of::<Seen>()))?,
            radiances: Buffer::storage(gpu, "the radiances", kept)?,
            upload: Buffer::host(gpu, "the camera rays", each(size_of::<Primary>()))?,
            readback: Buffer::host(gpu, "the read-back", each(size_of::<Seen>()) + kept)?,
        })
    }

    /// The second group of `trace`.
    fn traced(&self) -> Vec<(u32, Resource<'_>)> {
        let storage = [&self.primaries, &self.walks, &self.stack];
        group(&self.work, &storage)
    }

    /// The second group of `gather`.
    fn gathered(&self) -> Vec<(u32, Resource<'_>)> {
        let storage = [&self.primaries, &self.walks, &self.seen, &self.radiances];
        group(&self.gathering, &storage)
    }
}

fn group<'a>(uniform: &'a Buffer, storage: &[&'a Buffer]) -> Vec<(u32, Resource<'a>)> {
    let rest = (1..).zip(storage.iter().map(|buffer| Resource::Storage(buffer)));
    std::iter::once((0, Resource::Uniform(uniform))).chain(rest).collect()
}

impl VulkanLaunch {
    /// Runs both shaders over nothing, so that a driver that compiles at first use has done so.
    fn warm_up(&self) -> Result<(), Error> {
        self.gpu.prepare(|commands| {
            self.buffers.work.set(commands, bytes_of(&Work::default()));
            self.buffers.gathering.set(commands, bytes_of(&Gathering::default()));
            self.trace.dispatch(commands, 1);
            self.gather.dispatch(commands, 1);
        })
    }

    /// Bytes of the samples and of the radiances that a batch gives back.
    fn read_bytes(&self) -> [u64; 2] {
        let samples = u64::from(self.samples);
        let radiances = if self.spectral { samples * u64::from(self.lines) * 4 } else { 0 };
        [samples * size_of::<Seen>() as u64, radiances]
    }
}

impl Launch for VulkanLaunch {
    fn most_samples(&self) -> u32 {
        let stack = stack_bytes(&self.kernel);
        let all = stack + walk_bytes(self.kernel.form.polarized);
        let items = (self.gpu.limits.storage / stack).min(PATH_MEMORY / all);
        let dispatched = u64::from(self.gpu.limits.workgroups) * u64::from(WORKGROUP);
        (items.min(dispatched) / u64::from(self.lines)).min(u64::from(u32::MAX)) as u32
    }

    fn begin(&mut self, rays: &[Primary]) -> Result<(), Error> {
        self.samples = rays.len() as u32;
        if self.samples > self.buffers.samples {
            self.buffers = Buffers::new(&self.gpu, &self.kernel, self.samples, self.lines, self.spectral)?;
            self.trace.bind(1, &self.buffers.traced());
            self.gather.bind(1, &self.buffers.gathered());
        }
        self.buffers.upload.write(cast_slice(rays))
    }

    fn dispatch(&mut self, budget: u32, resume: bool, beat: &mut dyn FnMut()) -> Result<Finished, Error> {
        let items = self.samples * self.lines;
        let work = Work { items, budget, resume: u32::from(resume), padding: 0 };
        let gathering =
            Gathering { samples: self.samples, spectral: u32::from(self.spectral), padding: [0; 2] };
        let [seen, radiances] = self.read_bytes();
        let buffers = &self.buffers;
        self.gpu.submit(
            self.deadline,
            |commands| {
                if !resume {
                    let bytes = u64::from(self.samples) * size_of::<Primary>() as u64;
                    buffers.primaries.copy_from(commands, &buffers.upload, 0, 0, bytes);
                }
                buffers.work.set(commands, bytes_of(&work));
                buffers.gathering.set(commands, bytes_of(&gathering));
                self.trace.dispatch(commands, items);
                self.gather.dispatch(commands, self.samples);
                buffers.readback.copy_from(commands, &buffers.seen, 0, 0, seen);
                if radiances > 0 {
                    buffers.readback.copy_from(commands, &buffers.radiances, 0, seen, radiances);
                }
                barrier(&self.gpu, commands);
            },
            beat,
        )?;
        Ok(Finished {
            seen: buffers.readback.read(0, self.samples as usize)?,
            radiance: buffers.readback.read(seen, radiances as usize / size_of::<f32>())?,
        })
    }

    fn error(&self, message: String) -> Error {
        self.gpu.error(message)
    }
}
