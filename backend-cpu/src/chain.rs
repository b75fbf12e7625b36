//! One convex stone under an environment: what leaves never returns, so a path is a chain of internal
//! reflections, not a tree, and the next facet is the nearest plane.

use crate::{
    account::Account,
    direction::{reflected, refracted},
    light::Light,
    line::Line,
    planes::{Entry, Planes},
    throughput::Throughput,
};
use glam::Vec3;
use spectral_core::{
    fresnel::dielectric,
    prepare::PreparedScene,
    settings::{Leftover, RenderSettings},
};
use std::collections::HashMap;

/// The scene reduced to one convex stone.
#[derive(Debug)]
pub(crate) struct Chain {
    pub planes: Planes,
    material: usize,
    max_depth: u32,
    threshold: f32,
    leftover: Leftover,
}

/// A ray inside the stone.
struct Inside<'a, P> {
    origin: Vec3,
    direction: Vec3,
    throughput: P,
    trail: &'a mut Trail,
    /// Segments so far.
    steps: usize,
}

/// The facets that the last wavelength of this sample met, one a segment: the best guess for the next one.
#[derive(Debug, Default)]
pub(crate) struct Trail(Vec<usize>);

impl Trail {
    /// Forgets the facets, for another sample: guesses never come from outside it, so that the order of work
    /// cannot show.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    fn guess(&self, step: usize) -> usize {
        self.0.get(step).copied().unwrap_or(usize::MAX)
    }

    fn note(&mut self, step: usize, facet: usize) {
        match self.0.get_mut(step) {
            Some(place) => *place = facet,
            None => self.0.push(facet),
        }
    }
}

impl Chain {
    /// The chain for a scene, if it is one convex stone seen from outside.
    pub fn new(scene: &PreparedScene) -> Option<Self> {
        let stone = scene.lone_convex_stone()?;
        let RenderSettings { max_depth, threshold, leftover, .. } = scene.settings;
        let facets = &scene.geometry.facets[stone.facets.start as usize..stone.facets.end as usize];
        Some(Chain {
            planes: Planes::new(facets, &adjacent(scene)),
            material: stone.material as usize,
            max_depth,
            threshold: threshold as f32,
            leftover,
        })
    }

    /// Radiance towards the eye along a camera ray of unit `direction` that enters the stone at `entry`.
    pub fn radiance<P: Throughput<f32>>(
        &self,
        entry: &Entry,
        direction: Vec3,
        line: &Line,
        light: &Light,
        trail: &mut Trail,
        account: &mut Account,
    ) -> f32 {
        let n = line.media[self.material].n;
        let normal = self.planes.normal(entry.facet);
        let cos_i = -normal.dot(direction);
        let event = dielectric(cos_i, 1.0 / n);
        let [outer, inner] =
            P::eye(direction.to_array()).split(direction.to_array(), normal.to_array(), &event);
        account.rays += 2;
        let mirrored = light.radiance(reflected(direction, normal), line) * outer.intensity();
        if inner.intensity() < self.threshold {
            account.dropped_threshold += f64::from(inner.intensity());
            return mirrored;
        }
        let into = refracted(direction, normal, cos_i, event.cos_t, 1.0 / n);
        let ray =
            Inside { origin: entry.point.as_vec3(), direction: into, throughput: inner, trail, steps: 0 };
        mirrored + self.internal(ray, line, light, account)
    }

    /// What the chain of internal reflections gathers.
    fn internal<P: Throughput<f32>>(
        &self,
        mut ray: Inside<'_, P>,
        line: &Line,
        light: &Light,
        account: &mut Account,
    ) -> f32 {
        let medium = &line.media[self.material];
        let mut sum = 0.0;
        for _ in 1..self.max_depth {
            let facet = self.advance(&mut ray, medium.absorption);
            let normal = self.planes.normal(facet);
            let cos_i = normal.dot(ray.direction);
            let event = dielectric(cos_i, medium.n);
            let [inner, outer] = ray.throughput.split(ray.direction.to_array(), normal.to_array(), &event);
            account.rays += 1;
            if !event.tir {
                let out = refracted(ray.direction, -normal, cos_i, event.cos_t, medium.n);
                sum += light.radiance(out, line) * outer.intensity();
                account.rays += 1;
            }
            if inner.intensity() < self.threshold {
                account.dropped_threshold += f64::from(inner.intensity());
                return sum;
            }
            ray.direction = reflected(ray.direction, normal);
            ray.throughput = inner;
        }
        sum + self.at_limit(ray, line, light, account)
    }

    /// Moves a ray to the facet it meets next, fading on the way; returns the facet.
    #[inline]
    fn advance<P: Throughput<f32>>(&self, ray: &mut Inside<'_, P>, absorption: f32) -> usize {
        let exit = self.planes.exit_near(ray.origin, ray.direction, ray.trail.guess(ray.steps));
        ray.trail.note(ray.steps, exit.facet);
        ray.steps += 1;
        ray.origin += ray.direction * exit.distance;
        if absorption > 0.0 {
            ray.throughput = ray.throughput.scaled((-absorption * exit.distance).exp());
        }
        exit.facet
    }

    /// What becomes of a ray that would make one event too many.
    fn at_limit<P: Throughput<f32>>(
        &self,
        mut ray: Inside<'_, P>,
        line: &Line,
        light: &Light,
        account: &mut Account,
    ) -> f32 {
        let medium = &line.media[self.material];
        let facet = self.advance(&mut ray, medium.absorption);
        let left = ray.throughput.intensity();
        account.rays += 1;
        if self.leftover == Leftover::Drop {
            account.dropped_depth += f64::from(left);
            return 0.0;
        }
        account.left_at_limit += f64::from(left);
        let normal = self.planes.normal(facet);
        let cos_i = normal.dot(ray.direction);
        let event = dielectric(cos_i, medium.n);
        let out = if event.tir {
            ray.direction
        } else {
            refracted(ray.direction, -normal, cos_i, event.cos_t, medium.n)
        };
        light.radiance(out, line) * left
    }
}

/// For each facet the facets that it shares an edge with, in ascending order.
fn adjacent(scene: &PreparedScene) -> Vec<Vec<usize>> {
    let geometry = &scene.geometry;
    let mut edges = HashMap::new();
    let mut adjacent = vec![Vec::new(); geometry.facets.len()];
    for (corners, &facet) in geometry.triangles.iter().zip(&geometry.facet_of) {
        for k in 0..3 {
            edges.insert((corners[k], corners[(k + 1) % 3]), facet as usize);
        }
    }
    for (&(from, to), &facet) in &edges {
        let beyond = edges.get(&(to, from)).copied().unwrap_or(facet);
        if beyond != facet {
            adjacent[facet].push(beyond);
        }
    }
    for list in &mut adjacent {
        list.sort_unstable();
        list.dedup();
    }
    adjacent
}
