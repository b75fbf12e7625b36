//! One stretch of pixel samples on the device: upload, dispatch until every walk is over, read back.

use crate::{
    device::{Gpu, WORKGROUP},
    pipeline::Kernel,
};
use bytemuck::{bytes_of, cast_slice, pod_collect_to_vec};
use spectral_core::{
    Error,
    kernel::{
        block::{Gathering, Primary, Seen, Work, ray_bytes, walk_bytes},
        schedule::{COMPILE_DEADLINE, Finished, HEARTBEAT, overdue},
    },
};
use std::time::{Duration, Instant};

/// Buffers for batches of up to a number of work items.
pub(crate) struct Batch {
    /// Pixel samples that fit.
    pub samples: u32,
    lines: u32,
    work: wgpu::Buffer,
    gathering: wgpu::Buffer,
    primaries: wgpu::Buffer,
    seen: wgpu::Buffer,
    /// Present where the film keeps radiances.
    radiances: wgpu::Buffer,
    spectral: bool,
    readback: wgpu::Buffer,
    trace: wgpu::BindGroup,
    gather: wgpu::BindGroup,
}

/// Bytes that a work item takes in the largest of the buffers, and in all of them.
fn item_bytes(kernel: &Kernel) -> [u64; 2] {
    let stack = ray_bytes(kernel.form.polarized) * u64::from(kernel.form.stack);
    [stack, stack + walk_bytes(kernel.form.polarized)]
}

/// Pixel samples of `lines` wavelengths that a batch holds on this device within `memory` bytes, at most.
pub(crate) fn most_samples(gpu: &Gpu, kernel: &Kernel, lines: u32, memory: u64) -> u32 {
    let [largest, all] = item_bytes(kernel);
    let items = (gpu.largest_buffer() / largest).min(memory / all);
    let dispatched = u64::from(gpu.limits.max_compute_workgroups_per_dimension) * u64::from(WORKGROUP);
    (items.min(dispatched) / u64::from(lines)) as u32
}

impl Batch {
    /// Buffers for up to `samples` pixel samples of `lines` wavelengths.
    pub fn new(gpu: &Gpu, kernel: &Kernel, samples: u32, lines: u32, spectral: bool) -> Result<Self, Error> {
        use wgpu::BufferUsages as Usage;
        let items = u64::from(samples) * u64::from(lines);
        let uniform = Usage::UNIFORM | Usage::COPY_DST;
        let work = gpu.buffer("a dispatch", size_of::<Work>() as u64, uniform)?;
        let gathering = gpu.buffer("a dispatch", size_of::<Gathering>() as u64, uniform)?;
        let each = |size: usize| u64::from(samples) * size as u64;
        let primaries = gpu.storage("the camera rays", each(size_of::<Primary>()), false)?;
        let walks = gpu.storage("the paths", items * walk_bytes(kernel.form.polarized), false)?;
        let stack = gpu.storage("the stacks", items * item_bytes(kernel)[0], false)?;
        let seen = gpu.storage("the samples", each(size_of::<Seen>()), true)?;
        let kept = if spectral { items } else { 0 };
        let radiances = gpu.storage("the radiances", kept * size_of::<f32>() as u64, true)?;
        let read = each(size_of::<Seen>()) + kept * size_of::<f32>() as u64;
        let readback = gpu.buffer("the read-back", read, Usage::MAP_READ | Usage::COPY_DST)?;
        let trace = kernel.trace.bind(gpu, &[&work, &primaries, &walks, &stack])?;
        let gather = kernel.gather.bind(gpu, &[&gathering, &primaries, &walks, &seen, &radiances])?;
        Ok(Batch {
            samples,
            lines,
            work,
            gathering,
            primaries,
            seen,
            radiances,
            spectral,
            readback,
            trace,
            gather,
        })
    }

