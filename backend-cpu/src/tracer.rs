//! The CPU backend: single precision, facet planes for convex stones, the SBVH for whatever else there is.

use crate::{
    beam::BeamTracer,
    chain::{Chain, ChainTracer},
    environment::Light,
    schedule,
    stream::{Stream, StreamTracer, area::AreaTracer},
    sums,
    surface::Surfaces,
    tree::{Tree, TreeTracer},
};
use accel::Instructions;
use rayon::ThreadPool;
use spectral_core::{
    Error,
    film::Film,
    prepare::{Geometry, PreparedScene},
    tracer::{Device, DeviceInfo, OpenOptions, Progress, TraceFailure, TraceReport, Tracer},
};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Opens the CPU, in the best instruction set that it has.
pub(crate) fn open(device: &DeviceInfo, options: &OpenOptions) -> Result<Box<dyn Device>, Error> {
    open_in(Instructions::best(), device, options)
}

/// An [`OpenDevice`](spectral_core::tracer::OpenDevice) for one instruction set.
macro_rules! open_in {
    ($name:ident, $instructions:ident) => {
        pub(crate) fn $name(device: &DeviceInfo, options: &OpenOptions) -> Result<Box<dyn Device>, Error> {
            open_in(Instructions::$instructions, device, options)
        }
    };
}

open_in!(open_avx512, Avx512);
open_in!(open_avx2, Avx2);
open_in!(open_portable, Portable);

fn open_in(
    instructions: Instructions,
    device: &DeviceInfo,
    options: &OpenOptions,
) -> Result<Box<dyn Device>, Error> {
    let (device, options) = (device.clone(), *options);
    let workers = schedule::workers(&options)?.map(Arc::new);
    // The hierarchy over the last geometry that needed one.
    let mut last: Option<(Arc<Geometry>, Arc<Surfaces>)> = None;
    Ok(Box::new(move |scene: Arc<PreparedScene>| {
        let start = Instant::now();
        let light = Light::new(&scene.environment);
        let stream = Stream::new(&scene, &light, instructions);
        let path = match (Chain::new(&scene, instructions), stream) {
            (Some(chain), _) => Path::Chain(chain),
            (None, Some(stream)) => Path::Stream(stream),
            (None, None) => {
                let surfaces = match last.take() {
                    Some((geometry, surfaces))
                        if Arc::ptr_eq(&geometry, &scene.geometry) && surfaces.close_up == scene.close_up =>
                    {
                        surfaces
                    }
                    _ => Arc::new(Surfaces::new(&scene)?),
                };
                last = Some((scene.geometry.clone(), surfaces.clone()));
                Path::Tree(Tree::new(&scene, surfaces, instructions))
            }
        };
        let unit = scene.silhouette.as_ref().map_or(1.0, |_| sums::unit(&scene, &light));
        let (device, workers) = (device.clone(), workers.clone());
        let build = Some(start.elapsed());
        Ok(Box::new(CpuTracer { device, path, light, unit, scene, options, workers, build })
            as Box<dyn Tracer>)
    }))
}

/// How paths find their surfaces in this scene.
enum Path {
    Chain(Chain),
    Stream(Stream),
    Tree(Tree),
}

struct CpuTracer {
    device: DeviceInfo,
    path: Path,
    light: Light,
    /// Of a scene of areas, the parts of a unit of radiance that are summed.
    unit: f64,
    scene: Arc<PreparedScene>,
    options: OpenOptions,
    workers: Option<Arc<ThreadPool>>,
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
        let (scene, light, options, workers) =
            (&*self.scene, &self.light, &self.options, self.workers.as_deref());
        let outcome = match &self.path {
            Path::Chain(chain) => {
                if let Some(silhouette) = &scene.silhouette {
                    let tracer = BeamTracer { silhouette, unit: self.unit, chain, scene, light };
                    schedule::trace(&tracer, scene, options, workers, samples, film, progress)
                } else {
                    let tracer = ChainTracer { chain, scene, light };
                    schedule::trace(&tracer, scene, options, workers, samples, film, progress)
                }
            }
            Path::Stream(stream) => {
                if let Some(silhouette) = &scene.silhouette {
                    let tracer = AreaTracer { silhouette, stream, scene, light };
                    schedule::trace(&tracer, scene, options, workers, samples, film, progress)
                } else {
                    let tracer = StreamTracer { stream, scene, light };
                    schedule::trace(&tracer, scene, options, workers, samples, film, progress)
                }
            }
            Path::Tree(tree) => {
                let tracer = TreeTracer { tree, scene, light };
                schedule::trace(&tracer, scene, options, workers, samples, film, progress)
            }
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
