//! A prepared scene on the device.

use crate::{
    Intersection,
    acceleration_structure::AccelerationStructure,
    device::{Gpu, WORKGROUP},
    memory::{Buffer, Image},
    pipeline::{Group, Kind, Resource, Stage},
};
use accel::{BuildOptions, Bvh, glam::Vec3, software, software::TriangleBlock};
use ash::vk;
use bytemuck::{bytes_of, cast_slice};
use spectral_core::{
    Error,
    kernel::{
        ENABLE_RAY_QUERY, Form, INTERSECT_RAY_QUERY,
        block::Scene,
        facets::{Facets, Guess},
        pack,
        texel::Texels,
    },
    prepare::{Geometry, PreparedScene},
};
use std::collections::HashSet;
use std::sync::Arc;

/// The entry point `trace` as a compute shader.
const COMPUTE: Kind = Kind::Compute(c"trace");

/// What does not change from batch to batch: the shaders' texts, and what they bind in their first group.
pub(crate) struct Kernel {
    pub form: Form,
    trace: (Kind, String),
    scene: Buffer,
    light: Image,
    optics: Buffer,
    planes: Buffer,
    materials: Buffer,
    surfaces: Surfaces,
}

/// What rays are intersected with.
enum Surfaces {
    /// The facet planes, which every form has, with what lies around each.
    Facets(Buffer),
    /// Our nodes and triangles, and the units of the nodes per mm.
    Software([Buffer; 2], f32),
    /// The driver's hierarchy, and what its triangles are.
    Driver(AccelerationStructure, Buffer),
}

impl Kernel {
    /// Uploads a scene. A lone convex stone is met by its planes in the form `lone`, unless that is `None`: then by
    /// `intersection` like everything else.
    pub fn new(
        gpu: &Arc<Gpu>,
        scene: &PreparedScene,
        intersection: Intersection,
        lone: Option<Guess>,
    ) -> Result<Self, Error> {
        pack::check(scene)?;
        let form = pack::form(scene, WORKGROUP);
        let guess = if scene.geometry.stones.is_empty() {
            Some(Guess::Nothing)
        } else {
            lone.filter(|_| scene.lone_convex_stone().is_some())
        };
        let (text, surfaces) = match guess {
            Some(guess) => Surfaces::of_facets(gpu, scene, form, guess)?,
            None => Surfaces::new(gpu, &scene.geometry, form, intersection)?,
        };
        let texels = Texels::of(&scene.environment.source);
        let format =
            if texels.full { vk::Format::R32G32B32A32_SFLOAT } else { vk::Format::R16G16B16A16_SFLOAT };
        let size = [texels.width, texels.height];
        let light = Image::filled(gpu, "the environment", size, format, texels.row_bytes(), texels.pieces())?;
        let block = Buffer::uniform(gpu, "the scene", size_of::<Scene>() as u64)?;
        let contents =
            Scene { builder_scale: surfaces.builder_scale(), gain: texels.gain, ..pack::scene(scene) };
        block.fill("the scene", bytes_of(&contents))?;
        let filled = |what, contents: &[u8]| Buffer::filled(gpu, what, contents);
        Ok(Kernel {
            form,
            trace: text,
            scene: block,
            light,
            optics: filled("the optics of all wavelengths", cast_slice(&pack::optics(scene)))?,
            planes: filled("the facet planes", cast_slice(&pack::planes(&scene.geometry)))?,
            materials: filled("the stones", cast_slice(&pack::material_of_rank(&scene.geometry)))?,
            surfaces,
        })
    }

    /// The entry point `trace` with a batch's group.
    pub fn trace(&self, gpu: &Arc<Gpu>, batch: &Group<'_>) -> Result<Stage, Error> {
        let mut group = vec![
            (0, Resource::Uniform(&self.scene)),
            (1, Resource::Image(&self.light)),
            (2, Resource::Storage(&self.optics)),
            (3, Resource::Storage(&self.planes)),
            (4, Resource::Storage(&self.materials)),
        ];
        match &self.surfaces {
            Surfaces::Facets(outlines) => group.push((5, Resource::Storage(outlines))),
            Surfaces::Software([nodes, triangles], _) => {
                group.extend([(5, Resource::Storage(nodes)), (6, Resource::Storage(triangles))]);
            }
            Surfaces::Driver(hierarchy, faces) => {
                group.extend([(5, Resource::Hierarchy(hierarchy)), (6, Resource::Storage(faces))]);
            }
        }
        Stage::new(gpu, self.trace.0, &self.trace.1, [&group, batch])
    }

