//! The oracle: double precision, every triangle tested for every ray, a plain list of rays.
//!
//! It follows the same rules as the fast paths. It shares with them only the optics of media and the nest of stones: no
//! BVH, no planes for convex stones, no order among the rays that an event sends on.

mod beam;
mod crystal;
pub(crate) mod heaviest;
mod surface;

use crate::{
    account::Account,
    schedule::{self, Finished, Stop, TileTracer},
};
use beam::Facets;
use crystal::Mode;
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
        let lone = scene.lone_convex_stone().or_else(|| scene.lone_convex_crystal());
        let facets = lone.map(|stone| Facets::new(&scene.geometry, stone));
        Ok(Box::new(Reference { device, scene, surfaces, facets, options, workers }) as Box<dyn Tracer>)
    }))
}

struct Reference {
    device: DeviceInfo,
    scene: Arc<PreparedScene>,
    surfaces: Surfaces,
    /// Of a lone convex stone or crystal.
    facets: Option<Facets>,
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
        if let (Some(facets), Some(silhouette)) = (&self.facets, &scene.silhouette) {
            return self.areas(facets, silhouette, tile, samples, stop);
        }
        let (mut account, mut radiances, mut covered) = (Account::default(), Vec::<f64>::new(), Vec::new());
        for (sample, ray) in scene.camera_rays(tile, samples.clone()) {
            let light = Light::Row { row: StokesRow::eye(), axis: any_axis(ray.direction.to_array()) };
            let start =
                Ray { origin: ray.origin, direction: ray.direction, light, nest: scene.eye_nest, depth: 0 };
            let meets = self.surfaces.next(ray.origin, ray.direction, scene.eye_nest).is_some();
            let energy = Energy { started: scene.wavelength_count() as f64, ..Energy::default() };
            let table = scene.table(sample);
            let mut walk = Walk { energy, ..Walk::new(self, table, sample) };
            for line in 0..scene.wavelength_count() {
                if !meets && scene.background == Background::Transparent {
                    radiances.push(0.0);
                    continue;
                }
                walk.line = line;
                walk.start(start);
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
    light: Light,
    nest: Nest,
    depth: u32,
}

/// What a ray carries.
#[derive(Clone, Copy)]
enum Light {
    /// Outside crystals.
    Row {
        row: StokesRow<f64>,
        /// First axis of the row's frame, perpendicular to the ray.
        axis: [f64; 3],
    },
    /// In a crystal.
    Mode(Mode),
}

impl Light {
    fn intensity(&self) -> f64 {
        match self {
            Light::Row { row, .. } => row.intensity(),
            Light::Mode(mode) => mode.weight,
        }
    }

    /// What is left of it after `distance`, mm.
    fn faded(self, medium: &Medium, distance: f64) -> Self {
        match (self, &medium.crystal) {
            (Light::Mode(mode), Some((crystal, coefficients))) => {
                let alpha = crystal.absorption(&mode.wave, *coefficients);
                Light::Mode(Mode { weight: mode.weight * (-alpha * distance).exp(), ..mode })
            }
            (Light::Row { row, axis }, _) => {
                Light::Row { row: row.scaled(medium.transmittance(distance)), axis }
            }
            (light, None) => light,
        }
    }
}

/// The walks of a sample's wavelengths, one after another.
struct Walk<'a> {
    reference: &'a Reference,
    table: &'a SpectralTable,
    /// The pixel's sample.
    sample: u32,
    /// The wavelength in the table.
    line: usize,
    /// Rays still to be followed, in no particular order.
    pending: Vec<Ray>,
    rays: u64,
    energy: Energy,
}

impl<'a> Walk<'a> {
    fn new(reference: &'a Reference, table: &'a SpectralTable, sample: u32) -> Self {
        let (pending, energy) = (Vec::new(), Energy::default());
        Walk { reference, table, sample, line: 0, pending, rays: 0, energy }
    }

