//! Where a ray meets the scene, by testing every triangle in double precision.

use glam::DVec3;
use spectral_core::prepare::{Geometry, Nest, Rank};

/// A triangle with the plane of its facet.
#[derive(Debug, Clone, Copy)]
struct Triangle {
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    offset: f64,
    rank: Rank,
}

/// All triangles.
#[derive(Debug)]
pub(super) struct Surfaces {
    triangles: Vec<Triangle>,
    material_of_rank: Vec<u32>,
    margin: f64,
    contact: f64,
}

/// The next optical surface on a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub distance: f64,
    /// Unit, on the side the ray comes from.
    pub normal: DVec3,
    /// The stones the ray is in as it arrives: it may have crossed surfaces that are no optical ones.
    pub before: Nest,
    pub after: Nest,
}

impl Surfaces {
    pub fn new(geometry: &Geometry) -> Self {
        let triangle = |(corners, &facet): (&[u32; 3], &u32)| {
            let [a, b, c] = corners.map(|v| geometry.positions[v as usize]);
            let plane = &geometry.facets[facet as usize];
            let rank = geometry.stones[plane.stone as usize].rank;
            Triangle { corner: a, edges: [b - a, c - a], normal: plane.normal, offset: plane.offset, rank }
        };
        Surfaces {
            triangles: geometry.triangles.iter().zip(&geometry.facet_of).map(triangle).collect(),
            material_of_rank: geometry.material_of_rank(),
            margin: 1e-11 * geometry.radius,
            contact: if geometry.contacts { Geometry::CONTACT * geometry.radius } else { 0.0 },
        }
    }

    /// The next surface at which the medium changes.
    pub fn next(&self, origin: DVec3, direction: DVec3, mut nest: Nest) -> Option<Crossing> {
        let optics = |nest: Nest| nest.top().map(|rank| self.material_of_rank[rank as usize]);
        let mut travelled = 0.0;
        for _ in 0..10_000 {
            let crossing = self.nearest(origin + direction * travelled, direction, nest)?;
            travelled += crossing.distance;
            if optics(nest) != optics(crossing.after) {
                return Some(Crossing { distance: travelled, ..crossing });
            }
            nest = crossing.after;
        }
        None
    }

    fn nearest(&self, origin: DVec3, direction: DVec3, nest: Nest) -> Option<Crossing> {
        let mut found: Option<(f64, &Triangle)> = None;
        for triangle in &self.triangles {
            let Some(t) = self.meet(triangle, origin, direction) else { continue };
            let leaving = triangle.normal.dot(direction) > 0.0;
            if leaving == nest.contains(triangle.rank) && found.is_none_or(|(best, _)| t < best) {
                found = Some((t, triangle));
            }
        }
        let (t, first) = found?;
        let normal = if first.normal.dot(direction) > 0.0 { -first.normal } else { first.normal };
        let after = self.with_contacts(origin, direction, t, first, nest);
        Some(Crossing { distance: t.max(0.0), normal, before: nest, after })
    }

    /// Toggles `first` and every parallel face of another stone that lies on it.
    fn with_contacts(&self, origin: DVec3, direction: DVec3, t: f64, first: &Triangle, nest: Nest) -> Nest {
        let mut after = nest.toggled(first.rank);
        if self.contact == 0.0 {
            return after;
        }
        let window = self.contact / first.normal.dot(direction).abs().max(1e-6);
        let mut crossed = vec![first.rank];
        for triangle in &self.triangles {
            let leaving = triangle.normal.dot(direction) > 0.0;
            let touching = !crossed.contains(&triangle.rank)
                && leaving == after.contains(triangle.rank)
                && triangle.normal.dot(first.normal).abs() > 0.999
                && self.meet(triangle, origin, direction).is_some_and(|other| (other - t).abs() <= window);
            if touching {
                crossed.push(triangle.rank);
                after = after.toggled(triangle.rank);
            }
        }
        after
    }

    /// Möller & Trumbore (1997) with edges that belong to both sides; distance to the facet's plane. Hits
    /// count from where rounding may have put the start beyond the plane.
    fn meet(&self, triangle: &Triangle, origin: DVec3, direction: DVec3) -> Option<f64> {
        const EDGE: f64 = 1e-10;
        let [e1, e2] = triangle.edges;
        let p = direction.cross(e2);
        let determinant = e1.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let from_corner = origin - triangle.corner;
        let u = from_corner.dot(p) / determinant;
        let q = from_corner.cross(e1);
        let v = direction.dot(q) / determinant;
        if u < -EDGE || v < -EDGE || u + v > 1.0 + EDGE {
            return None;
        }
        let towards = triangle.normal.dot(direction);
        let gap = triangle.offset - triangle.normal.dot(origin);
        (gap * towards.signum() >= -self.margin).then(|| gap / towards)
    }
}
