//! An entry point with what is bound to it.

use crate::{
    acceleration_structure::AccelerationStructure,
    binding_table::BindingTable,
    device::Gpu,
    memory::{Buffer, Image},
    shader,
};
use ash::vk;
use spectral_core::{Error, kernel::plan::workgroups};
use std::ffi::CStr;
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

/// What kind of pipeline a shader is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// The compute entry point of this name.
    Compute(&'static CStr),
    /// The entry points of `Form::trace_pipeline`.
    Rays,
}

impl Kind {
    fn stages(self) -> vk::ShaderStageFlags {
        match self {
            Kind::Compute(_) => vk::ShaderStageFlags::COMPUTE,
            Kind::Rays => vk::ShaderStageFlags::RAYGEN_KHR | vk::ShaderStageFlags::ANY_HIT_KHR,
        }
    }
}

/// A compiled shader, with the layouts of its two groups of bindings: the scene's, and a batch's.
pub(crate) struct Shader {
    gpu: Arc<Gpu>,
    groups: Vec<vk::DescriptorSetLayout>,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
    /// Present where the pipeline traces rays.
    table: Option<BindingTable>,
}

impl Drop for Shader {
    fn drop(&mut self) {
        if !self.gpu.releases() {
            return;
        }
        let device = &self.gpu.device;
        // SAFETY: idle. Null handles are ignored.
        unsafe {
            device.destroy_pipeline(self.pipeline, None);
            device.destroy_pipeline_layout(self.layout, None);
            for group in &self.groups {
                device.destroy_descriptor_set_layout(*group, None);
            }
        }
    }
}

/// A shader with what it reads and writes.
pub(crate) struct Stage {
    shader: Arc<Shader>,
    pool: vk::DescriptorPool,
    sets: Vec<vk::DescriptorSet>,
}

impl Drop for Stage {
    fn drop(&mut self) {
        if self.shader.gpu.releases() {
            // SAFETY: idle. A null handle is ignored; the sets go with their pool.
            unsafe { self.shader.gpu.device.destroy_descriptor_pool(self.pool, None) };
        }
    }
}

