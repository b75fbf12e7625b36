//! A prepared scene as buffers and compiled shaders.

use crate::{
    device::Gpu,
    environment::{self, Light},
};
use accel::{BuildOptions, Bvh, glam::Vec3, software};
use bytemuck::{bytes_of, cast_slice};
use spectral_core::{
    Error,
    environment::Source,
    kernel::{
        Form,
        block::Scene,
        facets::{Facets, Guess},
        pack,
        plan::{self, Part, Stage},
    },
    prepare::{Geometry, Optics, PreparedScene},
};
use std::sync::{Arc, PoisonError};

/// What a device keeps of a scene, for the next that has the same.
pub(crate) struct Parts {
    surfaces: Surfaces,
    source: Source,
    light: Light,
    optics: (Arc<Optics>, wgpu::Buffer),
}

/// How rays find surfaces, with the stones' buffers.
struct Surfaces {
    geometry: Arc<Geometry>,
    /// The text after the form's own constants: of planes, or of `intersect` through a hierarchy.
    intersection: Intersection,
    /// From binding [`plan::SURFACES`] on.
    buffers: Vec<wgpu::Buffer>,
    planes: wgpu::Buffer,
    materials: wgpu::Buffer,
}

enum Intersection {
    Planes(Facets),
    Hierarchy(String, f32),
}

impl Parts {
    /// Uploads what the scene before did not have.
    pub fn new(gpu: &Gpu, scene: &PreparedScene, guess: Guess, before: Option<Parts>) -> Result<Self, Error> {
        pack::check(scene)?;
        let planar = scene.geometry.stones.is_empty() || scene.lone_convex_stone().is_some();
        let (surfaces, light, optics) = before
            .map_or((None, None, None), |b| (Some(b.surfaces), Some((b.source, b.light)), Some(b.optics)));
        let same = |before: &Surfaces| {
            Arc::ptr_eq(&before.geometry, &scene.geometry)
                && planar == matches!(before.intersection, Intersection::Planes(_))
        };
        let surfaces = match surfaces.filter(same) {
            Some(surfaces) => surfaces,
            None => Surfaces::new(gpu, scene, planar.then_some(guess))?,
        };
        let source = scene.environment.source.clone();
        let light = match light.filter(|(before, _)| before.shares_texels(&source)) {
            Some((_, light)) => light,
            None => environment::upload(gpu, &source)?,
        };
        let optics = match optics.filter(|(before, _)| Arc::ptr_eq(before, &scene.optics)) {
            Some(optics) => optics,
            None => {
                let contents = pack::optics(scene);
                let buffer = gpu.filled("the optics of all wavelengths", cast_slice(&contents))?;
                (scene.optics.clone(), buffer)
            }
        };
        Ok(Parts { surfaces, source, light, optics })
    }

    /// Whether every path is a chain.
    pub fn chain(&self) -> bool {
        matches!(self.surfaces.intersection, Intersection::Planes(_))
    }
}

impl Surfaces {
    /// One convex stone is met by its planes in the form `planar`; `None` takes a hierarchy.
    fn new(gpu: &Gpu, scene: &PreparedScene, planar: Option<Guess>) -> Result<Self, Error> {
        let planes = gpu.filled("the facet planes", cast_slice(&pack::planes(&scene.geometry)))?;
        let materials = scene.geometry.material_of_rank();
        let materials = gpu.filled("the stones", cast_slice(&materials))?;
        let mut buffers = Vec::new();
        let intersection = if let Some(guess) = planar {
            let facets = Facets::new(scene, guess, gpu.limits.max_compute_workgroup_storage_size);
            if facets.verifies() {
                buffers.push(gpu.filled("the facets' outlines", cast_slice(&facets.outlines))?);
            }
            Intersection::Planes(facets)
        } else {
            let bvh = hierarchy(&scene.geometry).map_err(|e| gpu.error(e.to_string()))?;
            let triangles = bvh.triangle_blocks(|number| scene.geometry.facet_of[number as usize]);
            buffers.push(gpu.filled("the hierarchy's nodes", bvh.node_bytes())?);
            buffers.push(gpu.filled("the triangles", cast_slice(&triangles))?);
            Intersection::Hierarchy(bvh.wgsl_constants() + software::INTERSECT, bvh.builder_scale())
        };
        Ok(Surfaces { geometry: scene.geometry.clone(), intersection, buffers, planes, materials })
    }
}

