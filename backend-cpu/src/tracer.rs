//! The CPU backend: single precision, the SBVH for any scene and a shorter way for one convex stone.

use crate::{
    chain::{Chain, ChainTracer},
    instructions::Instructions,
    light::Light,
    line::Line,
    schedule::{self, PixelTracer, Pixelwise, Work},
    surface::Surfaces,
    throughput::{Polarized, Throughput},
    tree::{Ray, Tree},
};
use spectral_core::{
    Error,
    camera::CameraRay,
    film::Film,
    prepare::PreparedScene,
    scene::Background,
    stokes::Scalar,
    tracer::{DeviceInfo, OpenOptions, Progress, TraceFailure, TraceReport, Tracer},
};
use std::marker::PhantomData;
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Opens the CPU for a scene, in the best instruction set that it has.
pub(crate) fn open(
    device: &DeviceInfo,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    open_in(Instructions::best(), device, scene, options)
}

/// An [`OpenDevice`](spectral_core::tracer::OpenDevice) for one instruction set.
macro_rules! open_in {
    ($name:ident, $instructions:ident) => {
        pub(crate) fn $name(
            device: &DeviceInfo,
            scene: Arc<PreparedScene>,
            options: &OpenOptions,
        ) -> Result<Box<dyn Tracer>, Error> {
            open_in(Instructions::$instructions, device, scene, options)
        }
    };
}

open_in!(open_avx512, Avx512);
open_in!(open_avx2, Avx2);
open_in!(open_portable, Portable);

fn open_in(
    instructions: Instructions,
    device: &DeviceInfo,
    scene: Arc<PreparedScene>,
    options: &OpenOptions,
) -> Result<Box<dyn Tracer>, Error> {
    let start = Instant::now();
    let path = match Chain::new(&scene, instructions) {
        Some(chain) => Path::Chain(chain),
        None if scene.geometry.stones.is_empty() => Path::Empty,
        None => Path::Tree(Tree::new(&scene, Surfaces::new(&scene)?)),
    };
    let lines = scene.tables.iter().map(Line::all).collect();
    let light = Light::new(&scene.environment);
    let kernel = Kernel { path, lines, light, scene };
    Ok(Box::new(CpuTracer {
        device: device.clone(),
        kernel,
        options: *options,
        build: Some(start.elapsed()),
    }))
}

struct CpuTracer {
    device: DeviceInfo,
    kernel: Kernel,
    options: OpenOptions,
    /// Reported by the first call.
    build: Option<Duration>,
}

impl Tracer for CpuTracer {
    fn device(&self) -> &DeviceInfo {
        &self.device
    }

    fn trace(
        &mut self,
        samples: Range<u32>,
        film: &mut Film,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<TraceReport, Box<TraceFailure>> {
        let (kernel, scene) = (&self.kernel, &*self.kernel.scene);
        let outcome = if let Path::Chain(chain) = &kernel.path {
            let tracer = ChainTracer { chain, scene, light: &kernel.light, lines: &kernel.lines };
            schedule::trace(&tracer, scene, &self.options, samples, film, progress)
        } else if scene.settings.polarized {
            let kernel = Pixelwise { kernel: Typed::<Polarized<f32>>(kernel, PhantomData), scene };
            schedule::trace(&kernel, scene, &self.options, samples, film, progress)
        } else {
            let kernel = Pixelwise { kernel: Typed::<Scalar<f32>>(kernel, PhantomData), scene };
            schedule::trace(&kernel, scene, &self.options, samples, film, progress)
        };
        let build = self.build.take().unwrap_or_default();
        match outcome {
            Ok(report) => Ok(TraceReport { build, ..report }),
            Err(mut failure) => {
                failure.report.build = build;
                Err(failure)
            }
        }
    }
}

/// How paths find their surfaces in this scene.
enum Path {
    Empty,
    Chain(Chain),
    Tree(Tree),
}

struct Kernel {
    path: Path,
    /// By sample (one entry if all share it), then by wavelength.
    lines: Vec<Vec<Line>>,
    light: Light,
    scene: Arc<PreparedScene>,
}

/// What a worker allocates once and uses for every sample.
pub(crate) struct Scratch<P> {
    /// Rays of a tree still to be followed.
    pub stack: Vec<Ray<P>>,
}

impl<P> Default for Scratch<P> {
    fn default() -> Self {
        Scratch { stack: Vec::new() }
    }
}

/// The kernel for one kind of throughput.
struct Typed<'a, P>(&'a Kernel, PhantomData<fn() -> P>);

impl<P: Throughput<f32>> PixelTracer for Typed<'_, P> {
    type Scratch = Scratch<P>;

    fn sample(
        &self,
        at: [f64; 2],
        sample: u32,
        radiance: &mut [f64],
        work: &mut Work<'_, Scratch<P>>,
    ) -> bool {
        let kernel = self.0;
        let lines = &kernel.lines[sample as usize % kernel.lines.len()];
        let ray = kernel.scene.view.ray(at[0], at[1]);
        let covered = match &kernel.path {
            // A chain is traced by the tile.
            Path::Empty | Path::Chain(_) => false,
            Path::Tree(tree) => kernel.tree(tree, &ray, lines, radiance, work),
        };
        if !covered {
            kernel.background(&ray, lines, radiance, work);
        }
        covered
    }
}

impl Kernel {
    fn background<S>(&self, ray: &CameraRay, lines: &[Line], radiance: &mut [f64], work: &mut Work<'_, S>) {
        if self.scene.background == Background::Transparent {
            radiance.fill(0.0);
            return;
        }
        work.account.rays += lines.len() as u64;
        // Once a sample, so in double precision: beside a lamp one texel may be a thousand times the next.
        let rgb = self.scene.environment.rgb(ray.direction).map(|c| c as f32);
        for (value, line) in radiance.iter_mut().zip(lines) {
            *value = f64::from(line.expand(rgb));
        }
    }

    fn tree<P: Throughput<f32>>(
        &self,
        tree: &Tree,
        ray: &CameraRay,
        lines: &[Line],
        radiance: &mut [f64],
        work: &mut Work<'_, Scratch<P>>,
    ) -> bool {
        let Some(start) = self.scene.geometry.approach(ray) else { return false };
        let (origin, direction) = (start.as_vec3(), ray.direction.as_vec3());
        let nest = self.scene.eye_nest;
        let Some(first) = tree.surfaces.next(origin, direction, nest) else { return false };
        for (value, line) in radiance.iter_mut().zip(lines) {
            let throughput = P::eye(direction.to_array());
            let ray = Ray { origin, direction, throughput, nest, depth: 0 };
            *value = f64::from(tree.radiance(ray, &first, line, &self.light, work));
        }
        true
    }
}
