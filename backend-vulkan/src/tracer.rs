//! An open device that shows scene after scene, and its batches.

use crate::{
    Intersection,
    device::Gpu,
    kernel::{Kernel, Parts, Shaders},
    memory::Buffer,
    pipeline::{Stage, barrier},
    submission::Submission,
};
use bytemuck::{bytes_of, cast_slice};
use spectral_core::{
    Error,
    kernel::{
        block::Batch,
        facets::Guess,
        plan::{self, Part, Plan},
        schedule::{COMPILE_DEADLINE, Finished, Job, KernelTracer, Launch},
    },
    prepare::PreparedScene,
    tracer::{Device, DeviceInfo, OpenOptions, Tracer},
};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Opens a device, which traces by the best form of intersection: the planes of a lone convex stone, else the first
/// of [`Intersection::ALL`] that the device offers.
pub(crate) fn open(info: &DeviceInfo, options: &OpenOptions) -> Result<Box<dyn Device>, Error> {
    let (gpu, intersection) = Gpu::open(info, None)?;
    let lone = Some(Guess::by_default(gpu.limits.subgroups));
    Ok(VulkanDevice::boxed(gpu, info, intersection, lone, options))
}

/// Opens one of [`VULKAN`](crate::VULKAN)'s devices; one convex stone is met by its planes in this way, whatever suits the
/// device.
///
/// # Errors
/// [`Error::Device`] where the device has no subgroups that are asked for, or fails.
pub fn open_guessing(
    guess: Guess,
    info: &DeviceInfo,
    options: &OpenOptions,
) -> Result<Box<dyn Device>, Error> {
    let (gpu, intersection) = Gpu::open(info, None)?;
    if guess == Guess::Subgroup && !gpu.limits.subgroups {
        return Err(gpu.error("this device has no subgroup operations"));
    }
    Ok(VulkanDevice::boxed(gpu, info, intersection, Some(guess), options))
}

/// Opens one of [`VULKAN`](crate::VULKAN)'s devices, with a form of intersection that is used whatever the scene.
///
/// # Errors
/// [`Error::Device`] where the device does not offer it, or fails.
pub fn open_with(
    intersection: Intersection,
    info: &DeviceInfo,
    options: &OpenOptions,
) -> Result<Box<dyn Device>, Error> {
    let (gpu, intersection) = Gpu::open(info, Some(intersection))?;
    Ok(VulkanDevice::boxed(gpu, info, intersection, None, options))
}

struct VulkanDevice {
    /// Of the scene before.
    parts: Option<Parts>,
    shaders: Shaders,
    gpu: Arc<Gpu>,
    intersection: Intersection,
    /// How a lone convex stone is met by its planes, if it is.
    lone: Option<Guess>,
    info: DeviceInfo,
    options: OpenOptions,
}

impl VulkanDevice {
    fn boxed(
        gpu: Arc<Gpu>,
        info: &DeviceInfo,
        intersection: Intersection,
        lone: Option<Guess>,
        options: &OpenOptions,
    ) -> Box<dyn Device> {
        let info = DeviceInfo { intersection: intersection.name(), ..info.clone() };
        let (parts, shaders, options) = (None, Shaders::new(), *options);
        Box::new(VulkanDevice { parts, shaders, gpu, intersection, lone, info, options })
    }
}

impl Device for VulkanDevice {
    fn load(&mut self, scene: Arc<PreparedScene>) -> Result<Box<dyn Tracer>, Error> {
        let start = Instant::now();
        let gpu = self.gpu.clone();
        let parts = Parts::new(&gpu, &scene, self.intersection, self.lone, self.parts.take())?;
        let kernel = Kernel::new(&gpu, &scene, &parts)?;
        let plan = Plan::new(&scene, kernel.form, parts.chain(), gpu.limits.storage);
        self.parts = Some(parts);
        let slots = Slot::all(&gpu, &kernel, &plan, &mut self.shaders)?;
        let mut launch = VulkanLaunch { slots, _kernel: kernel, plan, gpu };
        launch.warm_up()?;
        Ok(Box::new(KernelTracer::new(&self.info, launch, scene, &self.options, start.elapsed())?))
    }
}

struct VulkanLaunch {
    /// First, so that all is idle before anything is freed.
    slots: Vec<Slot>,
    /// What the stages are bound to.
    _kernel: Kernel,
    plan: Plan,
    gpu: Arc<Gpu>,
}

/// What one batch under way has for itself.
struct Slot {
    /// First, so that it is waited for before anything is freed.
    submission: Submission,
    /// By the numbers of [`plan::Stage`].
    stages: Vec<Stage>,
    /// By the numbers of [`Part`]; those that all batches share are the same in all slots.
    parts: Vec<Arc<Buffer>>,
    /// The host's end of what goes to the device.
    upload: Buffer,
    /// The host's end of what comes back.
    readback: Buffer,
    batch: Batch,
}

