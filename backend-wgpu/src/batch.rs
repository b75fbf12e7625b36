//! Batches on the device: what they read and write, and what is under way.

use crate::{device::Gpu, pipeline::Kernel};
use bytemuck::{bytes_of, cast_slice};
use spectral_core::{
    Error,
    kernel::{
        block::Batch,
        plan::{Part, Plan, Stage, workgroups},
        schedule::{COMPILE_DEADLINE, Finished, HEARTBEAT, Job, overdue},
    },
};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};
use wgpu::BufferUsages as Usage;

/// Buffers and bindings for the batches of a plan.
pub(crate) struct Batches {
    slots: Vec<Slot>,
}

/// What one batch under way has for itself.
struct Slot {
    /// By the numbers of [`Part`]; those that all batches share are the same in all slots.
    parts: Vec<wgpu::Buffer>,
    readback: wgpu::Buffer,
    /// The second group of each stage.
    groups: [wgpu::BindGroup; 3],
    batch: Batch,
    sent: Option<Sent>,
}

/// A batch that the device has.
struct Sent {
    submission: wgpu::SubmissionIndex,
    /// Says when the host may read what it gives back.
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Batches {
    pub fn new(gpu: &Gpu, kernel: &Kernel, plan: &Plan) -> Result<Self, Error> {
        let shared: Vec<_> = Part::ALL
            .into_iter()
            .map(|part| part.is_shared().then(|| buffer(gpu, plan, part)).transpose())
            .collect::<Result<_, _>>()?;
        let slot = |_| Slot::new(gpu, kernel, plan, &shared);
        Ok(Batches { slots: (0..plan.slots()).map(slot).collect::<Result<_, _>>()? })
    }

    /// A dispatch of nothing, so that a driver that compiles late does it now and not in a dispatch that is timed.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn warm_up(&self, gpu: &Gpu, kernel: &Kernel) -> Result<(), Error> {
        let slot = &self.slots[0];
        gpu.queue.write_buffer(&slot.parts[Part::Batch as usize], 0, bytes_of(&Batch::default()));
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        slot.encode(kernel, &mut encoder, &Batch::default(), 1);
        let submission = gpu.queue.submit([encoder.finish()]);
        let start = Instant::now();
        while !gpu.poll(&submission, HEARTBEAT)? {
            if start.elapsed() > COMPILE_DEADLINE {
                return Err(gpu.error(overdue(COMPILE_DEADLINE)));
            }
        }
        Ok(())
    }

