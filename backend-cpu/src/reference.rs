//! The oracle: double precision, every triangle tested for every ray, a plain list of rays.
//!
//! It follows the same rules as the fast paths. It shares with them only the optics of media and the nest of stones: no
//! BVH, no planes for convex stones, no order among the rays that an event sends on.

mod surface;

use crate::{
    account::Account,
    schedule::{self, Finished, Stop, TileTracer},
};
use glam::DVec3;
use rayon::ThreadPool;
use spectral_core::{
    Error,
    film::{Film, Tile},
    fresnel::Fresnel,
    prepare::{Medium, Nest, PreparedScene, SpectralTable},
    scene::Background,
    settings::Leftover,
    stokes::{StokesRow, align, any_axis},
    tracer::{Device, DeviceInfo, Energy, OpenOptions, Progress, TraceFailure, TraceReport, Tracer},
    upsample,
};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use surface::{Crossing, Surfaces};

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
        schedule::trace(self, &self.scene, options, workers, samples, film, progress)
    }
}

impl TileTracer for Reference {
    fn tile(&self, tile: Tile, samples: Range<u32>, stop: &Stop<'_>) -> Option<Finished> {
        let scene = &self.scene;
        let (mut account, mut radiances, mut covered) = (Account::default(), Vec::<f64>::new(), Vec::new());
        for (sample, ray) in scene.camera_rays(tile, samples.clone()) {
            let start = Ray {
                origin: ray.origin,
                direction: ray.direction,
                row: StokesRow::eye(),
                axis: any_axis(ray.direction.to_array()),
                nest: scene.eye_nest,
                depth: 0,
            };
            let meets = self.surfaces.next(ray.origin, ray.direction, scene.eye_nest).is_some();
            let energy = Energy { started: scene.wavelength_count() as f64, ..Energy::default() };
            let table = scene.table(sample);
            let mut walk = Walk { reference: self, table, line: 0, pending: Vec::new(), rays: 0, energy };
            for line in 0..scene.wavelength_count() {
                if !meets && scene.background == Background::Transparent {
                    radiances.push(0.0);
                    continue;
                }
                walk.line = line;
                walk.pending.push(start);
                radiances.push(walk.radiance(stop));
            }
            if stop() {
                return None;
            }
            account.add_sample(walk.rays, &walk.energy);
            covered.push(meets);
        }
        Some(Finished::new(scene, tile, samples, radiances, &covered, account))
    }
}

/// A ray on its way.
#[derive(Clone, Copy)]
struct Ray {
    origin: DVec3,
    direction: DVec3,
    row: StokesRow<f64>,
    /// First axis of the row's frame, perpendicular to the ray.
    axis: [f64; 3],
    nest: Nest,
    depth: u32,
}

/// The walks of a sample's wavelengths, one after another.
struct Walk<'a> {
    reference: &'a Reference,
    table: &'a SpectralTable,
    /// The wavelength in the table.
    line: usize,
    /// Rays still to be followed, in no particular order.
    pending: Vec<Ray>,
    rays: u64,
    energy: Energy,
}

