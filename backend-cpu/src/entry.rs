//! Where camera rays enter a convex stone. A ray mostly enters by the same facet as the ray before it, or passes between
//! the same two planes. Only if it does neither are all planes tested.

use crate::planes::Planes;
use glam::DVec3;
use spectral_core::{
    camera::CameraRay,
    prepare::{FacetPlane, Geometry, PreparedStone},
};

/// The way into one stone, with what the last ray met.
pub(crate) struct Entry<'a> {
    geometry: &'a Geometry,
    stone: &'a PreparedStone,
    planes: &'a Planes,
    /// The facet that a ray has entered by.
    facet: usize,
    /// The planes between which a ray has passed the stone by: it was beyond the second before it was inside the first.
    apart: [usize; 2],
}

impl<'a> Entry<'a> {
    pub fn new(geometry: &'a Geometry, stone: &'a PreparedStone, planes: &'a Planes) -> Self {
        Entry { geometry, stone, planes, facet: 0, apart: [0; 2] }
    }

    /// As [`Geometry::entry`], to the last bit.
    pub fn next(&mut self, ray: &CameraRay) -> Option<(DVec3, usize)> {
        if let Some(point) = self.again(ray) {
            return Some((point, self.facet));
        }
        if self.passes(ray) {
            return None;
        }
        let span = self.geometry.span(self.stone, ray);
        let entry = span.entry(ray);
        match entry {
            Some((_, facet)) => self.facet = facet,
            None if span.first.max(span.last) < self.stone.facets.len() => {
                self.apart = [span.first, span.last]
            }
            None => {}
        }
        entry
    }

    /// Where the ray enters, if it does so by the last one's facet, and well inside it: then by no other.
    fn again(&self, ray: &CameraRay) -> Option<DVec3> {
        let (distance, towards) = self.meets(self.facet, ray);
        let point = ray.origin + ray.direction * distance;
        (towards < 0.0 && distance > 0.0 && self.planes.holds(self.facet, point.as_vec3())).then_some(point)
    }

    /// Whether the ray leaves the inside of one plane before it reaches that of the other, as the last one did.
    fn passes(&self, ray: &CameraRay) -> bool {
        let [(near, facing), (far, away)] = self.apart.map(|facet| self.meets(facet, ray));
        facing < 0.0 && away > 0.0 && near > far
    }

    /// The distance of a plane along the ray, and the cosine.
    fn meets(&self, facet: usize, ray: &CameraRay) -> (f64, f64) {
        let FacetPlane { normal, offset, .. } =
            self.geometry.facets[self.stone.facets.start as usize + facet];
        let towards = normal.dot(ray.direction);
        ((offset - normal.dot(ray.origin)) / towards, towards)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::tests::chain;
    use spectral_core::shape::ShapeSpec;

    #[test]
    fn what_the_last_ray_met_does_not_show() {
        for shape in ShapeSpec::NAMES {
            let (chain, scene) = chain(shape);
            let (geometry, stone) = (&scene.geometry, &scene.geometry.stones[0]);
            let mut entry = Entry::new(geometry, stone, chain.planes());
            let (mut entered, mut passed) = (0, 0);
            for k in 0..40_000 {
                // Along lines over the stone, as a picture's pixels are; some through its corners.
                let corner = geometry.positions[k / 100 % geometry.positions.len()];
                let eye = DVec3::new(f64::from(k as u32 % 7) - 3.0, 9.0, 14.0 + f64::from(k as u32 % 3));
                let aim = corner + DVec3::X * (k % 100) as f64 * 0.02;
                let ray = CameraRay { origin: eye, direction: (aim - eye).normalize() };
                let exact = geometry.entry(stone, &ray);
                assert_eq!(entry.next(&ray), exact, "{shape}, ray {k}");
                entered += usize::from(exact.is_some());
                passed += usize::from(exact.is_none());
            }
            assert!(entered > 1_000 && passed > 1_000, "{shape}: {entered} enter, {passed} pass");
        }
    }
}
