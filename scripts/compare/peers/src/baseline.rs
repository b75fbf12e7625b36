//! The same renderer over obvhs's CWBVH, one ray and one wavelength at a time: the same scene tables, Fresnel and
//! Stokes formulas, depth, threshold and environment as gemtrace, in single precision.
//!
//! obvhs's triangle test is that of Möller and Trumbore. Rays skip the facet they start on, so no minimum distance is needed;
//! the few that leak through an edge are counted.

use crate::{
    Failure,
    light::{Light, expand},
    scene::{self, Studio},
    throughput::{Polarized, Throughput},
};
use cpu_time::ProcessTime;
use glam::Vec3A;
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    ray::{Ray, RayHit},
    triangle::Triangle,
};
use serde_json::{Value, json};
use spectral_core::{fresnel::dielectric, prepare::PreparedScene, stokes::Scalar};
use std::{collections::BTreeSet, time::Duration};

/// A stone behind a CWBVH.
pub struct Stone {
    bvh: CwBvh,
    /// In the order of the hierarchy.
    triangles: Vec<Triangle>,
    facets: Vec<u32>,
    /// By facet.
    pub normals: Vec<Vec3A>,
    /// By facet: the number of facets with which it shares an edge.
    sides: Vec<usize>,
}

/// Counts of the rays of a picture.
#[derive(Default)]
pub struct Count {
    /// Hits from inside.
    pub events: u64,
    /// Hits with transmitted light.
    pub leaving: u64,
    /// Sides of the facets hit.
    pub sides: u64,
    /// Rays that leaked through an edge.
    pub lost: u64,
}

/// One wavelength in single precision.
pub struct Wavelength {
    pub n: f32,
    basis: [f32; 7],
    luminance: f64,
}

impl Wavelength {
    /// Those of a scene.
    pub fn all(scene: &PreparedScene) -> Vec<Wavelength> {
        let table = scene.table(0);
        let line = |i: usize| Wavelength {
            n: table.media[0][i].n as f32,
            basis: table.basis[i].map(|b| b as f32),
            luminance: table.response[i][1],
        };
        (0..table.wavelengths.len()).map(line).collect()
    }
}

impl Stone {
    /// The scene's only stone.
    pub fn new(scene: &PreparedScene) -> Self {
        let geometry = &scene.geometry;
        let corner = |i: u32| geometry.positions[i as usize].as_vec3a();
        let corners = geometry.triangles.iter().map(|t| t.map(corner));
        let triangles: Vec<Triangle> = corners.map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
        // The slowest build gives the fastest tree here.
        let best = BvhBuildParams::very_slow_build();
        let bvh = build_cwbvh_from_tris(&triangles, best, &mut Duration::default());
        let order = || bvh.primitive_indices.iter().map(|&i| i as usize);
        Stone {
            triangles: order().map(|i| triangles[i]).collect(),
            facets: order().map(|i| geometry.facet_of[i]).collect(),
            normals: geometry.facets.iter().map(|f| f.normal.as_vec3a()).collect(),
            sides: sides(scene),
            bvh,
        }
    }

    /// Distance and facet of the nearest hit beyond the facet that the ray starts on.
    #[inline]
    pub fn hit(&self, origin: Vec3A, direction: Vec3A, from: u32) -> Option<(f32, u32)> {
        let mut hit = RayHit::none();
        let ray = Ray::new(origin, direction, 0.0, f32::INFINITY);
        let met = self.bvh.ray_traverse(ray, &mut hit, |ray, id| {
            if self.facets[id] == from { f32::INFINITY } else { self.triangles[id].intersect(ray) }
        });
        met.then(|| (hit.t, self.facets[hit.primitive_id as usize]))
    }
}

/// The picture of the first line by this renderer.
pub fn render(mode: &str) -> Result<Value, Failure> {
    let settings = scene::shallow(mode)?;
    let scene = scene::prepared(Studio::Coloured, &settings)?;
    if settings.polarized { picture::<Polarized>(&scene) } else { picture::<Scalar<f32>>(&scene) }
}