    /// See [`Launch::submit`](spectral_core::kernel::schedule::Launch::submit).
    pub fn submit(
        &mut self,
        gpu: &Gpu,
        kernel: &Kernel,
        plan: &Plan,
        slot: usize,
        job: &Job<'_>,
    ) -> Result<(), Error> {
        let slot = &mut self.slots[slot];
        slot.batch = job.batch;
        let contents: [(Part, &[u8]); 4] = [
            (Part::Batch, bytes_of(&job.batch)),
            (Part::Pixels, cast_slice(job.pixels)),
            (Part::Sums, cast_slice(job.sums)),
            (Part::Radiances, cast_slice(job.radiances)),
        ];
        for (part, bytes) in contents.into_iter().filter(|(_, bytes)| !bytes.is_empty()) {
            gpu.queue.write_buffer(&slot.parts[part as usize], 0, bytes);
        }
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        slot.encode(kernel, &mut encoder, &job.batch, plan.lines);
        let mut end = 0;
        for (part, bytes) in plan.returned(job.batch.pixels).into_iter().filter(|(_, bytes)| *bytes > 0) {
            encoder.copy_buffer_to_buffer(&slot.parts[part as usize], 0, &slot.readback, end, bytes);
            end += bytes;
        }
        let submission = gpu.queue.submit([encoder.finish()]);
        let (sender, receiver) = channel();
        slot.readback.slice(..end).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only when the host has given up.
            let _ = sender.send(result);
        });
        slot.sent = Some(Sent { submission, mapped: receiver });
        gpu.check()
    }

    /// See [`Launch::poll`](spectral_core::kernel::schedule::Launch::poll).
    pub fn poll(
        &mut self,
        gpu: &Gpu,
        plan: &Plan,
        slot: usize,
        patience: Duration,
        finished: &mut Finished,
    ) -> Result<bool, Error> {
        let slot = &mut self.slots[slot];
        let Some(sent) = &slot.sent else { return Ok(false) };
        let mut state = sent.mapped.try_recv();
        if state == Err(TryRecvError::Empty) {
            gpu.poll(&sent.submission, patience)?;
            state = sent.mapped.try_recv();
        }
        match state {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(gpu.error(format!("the result could not be read back: {e}"))),
            Err(TryRecvError::Empty) => return Ok(false),
            Err(TryRecvError::Disconnected) => return Err(gpu.error("the result never came back")),
        }
        slot.sent = None;
        let [sums, tallies, radiances] = plan.returned(slot.batch.pixels).map(|(_, bytes)| bytes as usize);
        let slice = slot.readback.slice(..(sums + tallies + radiances) as u64);
        {
            let view = slice.get_mapped_range().map_err(|e| gpu.error(e.to_string()))?;
            fill(&mut finished.sums, &view[..sums]);
            fill(&mut finished.tallies, &view[sums..sums + tallies]);
            fill(&mut finished.radiances, &view[sums + tallies..]);
        }
        slot.readback.unmap();
        Ok(true)
    }
}

/// Values in place of others, in the same memory.
fn fill<T: bytemuck::Pod>(values: &mut Vec<T>, bytes: &[u8]) {
    values.clear();
    values.extend_from_slice(cast_slice(bytes));
}

fn buffer(gpu: &Gpu, plan: &Plan, part: Part) -> Result<wgpu::Buffer, Error> {
    match part {
        Part::Batch => gpu.buffer(part.name(), plan.bytes(part), Usage::UNIFORM | Usage::COPY_DST),
        _ => gpu.storage(
            part.name(),
            plan.bytes(part),
            matches!(part, Part::Sums | Part::Tallies | Part::Radiances),
        ),
    }
}

impl Slot {
    fn new(gpu: &Gpu, kernel: &Kernel, plan: &Plan, shared: &[Option<wgpu::Buffer>]) -> Result<Self, Error> {
        let own = |part: Part| match &shared[part as usize] {
            Some(buffer) => Ok(buffer.clone()),
            None => buffer(gpu, plan, part),
        };
        let parts: Vec<_> = Part::ALL.into_iter().map(own).collect::<Result<_, _>>()?;
        let read = plan.returned(plan.pixels).map(|(_, bytes)| bytes).iter().sum();
        let readback = gpu.buffer("the read-back", read, Usage::MAP_READ | Usage::COPY_DST)?;
        let [prime, trace, gather] = Stage::ALL.map(|stage| kernel.bind(gpu, stage, &parts));
        let groups = [prime?, trace?, gather?];
        Ok(Slot { parts, readback, groups, batch: Batch::default(), sent: None })
    }

    /// All stages over a batch.
    fn encode(&self, kernel: &Kernel, encoder: &mut wgpu::CommandEncoder, batch: &Batch, lines: u32) {
        for (stage, own) in Stage::ALL.into_iter().zip(&self.groups) {
            // Walks that are resumed have their camera rays.
            if stage == Stage::Prime && batch.resume != 0 {
                continue;
            }
            let shader = &kernel.stages[stage as usize];
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&shader.pipeline);
            pass.set_bind_group(0, &shader.scene, &[]);
            pass.set_bind_group(1, own, &[]);
            let [across, down] = workgroups(stage.invocations(batch, lines));
            pass.dispatch_workgroups(across, down, 1);
        }
    }
}
