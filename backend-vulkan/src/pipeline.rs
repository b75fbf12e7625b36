//! An entry point with what is bound to it.

use crate::{
    acceleration_structure::AccelerationStructure,
    device::{Gpu, WORKGROUP},
    memory::{Buffer, Image},
    shader,
};
use ash::vk;
use spectral_core::Error;
use std::ffi::CString;
use std::sync::Arc;

/// Something that a shader reads or writes.
#[derive(Clone, Copy)]
pub(crate) enum Resource<'a> {
    Uniform(&'a Buffer),
    Storage(&'a Buffer),
    Image(&'a Image),
    Hierarchy(&'a AccelerationStructure),
}

impl Resource<'_> {
    fn kind(&self) -> vk::DescriptorType {
        match self {
            Resource::Uniform(_) => vk::DescriptorType::UNIFORM_BUFFER,
            Resource::Storage(_) => vk::DescriptorType::STORAGE_BUFFER,
            Resource::Image(_) => vk::DescriptorType::SAMPLED_IMAGE,
            Resource::Hierarchy(_) => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        }
    }
}

/// Resources by the numbers of their bindings.
pub(crate) type Group<'a> = [(u32, Resource<'a>)];

/// A compute pipeline and its two groups of bindings: the scene's, and a dispatch's own.
pub(crate) struct Stage {
    gpu: Arc<Gpu>,
    groups: Vec<vk::DescriptorSetLayout>,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
    pool: vk::DescriptorPool,
    sets: Vec<vk::DescriptorSet>,
}

impl Drop for Stage {
    fn drop(&mut self) {
        if !self.gpu.releases() {
            return;
        }
        let device = &self.gpu.device;
        // SAFETY: idle. Null handles are ignored; the sets go with their pool.
        unsafe {
            device.destroy_pipeline(self.pipeline, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_pool(self.pool, None);
            for group in &self.groups {
                device.destroy_descriptor_set_layout(*group, None);
            }
        }
    }
}

impl Stage {
    /// Compiles an entry point and binds what it reads and writes. The second group may be bound anew later.
    ///
    /// # Errors
    /// [`Error::Device`] where the driver refuses.
    pub fn new(gpu: &Arc<Gpu>, entry: &str, source: &str, groups: [&Group<'_>; 2]) -> Result<Self, Error> {
        let what = format!("the shader '{entry}'");
        let words = shader::spirv(source).map_err(|e| gpu.error(format!("{what}: {e}")))?;
        let mut stage = Stage {
            gpu: gpu.clone(),
            groups: Vec::new(),
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
            pool: vk::DescriptorPool::null(),
            sets: Vec::new(),
        };
        stage.lay_out(groups).map_err(gpu.failure(&what))?;
        for (index, group) in groups.into_iter().enumerate() {
            stage.bind(index, group);
        }
        stage.compile(entry, &words).map_err(gpu.failure(&what))?;
        Ok(stage)
    }

    /// Makes the layouts and sets for resources of these kinds.
    fn lay_out(&mut self, groups: [&Group<'_>; 2]) -> Result<(), vk::Result> {
        let device = &self.gpu.device;
        for group in groups {
            let binding = |(number, resource): &(u32, Resource<'_>)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(*number)
                    .descriptor_type(resource.kind())
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            };
            let bindings: Vec<_> = group.iter().map(binding).collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: valid.
            self.groups.push(unsafe { device.create_descriptor_set_layout(&info, None) }?);
        }
        let layout = vk::PipelineLayoutCreateInfo::default().set_layouts(&self.groups);
        let size =
            |resource: &Resource<'_>| vk::DescriptorPoolSize { ty: resource.kind(), descriptor_count: 1 };
        let sizes: Vec<_> = groups.into_iter().flatten().map(|(_, resource)| size(resource)).collect();
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(2).pool_sizes(&sizes);
        // SAFETY: valid; the pool has room for exactly the two sets.
        unsafe {
            self.layout = device.create_pipeline_layout(&layout, None)?;
            self.pool = device.create_descriptor_pool(&pool, None)?;
            let sets =
                vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&self.groups);
            self.sets = device.allocate_descriptor_sets(&sets)?;
        }
        Ok(())
    }

    fn compile(&mut self, entry: &str, words: &[u32]) -> Result<(), vk::Result> {
        let device = &self.gpu.device;
        let name = CString::new(entry).map_err(|_| vk::Result::ERROR_UNKNOWN)?;
        let info = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: valid: naga has validated the module that these words were written from.
        let module = unsafe { device.create_shader_module(&info, None) }?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(&name);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout)];
        // SAFETY: valid: the layout has the bindings that the module declares. The module is not needed afterwards.
        let made = unsafe {
            let made = device.create_compute_pipelines(self.gpu.cache, &info, None);
            device.destroy_shader_module(module, None);
            made
        };
        let pipelines = made.map_err(|(_, result)| result)?;
        self.pipeline = pipelines[0];
        Ok(())
    }

    /// Binds a group of resources in place of those before.
    pub fn bind(&self, index: usize, group: &Group<'_>) {
        for (number, resource) in group {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(self.sets[index])
                .dst_binding(*number)
                .descriptor_type(resource.kind())
                .descriptor_count(1);
            match resource {
                Resource::Uniform(buffer) | Resource::Storage(buffer) => {
                    let info = [vk::DescriptorBufferInfo {
                        buffer: buffer.handle,
                        offset: 0,
                        range: vk::WHOLE_SIZE,
                    }];
                    self.update(write.buffer_info(&info));
                }
                Resource::Image(image) => {
                    let info = [vk::DescriptorImageInfo::default()
                        .image_view(image.view)
                        .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)];
                    self.update(write.image_info(&info));
                }
                Resource::Hierarchy(hierarchy) => {
                    let handles = [hierarchy.handle];
                    let mut info = vk::WriteDescriptorSetAccelerationStructureKHR::default()
                        .acceleration_structures(&handles);
                    self.update(write.push_next(&mut info));
                }
            }
        }
    }

    fn update(&self, write: vk::WriteDescriptorSet<'_>) {
        // SAFETY: valid, idle; the resource is of the kind that the layout has there.
        unsafe { self.gpu.device.update_descriptor_sets(&[write], &[]) };
    }

    /// Records a dispatch of at least `invocations`, with all writes before it visible to it and its own to all after.
    pub fn dispatch(&self, commands: vk::CommandBuffer, invocations: u32) {
        let device = &self.gpu.device;
        let point = vk::PipelineBindPoint::COMPUTE;
        barrier(&self.gpu, commands);
        // SAFETY: alive; what is bound outlives the submission, and callers keep within the device's workgroups.
        unsafe {
            device.cmd_bind_pipeline(commands, point, self.pipeline);
            device.cmd_bind_descriptor_sets(commands, point, self.layout, 0, &self.sets, &[]);
            device.cmd_dispatch(commands, invocations.div_ceil(WORKGROUP), 1, 1);
        }
        barrier(&self.gpu, commands);
    }
}

/// Records that all writes before are visible to all that comes after.
pub(crate) fn barrier(gpu: &Gpu, commands: vk::CommandBuffer) {
    let memory = [vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)];
    let all = vk::PipelineStageFlags::ALL_COMMANDS;
    let none = vk::DependencyFlags::empty();
    // SAFETY: valid.
    unsafe {
        gpu.device.cmd_pipeline_barrier(
            commands,
            all,
            all | vk::PipelineStageFlags::HOST,
            none,
            &memory,
            &[],
            &[],
        )
    };
}