fn hierarchy(geometry: &Geometry) -> Result<Bvh, accel::Error> {
    let positions: Vec<Vec3> = geometry.positions.iter().map(|p| p.as_vec3()).collect();
    Bvh::build(&positions, &geometry.triangles, &BuildOptions::default())
}

/// All entry points, compiled, with the scene bound to each.
pub(crate) struct Kernel {
    pub form: Form,
    /// By the numbers of [`Stage`].
    pub stages: [Shader; 3],
    chain: bool,
}

/// An entry point and its scene.
pub(crate) struct Shader {
    pub pipeline: wgpu::ComputePipeline,
    pub scene: wgpu::BindGroup,
}

impl Kernel {
    /// Compiles what was not compiled before, and binds a scene.
    pub fn new(gpu: &Gpu, scene: &PreparedScene, parts: &Parts) -> Result<Self, Error> {
        let form = pack::form(scene);
        let Parts { surfaces, light, optics: (_, optics), .. } = parts;
        let (trace, builder_scale) = match &surfaces.intersection {
            Intersection::Planes(facets) => (form.trace_facets(facets), 1.0),
            Intersection::Hierarchy(text, scale) => (form.trace(text), *scale),
        };
        let uniform = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let block = gpu.buffer("scene", size_of::<Scene>() as u64, uniform)?;
        let contents = Scene { builder_scale, gain: light.gain, ..pack::scene(scene) };
        gpu.queue.write_buffer(&block, 0, bytes_of(&contents));
        let offsets = gpu.filled("the samples' places", cast_slice(&pack::offsets(scene)))?;
        let resource = |binding: u32| match binding {
            plan::SCENE => block.as_entire_binding(),
            plan::LIGHT => wgpu::BindingResource::TextureView(&light.view),
            plan::OPTICS => optics.as_entire_binding(),
            plan::PLANES => surfaces.planes.as_entire_binding(),
            plan::MATERIALS => surfaces.materials.as_entire_binding(),
            plan::OFFSETS => offsets.as_entire_binding(),
            other => surfaces.buffers[(other - plan::SURFACES) as usize].as_entire_binding(),
        };
        let chain = parts.chain();
        let stage = |stage: Stage, text: String| {
            let own = if stage == Stage::Trace { surfaces.buffers.len() as u32 } else { 0 };
            let bindings = stage.scene_bindings().iter().copied().chain(plan::SURFACES..plan::SURFACES + own);
            let entries: Vec<_> = bindings.map(|binding| entry(binding, resource(binding))).collect();
            Shader::new(gpu, stage.name(), text, &entries)
        };
        let stages = [
            stage(Stage::Prime, form.prime())?,
            stage(Stage::Trace, trace)?,
            stage(Stage::Gather, form.gather(chain))?,
        ];
        Ok(Kernel { form, stages, chain })
    }

    /// A batch's buffers, by the numbers of [`Part`], bound to a stage.
    pub fn bind(&self, gpu: &Gpu, stage: Stage, parts: &[wgpu::Buffer]) -> Result<wgpu::BindGroup, Error> {
        let buffer = |part: &Part| entry(*part as u32, parts[*part as usize].as_entire_binding());
        let entries: Vec<_> = stage.parts(self.chain).iter().map(buffer).collect();
        bind(gpu, &self.stages[stage as usize].pipeline, 1, &entries)
    }
}

fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

impl Shader {
    fn new(
        gpu: &Gpu,
        entry_point: &'static str,
        source: String,
        entries: &[wgpu::BindGroupEntry<'_>],
    ) -> Result<Self, Error> {
        let pipeline = compiled(gpu, entry_point, source)?;
        let scene = bind(gpu, &pipeline, 0, entries)?;
        Ok(Shader { pipeline, scene })
    }
}

/// A shader's pipeline, compiled once for the device.
fn compiled(gpu: &Gpu, entry_point: &'static str, source: String) -> Result<wgpu::ComputePipeline, Error> {
    let mut known = gpu.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pipeline) = known.get(&source) {
        return Ok(pipeline.clone());
    }
    let what = format!("the shader '{entry_point}'");
    let module = gpu.attempt(&what, || module(&gpu.device, entry_point, &source))?;
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
    known.insert(source, pipeline.clone());
    Ok(pipeline)
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
    // SAFETY: the text is ours, not a user's. Every index it takes comes from the batch's plan (pixels, items, stack
    // places) or from tables that were validated when the scene was prepared (facets, ranks, materials, lines) or
    // built (outlines, nodes, triangles); a guessed facet is compared with their number; and every loop ends: traversals
    // by the tree's size, walks by their budget, chains by the depth limit.
    unsafe { device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) }
}
