//! The oracle: double precision, every triangle tested for every ray, a plain list of rays.
//!
//! It follows the same rules as the fast paths and shares with them Fresnel's formulas and the nest of
//! media, nothing else: no BVH, no planes for convex stones, no ordering of children.

mod surface;

use crate::{
    account::Account,
    schedule::{self, PixelTracer, Pixelwise, Work},
    throughput::{Polarized, Throughput},
};
use glam::DVec3;
use rayon::ThreadPool;
use spectral_core::{
    Error,
    film::Film,
    fresnel::{Fresnel, conductor, dielectric},
    prepare::{Medium, Nest, PreparedScene, SpectralTable},
    scene::Background,
    settings::Leftover,
    stokes::Scalar,
    tracer::{Device, DeviceInfo, OpenOptions, Progress, TraceFailure, TraceReport, Tracer},
    upsample::smits::Weights,
};
use std::marker::PhantomData;
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use surface::{Crossing, Surfaces};

const AIR: Medium = Medium { n: 1.0, k: 0.0, absorption: 0.0 };

/// Opens the oracle for a scene.
pub(crate) fn open(device: &DeviceInfo, options: &OpenOptions) -> Result<Box<dyn Device>, Error> {
    let (device, options) = (device.clone(), *options);
    Ok(Box::new(move |scene: Arc<PreparedScene>| {
        let surfaces = Surfaces::new(&scene.geometry);
        let (device, workers) = (device.clone(), schedule::workers(&options)?);
        Ok(Box::new(Reference { device, scene, surfaces, options, workers }) as Box<dyn Tracer>)
    }))
}

struct Reference {
    device: DeviceInfo,
    scene: Arc<PreparedScene>,
    surfaces: Surfaces,
    options: OpenOptions,
    workers: Option<ThreadPool>,
}

impl Tracer for Reference {
    fn device(&self) -> &DeviceInfo {
        &self.device
    }

    fn trace(
        &mut self,
        samples: Range<u32>,
        film: &mut Film,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<TraceReport, Box<TraceFailure>> {
        let (options, workers) = (&self.options, self.workers.as_ref());
        if self.scene.settings.polarized {
            let kernel = Typed::<Polarized<f64>>(self, PhantomData);
            let typed = Pixelwise { kernel, scene: &self.scene };
            schedule::trace(&typed, &self.scene, options, workers, samples, film, progress)
        } else {
            let kernel = Typed::<Scalar<f64>>(self, PhantomData);
            let typed = Pixelwise { kernel, scene: &self.scene };
            schedule::trace(&typed, &self.scene, options, workers, samples, film, progress)
        }
    }
}

/// The oracle for one kind of throughput.
struct Typed<'a, P>(&'a Reference, PhantomData<fn() -> P>);

/// A ray on its way.
#[derive(Clone, Copy)]
struct Ray<P> {
    origin: DVec3,
    direction: DVec3,
    throughput: P,
    nest: Nest,
    depth: u32,
}

impl<P: Throughput<f64>> PixelTracer for Typed<'_, P> {
    fn sample(&self, at: [f64; 2], sample: u32, radiance: &mut [f64], work: &mut Work<'_>) -> bool {
        let scene = &self.0.scene;
        let ray = scene.view.ray(at[0], at[1]);
        let covered = self.0.surfaces.next(ray.origin, ray.direction, scene.eye_nest).is_some();
        for (line, value) in radiance.iter_mut().enumerate() {
            if !covered && scene.background == Background::Transparent {
                *value = 0.0;
                continue;
            }
            let start = Ray {
                origin: ray.origin,
                direction: ray.direction,
                throughput: P::eye(ray.direction.to_array()),
                nest: scene.eye_nest,
                depth: 0,
            };
            *value = Walk::<P> { reference: self.0, table: scene.table(sample), line, pending: vec![start] }
                .radiance(work);
        }
        covered
    }
}

/// One wavelength's walk: rays still to be followed, in no particular order.
struct Walk<'a, P> {
    reference: &'a Reference,
    table: &'a SpectralTable,
    line: usize,
    pending: Vec<Ray<P>>,
}