    /// The entry point `gather` with a batch's group.
    pub fn gather(&self, gpu: &Arc<Gpu>, batch: &Group<'_>) -> Result<Stage, Error> {
        let group = [(0, Resource::Uniform(&self.scene)), (2, Resource::Storage(&self.optics))];
        Stage::new(gpu, Kind::Compute(c"gather"), &self.form.gather(), [&group, batch])
    }
}

impl Surfaces {
    /// The shader and what it needs for one convex stone, or none.
    fn of_facets(
        gpu: &Arc<Gpu>,
        scene: &PreparedScene,
        form: Form,
        guess: Guess,
    ) -> Result<((Kind, String), Self), Error> {
        if guess == Guess::Subgroup && !gpu.limits.subgroups {
            return Err(gpu.error("this device has no subgroup operations"));
        }
        let facets = Facets::new(scene, guess, gpu.limits.workgroup_memory);
        let outlines = Buffer::filled(gpu, "the facets' outlines", cast_slice(&facets.outlines))?;
        Ok(((COMPUTE, form.trace_facets(&facets)), Surfaces::Facets(outlines)))
    }

    /// The shader and what it needs for a form of intersection.
    fn new(
        gpu: &Arc<Gpu>,
        geometry: &Geometry,
        form: Form,
        intersection: Intersection,
    ) -> Result<((Kind, String), Self), Error> {
        let positions: Vec<Vec3> = geometry.positions.iter().map(|p| p.as_vec3()).collect();
        let bvh = Bvh::build(&positions, &geometry.triangles, &BuildOptions::default())
            .map_err(|e| gpu.error(e.to_string()))?;
        let triangles = bvh.triangle_blocks(|number| geometry.facet_of[number as usize]);
        match intersection {
            Intersection::Software => {
                let nodes = Buffer::filled(gpu, "the hierarchy's nodes", bvh.node_bytes())?;
                let triangles = Buffer::filled(gpu, "the triangles", cast_slice(&triangles))?;
                let text = form.trace(&(bvh.wgsl_constants() + software::INTERSECT));
                Ok(((COMPUTE, text), Surfaces::Software([nodes, triangles], bvh.builder_scale())))
            }
            Intersection::RayQuery => {
                let text = ENABLE_RAY_QUERY.to_owned() + &form.trace(INTERSECT_RAY_QUERY);
                Ok(((COMPUTE, text), Self::of_driver(gpu, &triangles)?))
            }
            Intersection::Pipeline => {
                Ok(((Kind::Rays, form.trace_pipeline()), Self::of_driver(gpu, &triangles)?))
            }
        }
    }

    /// The driver's hierarchy over the triangles in the order of ours. Spatial splits refer to a triangle more than
    /// once; the driver is given its first place.
    fn of_driver(gpu: &Arc<Gpu>, triangles: &[TriangleBlock]) -> Result<Self, Error> {
        let mut seen = HashSet::new();
        let ordered: Vec<_> = triangles.iter().filter(|triangle| seen.insert(triangle.number)).collect();
        let corners: Vec<[f32; 3]> = ordered.iter().flat_map(|t| [t.a, t.b, t.c]).collect();
        let faces: Vec<[u32; 2]> = ordered.iter().map(|t| [t.number, t.facet]).collect();
        let hierarchy = AccelerationStructure::new(gpu, &corners)?;
        Ok(Surfaces::Driver(hierarchy, Buffer::filled(gpu, "the faces", cast_slice(&faces))?))
    }

    /// What the kernel multiplies lengths by on their way into the hierarchy.
    fn builder_scale(&self) -> f32 {
        match self {
            Surfaces::Software(_, scale) => *scale,
            Surfaces::Facets(_) | Surfaces::Driver(..) => 1.0,
        }
    }
}
