//! Buffers and images, each with memory of its own.

use crate::device::Gpu;
use ash::vk;
use bytemuck::Pod;
use spectral_core::Error;
use std::sync::Arc;

use vk::MemoryPropertyFlags as Flags;

/// Where memory lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    /// On the device.
    Device,
    /// Where the host writes and reads it.
    Host,
}

const SHARED: Flags = Flags::from_raw(Flags::HOST_VISIBLE.as_raw() | Flags::HOST_COHERENT.as_raw());
const CACHED: Flags = Flags::from_raw(SHARED.as_raw() | Flags::HOST_CACHED.as_raw());

impl Place {
    /// What memory here must be, the most wanted first.
    fn wishes(self) -> [Flags; 2] {
        match self {
            Place::Device => [Flags::DEVICE_LOCAL, Flags::empty()],
            Place::Host => [CACHED, SHARED],
        }
    }
}

/// Memory of the device.
struct Memory {
    gpu: Arc<Gpu>,
    handle: vk::DeviceMemory,
}

impl Drop for Memory {
    fn drop(&mut self) {
        if self.gpu.releases() {
            // SAFETY: idle; what is bound to it is dropped before it.
            unsafe { self.gpu.device.free_memory(self.handle, None) };
        }
    }
}

impl Memory {
    fn new(
        gpu: &Arc<Gpu>,
        what: &str,
        needs: &vk::MemoryRequirements,
        place: Place,
        flags: vk::MemoryAllocateFlags,
    ) -> Result<Self, Error> {
        let kinds = gpu.memory.memory_types_as_slice();
        let suits = |wish: Flags| {
            (0..kinds.len())
                .find(|&i| needs.memory_type_bits & (1 << i) != 0 && kinds[i].property_flags.contains(wish))
        };
        let kind = place.wishes().into_iter().find_map(suits);
        let kind = kind.ok_or_else(|| gpu.error(format!("{what}: the device has no memory of the kind")))?;
        let mut how = vk::MemoryAllocateFlagsInfo::default().flags(flags);
        let mut info =
            vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind as u32);
        if !flags.is_empty() {
            info = info.push_next(&mut how);
        }
        // SAFETY: valid.
        let handle = unsafe { gpu.device.allocate_memory(&info, None) };
        Ok(Memory { gpu: gpu.clone(), handle: handle.map_err(gpu.failure(what))? })
    }
}

/// A buffer.
pub(crate) struct Buffer {
    pub handle: vk::Buffer,
    pub bytes: u64,
    /// What shaders see of it: contents alone, since they count them by its length, and what follows was never written.
    pub shown: u64,
    memory: Memory,
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if self.memory.gpu.releases() {
            // SAFETY: idle.
            unsafe { self.memory.gpu.device.destroy_buffer(self.handle, None) };
        }
    }
}

impl Buffer {
    /// A buffer of `bytes`, at least 256.
    ///
    /// # Errors
    /// [`Error::Device`] where memory runs out.
    pub fn new(
        gpu: &Arc<Gpu>,
        what: &str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        place: Place,
    ) -> Result<Self, Error> {
        let shown = bytes.next_multiple_of(16).max(16);
        let bytes = shown.max(256);
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: valid.
        let handle = unsafe { gpu.device.create_buffer(&info, None) }.map_err(gpu.failure(what))?;
        // SAFETY: alive.
        let needs = unsafe { gpu.device.get_buffer_memory_requirements(handle) };
        let addressed = usage.contains(vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS);
        let flags = if addressed {
            vk::MemoryAllocateFlags::DEVICE_ADDRESS
        } else {
            vk::MemoryAllocateFlags::empty()
        };
        let memory = Memory::new(gpu, what, &needs, place, flags).inspect_err(|_| {
            // SAFETY: idle: never used.
            unsafe { gpu.device.destroy_buffer(handle, None) };
        })?;
        let buffer = Buffer { handle, bytes, shown, memory };
        // SAFETY: valid: memory of the kind and size that the buffer needs.
        unsafe { gpu.device.bind_buffer_memory(handle, buffer.memory.handle, 0) }
            .map_err(gpu.failure(what))?;
        Ok(buffer)
    }