    /// Takes a ray from the eye, which may stand in a crystal.
    fn start(&mut self, ray: Ray) {
        match self.medium(ray.nest).crystal {
            Some((crystal, _)) => {
                let modes = Mode::of_eye(&crystal, ray.direction);
                let along = |mode: Mode| Ray { direction: mode.direction(), light: Light::Mode(mode), ..ray };
                self.pending.extend(modes.map(along));
            }
            None => self.pending.push(ray),
        }
    }

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
                        self.energy.lost += ray.light.intensity();
                    }
                    self.light(ray.origin, ray.direction) * ray.light.intensity()
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
        ray.light = ray.light.faded(&here, crossing.distance);
        let intensity = ray.light.intensity();
        if ray.depth == settings.max_depth {
            return self.at_limit(&ray, crossing);
        }
        if ray.nest.is_empty() && intensity < settings.threshold {
            self.energy.dropped_threshold += intensity;
            return 0.0;
        }
        match ray.light {
            Light::Row { row, axis } if beyond.crystal.is_none() => {
                self.send_on(&ray, (row, axis), crossing, here, beyond);
            }
            _ => self.send_on_at_crystal(&ray, crossing, here, beyond),
        }
        0.0
    }

    /// Lists the rays that an event sends on: the reflected one and, unless reflection is total or the medium beyond a
    /// metal, the refracted one.
    fn send_on(&mut self, ray: &Ray, row: Row, crossing: &Crossing, here: Medium, beyond: Medium) {
        let (direction, normal) = (ray.direction, crossing.normal);
        let event = here.interface(&beyond, -direction.dot(normal));
        let [back, on] = self.split(direction, row, normal, &event);
        let origin = ray.origin + direction * crossing.distance;
        let next = Ray { origin, depth: ray.depth + 1, ..*ray };
        self.go_on(Ray { direction: direction.reflect(normal), light: back, ..next });
        if !event.tir && !beyond.is_opaque() {
            let direction = refracted(direction, normal, &event, here.n / beyond.n);
            self.go_on(Ray { direction, light: on, nest: crossing.after, ..next });
        }
    }

    /// The reflected and the refracted share. Without polarisation the mean of s and p
    /// is taken at each event: the rest of the row is dropped.
    fn split(&self, direction: DVec3, (row, axis): Row, normal: DVec3, event: &Fresnel<f64>) -> [Light; 2] {
        let frame = align(direction.to_array(), axis, normal.to_array());
        let row = row.rotated(frame.cos2, frame.sin2);
        let mut shares = [row.reflected(event), row.refracted(event)];
        if !self.reference.scene.settings.polarized {
            shares = shares.map(|share| StokesRow::eye().scaled(share.intensity()));
        }
        shares.map(|row| Light::Row { row, axis: frame.axis })
    }

    fn go_on(&mut self, ray: Ray) {
        let intensity = ray.light.intensity();
        if !ray.nest.is_empty() && intensity < self.reference.scene.settings.threshold {
            self.energy.dropped_threshold += intensity;
        } else if intensity > 0.0 {
            self.pending.push(ray);
        }
    }

    fn at_limit(&mut self, ray: &Ray, crossing: &Crossing) -> f64 {
        let intensity = ray.light.intensity();
        if self.reference.scene.settings.leftover == Leftover::Drop {
            self.energy.dropped_depth += intensity;
            return 0.0;
        }
        let (here, beyond) = (self.medium(ray.nest), self.medium(crossing.after));
        let (direction, normal) = (ray.direction, crossing.normal);
        let place = ray.origin + direction * crossing.distance;
        // A mode leaves straight on, or as from a mirror.
        let (reflected, event) = match ray.light {
            Light::Row { row, axis } => {
                let event = here.interface(&beyond, -direction.dot(normal));
                let [back, _] = self.split(direction, (row, axis), normal, &event);
                (back.intensity(), Some(here.interface(&Medium::AIR, -direction.dot(normal))))
            }
            Light::Mode(_) => (intensity, None),
        };
        if beyond.is_opaque() {
            self.energy.left_at_limit += reflected;
            return self.light(place, direction.reflect(normal)) * reflected;
        }
        self.energy.left_at_limit += intensity;
        let out = match event {
            Some(event) if !event.tir && !ray.nest.is_empty() => refracted(direction, normal, &event, here.n),
            _ => direction,
        };
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

/// A row with the first axis of its frame.
type Row = (StokesRow<f64>, [f64; 3]);

fn refracted(direction: DVec3, normal: DVec3, event: &Fresnel<f64>, eta: f64) -> DVec3 {
    let cos_i = -direction.dot(normal);
    (direction * eta + normal * (eta * cos_i - event.cos_t)).normalize()
}