/// What the host uploads with a batch, but for its constants.
const UPLOADED: [Part; 3] = [Part::Pixels, Part::Sums, Part::Radiances];

impl Slot {
    fn all(gpu: &Arc<Gpu>, kernel: &Kernel, plan: &Plan, shaders: &mut Shaders) -> Result<Vec<Self>, Error> {
        let buffer = |part: Part| match part {
            Part::Batch => Buffer::uniform(gpu, part.name(), plan.bytes(part)),
            _ => Buffer::storage(gpu, part.name(), plan.bytes(part)),
        };
        let mut slots: Vec<Slot> = Vec::new();
        for _ in 0..plan.slots() {
            let own = |part: Part| match slots.first() {
                Some(first) if part.is_shared() => Ok(first.parts[part as usize].clone()),
                _ => buffer(part).map(Arc::new),
            };
            let parts: Vec<_> = Part::ALL.into_iter().map(own).collect::<Result<_, _>>()?;
            let mut stages = Vec::new();
            for stage in plan::Stage::ALL {
                stages.push(kernel.stage(gpu, stage, &parts, shaders)?);
            }
            let uploaded = UPLOADED.iter().map(|part| plan.bytes(*part)).sum();
            let read = plan.returned(plan.pixels).iter().map(|(_, bytes)| bytes).sum();
            slots.push(Slot {
                submission: Submission::new(gpu)?,
                stages,
                parts,
                upload: Buffer::host(gpu, "the upload", uploaded)?,
                readback: Buffer::host(gpu, "the read-back", read)?,
                batch: Batch::default(),
            });
        }
        Ok(slots)
    }
}

impl VulkanLaunch {
    /// Runs all shaders over nothing, so that a driver that compiles at first use has done so.
    fn warm_up(&mut self) -> Result<(), Error> {
        let Slot { submission, stages, parts, .. } = &mut self.slots[0];
        submission.send(|commands| {
            parts[Part::Batch as usize].set(commands, bytes_of(&Batch::default()));
            stages.iter().for_each(|stage| stage.dispatch(commands, 1));
        })?;
        submission.finish(COMPILE_DEADLINE)
    }
}

impl Launch for VulkanLaunch {
    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn submit(&mut self, slot: usize, job: &Job<'_>) -> Result<(), Error> {
        let (gpu, plan, slot) = (&self.gpu, &self.plan, &mut self.slots[slot]);
        slot.batch = job.batch;
        let contents: [&[u8]; 3] = [cast_slice(job.pixels), cast_slice(job.sums), cast_slice(job.radiances)];
        slot.upload.write(&contents)?;
        let Slot { submission, stages, parts, upload, readback, .. } = slot;
        submission.send(|commands| {
            let mut start = 0;
            for (part, bytes) in UPLOADED.into_iter().zip(contents).filter(|(_, bytes)| !bytes.is_empty()) {
                parts[part as usize].copy_from(commands, upload, start, 0, bytes.len() as u64);
                start += bytes.len() as u64;
            }
            parts[Part::Batch as usize].set(commands, bytes_of(&job.batch));
            for (stage, bound) in plan::Stage::ALL.into_iter().zip(stages) {
                // Walks that are resumed have their camera rays.
                if stage != plan::Stage::Prime || job.batch.resume == 0 {
                    bound.dispatch(commands, stage.invocations(&job.batch, plan.lines));
                }
            }
            let mut end = 0;
            for (part, bytes) in plan.returned(job.batch.pixels).into_iter().filter(|(_, bytes)| *bytes > 0) {
                readback.copy_from(commands, &parts[part as usize], 0, end, bytes);
                end += bytes;
            }
            barrier(gpu, commands);
        })
    }

    fn poll(&mut self, slot: usize, patience: Duration, finished: &mut Finished) -> Result<bool, Error> {
        let slot = &mut self.slots[slot];
        if !slot.submission.wait(patience)? {
            return Ok(false);
        }
        let [sums, tallies, radiances] = self.plan.returned(slot.batch.pixels).map(|(_, bytes)| bytes);
        slot.readback.read(0, sums, &mut finished.sums)?;
        slot.readback.read(sums, tallies, &mut finished.tallies)?;
        slot.readback.read(sums + tallies, radiances, &mut finished.radiances)?;
        Ok(true)
    }

    fn abandon(&mut self) {
        self.gpu.abandon();
    }

    fn error(&self, message: String) -> Error {
        self.gpu.error(message)
    }
}