    /// A buffer on the device for shaders, and for copies to and from it.
    ///
    /// # Errors
    /// [`Error::Device`] where it exceeds what shaders may bind, or memory runs out.
    pub fn storage(gpu: &Arc<Gpu>, what: &str, bytes: u64) -> Result<Self, Error> {
        use vk::BufferUsageFlags as Usage;
        let limit = gpu.limits.storage;
        if bytes > limit {
            let mib = |bytes: u64| bytes.div_ceil(1 << 20);
            let message =
                format!("{what} need {} MiB; this device binds at most {} MiB", mib(bytes), mib(limit));
            return Err(gpu.error(message));
        }
        let usage = Usage::STORAGE_BUFFER | Usage::TRANSFER_DST | Usage::TRANSFER_SRC;
        Self::new(gpu, what, bytes, usage, Place::Device)
    }

    /// A buffer on the device for a block of constants.
    pub fn uniform(gpu: &Arc<Gpu>, what: &str, bytes: u64) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::UNIFORM_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        Self::new(gpu, what, bytes, usage, Place::Device)
    }

    /// A buffer of the host's to copy from or to.
    pub fn host(gpu: &Arc<Gpu>, what: &str, bytes: u64) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        Self::new(gpu, what, bytes, usage, Place::Host)
    }

    /// A storage buffer on the device with the given contents.
    pub fn filled(gpu: &Arc<Gpu>, what: &str, contents: &[u8]) -> Result<Self, Error> {
        let buffer = Self::storage(gpu, what, contents.len() as u64)?;
        buffer.fill(what, contents)?;
        Ok(buffer)
    }

    /// Sets the first bytes of a buffer on the device.
    pub fn fill(&self, what: &str, contents: &[u8]) -> Result<(), Error> {
        if contents.is_empty() {
            return Ok(());
        }
        let gpu = &self.memory.gpu;
        let staging = Buffer::host(gpu, what, contents.len() as u64)?;
        staging.write(&[contents])?;
        gpu.prepare(|commands| self.copy_from(commands, &staging, 0, 0, contents.len() as u64))
    }

    /// Records a copy of `bytes` from another buffer.
    pub fn copy_from(&self, commands: vk::CommandBuffer, from: &Buffer, start: u64, to: u64, bytes: u64) {
        let region = [vk::BufferCopy { src_offset: start, dst_offset: to, size: bytes }];
        // SAFETY: alive; callers copy within both buffers.
        unsafe { self.memory.gpu.device.cmd_copy_buffer(commands, from.handle, self.handle, &region) };
    }

    /// Records that the first bytes of a buffer on the device are set, up to 65,536 of them.
    pub fn set(&self, commands: vk::CommandBuffer, contents: &[u8]) {
        // SAFETY: alive; callers set what the buffer was made for, whole blocks of four bytes.
        unsafe { self.memory.gpu.device.cmd_update_buffer(commands, self.handle, 0, contents) };
    }

    /// Writes pieces, one after another, from the first byte of a buffer of the host's on.
    pub fn write(&self, pieces: &[&[u8]]) -> Result<(), Error> {
        assert!(pieces.iter().map(|piece| piece.len() as u64).sum::<u64>() <= self.bytes);
        let mut at = self.map()?;
        for piece in pieces {
            // SAFETY: idle; the mapping is of the whole buffer, which is no smaller than all pieces together.
            unsafe {
                at.copy_from_nonoverlapping(piece.as_ptr(), piece.len());
                at = at.add(piece.len());
            }
        }
        // SAFETY: alive, mapped above.
        unsafe { self.memory.gpu.device.unmap_memory(self.memory.handle) };
        Ok(())
    }

    /// Puts `bytes` bytes from byte `start` on, of a buffer of the host's, in place of values.
    pub fn read<T: Pod>(&self, start: u64, bytes: u64, values: &mut Vec<T>) -> Result<(), Error> {
        assert!(start + bytes <= self.bytes);
        values.resize(bytes as usize / size_of::<T>(), T::zeroed());
        let into: &mut [u8] = bytemuck::cast_slice_mut(values);
        let at = self.map()?;
        // SAFETY: idle; the mapping is of the whole buffer, within which the values lie.
        unsafe {
            into.as_mut_ptr().copy_from_nonoverlapping(at.add(start as usize), into.len());
            self.memory.gpu.device.unmap_memory(self.memory.handle);
        }
        Ok(())
    }

    fn map(&self) -> Result<*mut u8, Error> {
        let gpu = &self.memory.gpu;
        let flags = vk::MemoryMapFlags::empty();
        // SAFETY: valid: memory that the host sees, not mapped now.
        let at = unsafe { gpu.device.map_memory(self.memory.handle, 0, vk::WHOLE_SIZE, flags) };
        Ok(at.map_err(gpu.failure("memory of the host"))?.cast())
    }

    /// Where the device finds it, for buffers made with that usage.
    pub fn address(&self) -> vk::DeviceAddress {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.handle);
        // SAFETY: alive.
        unsafe { self.memory.gpu.device.get_buffer_device_address(&info) }
    }
}

