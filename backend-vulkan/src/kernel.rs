//! A prepared scene on the device.

use crate::{
    Intersection,
    acceleration_structure::AccelerationStructure,
    device::Gpu,
    memory::{Buffer, Image},
    pipeline::{Kind, Resource, Shader, Stage},
};
use accel::{BuildOptions, Bvh, glam::Vec3, software, software::TriangleBlock};
use ash::vk;
use bytemuck::{bytes_of, cast_slice};
use spectral_core::{
    Error,
    environment::Source,
    kernel::{
        ENABLE_RAY_QUERY, Form, INTERSECT_RAY_QUERY,
        block::Scene,
        facets::{Facets, Guess},
        pack,
        plan::{self, Part},
        texel::Texels,
    },
    prepare::{Geometry, Optics, PreparedScene},
};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Compiled shaders by their text.
pub(crate) type Shaders = HashMap<String, Arc<Shader>>;

/// What a device keeps of a scene, for the next that has the same.
#[derive(Clone)]
pub(crate) struct Parts {
    surfaces: Arc<Surfaces>,
    light: Arc<Light>,
    optics: Arc<Lines>,
}

/// The optics of all wavelengths on the device.
struct Lines {
    of: Arc<Optics>,
    buffer: Buffer,
}

/// The light on the device.
struct Light {
    of: Source,
    image: Image,
    /// What a texel is to be multiplied by.
    gain: f32,
}

/// How rays find surfaces, with the stones' buffers.
struct Surfaces {
    of: Arc<Geometry>,
    form: Surface,
    planes: Buffer,
    materials: Buffer,
}

/// What rays are intersected with.
enum Surface {
    /// The facet planes, which every form has, with what lies around each.
    Facets(Facets, Buffer),
    /// Our nodes and triangles, the text that reads them, and the units of the nodes per mm.
    Software([Buffer; 2], String, f32),
    /// The driver's hierarchy, and what its triangles are.
    Driver(Intersection, AccelerationStructure, Buffer),
}

impl Parts {
    /// Uploads what the scene before did not have. A lone convex stone is met by its planes in the form `lone`, unless
    /// that is `None`: then by `intersection` like everything else.
    pub fn new(
        gpu: &Arc<Gpu>,
        scene: &PreparedScene,
        intersection: Intersection,
        lone: Option<Guess>,
        before: Option<Parts>,
    ) -> Result<Self, Error> {
        pack::check(scene)?;
        let guess = if scene.geometry.stones.is_empty() {
            Some(Guess::Nothing)
        } else {
            lone.filter(|_| scene.lone_convex_stone().is_some())
        };
        let (surfaces, light, optics) =
            before.map_or((None, None, None), |b| (Some(b.surfaces), Some(b.light), Some(b.optics)));
        let same = |before: &Arc<Surfaces>| {
            Arc::ptr_eq(&before.of, &scene.geometry)
                && guess.is_some() == matches!(before.form, Surface::Facets(..))
        };
        let surfaces = match surfaces.filter(same) {
            Some(surfaces) => surfaces,
            None => Arc::new(Surfaces::new(gpu, scene, intersection, guess)?),
        };
        let source = &scene.environment.source;
        let light = match light.filter(|before| before.of.shares_texels(source)) {
            Some(light) => light,
            None => Arc::new(Light::new(gpu, source)?),
        };
        let optics = match optics.filter(|before| Arc::ptr_eq(&before.of, &scene.optics)) {
            Some(optics) => optics,
            None => {
                let contents = pack::optics(scene);
                let buffer = Buffer::filled(gpu, "the optics of all wavelengths", cast_slice(&contents))?;
                Arc::new(Lines { of: scene.optics.clone(), buffer })
            }
        };
        Ok(Parts { surfaces, light, optics })
    }

    /// Whether every path is a chain.
    pub fn chain(&self) -> bool {
        matches!(self.surfaces.form, Surface::Facets(..))
    }
}

