//! Commands that the device works on while the host goes on.

use crate::device::Gpu;
use ash::vk;
use spectral_core::{
    Error,
    kernel::schedule::{COMPILE_DEADLINE, HEARTBEAT, overdue},
};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Room for one list of commands, which is recorded, sent and waited for again and again.
pub(crate) struct Submission {
    gpu: Arc<Gpu>,
    pool: vk::CommandPool,
    fence: vk::Fence,
    /// Whether the device may still work on what was sent.
    pending: bool,
}

impl Drop for Submission {
    fn drop(&mut self) {
        if self.finish(COMPILE_DEADLINE).is_err() || !self.gpu.releases() {
            return;
        }
        // SAFETY: idle: nothing is pending. Commands go with their pool; null handles are ignored.
        unsafe {
            self.gpu.device.destroy_fence(self.fence, None);
            self.gpu.device.destroy_command_pool(self.pool, None);
        }
    }
}

impl Submission {
    /// Nothing sent yet.
    ///
    /// # Errors
    /// [`Error::Device`] where the device has no memory left.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self, Error> {
        let (pool, fence) = (vk::CommandPool::null(), vk::Fence::null());
        let mut submission = Submission { gpu: gpu.clone(), pool, fence, pending: false };
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(gpu.family);
        // SAFETY: valid: the family is that of the device's queue.
        submission.pool =
            unsafe { gpu.device.create_command_pool(&info, None) }.map_err(gpu.failure("commands"))?;
        // SAFETY: valid.
        submission.fence = unsafe { gpu.device.create_fence(&vk::FenceCreateInfo::default(), None) }
            .map_err(gpu.failure("a fence"))?;
        Ok(submission)
    }

    /// Records commands and sends them. What was sent before must have ended.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails; it can then not be used any more.
    pub fn send(&mut self, record: impl FnOnce(vk::CommandBuffer)) -> Result<(), Error> {
        assert!(!self.pending, "commands are sent once those before have ended");
        let gpu = &self.gpu;
        let allocate =
            vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let flags = vk::CommandPoolResetFlags::RELEASE_RESOURCES;
        // SAFETY: alive, valid, idle: nothing of the pool is pending.
        let commands = unsafe {
            gpu.device
                .reset_command_pool(self.pool, flags)
                .and_then(|()| gpu.device.reset_fences(&[self.fence]))
                .and_then(|()| gpu.device.allocate_command_buffers(&allocate))
                .map_err(gpu.failure("commands"))?
        };
        // SAFETY: as above.
        unsafe { gpu.device.begin_command_buffer(commands[0], &begin) }.map_err(gpu.failure("commands"))?;
        record(commands[0]);
        // SAFETY: valid: begun above.
        unsafe { gpu.device.end_command_buffer(commands[0]) }.map_err(gpu.failure("commands"))?;
        gpu.submit(&commands, self.fence)?;
        self.pending = true;
        Ok(())
    }

    /// Waits for what was sent for at most `patience`; whether it has ended.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails; it can then not be used any more.
    pub fn wait(&mut self, patience: Duration) -> Result<bool, Error> {
        if !self.pending {
            return Ok(true);
        }
        // SAFETY: alive.
        match unsafe { self.gpu.device.wait_for_fences(&[self.fence], true, patience.as_nanos() as u64) } {
            Ok(()) => {
                self.pending = false;
                Ok(true)
            }
            Err(vk::Result::TIMEOUT) => Ok(false),
            Err(result) => {
                self.gpu.abandon();
                Err(self.gpu.failure("the kernel")(result))
            }
        }
    }

    /// Waits for the end of what was sent.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails, or hangs past the deadline; it can then not be used any more.
    pub fn finish(&mut self, deadline: Duration) -> Result<(), Error> {
        let start = Instant::now();
        while self.gpu.releases() && !self.wait(HEARTBEAT)? {
            if start.elapsed() > deadline {
                self.gpu.abandon();
                return Err(self.gpu.error(overdue(deadline)));
            }
        }
        Ok(())
    }
}

// Here, so that devices do not know of submissions.
impl Gpu {
    /// Records commands, such as copies and builds, sends them, and waits for their end.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails or hangs; it can then not be used any more.
    pub fn prepare(self: &Arc<Self>, record: impl FnOnce(vk::CommandBuffer)) -> Result<(), Error> {
        let mut submission = Submission::new(self)?;
        submission.send(record)?;
        submission.finish(COMPILE_DEADLINE)
    }
}