impl<P: Throughput<f64>> Walk<'_, P> {
    fn radiance(&mut self, work: &mut Work<'_>) -> f64 {
        let mut sum = 0.0;
        while let Some(ray) = self.pending.pop() {
            if (work.stop)() {
                break;
            }
            work.account.rays += 1;
            sum += match self.reference.surfaces.next(ray.origin, ray.direction, ray.nest) {
                Some(crossing) => self.event(ray, &crossing, &mut work.account),
                None => {
                    if !ray.nest.is_empty() {
                        work.account.lost += ray.throughput.intensity();
                    }
                    self.light(ray.origin, ray.direction) * ray.throughput.intensity()
                }
            };
        }
        sum
    }

    /// Splits a ray at a surface; returns the radiance of what leaves for good here.
    fn event(&mut self, mut ray: Ray<P>, crossing: &Crossing, account: &mut Account) -> f64 {
        let settings = &self.reference.scene.settings;
        ray.nest = crossing.before;
        let (here, beyond) = (self.medium(ray.nest), self.medium(crossing.after));
        if here.k > 0.0 {
            return 0.0;
        }
        ray.throughput = ray.throughput.scaled((-here.absorption * crossing.distance).exp());
        let intensity = ray.throughput.intensity();
        if ray.depth == settings.max_depth {
            return self.at_limit(&ray, crossing, account);
        }
        if ray.nest.is_empty() && intensity < settings.threshold {
            account.dropped_threshold += intensity;
            return 0.0;
        }
        let (direction, normal) = (ray.direction, crossing.normal);
        let event = interface(direction, normal, here, beyond);
        let [back, on] = ray.throughput.split(direction.to_array(), normal.to_array(), &event);
        let next = Ray { origin: ray.origin + direction * crossing.distance, depth: ray.depth + 1, ..ray };
        self.go_on(Ray { direction: direction.reflect(normal), throughput: back, ..next }, account);
        if !event.tir && beyond.k == 0.0 {
            let direction = refracted(direction, normal, &event, here.n / beyond.n);
            self.go_on(Ray { direction, throughput: on, nest: crossing.after, ..next }, account);
        }
        0.0
    }

    fn go_on(&mut self, ray: Ray<P>, account: &mut Account) {
        let intensity = ray.throughput.intensity();
        if !ray.nest.is_empty() && intensity < self.reference.scene.settings.threshold {
            account.dropped_threshold += intensity;
        } else if intensity > 0.0 {
            self.pending.push(ray);
        }
    }

    fn at_limit(&self, ray: &Ray<P>, crossing: &Crossing, account: &mut Account) -> f64 {
        let intensity = ray.throughput.intensity();
        if self.reference.scene.settings.leftover == Leftover::Drop {
            account.dropped_depth += intensity;
            return 0.0;
        }
        let (here, beyond) = (self.medium(ray.nest), self.medium(crossing.after));
        let (direction, normal) = (ray.direction, crossing.normal);
        let place = ray.origin + direction * crossing.distance;
        if beyond.k > 0.0 {
            let event = interface(direction, normal, here, beyond);
            let [back, _] = ray.throughput.split(direction.to_array(), normal.to_array(), &event);
            account.left_at_limit += back.intensity();
            return self.light(place, direction.reflect(normal)) * back.intensity();
        }
        account.left_at_limit += intensity;
        let event = interface(direction, normal, here, AIR);
        let straight_on = event.tir || ray.nest.is_empty();
        let out = if straight_on { direction } else { refracted(direction, normal, &event, here.n) };
        self.light(place, out) * intensity
    }

    fn medium(&self, nest: Nest) -> Medium {
        nest.top().map_or(AIR, |rank| {
            let material = self.reference.scene.geometry.stone(rank).material;
            self.table.media[material as usize][self.line]
        })
    }

    fn light(&self, origin: DVec3, direction: DVec3) -> f64 {
        Weights::new(self.reference.scene.environment.seen(origin, direction))
            .mix(&self.table.basis[self.line])
    }
}

fn interface(direction: DVec3, normal: DVec3, here: Medium, beyond: Medium) -> Fresnel<f64> {
    let cos_i = -direction.dot(normal);
    if beyond.k > 0.0 {
        conductor(cos_i, here.n, beyond.n, beyond.k)
    } else {
        dielectric(cos_i, here.n / beyond.n)
    }
}

fn refracted(direction: DVec3, normal: DVec3, event: &Fresnel<f64>, eta: f64) -> DVec3 {
    let cos_i = -direction.dot(normal);
    (direction * eta + normal * (eta * cos_i - event.cos_t)).normalize()
}