impl Light {
    fn new(gpu: &Arc<Gpu>, source: &Source) -> Result<Self, Error> {
        let texels = Texels::of(source);
        let format =
            if texels.full { vk::Format::R32G32B32A32_SFLOAT } else { vk::Format::R16G16B16A16_SFLOAT };
        let size = [texels.width, texels.height];
        let image = Image::filled(gpu, "the environment", size, format, texels.row_bytes(), texels.pieces())?;
        Ok(Light { of: source.clone(), image, gain: texels.gain })
    }
}

impl Surfaces {
    fn new(
        gpu: &Arc<Gpu>,
        scene: &PreparedScene,
        intersection: Intersection,
        guess: Option<Guess>,
    ) -> Result<Self, Error> {
        let form = match guess {
            Some(guess) => {
                let facets = Facets::new(scene, guess, gpu.limits.workgroup_memory);
                let outlines = Buffer::filled(gpu, "the facets' outlines", cast_slice(&facets.outlines))?;
                Surface::Facets(facets, outlines)
            }
            None => Surface::new(gpu, &scene.geometry, intersection)?,
        };
        let planes = Buffer::filled(gpu, "the facet planes", cast_slice(&pack::planes(&scene.geometry)))?;
        let materials = scene.geometry.material_of_rank();
        let materials = Buffer::filled(gpu, "the stones", cast_slice(&materials))?;
        Ok(Surfaces { of: scene.geometry.clone(), form, planes, materials })
    }
}

impl Surface {
    fn new(gpu: &Arc<Gpu>, geometry: &Geometry, intersection: Intersection) -> Result<Self, Error> {
        let positions: Vec<Vec3> = geometry.positions.iter().map(|p| p.as_vec3()).collect();
        let bvh = Bvh::build(&positions, &geometry.triangles, &BuildOptions::default())
            .map_err(|e| gpu.error(e.to_string()))?;
        let triangles = bvh.triangle_blocks(|number| geometry.facet_of[number as usize]);
        if intersection == Intersection::Software {
            let nodes = Buffer::filled(gpu, "the hierarchy's nodes", bvh.node_bytes())?;
            let triangles = Buffer::filled(gpu, "the triangles", cast_slice(&triangles))?;
            let text = bvh.wgsl_constants() + software::INTERSECT;
            return Ok(Surface::Software([nodes, triangles], text, bvh.builder_scale()));
        }
        Self::of_driver(gpu, intersection, &triangles)
    }

    /// The driver's hierarchy over the triangles in the order of ours. Spatial splits refer to a triangle more than
    /// once; the driver is given its first place.
    fn of_driver(gpu: &Arc<Gpu>, form: Intersection, triangles: &[TriangleBlock]) -> Result<Self, Error> {
        let mut seen = HashSet::new();
        let ordered: Vec<_> = triangles.iter().filter(|triangle| seen.insert(triangle.number)).collect();
        let corners: Vec<[f32; 3]> = ordered.iter().flat_map(|t| [t.a, t.b, t.c]).collect();
        let faces: Vec<[u32; 2]> = ordered.iter().map(|t| [t.number, t.facet]).collect();
        let hierarchy = AccelerationStructure::new(gpu, &corners)?;
        Ok(Surface::Driver(form, hierarchy, Buffer::filled(gpu, "the faces", cast_slice(&faces))?))
    }

    /// The shader that traces: what kind, and its text.
    fn trace(&self, form: &Form) -> (Kind, String) {
        let compute = Kind::Compute(c"trace");
        match self {
            Surface::Facets(facets, _) => (compute, form.trace_facets(facets)),
            Surface::Software(_, text, _) => (compute, form.trace(text)),
            Surface::Driver(Intersection::Pipeline, ..) => (Kind::Rays, form.trace_pipeline()),
            Surface::Driver(..) => (compute, ENABLE_RAY_QUERY.to_owned() + &form.trace(INTERSECT_RAY_QUERY)),
        }
    }