fn picture<P: Throughput>(scene: &PreparedScene) -> Result<Value, Failure> {
    let stone = Stone::new(scene);
    let light = Light::new(scene).ok_or("the scene is lit by an image")?;
    let lines = Wavelength::all(scene);
    let mut paths = Paths { stone: &stone, light: &light, scene, count: Count::default() };
    let (mut sum, mut covered) = (0.0, 0);
    let time = ProcessTime::now();
    for y in 0..scene.height {
        for x in 0..scene.width {
            let ray = scene.view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let (origin, direction) = (ray.origin.as_vec3a(), ray.direction.as_vec3a());
            let Some((distance, facet)) = stone.hit(origin, direction, u32::MAX) else { continue };
            covered += 1;
            let point = (ray.origin + ray.direction * f64::from(distance)).as_vec3a();
            for line in &lines {
                sum += line.luminance * f64::from(paths.radiance::<P>(point, direction, facet, line));
            }
        }
    }
    let Count { events, leaving, sides, lost } = paths.count;
    Ok(json!({
        "cpu": time.elapsed().as_secs_f64(),
        "mean": sum / f64::from(covered),
        "events": events,
        "leaving": leaving,
        "sides": sides as f64 / events as f64,
        "lost": lost,
    }))
}

struct Paths<'a> {
    stone: &'a Stone,
    light: &'a Light<'a>,
    scene: &'a PreparedScene,
    count: Count,
}

impl Paths<'_> {
    fn radiance<P: Throughput>(&mut self, point: Vec3A, eye: Vec3A, facet: u32, line: &Wavelength) -> f32 {
        let normal = self.stone.normals[facet as usize];
        let cosine = -normal.dot(eye);
        let event = dielectric(cosine, 1.0 / line.n);
        let [outer, inner] = P::eye(eye.into()).children(eye.into(), normal.into(), &event);
        let mirrored = expand(&line.basis, self.light.rgb(reflected(eye, normal))) * outer.intensity();
        let direction = refracted(eye, normal, cosine, event.cos_t, 1.0 / line.n);
        mirrored + self.inside(point, direction, facet, inner, line)
    }

    fn inside<P: Throughput>(
        &mut self,
        mut point: Vec3A,
        mut direction: Vec3A,
        mut facet: u32,
        mut throughput: P,
        line: &Wavelength,
    ) -> f32 {
        let settings = &self.scene.settings;
        let (threshold, depth) = (settings.threshold as f32, settings.max_depth);
        let mut sum = 0.0;
        for event in 1..=depth {
            if throughput.intensity() < threshold {
                break;
            }
            let Some((distance, met)) = self.stone.hit(point, direction, facet) else {
                self.count.lost += 1;
                break;
            };
            self.count.events += 1;
            self.count.sides += self.stone.sides[met as usize] as u64;
            (point, facet) = (point + direction * distance, met);
            let normal = self.stone.normals[facet as usize];
            let cosine = normal.dot(direction);
            let at = dielectric(cosine, line.n);
            let [inner, mut outer] = throughput.children(direction.into(), normal.into(), &at);
            let mut out = direction;
            if event == depth {
                outer = throughput;
            }
            if !at.tir {
                out = refracted(direction, -normal, cosine, at.cos_t, line.n);
            }
            if !at.tir || event == depth {
                self.count.leaving += 1;
                sum += expand(&line.basis, self.light.rgb(out)) * outer.intensity();
            }
            (direction, throughput) = (reflected(direction, normal), inner);
        }
        sum
    }
}

/// A Newton step towards length 1.
#[inline]
fn renormalized(v: Vec3A) -> Vec3A {
    v * (1.5 - 0.5 * v.dot(v))
}

/// Mirrored at a surface of unit normal.
#[inline]
pub fn reflected(direction: Vec3A, normal: Vec3A) -> Vec3A {
    renormalized(direction - normal * (2.0 * direction.dot(normal)))
}

/// Refracted; the normal is on the side of the incident ray.
#[inline]
pub fn refracted(direction: Vec3A, normal: Vec3A, cos_i: f32, cos_t: f32, eta: f32) -> Vec3A {
    renormalized(direction * eta + normal * (eta * cos_i - cos_t))
}

/// For each facet, the number of others that share an edge with it.
fn sides(scene: &PreparedScene) -> Vec<usize> {
    let geometry = &scene.geometry;
    let mut around = vec![BTreeSet::new(); geometry.facets.len()];
    let edges: Vec<([u32; 2], u32)> = geometry
        .triangles
        .iter()
        .zip(&geometry.facet_of)
        .flat_map(|(t, &facet)| [0, 1, 2].map(|k| ([t[k], t[(k + 1) % 3]], facet)))
        .collect();
    let facet_of: std::collections::HashMap<_, _> = edges.iter().copied().collect();
    for &([from, to], facet) in &edges {
        if let Some(&beyond) = facet_of.get(&[to, from]).filter(|&&beyond| beyond != facet) {
            around[facet as usize].insert(beyond);
        }
    }
    around.iter().map(BTreeSet::len).collect()
}