    /// A dispatch of nothing, so that a driver that compiles late does it now and not in a dispatch that is timed.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn warm_up(&self, gpu: &Gpu, kernel: &Kernel) -> Result<(), Error> {
        gpu.queue.write_buffer(&self.work, 0, bytes_of(&Work::default()));
        gpu.queue.write_buffer(&self.gathering, 0, bytes_of(&Gathering::default()));
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.encode(kernel, &mut encoder, [1, 1]);
        gpu.queue.submit([encoder.finish()]);
        wait(gpu, COMPILE_DEADLINE, &mut || {})
    }

    /// Both entry points over so many invocations.
    fn encode(&self, kernel: &Kernel, encoder: &mut wgpu::CommandEncoder, [items, samples]: [u32; 2]) {
        for (stage, own, count) in
            [(&kernel.trace, &self.trace, items), (&kernel.gather, &self.gather, samples)]
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&stage.pipeline);
            pass.set_bind_group(0, &stage.scene, &[]);
            pass.set_bind_group(1, own, &[]);
            pass.dispatch_workgroups(count.div_ceil(WORKGROUP), 1, 1);
        }
    }

    /// Uploads camera rays, at most [`Batch::samples`] of them.
    pub fn begin(&self, gpu: &Gpu, rays: &[Primary]) {
        gpu.queue.write_buffer(&self.primaries, 0, cast_slice(rays));
        let samples = rays.len() as u32;
        let gathering = Gathering { samples, spectral: u32::from(self.spectral), padding: [0; 2] };
        gpu.queue.write_buffer(&self.gathering, 0, bytes_of(&gathering));
    }

    /// One dispatch over `samples` pixel samples, each invocation following at most `budget` rays. Waits for it,
    /// calling `beat` now and then.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails or hangs.
    pub fn dispatch(
        &self,
        gpu: &Gpu,
        kernel: &Kernel,
        samples: u32,
        budget: u32,
        resume: bool,
        beat: &mut dyn FnMut(),
    ) -> Result<Finished, Error> {
        let items = samples * self.lines;
        let work = Work { items, budget, resume: u32::from(resume), padding: 0 };
        gpu.queue.write_buffer(&self.work, 0, bytes_of(&work));
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.encode(kernel, &mut encoder, [items, samples]);
        let [seen, radiances] = self.read_bytes(samples);
        encoder.copy_buffer_to_buffer(&self.seen, 0, &self.readback, 0, seen);
        if radiances > 0 {
            encoder.copy_buffer_to_buffer(&self.radiances, 0, &self.readback, seen, radiances);
        }
        gpu.queue.submit([encoder.finish()]);
        self.read(gpu, samples, beat)
    }

    fn read_bytes(&self, samples: u32) -> [u64; 2] {
        let samples = u64::from(samples);
        let radiances = if self.spectral { samples * u64::from(self.lines) * 4 } else { 0 };
        [samples * size_of::<Seen>() as u64, radiances]
    }

    fn read(&self, gpu: &Gpu, samples: u32, beat: &mut dyn FnMut()) -> Result<Finished, Error> {
        let [seen, radiances] = self.read_bytes(samples);
        let (sender, receiver) = std::sync::mpsc::channel();
        let slice = self.readback.slice(..seen + radiances);
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only when the host has given up.
            let _ = sender.send(result);
        });
        wait(gpu, gpu.deadline, beat)?;
        gpu.check()?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(gpu.error(format!("the result could not be read back: {e}"))),
            Err(_) => return Err(gpu.error("the result never came back")),
        }
        let finished = {
            let view = slice.get_mapped_range().map_err(|e| gpu.error(e.to_string()))?;
            let (first, second) = view.split_at(seen as usize);
            Finished { seen: pod_collect_to_vec(first), radiance: pod_collect_to_vec(second) }
        };
        self.readback.unmap();
        Ok(finished)
    }
}

/// Waits until the device is idle.
fn wait(gpu: &Gpu, deadline: Duration, beat: &mut dyn FnMut()) -> Result<(), Error> {
    let start = Instant::now();
    loop {
        match gpu
            .device
            .poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(HEARTBEAT.min(deadline)) })
        {
            Ok(_) => return Ok(()),
            Err(wgpu::PollError::Timeout) => {}
            Err(e) => return Err(gpu.error(e.to_string())),
        }
        beat();
        gpu.check()?;
        if start.elapsed() > deadline {
            return Err(gpu.error(overdue(deadline)));
        }
    }
}