    /// What it binds, from [`plan::SURFACES`] on.
    fn resources(&self) -> Vec<Resource<'_>> {
        match self {
            Surface::Facets(_, outlines) => vec![Resource::Storage(outlines)],
            Surface::Software([nodes, triangles], ..) => {
                vec![Resource::Storage(nodes), Resource::Storage(triangles)]
            }
            Surface::Driver(_, hierarchy, faces) => {
                vec![Resource::Hierarchy(hierarchy), Resource::Storage(faces)]
            }
        }
    }
}

/// What does not change from batch to batch: the shaders' texts, and what they bind in their first group.
pub(crate) struct Kernel {
    pub form: Form,
    parts: Parts,
    scene: Buffer,
    offsets: Buffer,
}

impl Kernel {
    /// Uploads what is a scene's own.
    pub fn new(gpu: &Arc<Gpu>, scene: &PreparedScene, parts: &Parts) -> Result<Self, Error> {
        let builder_scale = match parts.surfaces.form {
            Surface::Software(.., scale) => scale,
            Surface::Facets(..) | Surface::Driver(..) => 1.0,
        };
        let block = Buffer::uniform(gpu, "the scene", size_of::<Scene>() as u64)?;
        let contents = Scene { builder_scale, gain: parts.light.gain, ..pack::scene(scene) };
        block.fill("the scene", bytes_of(&contents))?;
        Ok(Kernel {
            form: pack::form(scene),
            parts: parts.clone(),
            scene: block,
            offsets: Buffer::filled(gpu, "the samples' places", cast_slice(&pack::offsets(scene)))?,
        })
    }

    fn resource(&self, binding: u32) -> Resource<'_> {
        let surfaces = &self.parts.surfaces;
        match binding {
            plan::SCENE => Resource::Uniform(&self.scene),
            plan::LIGHT => Resource::Image(&self.parts.light.image),
            plan::OPTICS => Resource::Storage(&self.parts.optics.buffer),
            plan::PLANES => Resource::Storage(&surfaces.planes),
            plan::MATERIALS => Resource::Storage(&surfaces.materials),
            plan::OFFSETS => Resource::Storage(&self.offsets),
            other => surfaces.form.resources()[(other - plan::SURFACES) as usize],
        }
    }

    /// A stage with a batch's buffers, by the numbers of [`Part`]. Its shader is compiled if it is not among those that
    /// are.
    pub fn stage(
        &self,
        gpu: &Arc<Gpu>,
        stage: plan::Stage,
        parts: &[Arc<Buffer>],
        shaders: &mut Shaders,
    ) -> Result<Stage, Error> {
        let surfaces = &self.parts.surfaces.form;
        let chain = self.parts.chain();
        let ((kind, text), own) = match stage {
            plan::Stage::Prime => ((Kind::Compute(c"prime"), self.form.prime()), 0),
            plan::Stage::Trace => (surfaces.trace(&self.form), surfaces.resources().len() as u32),
            plan::Stage::Gather => ((Kind::Compute(c"gather"), self.form.gather(chain)), 0),
        };
        let bindings = stage.scene_bindings().iter().copied().chain(plan::SURFACES..plan::SURFACES + own);
        let scene: Vec<_> = bindings.map(|binding| (binding, self.resource(binding))).collect();
        let part = |part: &Part| match part {
            Part::Batch => (0, Resource::Uniform(&parts[0])),
            other => (*other as u32, Resource::Storage(&parts[*other as usize])),
        };
        let batch: Vec<_> = stage.parts(chain).iter().map(part).collect();
        let groups = [&scene[..], &batch];
        let shader = match shaders.get(&text) {
            Some(shader) => shader.clone(),
            None => {
                let shader = Arc::new(Shader::new(gpu, kind, &text, groups)?);
                shaders.insert(text, shader.clone());
                shader
            }
        };
        Stage::new(&shader, groups)
    }
}
