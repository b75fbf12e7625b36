//! One beam by itself: how it is cut where facets meet, and what waits to be followed.

use crate::planes::Planes;
use glam::Vec3A;
use spectral_core::beam::{LEAST_AREA, LEAST_DISTANCE, Polygon};

/// A beam that waits for a lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub pencil: Pencil,
    /// The row, times the share of the pixel, and the first axis of its frame.
    pub throughput: [f32; 7],
    pub depth: f32,
    pub line: u16,
    pub place: u32,
    pub polygon: Polygon,
}

/// The rays of a beam, linear in u and v: the twin of `spectral_core::beam::Pencil`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pencil {
    pub origin: Vec3A,
    pub direction: Vec3A,
    pub origin_by: [Vec3A; 2],
    pub direction_by: [Vec3A; 2],
}

/// The least cosine at which a pencil meets a plane: where rays are far apart, that of the centroid of a part may pass the
/// plane by.
const GRAZING: f32 = 1e-6;

/// Where a pencil meets a plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Met {
    pub point: Vec3A,
    pub by: [Vec3A; 2],
    pub cosine: f32,
    pub distance: f32,
}

impl Pencil {
    /// The pencil about the ray at (u, v).
    pub fn about(&self, [u, v]: [f64; 2]) -> Self {
        let (u, v) = (u as f32, v as f32);
        let origin = self.origin + self.origin_by[0] * u + self.origin_by[1] * v;
        let direction = self.direction + self.direction_by[0] * u + self.direction_by[1] * v;
        let scale = direction.length_recip();
        let direction = direction * scale;
        let turned = |by: Vec3A| (by - direction * direction.dot(by)) * scale;
        Pencil { origin, direction, direction_by: self.direction_by.map(turned), ..*self }
    }

    /// Where it meets a plane n · x = d.
    pub fn met(&self, normal: Vec3A, offset: f32) -> Met {
        let cosine = normal.dot(self.direction).max(GRAZING);
        let distance = (offset - normal.dot(self.origin)).max(0.0) / cosine;
        let by = [0, 1].map(|axis| {
            let across = self.origin_by[axis] + self.direction_by[axis] * distance;
            across - self.direction * (normal.dot(across) / cosine)
        });
        Met { point: self.origin + self.direction * distance, by, cosine, distance }
    }
}

/// A beam that may be cut.
pub(crate) trait Divisible: Copy {
    fn polygon(&mut self) -> &mut Polygon;
    /// Keeps a share of what it carries, that beyond a side of the facet; returns the rest.
    fn divided(&mut self, share: f32, side: usize) -> Self;
    /// Makes it one about the centroid of its polygon.
    fn recentre(&mut self, centroid: [f64; 2]);
}

/// Cuts off what meets the plane of a facet beyond one of its sides, and lets it wait; `met` is where the pencil meets the
/// plane. False if there is none; else what is left is about its own centroid.
pub(crate) fn cut<B: Divisible>(
    beam: &mut B,
    planes: &Planes,
    facet: usize,
    met: &Met,
    waiting: &mut Vec<B>,
) -> bool {
    let whole = waiting.len();
    let (.., sides) = planes.facet(facet);
    for (number, side) in sides.as_flattened().iter().enumerate() {
        let normal = Vec3A::from(side.normal);
        let at = f64::from(normal.dot(met.point) - (side.offset + planes.margin()));
        let by = met.by.map(|by| f64::from(normal.dot(by)));
        cut_along(beam, number, (at, by), waiting);
    }
    let cut = waiting.len() > whole;
    if cut {
        let centroid = beam.polygon().centroid();
        beam.recentre(centroid);
    }
    cut
}

/// Cuts along the line where `at` + u·by₀ + v·by₁ is 0, which is a side of the facet.
fn cut_along<B: Divisible>(beam: &mut B, side: usize, (at, by): (f64, [f64; 2]), waiting: &mut Vec<B>) {
    let value = |[u, v]: [f64; 2]| at + u * by[0] + v * by[1];
    let least = LEAST_DISTANCE * (by[0].abs() + by[1].abs());
    // Not finite where rays are so far apart that they are no longer known.
    if !least.is_finite() || beam.polygon().vertices().iter().all(|&vertex| value(vertex) <= least) {
        return;
    }
    let (mut inside, mut outside) = (*beam.polygon(), Polygon::EMPTY);
    inside.cut_off(value, &mut outside);
    let [(within, _), (beyond, centroid)] = [inside.moments(), outside.moments()];
    // Less is rounding at an edge.
    if within < LEAST_AREA || beyond < LEAST_AREA {
        return;
    }
    let share = (beyond / (within + beyond)) as f32;
    let rest = beam.divided(share, side);
    let mut part = std::mem::replace(beam, rest);
    *part.polygon() = outside;
    part.recentre(centroid);
    waiting.push(part);
    *beam.polygon() = inside;
}

impl Part {
    /// A share of the throughput.
    fn share(&self, share: f32) -> [f32; 7] {
        let [i, q, u, v, x, y, z] = self.throughput;
        [i * share, q * share, u * share, v * share, x, y, z]
    }
}

impl Divisible for Part {
    fn polygon(&mut self) -> &mut Polygon {
        &mut self.polygon
    }

    fn divided(&mut self, share: f32, _: usize) -> Self {
        let rest = Part { throughput: self.share(1.0 - share), ..*self };
        self.throughput = self.share(share);
        rest
    }

    fn recentre(&mut self, centroid: [f64; 2]) {
        self.pencil = self.pencil.about(centroid);
        self.polygon.shift([-centroid[0], -centroid[1]]);
        let (along, axis) = (self.pencil.direction, Vec3A::from_slice(&self.throughput[4..]));
        let axis = (axis - along * along.dot(axis)).normalize_or_zero();
        self.throughput[4..].copy_from_slice(&axis.to_array());
    }
}
