//! Reciprocity (Stokes–Helmholtz): a path has the same throughput from the lamp to the eye as from the eye to the lamp.
//! The throughput T_in · ΠR · T_out in energy is symmetric.

use gemtrace_tests::prelude::*;
use spectral_core::{
    fresnel::{Fresnel, dielectric},
    mesh::Mesh,
    stokes::{Scalar, StokesRow, align, any_axis},
};

const N: f64 = 2.41726;

/// A ray that leaves a stone.
#[derive(Debug, Clone, Copy)]
struct Exit {
    origin: DVec3,
    direction: DVec3,
    polarized: f64,
    scalar: f64,
    events: u32,
}

/// A ray with both kinds of throughput, traced by the functions of the core alone.
struct Walker<'a> {
    mesh: &'a Mesh,
    origin: DVec3,
    direction: DVec3,
    row: StokesRow<f64>,
    axis: [f64; 3],
    scalar: Scalar<f64>,
}

impl<'a> Walker<'a> {
    fn new(mesh: &'a Mesh, origin: DVec3, direction: DVec3) -> Self {
        let (row, axis) = (StokesRow::eye(), any_axis(direction.to_array()));
        Walker { mesh, origin, direction, row, axis, scalar: Scalar::eye() }
    }

    /// The nearest plane along the ray, seen from inside or outside.
    fn nearest(&self, inside: bool) -> Option<(f64, DVec3)> {
        let planes = self.mesh.facets().iter().map(|f| f.plane);
        let hits = planes.filter_map(|plane| {
            let towards = plane.normal.dot(self.direction);
            let distance = -plane.distance(self.origin) / towards;
            ((towards > 0.0) == inside && distance > -1e-12).then_some((distance, plane.normal))
        });
        // From inside the first plane counts, from outside the last.
        hits.reduce(|a, b| if (b.0 < a.0) == inside { b } else { a })
    }

    /// Moves to a surface and returns its event.
    fn arrive(&mut self, distance: f64, normal: DVec3, eta: f64) -> Fresnel<f64> {
        self.origin += self.direction * distance;
        let frame = align(self.direction.to_array(), self.axis, normal.to_array());
        (self.row, self.axis) = (self.row.rotated(frame.cos2, frame.sin2), frame.axis);
        dielectric(self.direction.dot(normal).abs(), eta)
    }

    fn refract(&self, normal: DVec3, eta: f64, cos_t: f64) -> DVec3 {
        let towards = self.direction.dot(normal);
        let facing = -normal * towards.signum();
        (self.direction * eta + facing * (eta * towards.abs() - cos_t)).normalize()
    }

    /// All exits within `events` surface events.
    fn exits(mut self, events: u32) -> Vec<Exit> {
        let mut exits = Vec::new();
        let Some((distance, normal)) = self.nearest(false) else { return exits };
        let event = self.arrive(distance, normal, 1.0 / N);
        self.direction = self.refract(normal, 1.0 / N, event.cos_t);
        (self.row, self.scalar) = (self.row.refracted(&event), self.scalar.refracted(&event));
        for k in 2..=events {
            let (distance, normal) = self.nearest(true).expect("the inside is bounded");
            let event = self.arrive(distance, normal, N);
            if !event.tir {
                exits.push(Exit {
                    origin: self.origin,
                    direction: self.refract(normal, N, event.cos_t),
                    polarized: self.row.refracted(&event).intensity(),
                    scalar: self.scalar.refracted(&event).intensity(),
                    events: k,
                });
            }
            self.direction = self.direction.reflect(normal).normalize();
            (self.row, self.scalar) = (self.row.reflected(&event), self.scalar.reflected(&event));
        }
        exits
    }
}

/// Rays to the stone from all directions.
fn rays(count: u32) -> impl Iterator<Item = (DVec3, DVec3)> {
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
        let (sin, cos) = (2.399_963 * f64::from(k)).sin_cos();
        let from = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
        let target = 0.15 * DVec3::new((1.7 * f64::from(k)).sin(), (2.3 * f64::from(k)).sin(), 0.2);
        let origin = 5.0 * from;
        (origin, (target - origin).normalize())
    })
}

#[test]
fn every_path_has_the_same_throughput_backwards() {
    let mesh = cut("round-brilliant");
    let (mut paths, mut worst) = (0, 0.0_f64);
    for (origin, direction) in rays(300) {
        for exit in Walker::new(&mesh, origin, direction).exits(10) {
            // Back along the exit.
            let back = Walker::new(&mesh, exit.origin + 5.0 * exit.direction, -exit.direction);
            let returned = back.exits(10).into_iter().find(|e| e.events == exit.events);
            let Some(returned) = returned else { continue };
            if exit.polarized < 1e-6 || returned.direction.dot(-direction) < 1.0 - 1e-12 {
                // At an edge, rounding may change the path.
                continue;
            }
            paths += 1;
            worst = worst.max((returned.polarized / exit.polarized - 1.0).abs());
            worst = worst.max((returned.scalar / exit.scalar - 1.0).abs());
        }
    }
    println!("{paths} paths, worst relative difference {worst:.1e}");
    // Rounding grows with each reflection. Another program found 692 such paths within 6e-14.
    assert!(paths > 692 && worst < 1e-11, "{paths} paths, {worst:e}");
}

/// The radiance along a ray, lit by a lamp of 3° radius in the direction `towards`.
fn seen(way: Way, ray: (DVec3, DVec3), towards: DVec3, mesh: &Arc<Mesh>, polarized: bool) -> f64 {
    let camera = probe(ray.0, ray.1, 1e-6);
    let scene = scene(camera, 1, lamp(towards, 3.0), vec![stone(mesh.clone(), glass(N))]);
    let leftover = Leftover::Drop;
    let settings = RenderSettings { polarized, max_depth: 12, leftover, ..settings(&[550.0]) };
    way.render(&scene, &settings).first_line()[0]
}

/// Whether only one exit of a ray lies within reach of a lamp in that direction.
fn alone(ray: (DVec3, DVec3), towards: DVec3, mesh: &Mesh) -> bool {
    let near = |d: DVec3| d.dot(towards) > 6.0_f64.to_radians().cos();
    let mirrored = mesh.facets().iter().any(|f| near(ray.1.reflect(f.plane.normal)));
    !mirrored && Walker::new(mesh, ray.0, ray.1).exits(12).iter().filter(|e| near(e.direction)).count() == 1
}

#[test]
fn the_renderer_is_reciprocal() {
    let mesh = cut("round-brilliant");
    let mut paths = 0;
    for ray in rays(25) {
        for exit in Walker::new(&mesh, ray.0, ray.1).exits(8) {
            let back = (exit.origin + 5.0 * exit.direction, -exit.direction);
            let clear = alone(ray, exit.direction, &mesh) && alone(back, -ray.1, &mesh);
            if exit.polarized < 1e-3 || !clear {
                continue;
            }
            for way in Way::ALL {
                for (polarized, expected) in [(true, exit.polarized), (false, exit.scalar)] {
                    for (ray, towards) in [(ray, exit.direction), (back, -ray.1)] {
                        let found = seen(way, ray, towards, &mesh, polarized);
                        let what = format!("{way:?}, {} events, polarised {polarized}", exit.events);
                        close(found / expected, 1.0, way.tolerance(1e-4, 1e-6), what);
                    }
                }
            }
            paths += 1;
        }
    }
    println!("{paths} paths");
    assert!(paths > 30, "only {paths} paths were clear of others");
}
