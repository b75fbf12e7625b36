//! The shaders of a ray-tracing pipeline, as rays find them.

use crate::{
    device::Gpu,
    memory::{Buffer, Place},
};
use ash::vk;
use spectral_core::Error;
use std::sync::Arc;

use vk::BufferUsageFlags as Usage;

/// Tables of one shader group each: ray generation, miss, hit.
pub(crate) struct BindingTable {
    regions: [vk::StridedDeviceAddressRegionKHR; 3],
    _memory: Buffer,
}

impl BindingTable {
    /// The tables of a pipeline with these three groups, in this order.
    ///
    /// # Errors
    /// [`Error::Device`] where the driver refuses.
    pub fn new(gpu: &Arc<Gpu>, pipeline: vk::Pipeline) -> Result<Self, Error> {
        let what = "the table of shaders";
        let size = gpu.limits.handle as usize;
        // SAFETY: alive; the pipeline has three groups.
        let handles =
            unsafe { gpu.pipelines()?.get_ray_tracing_shader_group_handles(pipeline, 0, 3, 3 * size) };
        let handles = handles.map_err(gpu.failure(what))?;
        let alignment = gpu.limits.table_alignment;
        let stride = u64::from(gpu.limits.handle.next_multiple_of(gpu.limits.handle_alignment));
        let step = stride.next_multiple_of(alignment);
        let usage = Usage::SHADER_BINDING_TABLE_KHR | Usage::SHADER_DEVICE_ADDRESS | Usage::TRANSFER_DST;
        let memory = Buffer::new(gpu, what, 3 * step + alignment, usage, Place::Device)?;
        let first = memory.address().next_multiple_of(alignment);
        let skipped = (first - memory.address()) as usize;
        let mut contents = vec![0; skipped + 3 * step as usize];
        for (handle, to) in handles.chunks(size).zip(contents[skipped..].chunks_mut(step as usize)) {
            to[..size].copy_from_slice(handle);
        }
        memory.fill(what, &contents)?;
        let region = |index: u64| vk::StridedDeviceAddressRegionKHR {
            device_address: first + index * step,
            stride,
            size: stride,
        };
        Ok(BindingTable { regions: [0, 1, 2].map(region), _memory: memory })
    }

    /// Records rays from `invocations` of the ray-generation shader, the pipeline and its bindings being set.
    pub fn trace(&self, gpu: &Gpu, commands: vk::CommandBuffer, invocations: u32) {
        let [generation, miss, hit] = &self.regions;
        let callable = vk::StridedDeviceAddressRegionKHR::default();
        if let Ok(functions) = gpu.pipelines() {
            // SAFETY: alive; the tables are the bound pipeline's own.
            unsafe {
                functions.cmd_trace_rays(commands, generation, miss, hit, &callable, invocations, 1, 1)
            };
        }
    }
}
