//! A prepared scene as buffers and compiled shaders.

use crate::{
    device::{Gpu, WORKGROUP},
    environment,
};
use accel::{BuildOptions, Bvh, glam::Vec3, software};
use bytemuck::{bytes_of, cast_slice};
use spectral_core::{
    Error,
    kernel::{
        Form,
        block::Scene,
        facets::{Facets, Guess},
        pack,
    },
    prepare::{Geometry, PreparedScene},
};

/// Both entry points, compiled, with the scene bound to each.
pub(crate) struct Kernel {
    pub form: Form,
    pub trace: Stage,
    pub gather: Stage,
}

/// An entry point and its scene.
pub(crate) struct Stage {
    pub pipeline: wgpu::ComputePipeline,
    pub scene: wgpu::BindGroup,
}

/// How rays find surfaces: the shader of `trace`, and the buffers of its own, from binding 5 on.
struct Intersection {
    text: String,
    buffers: Vec<wgpu::Buffer>,
    builder_scale: f32,
}

impl Kernel {
    /// Compiles the kernel for a scene and uploads what does not change from sample to sample. `guess` is for one
    /// convex stone, and by default what suits the device.
    pub fn new(gpu: &Gpu, scene: &PreparedScene, guess: Option<Guess>) -> Result<Self, Error> {
        pack::check(scene)?;
        let form = pack::form(scene, WORKGROUP);
        let intersection = Intersection::new(gpu, scene, form, guess)?;
        let light = environment::upload(gpu, &scene.environment.source)?;
        let block = gpu.buffer(
            "scene",
            size_of::<Scene>() as u64,
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        )?;
        let contents =
            Scene { builder_scale: intersection.builder_scale, gain: light.gain, ..pack::scene(scene) };
        gpu.queue.write_buffer(&block, 0, bytes_of(&contents));
        let optics = gpu.filled("the optics of all wavelengths", cast_slice(&pack::optics(scene)))?;
        let planes = gpu.filled("the facet planes", cast_slice(&pack::planes(&scene.geometry)))?;
        let materials = pack::material_of_rank(&scene.geometry);
        let materials = gpu.filled("the stones", cast_slice(&materials))?;

        let mut entries = vec![
            entry(0, block.as_entire_binding()),
            entry(1, wgpu::BindingResource::TextureView(&light.view)),
            entry(2, optics.as_entire_binding()),
            entry(3, planes.as_entire_binding()),
            entry(4, materials.as_entire_binding()),
        ];
        entries.extend((5..).zip(&intersection.buffers).map(|(at, b)| entry(at, b.as_entire_binding())));
        let trace = Stage::new(gpu, "trace", &intersection.text, &entries)?;
        let entries = [entry(0, block.as_entire_binding()), entry(2, optics.as_entire_binding())];
        let gather = Stage::new(gpu, "gather", &form.gather(), &entries)?;
        Ok(Kernel { form, trace, gather })
    }
}

fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

impl Intersection {
    fn new(gpu: &Gpu, scene: &PreparedScene, form: Form, guess: Option<Guess>) -> Result<Self, Error> {
        if scene.geometry.stones.is_empty() || scene.lone_convex_stone().is_some() {
            let guess = guess.unwrap_or(Guess::by_default(gpu.subgroups));
            if guess == Guess::Subgroup && !gpu.subgroups {
                return Err(gpu.error("this device has no subgroup operations"));
            }
            let facets = Facets::new(scene, guess, gpu.limits.max_compute_workgroup_storage_size);
            let mut buffers = Vec::new();
            if facets.verifies() {
                buffers.push(gpu.filled("the facets' outlines", cast_slice(&facets.outlines))?);
            }
            return Ok(Intersection { text: form.trace_facets(&facets), buffers, builder_scale: 1.0 });
        }
        let bvh = hierarchy(&scene.geometry).map_err(|e| gpu.error(e.to_string()))?;
        let triangles = bvh.triangle_blocks(|number| scene.geometry.facet_of[number as usize]);
        let nodes = gpu.filled("the hierarchy's nodes", bvh.node_bytes())?;
        let triangles = gpu.filled("the triangles", cast_slice(&triangles))?;
        let text = form.trace(&(bvh.wgsl_constants() + software::INTERSECT));
        Ok(Intersection { text, buffers: vec![nodes, triangles], builder_scale: bvh.builder_scale() })
    }
}

fn hierarchy(geometry: &Geometry) -> Result<Bvh, accel::Error> {
    let positions: Vec<Vec3> = geometry.positions.iter().map(|p| p.as_vec3()).collect();
    Bvh::build(&positions, &geometry.triangles, &BuildOptions::default())
}

impl Stage {
    fn new(
        gpu: &Gpu,
        entry_point: &'static str,
        source: &str,
        entries: &[wgpu::BindGroupEntry<'_>],
    ) -> Result<Self, Error> {
        let what = format!("the shader '{entry_point}'");
        let module = gpu.attempt(&what, || module(&gpu.device, entry_point, source))?;
        let pipeline = gpu.attempt(&what, || {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: None,
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..wgpu::PipelineCompilationOptions::default()
                },
                cache: None,
            })
        })?;
        let scene = bind(gpu, &pipeline, 0, entries)?;
        Ok(Stage { pipeline, scene })
    }

    /// Binds a dispatch's own buffers, in the order of their numbers.
    pub fn bind(&self, gpu: &Gpu, buffers: &[&wgpu::Buffer]) -> Result<wgpu::BindGroup, Error> {
        let resources = buffers.iter().zip(0..);
        let entries: Vec<_> = resources.map(|(buffer, at)| entry(at, buffer.as_entire_binding())).collect();
        bind(gpu, &self.pipeline, 1, &entries)
    }
}

fn bind(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    group: u32,
    entries: &[wgpu::BindGroupEntry<'_>],
) -> Result<wgpu::BindGroup, Error> {
    gpu.attempt("the bindings", || {
        let layout = pipeline.get_bind_group_layout(group);
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries })
    })
}

fn module(device: &wgpu::Device, label: &str, source: &str) -> wgpu::ShaderModule {
    let descriptor =
        wgpu::ShaderModuleDescriptor { label: Some(label), source: wgpu::ShaderSource::Wgsl(source.into()) };
    // SAFETY: the text is ours, not a user's. Every index it takes comes from the buffers' own lengths (items, stack
    // places) or from tables that were validated when the scene was prepared (facets, ranks, materials, lines) or
    // built (outlines, nodes, triangles); a guessed facet is compared with their number; and every loop ends: traversals
    // by the tree's size, walks by their budget.
    unsafe { device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) }
}
