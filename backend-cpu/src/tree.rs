//! Any scene: several stones, nested and touching, non-convex, metals. A path is a tree; an explicit stack
//! goes on with the stronger child and keeps the other.

use crate::{
    account::Account,
    direction::{reflected, refracted},
    light::Light,
    line::{Line, Medium},
    schedule::Work,
    surface::{Crossing, Surfaces},
    throughput::Throughput,
    tracer::Scratch,
};
use glam::Vec3;
use spectral_core::{
    fresnel::{Fresnel, conductor, dielectric},
    prepare::{Nest, PreparedScene},
    settings::{Leftover, RenderSettings},
};
use std::sync::atomic::Ordering;

/// Air, and the world beyond the stones.
const AIR: Medium = Medium { n: 1.0, k: 0.0, absorption: 0.0 };

/// A ray on its way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray<P> {
    pub origin: Vec3,
    pub direction: Vec3,
    pub throughput: P,
    /// The stones it is in.
    pub nest: Nest,
    /// Surface events so far.
    pub depth: u32,
}

/// The rules of transport over the scene's surfaces.
#[derive(Debug)]
pub(crate) struct Tree {
    pub surfaces: Surfaces,
    max_depth: u32,
    threshold: f32,
    leftover: Leftover,
}

/// One wavelength's walk through the tree.
struct Walk<'a, P> {
    tree: &'a Tree,
    line: &'a Line,
    light: &'a Light,
    account: &'a mut Account,
    stack: &'a mut Vec<Ray<P>>,
    sum: f32,
}

impl Tree {
    pub fn new(scene: &PreparedScene, surfaces: Surfaces) -> Self {
        let RenderSettings { max_depth, threshold, leftover, .. } = scene.settings;
        Tree { surfaces, max_depth, threshold: threshold as f32, leftover }
    }

    /// Radiance towards the eye along a ray whose first crossing is known: it is the same for every
    /// wavelength.
    pub fn radiance<P: Throughput<f32>>(
        &self,
        ray: Ray<P>,
        first: &Crossing,
        line: &Line,
        light: &Light,
        work: &mut Work<'_, Scratch<P>>,
    ) -> f32 {
        let Work { account, scratch: Scratch { stack, .. }, stop } = work;
        stack.clear();
        let mut walk = Walk { tree: self, line, light, account, stack, sum: 0.0 };
        let mut next = walk.arrive(ray, first);
        while let Some(ray) = next.or_else(|| walk.stack.pop()) {
            // A tree can be vast: breaking off must not wait for the pixel.
            if stop.load(Ordering::Relaxed) {
                break;
            }
            next = walk.go_on(ray);
        }
        walk.sum
    }
}