impl Stage {
    /// Binds what a shader reads and writes, of the kinds that it was made for.
    ///
    /// # Errors
    /// [`Error::Device`] where the driver refuses.
    pub fn new(shader: &Arc<Shader>, groups: [&Group<'_>; 2]) -> Result<Self, Error> {
        let gpu = &shader.gpu;
        let mut stage = Stage { shader: shader.clone(), pool: vk::DescriptorPool::null(), sets: Vec::new() };
        let size =
            |resource: &Resource<'_>| vk::DescriptorPoolSize { ty: resource.kind(), descriptor_count: 1 };
        let sizes: Vec<_> = groups.into_iter().flatten().map(|(_, resource)| size(resource)).collect();
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(2).pool_sizes(&sizes);
        // SAFETY: valid; the pool has room for exactly the two sets.
        let made = unsafe {
            gpu.device.create_descriptor_pool(&pool, None).and_then(|pool| {
                stage.pool = pool;
                let sets = vk::DescriptorSetAllocateInfo::default()
                    .descriptor_pool(pool)
                    .set_layouts(&shader.groups);
                gpu.device.allocate_descriptor_sets(&sets)
            })
        };
        stage.sets = made.map_err(gpu.failure("the bindings"))?;
        for (index, group) in groups.into_iter().enumerate() {
            stage.bind(index, group);
        }
        Ok(stage)
    }

    fn bind(&self, index: usize, group: &Group<'_>) {
        for (number, resource) in group {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(self.sets[index])
                .dst_binding(*number)
                .descriptor_type(resource.kind())
                .descriptor_count(1);
            match resource {
                Resource::Uniform(buffer) | Resource::Storage(buffer) => {
                    let info =
                        [vk::DescriptorBufferInfo { buffer: buffer.handle, offset: 0, range: buffer.shown }];
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
        unsafe { self.shader.gpu.device.update_descriptor_sets(&[write], &[]) };
    }

    /// Records a dispatch of at least `invocations`, with all writes before it visible to it and its own to all after.
    pub fn dispatch(&self, commands: vk::CommandBuffer, invocations: u32) {
        let Shader { gpu, layout, pipeline, table, .. } = &*self.shader;
        let device = &gpu.device;
        let point = match table {
            None => vk::PipelineBindPoint::COMPUTE,
            Some(_) => vk::PipelineBindPoint::RAY_TRACING_KHR,
        };
        barrier(gpu, commands);
        // SAFETY: alive; what is bound outlives the submission.
        unsafe {
            device.cmd_bind_pipeline(commands, point, *pipeline);
            device.cmd_bind_descriptor_sets(commands, point, *layout, 0, &self.sets, &[]);
        }
        let [across, down] = workgroups(invocations);
        match table {
            // SAFETY: a compute pipeline is bound; every device takes so many workgroups.
            None => unsafe { device.cmd_dispatch(commands, across, down, 1) },
            Some(table) => table.trace(gpu, commands, invocations),
        }
        barrier(gpu, commands);
    }
}

impl Shader {
    /// Compiles a shader that binds such resources.
    ///
    /// # Errors
    /// [`Error::Device`] where the driver refuses.
    pub fn new(gpu: &Arc<Gpu>, kind: Kind, source: &str, groups: [&Group<'_>; 2]) -> Result<Self, Error> {
        let what = "a shader";
        let mut words = shader::spirv(source).map_err(|e| gpu.error(format!("{what}: {e}")))?;
        if kind == Kind::Rays {
            shader::ignore_at_early_returns(&mut words).map_err(|e| gpu.error(format!("{what}: {e}")))?;
        }
        let mut shader = Shader {
            gpu: gpu.clone(),
            groups: Vec::new(),
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
            table: None,
        };
        shader.lay_out(kind, groups).map_err(gpu.failure(what))?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: valid: naga has validated the module that these words were written from.
        let module = unsafe { gpu.device.create_shader_module(&info, None) }.map_err(gpu.failure(what))?;
        let made = match kind {
            Kind::Compute(entry) => shader.compute_pipeline(module, entry),
            Kind::Rays => shader.ray_pipeline(module),
        };
        // SAFETY: pipelines do not need their modules once they are made.
        unsafe { gpu.device.destroy_shader_module(module, None) };
        shader.pipeline = made.map_err(gpu.failure(what))?;
        if kind == Kind::Rays {
            shader.table = Some(BindingTable::new(gpu, shader.pipeline)?);
        }
        Ok(shader)
    }

    /// Makes the layouts for resources of these kinds.
    fn lay_out(&mut self, kind: Kind, groups: [&Group<'_>; 2]) -> Result<(), vk::Result> {
        let device = &self.gpu.device;
        for group in groups {
            let binding = |(number, resource): &(u32, Resource<'_>)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(*number)
                    .descriptor_type(resource.kind())
                    .descriptor_count(1)
                    .stage_flags(kind.stages())
            };
            let bindings: Vec<_> = group.iter().map(binding).collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: valid.
            self.groups.push(unsafe { device.create_descriptor_set_layout(&info, None) }?);
        }
        let layout = vk::PipelineLayoutCreateInfo::default().set_layouts(&self.groups);
        // SAFETY: valid.
        self.layout = unsafe { device.create_pipeline_layout(&layout, None) }?;
        Ok(())
    }

    fn compute_pipeline(&self, module: vk::ShaderModule, entry: &CStr) -> Result<vk::Pipeline, vk::Result> {
        let info = [vk::ComputePipelineCreateInfo::default()
            .stage(shader_stage(vk::ShaderStageFlags::COMPUTE, module, entry))
            .layout(self.layout)];
        // SAFETY: valid: the layout has the bindings that the module declares.
        let made = unsafe { self.gpu.device.create_compute_pipelines(self.gpu.cache, &info, None) };
        made.map(|pipelines| pipelines[0]).map_err(|(_, result)| result)
    }

    fn ray_pipeline(&self, module: vk::ShaderModule) -> Result<vk::Pipeline, vk::Result> {
        let Ok(functions) = self.gpu.pipelines() else { return Err(vk::Result::ERROR_EXTENSION_NOT_PRESENT) };
        let stages = [
            shader_stage(vk::ShaderStageFlags::RAYGEN_KHR, module, c"trace"),
            shader_stage(vk::ShaderStageFlags::MISS_KHR, module, c"pass_by"),
            shader_stage(vk::ShaderStageFlags::ANY_HIT_KHR, module, c"consider"),
        ];
        let groups = [general(0), general(1), any_hit(2)];
        let info = [vk::RayTracingPipelineCreateInfoKHR::default()
            .stages(&stages)
            .groups(&groups)
            .max_pipeline_ray_recursion_depth(1)
            .layout(self.layout)];
        let deferred = vk::DeferredOperationKHR::null();
        // SAFETY: valid: the layout has the bindings that the module declares, the groups name its stages.
        let made = unsafe { functions.create_ray_tracing_pipelines(deferred, self.gpu.cache, &info, None) };
        made.map(|pipelines| pipelines[0]).map_err(|(_, result)| result)
    }
}

fn shader_stage(
    stage: vk::ShaderStageFlags,
    module: vk::ShaderModule,
    entry: &CStr,
) -> vk::PipelineShaderStageCreateInfo<'_> {
    vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(entry)
}

/// A group of one ray-generation or miss shader.
fn general(stage: u32) -> vk::RayTracingShaderGroupCreateInfoKHR<'static> {
    group(vk::RayTracingShaderGroupTypeKHR::GENERAL).general_shader(stage)
}

/// A group of an any-hit shader for triangles.
fn any_hit(stage: u32) -> vk::RayTracingShaderGroupCreateInfoKHR<'static> {
    group(vk::RayTracingShaderGroupTypeKHR::TRIANGLES_HIT_GROUP).any_hit_shader(stage)
}

fn group(kind: vk::RayTracingShaderGroupTypeKHR) -> vk::RayTracingShaderGroupCreateInfoKHR<'static> {
    vk::RayTracingShaderGroupCreateInfoKHR::default()
        .ty(kind)
        .general_shader(vk::SHADER_UNUSED_KHR)
        .closest_hit_shader(vk::SHADER_UNUSED_KHR)
        .any_hit_shader(vk::SHADER_UNUSED_KHR)
        .intersection_shader(vk::SHADER_UNUSED_KHR)
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