/// A two-dimensional image that shaders load texels from.
pub(crate) struct Image {
    pub view: vk::ImageView,
    handle: vk::Image,
    memory: Memory,
}

impl Drop for Image {
    fn drop(&mut self) {
        if self.memory.gpu.releases() {
            // SAFETY: idle. A null view is ignored.
            unsafe {
                self.memory.gpu.device.destroy_image_view(self.view, None);
                self.memory.gpu.device.destroy_image(self.handle, None);
            }
        }
    }
}

const COLOUR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

impl Image {
    /// An image with contents that come in pieces of whole rows of `row_bytes`, each with its first row.
    ///
    /// # Errors
    /// [`Error::Device`] where it exceeds the device's limits or memory.
    pub fn filled(
        gpu: &Arc<Gpu>,
        what: &str,
        [width, height]: [u32; 2],
        format: vk::Format,
        row_bytes: u32,
        pieces: impl Iterator<Item = (u32, Vec<u8>)>,
    ) -> Result<Self, Error> {
        let edge = gpu.limits.image;
        if width.max(height) > edge {
            let message = format!(
                "{what} has {width} × {height} texels; this device's images have at most {edge} an edge"
            );
            return Err(gpu.error(message));
        }
        let image = Self::new(gpu, what, [width, height], format)?;
        for (row, bytes) in pieces {
            image.fill(what, width, row, bytes.len() as u32 / row_bytes, &bytes)?;
        }
        let (from, to) = (vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        gpu.prepare(|commands| image.change(commands, from, to))?;
        Ok(image)
    }

    fn new(gpu: &Arc<Gpu>, what: &str, [width, height]: [u32; 2], format: vk::Format) -> Result<Self, Error> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST);
        // SAFETY: valid: every device samples the two formats in use.
        let handle = unsafe { gpu.device.create_image(&info, None) }.map_err(gpu.failure(what))?;
        // SAFETY: alive.
        let needs = unsafe { gpu.device.get_image_memory_requirements(handle) };
        let memory = Memory::new(gpu, what, &needs, Place::Device, vk::MemoryAllocateFlags::empty())
            .inspect_err(|_| {
                // SAFETY: idle: never used.
                unsafe { gpu.device.destroy_image(handle, None) };
            })?;
        let mut image = Image { view: vk::ImageView::null(), handle, memory };
        let view = vk::ImageViewCreateInfo::default()
            .image(handle)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(COLOUR);
        // SAFETY: valid: memory of the kind and size that the image needs; the view is of its own format.
        image.view = unsafe {
            gpu.device.bind_image_memory(handle, image.memory.handle, 0).map_err(gpu.failure(what))?;
            gpu.device.create_image_view(&view, None).map_err(gpu.failure(what))?
        };
        let (from, to) = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        gpu.prepare(|commands| image.change(commands, from, to))?;
        Ok(image)
    }

    fn fill(&self, what: &str, width: u32, row: u32, rows: u32, bytes: &[u8]) -> Result<(), Error> {
        let gpu = &self.memory.gpu;
        let staging = Buffer::host(gpu, what, bytes.len() as u64)?;
        staging.write(&[bytes])?;
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        };
        let region = [vk::BufferImageCopy::default()
            .image_subresource(layers)
            .image_offset(vk::Offset3D { x: 0, y: row as i32, z: 0 })
            .image_extent(vk::Extent3D { width, height: rows, depth: 1 })];
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        gpu.prepare(
            // SAFETY: alive, in that layout, the piece within the image.
            |commands| unsafe {
                gpu.device.cmd_copy_buffer_to_image(commands, staging.handle, self.handle, layout, &region);
            },
        )
    }

    /// Records a change of layout, after all before it and before all after it.
    fn change(&self, commands: vk::CommandBuffer, from: vk::ImageLayout, to: vk::ImageLayout) {
        let barrier = [vk::ImageMemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
            .old_layout(from)
            .new_layout(to)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(self.handle)
            .subresource_range(COLOUR)];
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        // SAFETY: alive; the image is in the layout `from`.
        unsafe {
            self.memory.gpu.device.cmd_pipeline_barrier(
                commands,
                all,
                all,
                vk::DependencyFlags::empty(),
                &[],
                &[],
                &barrier,
            );
        }
    }
}
