//! What bounds the polygon of each facet of a convex stone, for backends that guess a facet and verify the guess.
//!
//! Where a ray inside a convex solid meets the plane of a facet inside that facet's polygon, it leaves there: the
//! polygon is part of the surface. So one facet can be accepted without a test of the others. It is accepted only where
//! the point is inside every side by [`Rounding::margin`](super::Rounding::margin), which covers the rounding of this
//! test and of a search through all planes. So an accepted facet is the one that a search finds.

use super::{Geometry, PreparedStone};
use std::collections::HashMap;

/// A plane n · x = d that bounds a facet's polygon, moved inwards by the margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// Unit, away from the polygon.
    pub normal: [f32; 3],
    /// mm from the local origin along the normal.
    pub offset: f32,
}

/// What bounds the polygon of one facet.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outline {
    /// The facets around it, counted from the stone's first, in ascending order.
    pub around: Vec<u32>,
    /// Their planes, moved inwards.
    pub sides: Vec<Side>,
}

impl Outline {
    /// Cosine of the angle below which two planes are nearly parallel.
    const NEARLY_PARALLEL: f64 = 0.98;
}

impl Geometry {
    /// The outlines of a convex stone's facets, counted from its first.
    ///
    /// A facet is bounded by those that it shares an edge with, and, so that a margin on the former holds for the latter
    /// too, by those that it shares only a corner with and that are nearly parallel to it.
    ///
    /// ```
    /// use spectral_core::{material::Catalogue, prepare::PreparedScene, scene::{Scene, Stone}};
    /// use spectral_core::{settings::RenderSettings, shape::ShapeSpec};
    /// use std::sync::Arc;
    ///
    /// let cut = ShapeSpec::by_name("round-brilliant")?.cut()?;
    /// let diamond = Arc::new(Catalogue::builtin().get("diamond")?.clone());
    /// let stone = Stone::new("brilliant", Arc::new(cut.solid()?.0), diamond);
    /// let scene = PreparedScene::new(&Scene::in_studio(vec![stone]), &RenderSettings::default())?;
    /// let outlines = scene.geometry.outlines(&scene.geometry.stones[0]);
    /// assert_eq!(outlines.len(), scene.geometry.facets.len());
    /// assert!(outlines.iter().all(|outline| outline.sides.len() >= 3));
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn outlines(&self, stone: &PreparedStone) -> Vec<Outline> {
        let margin = self.rounding().margin;
        let facets = self.facets_of(stone);
        let side = |facet: &u32| {
            let plane = &facets[*facet as usize];
            Side { normal: plane.normal.as_vec3().to_array(), offset: plane.offset as f32 - margin }
        };
        let outline = |around: Vec<u32>| Outline { sides: around.iter().map(side).collect(), around };
        self.adjacent(stone).into_iter().map(outline).collect()
    }

    /// For each facet of a stone, in ascending order, the facets that bound its polygon.
    fn adjacent(&self, stone: &PreparedStone) -> Vec<Vec<u32>> {
        let facets = self.facets_of(stone);
        let mut corners: HashMap<u32, Vec<u32>> = HashMap::new();
        let mut edges = HashMap::new();
        for t in stone.triangles.start as usize..stone.triangles.end as usize {
            let (triangle, facet) = (self.triangles[t], self.facet_of[t] - stone.facets.start);
            for k in 0..3 {
                edges.insert((triangle[k], triangle[(k + 1) % 3]), facet);
                corners.entry(triangle[k]).or_default().push(facet);
            }
        }
        let mut adjacent = vec![Vec::new(); facets.len()];
        for (&(from, to), &facet) in &edges {
            adjacent[facet as usize].extend(edges.get(&(to, from)));
        }
        for around in corners.values() {
            for &facet in around {
                let normal = facets[facet as usize].normal;
                let parallel = |j: &&u32| facets[**j as usize].normal.dot(normal) > Outline::NEARLY_PARALLEL;
                adjacent[facet as usize].extend(around.iter().filter(parallel));
            }
        }
        for (facet, list) in adjacent.iter_mut().enumerate() {
            list.sort_unstable();
            list.dedup();
            list.retain(|&j| j as usize != facet);
        }
        adjacent
    }
}