impl<P: Throughput<f32>> Walk<'_, P> {
    /// Follows a ray to its next surface; returns the child to go on with.
    fn go_on(&mut self, ray: Ray<P>) -> Option<Ray<P>> {
        match self.tree.surfaces.next(ray.origin, ray.direction, ray.nest) {
            Some(crossing) => self.arrive(ray, &crossing),
            None => {
                self.account.rays += 1;
                if !ray.nest.is_empty() {
                    self.account.lost += f64::from(ray.throughput.intensity());
                }
                self.leave(ray.throughput, ray.direction);
                None
            }
        }
    }

    /// A surface event: fades the ray, splits it, stacks the weaker child and returns the stronger.
    fn arrive(&mut self, mut ray: Ray<P>, crossing: &Crossing) -> Option<Ray<P>> {
        let (here, beyond) = (self.medium(crossing.before), self.medium(crossing.after));
        self.account.rays += 1;
        if here.absorption > 0.0 {
            ray.throughput = ray.throughput.scaled((-here.absorption * crossing.distance).exp());
        }
        // Inside a metal nothing travels.
        if here.k > 0.0 {
            return None;
        }
        let intensity = ray.throughput.intensity();
        if ray.depth == self.tree.max_depth {
            self.at_limit(&ray, crossing, here, beyond);
            return None;
        }
        if crossing.before.is_empty() && intensity < self.tree.threshold {
            self.account.dropped_threshold += f64::from(intensity);
            return None;
        }
        let (mirrored, through) = self.split(&ray, crossing, here, beyond);
        match (self.worthwhile(Some(mirrored)), self.worthwhile(through)) {
            (Some(a), Some(b)) => {
                let weaker_first = b.throughput.intensity() > a.throughput.intensity();
                let (strong, weak) = if weaker_first { (b, a) } else { (a, b) };
                self.stack.push(weak);
                Some(strong)
            }
            (a, b) => a.or(b),
        }
    }

    /// The two children of an event; the second is absent under total reflection and at metals.
    fn split(
        &self,
        ray: &Ray<P>,
        crossing: &Crossing,
        here: Medium,
        beyond: Medium,
    ) -> (Ray<P>, Option<Ray<P>>) {
        let (event, cos_i) = interface(ray.direction, crossing.normal, here, beyond);
        let [back, on] = ray.throughput.split(ray.direction.to_array(), crossing.normal.to_array(), &event);
        let origin = ray.origin + ray.direction * crossing.distance;
        let depth = ray.depth + 1;
        let direction = reflected(ray.direction, crossing.normal);
        let mirrored = Ray { origin, direction, throughput: back, nest: crossing.before, depth };
        if event.tir || beyond.k > 0.0 {
            return (mirrored, None);
        }
        let direction = refracted(ray.direction, crossing.normal, cos_i, event.cos_t, here.n / beyond.n);
        (mirrored, Some(Ray { origin, direction, throughput: on, nest: crossing.after, depth }))
    }

    /// The ray itself if it goes on: inside a stone only above the threshold, and never with nothing.
    fn worthwhile(&mut self, ray: Option<Ray<P>>) -> Option<Ray<P>> {
        let ray = ray?;
        let intensity = ray.throughput.intensity();
        if intensity <= 0.0 {
            return None;
        }
        if intensity < self.tree.threshold && !ray.nest.is_empty() {
            self.account.dropped_threshold += f64::from(intensity);
            return None;
        }
        Some(ray)
    }

    /// What becomes of a ray that would make one event too many.
    fn at_limit(&mut self, ray: &Ray<P>, crossing: &Crossing, here: Medium, beyond: Medium) {
        let left = ray.throughput.intensity();
        if self.tree.leftover == Leftover::Drop {
            self.account.dropped_depth += f64::from(left);
            return;
        }
        if beyond.k > 0.0 {
            // A metal lets nothing through: the rest leaves as the metal reflects it.
            let (event, _) = interface(ray.direction, crossing.normal, here, beyond);
            let normal = crossing.normal.to_array();
            let [back, _] = ray.throughput.split(ray.direction.to_array(), normal, &event);
            self.account.left_at_limit += f64::from(back.intensity());
            self.leave(back, reflected(ray.direction, crossing.normal));
            return;
        }
        self.account.left_at_limit += f64::from(left);
        let (event, cos_i) = interface(ray.direction, crossing.normal, here, AIR);
        let straight = event.tir || crossing.before.is_empty();
        let direction = if straight {
            ray.direction
        } else {
            refracted(ray.direction, crossing.normal, cos_i, event.cos_t, here.n)
        };
        self.leave(ray.throughput, direction);
    }

    fn leave(&mut self, throughput: P, direction: Vec3) {
        self.sum += self.light.radiance(direction, self.line) * throughput.intensity();
    }

    fn medium(&self, nest: Nest) -> Medium {
        nest.top().map_or(AIR, |rank| self.line.media[self.tree.surfaces.material(rank)])
    }
}

/// Fresnel's energies at an interface, and the cosine of incidence.
#[inline]
fn interface(direction: Vec3, normal: Vec3, here: Medium, beyond: Medium) -> (Fresnel<f32>, f32) {
    let cos_i = -normal.dot(direction);
    let event = if beyond.k > 0.0 {
        conductor(cos_i, here.n, beyond.n, beyond.k)
    } else {
        dielectric(cos_i, here.n / beyond.n)
    };
    (event, cos_i)
}