impl Walk<'_> {
    fn radiance(&mut self, stop: &Stop<'_>) -> f64 {
        let mut sum = 0.0;
        while let Some(ray) = self.pending.pop() {
            if stop() {
                break;
            }
            self.rays += 1;
            sum += match self.reference.surfaces.next(ray.origin, ray.direction, ray.nest) {
                Some(crossing) => self.event(ray, &crossing),
                None => {
                    if !ray.nest.is_empty() {
                        self.energy.lost += ray.row.intensity();
                    }
                    self.light(ray.origin, ray.direction) * ray.row.intensity()
                }
            };
        }
        sum
    }

    /// A surface event: lists the rays that it sends on; returns the radiance of what leaves for good here.
    fn event(&mut self, mut ray: Ray, crossing: &Crossing) -> f64 {
        let settings = &self.reference.scene.settings;
        ray.nest = crossing.before;
        let (here, beyond) = (self.medium(ray.nest), self.medium(crossing.after));
        if here.is_opaque() {
            return 0.0;
        }
        ray.row = ray.row.scaled(here.transmittance(crossing.distance));
        let intensity = ray.row.intensity();
        if ray.depth == settings.max_depth {
            return self.at_limit(&ray, crossing);
        }
        if ray.nest.is_empty() && intensity < settings.threshold {
            self.energy.dropped_threshold += intensity;
            return 0.0;
        }
        self.send_on(&ray, crossing, here, beyond);
        0.0
    }

    /// Lists the rays that an event sends on: the reflected one and, unless reflection is total or the medium beyond a
    /// metal, the refracted one.
    fn send_on(&mut self, ray: &Ray, crossing: &Crossing, here: Medium, beyond: Medium) {
        let (direction, normal) = (ray.direction, crossing.normal);
        let event = here.interface(&beyond, -direction.dot(normal));
        let (axis, [back, on]) = self.split(ray, normal, &event);
        let origin = ray.origin + direction * crossing.distance;
        let next = Ray { origin, axis, depth: ray.depth + 1, ..*ray };
        self.go_on(Ray { direction: direction.reflect(normal), row: back, ..next });
        if !event.tir && !beyond.is_opaque() {
            let direction = refracted(direction, normal, &event, here.n / beyond.n);
            self.go_on(Ray { direction, row: on, nest: crossing.after, ..next });
        }
    }

    /// The reflected and the refracted share with the first axis of their frame. Without polarisation the mean of s and p
    /// is taken at each event: the rest of the row is dropped.
    fn split(&self, ray: &Ray, normal: DVec3, event: &Fresnel<f64>) -> ([f64; 3], [StokesRow<f64>; 2]) {
        let frame = align(ray.direction.to_array(), ray.axis, normal.to_array());
        let row = ray.row.rotated(frame.cos2, frame.sin2);
        let mut shares = [row.reflected(event), row.refracted(event)];
        if !self.reference.scene.settings.polarized {
            shares = shares.map(|share| StokesRow::eye().scaled(share.intensity()));
        }
        (frame.axis, shares)
    }

    fn go_on(&mut self, ray: Ray) {
        let intensity = ray.row.intensity();
        if !ray.nest.is_empty() && intensity < self.reference.scene.settings.threshold {
            self.energy.dropped_threshold += intensity;
        } else if intensity > 0.0 {
            self.pending.push(ray);
        }
    }

    fn at_limit(&mut self, ray: &Ray, crossing: &Crossing) -> f64 {
        let intensity = ray.row.intensity();
        if self.reference.scene.settings.leftover == Leftover::Drop {
            self.energy.dropped_depth += intensity;
            return 0.0;
        }
        let (here, beyond) = (self.medium(ray.nest), self.medium(crossing.after));
        let (direction, normal) = (ray.direction, crossing.normal);
        let place = ray.origin + direction * crossing.distance;
        if beyond.is_opaque() {
            let event = here.interface(&beyond, -direction.dot(normal));
            let (_, [back, _]) = self.split(ray, normal, &event);
            self.energy.left_at_limit += back.intensity();
            return self.light(place, direction.reflect(normal)) * back.intensity();
        }
        self.energy.left_at_limit += intensity;
        let event = here.interface(&Medium::AIR, -direction.dot(normal));
        let straight_on = event.tir || ray.nest.is_empty();
        let out = if straight_on { direction } else { refracted(direction, normal, &event, here.n) };
        self.light(place, out) * intensity
    }

    fn medium(&self, nest: Nest) -> Medium {
        nest.top().map_or(Medium::AIR, |rank| {
            let material = self.reference.scene.geometry.stone(rank).material;
            self.table.media[material as usize][self.line]
        })
    }

    fn light(&self, origin: DVec3, direction: DVec3) -> f64 {
        let rgb = self.reference.scene.environment.seen(origin, direction);
        upsample::radiance(rgb, &self.table.basis[self.line])
    }
}

fn refracted(direction: DVec3, normal: DVec3, event: &Fresnel<f64>, eta: f64) -> DVec3 {
    let cos_i = -direction.dot(normal);
    (direction * eta + normal * (eta * cos_i - event.cos_t)).normalize()
}
