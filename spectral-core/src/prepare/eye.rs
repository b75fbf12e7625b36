//! Where camera rays begin: a point on a surface counts as outside.
//!
//! A ray keeps the set of stones that it is in, and with it which surfaces it can cross. Of a camera on a surface, rounding
//! would decide, and every backend rounds differently. So a camera that is nearer to a surface than [`Geometry::CLEARANCE`]
//! is moved in front of it, once, in double precision, before any backend sees it.

use super::{Geometry, PreparedStone};
use crate::{Error, Warning, camera::View, mesh::proximity::distance};
use glam::DVec3;

impl Geometry {
    /// A camera nearer to a surface than this share of [`Geometry::radius`] stands on it: a thousand times what
    /// single precision may move a point, so that it does not decide which of the facets at a corner a ray meets first. Of a
    /// stone of 6.5 mm it is a micrometre.
    pub const CLEARANCE: f64 = 3.2e-4;
    /// A share of [`Geometry::radius`]. From nearer to a surface, the band along each edge in which rounding may take one facet
    /// for the other ([`Rounding::margin`](super::Rounding::margin)) is wide enough to be seen.
    pub const CLOSE: f64 = 3.2e-2;

    /// Whether rays begin at an eye that is nearer to a surface than [`Geometry::CLOSE`].
    pub(super) fn is_close(&self, view: &View) -> bool {
        view.eye().is_some_and(|eye| !self.near(eye, Self::CLOSE * self.radius).is_empty())
    }

    /// The view with its rays beginning beside surfaces, and a remark if it had to be moved.
    ///
    /// # Errors
    /// [`Error::Value`] for an eye that no short way leads away from surfaces.
    pub(super) fn clear(&self, view: View) -> Result<(View, Option<Warning>), Error> {
        if let Some(eye) = view.eye() {
            return match self.beside_surfaces(eye)? {
                Some(place) => {
                    let moved = (place - eye).length();
                    let message = format!(
                        "the camera stands on a surface, which counts as outside: its rays begin {moved:.1e} mm in front of it"
                    );
                    Ok((view.from(place), Some(Warning::new(message))))
                }
                None => Ok((view, None)),
            };
        }
        let cleared = self.before_stones(view.clone());
        let warning = (cleared != view).then(|| {
            Warning::new(
                "the camera's image plane cuts a stone: its rays begin before the stone, not within it",
            )
        });
        Ok((cleared, warning))
    }

    /// Where an eye on a surface is moved to; `None` if it is beside all.
    fn beside_surfaces(&self, eye: DVec3) -> Result<Option<DVec3>, Error> {
        let clearance = Self::CLEARANCE * self.radius;
        let near = self.near(eye, clearance);
        if near.is_empty() {
            return Ok(None);
        }
        let mut stones: Vec<u32> = near.iter().map(|&facet| self.facets[facet as usize].stone).collect();
        stones.sort_by_key(|&stone| self.stones[stone as usize].rank);
        stones.dedup();
        let all = stones.clone();
        // Between stones that touch there is no place outside of all: then the one of the highest rank is left.
        for leave in std::iter::once(all.as_slice()).chain(all.chunks(1).rev()) {
            let normals = near.iter().map(|&facet| &self.facets[facet as usize]);
            let away: DVec3 =
                normals.filter(|facet| leave.contains(&facet.stone)).map(|facet| facet.normal).sum();
            let outside = |place: DVec3| {
                let winding = |&stone: &u32| self.winding(&self.stones[stone as usize], place);
                leave.iter().all(|stone| winding(stone) < 0.5) && self.near(place, 0.5 * clearance).is_empty()
            };
            let steps = (0..6).map(|k| eye + away.normalize_or_zero() * (clearance * f64::from(1 << k)));
            if let Some(place) = steps.into_iter().find(|&place| outside(place)) {
                return Ok(Some(place));
            }
        }
        let expected = "surfaces meet here so that no side of them is in front; move the camera a little";
        Err(Error::value("camera.position", eye + self.origin, expected))
    }

    /// The facets within `reach` of a point, each once.
    fn near(&self, point: DVec3, reach: f64) -> Vec<u32> {
        let in_box =
            |stone: &&PreparedStone| (stone.low - point).max(point - stone.high).max_element() <= reach;
        let triangles = self.stones.iter().filter(in_box).flat_map(|stone| stone.triangles.clone());
        let is_near = |t: &u32| {
            let corners = self.triangles[*t as usize].map(|v| self.positions[v as usize]);
            distance(point, &corners) <= reach
        };
        let mut facets: Vec<u32> = triangles.filter(is_near).map(|t| self.facet_of[t as usize]).collect();
        facets.sort_unstable();
        facets.dedup();
        facets
    }

    /// Parallel rays moved back until their image plane cuts no stone within the picture.
    fn before_stones(&self, mut view: View) -> View {
        let clearance = Self::CLEARANCE * self.radius;
        // Each step passes a stone at least.
        for _ in 0..self.stones.len() {
            let Some((origin, forward)) = view.plane() else { return view };
            let cut = self.stones.iter().filter_map(|stone| {
                let corners = (0..8).map(|k| {
                    DVec3::select(glam::BVec3::new(k & 1 > 0, k & 2 > 0, k & 4 > 0), stone.low, stone.high)
                });
                straddles(&view, corners, clearance)?;
                let vertices = self.triangles_of(stone).iter().flatten().map(|&v| self.positions[v as usize]);
                straddles(&view, vertices, clearance)
            });
            let nearest = cut.fold(f64::INFINITY, f64::min);
            if nearest == f64::INFINITY {
                return view;
            }
            view = view.from(origin + forward * (nearest - 2.0 * clearance));
        }
        view
    }
}

/// The least distance of points before the image plane, if there are some on both sides of it and they may be in the picture.
fn straddles(view: &View, points: impl Iterator<Item = DVec3>, clearance: f64) -> Option<f64> {
    let seen = points.map(|point| view.on_plane(point));
    let (low, high) = seen.map(|p| (p, p)).reduce(|(low, high), (p, _)| (low.min(p), high.max(p)))?;
    let in_picture = low.truncate().max_element() <= 1.0 && high.truncate().min_element() >= -1.0;
    (in_picture && low.z < clearance && high.z > -clearance).then_some(low.z)
}
