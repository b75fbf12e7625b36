//! Which facets may be in optical contact with another stone.

use super::{FacetPlane, Geometry, PreparedStone, Rounding};

/// At most so many pairs of a facet and a triangle are looked at; the facets of the rest count as touched.
const MOST_PAIRS: usize = 10_000_000;

impl Geometry {
    /// By facet: whether a face of another stone may be in contact with it. Who crosses another facet need not look for
    /// faces in contact.
    ///
    /// Faces in contact are nearly parallel and cross their facet's plane, within [`Rounding::contact`] along its normal.
    /// How far apart they are along the plane does not count: a grazing ray finds them far away.
    pub fn touched_facets(&self) -> Vec<bool> {
        if !self.contacts {
            return vec![false; self.facets.len()];
        }
        let reach = 4.0 * f64::from(self.rounding().contact);
        let mut pairs = 0;
        let touched = |(index, facet): (usize, &FacetPlane)| {
            let others = self.stones.iter().enumerate().filter(|(other, _)| *other != facet.stone as usize);
            let near = others.filter(|(_, other)| crosses_box(facet, other, reach));
            near.map(|(_, other)| other).any(|other| {
                pairs += other.triangles.len();
                pairs > MOST_PAIRS || self.touches(index, other, reach)
            })
        };
        self.facets.iter().enumerate().map(touched).collect()
    }

    fn touches(&self, facet: usize, other: &PreparedStone, reach: f64) -> bool {
        let FacetPlane { normal, offset, .. } = self.facets[facet];
        // Less than the cosine that is asked for in single precision.
        let parallel = 2.0 * f64::from(Rounding::PARALLEL) - 1.0;
        let beside = |corner: u32| normal.dot(self.positions[corner as usize]) - offset;
        other.triangles.clone().any(|triangle| {
            let plane = &self.facets[self.facet_of[triangle as usize] as usize];
            plane.normal.dot(normal).abs() > parallel && {
                let sides = self.triangles[triangle as usize].map(beside);
                sides.iter().any(|side| *side <= reach) && sides.iter().any(|side| *side >= -reach)
            }
        })
    }
}

/// Whether a facet's plane comes within `reach` of a stone's box.
fn crosses_box(facet: &FacetPlane, stone: &PreparedStone, reach: f64) -> bool {
    let (middle, half) = ((stone.low + stone.high) / 2.0, (stone.high - stone.low) / 2.0);
    (facet.normal.dot(middle) - facet.offset).abs() <= facet.normal.abs().dot(half) + reach
}

#[cfg(test)]
mod tests {
    use crate::{material::Catalogue, prepare::Geometry, scene::Stone, shape::ShapeSpec};
    use std::sync::Arc;

    /// A step cut and another of its kind this far above its table.
    fn touched(gap: f64, tilt: f64) -> usize {
        let (mesh, _) = ShapeSpec::by_name("step").unwrap().cut().unwrap().solid().unwrap();
        let material = Arc::new(Catalogue::builtin().get("quartz").unwrap().clone());
        let below = Stone::new("below", Arc::new(mesh), material);
        let table = Geometry::new(std::slice::from_ref(&below)).unwrap();
        let height = table.stones[0].high.z - table.stones[0].low.z;
        let mut above = Stone { name: "above".into(), ..below.clone() };
        // Upside down, table on table; turned, so that no side lies in the plane of another.
        above.rotation.x = 180.0 + tilt;
        above.rotation.z = 7.0;
        above.position.z += 2.0 * (table.origin.z + table.stones[0].high.z) + gap * height;
        let geometry = Geometry::new(&[below, above]).unwrap();
        geometry.touched_facets().into_iter().filter(|touched| *touched).count()
    }

    #[test]
    fn tables_that_lie_on_each_other_are_touched_and_nothing_else() {
        assert_eq!(touched(0.0, 0.0), 2);
        assert_eq!(touched(1e-6, 0.0), 2);
        assert_eq!(touched(1e-3, 0.0), 0);
        assert_eq!(touched(0.0, 10.0), 0);
    }
}
