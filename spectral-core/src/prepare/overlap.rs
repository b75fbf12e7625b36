//! How many stones lie over one point: more than a [`Nest`] holds are refused.
//!
//! Space is halved until at most as many stones reach into a box as may overlap, or a point is found in more. Convex
//! stones are known by their planes, moved inwards by what counts as contact, so that stones that only touch are apart.
//! Where few enough convex stones are left, the intersection of every choice of them decides.

use super::{Geometry, Nest, PreparedStone};
use crate::{
    Error,
    mesh::{Facet, Mesh, Plane},
};
use glam::DVec3;

/// Of more stones than these a box is halved before their planes are asked.
const FEW: usize = 64;
/// Of at most so many convex stones every choice is intersected.
const CHOSEN: usize = 9;
/// Boxes smaller than this share of the radius are not halved.
const SMALLEST: f64 = 1e-4;
/// Planes and triangles that are asked, a second's work: stones of very many triangles that come so near each other are
/// not searched to the end.
const MOST_WORK: usize = 100_000_000;
/// What a triangle takes, in planes.
const TRIANGLE: usize = 8;

/// An axis-aligned box: its middle and half its size.
#[derive(Clone, Copy)]
struct Cell {
    middle: DVec3,
    half: DVec3,
}

struct Search<'a> {
    geometry: &'a Geometry,
    /// How far inside a point counts as inside, mm.
    depth: f64,
    /// Planes asked so far.
    work: usize,
}

impl Geometry {
    /// Refuses stones of which more than [`Nest::CAPACITY`] lie over one point.
    ///
    /// # Errors
    /// [`Error::Value`] that names the stones and the point.
    pub(super) fn check_overlaps(&self) -> Result<(), Error> {
        if self.stones.len() <= Nest::CAPACITY {
            return Ok(());
        }
        let low = self.stones.iter().fold(DVec3::INFINITY, |low, stone| low.min(stone.low));
        let high = self.stones.iter().fold(DVec3::NEG_INFINITY, |high, stone| high.max(stone.high));
        let cell = Cell { middle: (low + high) / 2.0, half: (high - low) / 2.0 };
        let mut search = Search { geometry: self, depth: Self::CONTACT * self.radius, work: 0 };
        let all = (0..self.stones.len() as u32).collect();
        let Some((point, over)) = search.within(cell, all) else { return Ok(()) };
        let mut names: Vec<&str> = over.iter().map(|&k| self.stones[k as usize].name.as_str()).collect();
        names.dedup();
        let listed = names[..names.len().min(Nest::CAPACITY + 1)].join(", ");
        let DVec3 { x, y, z } = point + self.origin;
        let value = format!("{} over the point ({x:.4}, {y:.4}, {z:.4}) mm", over.len());
        let most = Nest::CAPACITY;
        let expected = format!("at most {most} may overlap at one point, but these do: {listed}");
        Err(Error::value("stones", value, expected))
    }
}

impl Search<'_> {
    /// A point of the cell that lies in too many of the stones, with those that it lies in.
    fn within(&mut self, cell: Cell, mut stones: Vec<u32>) -> Option<(DVec3, Vec<u32>)> {
        stones.retain(|&k| self.in_box(self.stone(k), cell));
        if stones.len() <= FEW {
            stones.retain(|&k| self.reaches(self.stone(k), cell));
        }
        if stones.len() <= Nest::CAPACITY || self.work > MOST_WORK {
            return None;
        }
        self.work += stones.iter().take(FEW).map(|&k| effort(self.stone(k))).sum::<usize>();
        let over = self.over(cell.middle, &stones);
        if over.len() > Nest::CAPACITY {
            return Some((cell.middle, over));
        }
        if stones.len() <= CHOSEN && stones.iter().all(|&k| self.stone(k).has_few_planes()) {
            return self.any_common(&stones);
        }
        if cell.half.max_element() < SMALLEST * self.geometry.radius {
            return None;
        }
        let axis = cell.half.max_position();
        let mut half = cell.half;
        half[axis] /= 2.0;
        let step = DVec3::AXES[axis] * half[axis];
        let parts = [cell.middle - step, cell.middle + step];
        parts.into_iter().find_map(|middle| self.within(Cell { middle, half }, stones.clone()))
    }

    fn stone(&self, k: u32) -> &PreparedStone {
        &self.geometry.stones[k as usize]
    }

    fn in_box(&self, stone: &PreparedStone, cell: Cell) -> bool {
        let (low, high) = (cell.middle - cell.half, cell.middle + cell.half);
        (stone.low - high).max(low - stone.high).max_element() < -self.depth
    }

    /// Whether no plane of a convex stone has the cell before it. Others may reach anywhere within their boxes.
    fn reaches(&self, stone: &PreparedStone, cell: Cell) -> bool {
        !stone.has_few_planes()
            || self.geometry.facets_of(stone).iter().all(|facet| {
                let nearest = facet.normal.dot(cell.middle) - facet.normal.abs().dot(cell.half);
                nearest < facet.offset - self.depth
            })
    }

    /// The first few of the stones that hold a point.
    fn over(&self, point: DVec3, stones: &[u32]) -> Vec<u32> {
        let holds = |stone: &PreparedStone| {
            if stone.has_few_planes() {
                let facets = self.geometry.facets_of(stone);
                return facets.iter().all(|facet| facet.normal.dot(point) < facet.offset - self.depth);
            }
            self.geometry.winding(stone, point) > 0.5
        };
        stones.iter().copied().take(FEW).filter(|&k| holds(self.stone(k))).collect()
    }

    /// A point that lies in too many of a few convex stones.
    fn any_common(&self, stones: &[u32]) -> Option<(DVec3, Vec<u32>)> {
        (0_u32..1 << stones.len()).filter(|set| set.count_ones() as usize == Nest::CAPACITY + 1).find_map(
            |set| {
                let chosen: Vec<u32> =
                    (0..stones.len()).filter(|k| set >> k & 1 == 1).map(|k| stones[k]).collect();
                let low = chosen.iter().fold(DVec3::NEG_INFINITY, |low, &k| low.max(self.stone(k).low));
                let high = chosen.iter().fold(DVec3::INFINITY, |high, &k| high.min(self.stone(k).high));
                if (high - low).min_element() <= 2.0 * self.depth {
                    return None;
                }
                let facets = chosen.iter().flat_map(|&k| self.geometry.facets_of(self.stone(k)));
                let facet = |plane: &super::FacetPlane| Facet {
                    plane: Plane { normal: plane.normal, offset: plane.offset - self.depth },
                    name: None,
                };
                let (common, _) = Mesh::from_half_spaces(&facets.map(facet).collect::<Vec<_>>()).ok()?;
                let corners = common.positions();
                let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
                Some((middle, chosen))
            },
        )
    }
}

/// What it takes to find whether a point lies in a stone.
fn effort(stone: &PreparedStone) -> usize {
    if stone.has_few_planes() { stone.facets.len() } else { TRIANGLE * stone.triangles.len() }
}
