//! The driver's hierarchy over our triangles.

use crate::{
    device::Gpu,
    memory::{Buffer, Place},
};
use ash::vk;
use spectral_core::Error;
use std::sync::Arc;

use vk::BufferUsageFlags as Usage;

/// An acceleration structure, with those that it refers to.
pub(crate) struct AccelerationStructure {
    pub handle: vk::AccelerationStructureKHR,
    gpu: Arc<Gpu>,
    _memory: Buffer,
    _below: Option<Box<AccelerationStructure>>,
}

impl Drop for AccelerationStructure {
    fn drop(&mut self) {
        if let (true, Ok(structures)) = (self.gpu.releases(), self.gpu.structures()) {
            // SAFETY: idle. Its memory is dropped after it.
            unsafe { structures.destroy_acceleration_structure(self.handle, None) };
        }
    }
}

/// A buffer that builds read from, with contents.
fn input(gpu: &Arc<Gpu>, what: &str, contents: &[u8]) -> Result<Buffer, Error> {
    let usage = Usage::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
        | Usage::SHADER_DEVICE_ADDRESS
        | Usage::TRANSFER_DST;
    let buffer = Buffer::new(gpu, what, contents.len() as u64, usage, Place::Device)?;
    buffer.fill(what, contents)?;
    Ok(buffer)
}

impl AccelerationStructure {
    /// The hierarchy over triangles with the given corners (mm, local), three a triangle, none of them opaque. Shaders
    /// see a triangle by its place in this order, which should be one of space: some drivers build no better than it.
    ///
    /// # Errors
    /// [`Error::Device`] where there are more than the device takes, or where memory runs out.
    pub fn new(gpu: &Arc<Gpu>, corners: &[[f32; 3]]) -> Result<Self, Error> {
        let count = corners.len() / 3;
        if count as u64 > gpu.limits.triangles {
            let message = format!("{count} triangles; this device traces at most {}", gpu.limits.triangles);
            return Err(gpu.error(message));
        }
        let bottom = Self::of_triangles(gpu, corners, count as u32)?;
        Self::of_instance(gpu, bottom)
    }

    fn of_triangles(gpu: &Arc<Gpu>, corners: &[[f32; 3]], count: u32) -> Result<Self, Error> {
        let vertices = input(gpu, "the triangles", bytemuck::cast_slice(corners))?;
        let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
            .vertex_format(vk::Format::R32G32B32_SFLOAT)
            .vertex_data(vk::DeviceOrHostAddressConstKHR { device_address: vertices.address() })
            .vertex_stride(size_of::<[f32; 3]>() as u64)
            .max_vertex(3 * count - 1)
            .index_type(vk::IndexType::NONE_KHR);
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { triangles });
        Self::build(gpu, vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL, geometry, count, None)
    }

    fn of_instance(gpu: &Arc<Gpu>, below: AccelerationStructure) -> Result<Self, Error> {
        let info =
            vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(below.handle);
        // SAFETY: alive.
        let address = unsafe { gpu.structures()?.get_acceleration_structure_device_address(&info) };
        // A row-major 3 × 4 identity; index 0 with mask 255; no offset, no flags; the reference: 64 bytes.
        let mut words = [0u32; 16];
        for diagonal in [0, 5, 10] {
            words[diagonal] = 1.0f32.to_bits();
        }
        words[12] = 0xff << 24;
        words[14] = address as u32;
        words[15] = (address >> 32) as u32;
        let instances = input(gpu, "the instance", bytemuck::bytes_of(&words))?;
        let data = vk::AccelerationStructureGeometryInstancesDataKHR::default()
            .data(vk::DeviceOrHostAddressConstKHR { device_address: instances.address() });
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::INSTANCES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data });
        Self::build(gpu, vk::AccelerationStructureTypeKHR::TOP_LEVEL, geometry, 1, Some(Box::new(below)))
    }

    /// Builds over `count` primitives, whose buffers the caller keeps until this returns.
    fn build(
        gpu: &Arc<Gpu>,
        level: vk::AccelerationStructureTypeKHR,
        geometry: vk::AccelerationStructureGeometryKHR<'_>,
        count: u32,
        below: Option<Box<AccelerationStructure>>,
    ) -> Result<Self, Error> {
        let functions = gpu.structures()?;
        let geometries = [geometry];
        let mut info = vk::AccelerationStructureBuildGeometryInfoKHR::default()
            .ty(level)
            .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
            .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
            .geometries(&geometries);
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        let device = vk::AccelerationStructureBuildTypeKHR::DEVICE;
        // SAFETY: valid.
        unsafe { functions.get_acceleration_structure_build_sizes(device, &info, &[count], &mut sizes) };
        let usage = Usage::ACCELERATION_STRUCTURE_STORAGE_KHR | Usage::SHADER_DEVICE_ADDRESS;
        let what = "the hierarchy";
        let memory = Buffer::new(gpu, what, sizes.acceleration_structure_size, usage, Place::Device)?;
        let create = vk::AccelerationStructureCreateInfoKHR::default()
            .buffer(memory.handle)
            .size(sizes.acceleration_structure_size)
            .ty(level);
        // SAFETY: valid: the buffer is of the size and usage asked for.
        let handle = unsafe { functions.create_acceleration_structure(&create, None) };
        let handle = handle.map_err(gpu.failure(what))?;
        let made = AccelerationStructure { handle, gpu: gpu.clone(), _memory: memory, _below: below };

        let alignment = gpu.limits.scratch_alignment;
        let usage = Usage::STORAGE_BUFFER | Usage::SHADER_DEVICE_ADDRESS;
        let scratch = Buffer::new(gpu, what, sizes.build_scratch_size + alignment, usage, Place::Device)?;
        info = info.dst_acceleration_structure(handle).scratch_data(vk::DeviceOrHostAddressKHR {
            device_address: scratch.address().next_multiple_of(alignment),
        });
        let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count)];
        gpu.prepare(
            // SAFETY: valid: sizes as the driver asked; inputs and scratch memory live until the build has ended.
            |commands| unsafe {
                functions.cmd_build_acceleration_structures(commands, &[info], &[&range]);
            },
        )?;
        Ok(made)
    }
}
