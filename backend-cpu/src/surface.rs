//! The scene's surfaces in single precision: which one a ray crosses next, and between which media.
//!
//! A ray knows the stones it is in ([`Nest`]). It can only enter a stone it is outside of and leave one it is inside of;
//! other candidates, such as the surface it starts on or a touching stone's face, are ignored. What remains of
//! self-intersection is handled by an error bound, not by an offset: rounding puts the start at most
//! [`Rounding::margin`] beyond a plane, so hits up to that far behind the start count. Beside an edge that a ray runs away from
//! this is wrong: the other facet lies behind the start without any rounding. It shows in close-ups, so there it is looked for.

use accel::lanes::{Lanes, Row, Triple, WIDTH};
use accel::packet::{Accept, Pending, Rays};
use accel::{Bvh, Hit, Ray};
use glam::Vec3;
use spectral_core::{
    Error,
    prepare::{FacetPlane, Nest, PreparedScene, Rank, Rounding},
};

/// A facet plane in single precision.
#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: Vec3,
    offset: f32,
    rank: Rank,
    /// Whether another stone's face may be in contact with it.
    touched: bool,
}

/// The next optical surface on a ray: media differ before and after it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    /// mm along the ray; never negative.
    pub distance: f32,
    /// Unit normal on the side the ray comes from.
    pub normal: Vec3,
    /// The stones the ray is in as it arrives.
    pub before: Nest,
    /// The stones it is in if it goes through.
    pub after: Nest,
}

/// All stones' surfaces behind one SBVH.
#[derive(Debug)]
pub(crate) struct Surfaces {
    bvh: Bvh,
    facet_of: Vec<u32>,
    planes: Vec<Plane>,
    material_of_rank: Vec<u32>,
    rounding: Rounding,
    /// Of a close-up: see [`PreparedScene::close_up`].
    pub close_up: bool,
}

impl Surfaces {
    pub fn new(scene: &PreparedScene) -> Result<Self, Error> {
        let geometry = &scene.geometry;
        let positions: Vec<Vec3> = geometry.positions.iter().map(|p| p.as_vec3()).collect();
        let bvh = Bvh::build(&positions, &geometry.triangles, &accel::BuildOptions::default())
            .map_err(|e| Error::Device { device: "cpu".into(), message: e.to_string() })?;
        let plane = |(f, touched): (&FacetPlane, bool)| Plane {
            normal: f.normal.as_vec3(),
            offset: f.offset as f32,
            rank: geometry.stones[f.stone as usize].rank,
            touched,
        };
        Ok(Surfaces {
            bvh,
            facet_of: geometry.facet_of.clone(),
            planes: geometry.facets.iter().zip(geometry.touched_facets()).map(plane).collect(),
            material_of_rank: geometry.material_of_rank(),
            rounding: geometry.rounding(),
            close_up: scene.close_up,
        })
    }

    /// Index of the material of the stone of a rank.
    #[inline]
    pub fn material(&self, rank: Rank) -> usize {
        self.material_of_rank[rank as usize] as usize
    }

    /// The next optical interface along a ray, or `None` if it meets no more.
    pub fn next(&self, origin: Vec3, direction: Vec3, nest: Nest) -> Option<Crossing> {
        let (mut at, mut travelled, mut nest) = (origin, 0.0, nest);
        for _ in 0..Rounding::MOST_CROSSINGS {
            let crossing = self.nearest(at, direction, nest)?;
            let same = self.optics(crossing.before) == self.optics(crossing.after);
            if !same {
                return Some(Crossing { distance: travelled + crossing.distance, ..crossing });
            }
            travelled += crossing.distance;
            at = origin + direction * travelled;
            nest = crossing.after;
        }
        None
    }

    /// [`next`](Self::next) for the lanes that are set, all in the same stones; `None` for those that meet no more.
    #[inline(always)]
    pub fn next_of_packet<V: Lanes>(
        &self,
        origin: Triple<V>,
        direction: Triple<V>,
        nest: Nest,
        lanes: u16,
        pending: &mut Pending<V>,
    ) -> [Option<Crossing>; WIDTH] {
        let passable = Passable { surfaces: self, origin, direction, nest };
        let rays = Rays { origin, direction, t_min: -self.rounding.behind, lanes };
        let hits = self.bvh.closest_of_packet(&rays, &passable, pending);
        let (origins, directions) = (origin.stored(), direction.stored());
        let mut crossings = [None; WIDTH];
        let mut toggled = (Rank::MAX, nest);
        let mut open = lanes;
        while open != 0 {
            let lane = open.trailing_zeros() as usize;
            open &= open - 1;
            let vector = |rows: &[Row; 3]| Vec3::new(rows[0].0[lane], rows[1].0[lane], rows[2].0[lane]);
            let (origin, direction) = (vector(&origins), vector(&directions));
            if hits.lanes >> lane & 1 == 0 {
                if !nest.is_empty() {
                    crossings[lane] = self.next(origin, direction, nest);
                }
                continue;
            }
            let (triangle, t) = (hits.triangle[lane], hits.t.0[lane]);
            let plane = &self.planes[self.facet_of[triangle as usize] as usize];
            // Perhaps beside an edge.
            if self.close_up && t <= 0.0 && !nest.contains(plane.rank) {
                crossings[lane] = self.next(origin, direction, nest);
                continue;
            }
            if toggled.0 != plane.rank {
                toggled = (plane.rank, nest.toggled(plane.rank));
            }
            let distance = self.distance(plane, t, origin, direction);
            let after = if plane.touched {
                self.with_contacts(origin, direction, distance, plane, nest)
            } else {
                toggled.1
            };
            crossings[lane] = if self.optics(nest) == self.optics(after) {
                self.next(origin, direction, nest)
            } else {
                let normal = if plane.normal.dot(direction) > 0.0 { -plane.normal } else { plane.normal };
                Some(Crossing { distance, normal, before: nest, after })
            };
        }
        crossings
    }

    /// The material that fills the space; none for air.
    #[inline]
    fn optics(&self, nest: Nest) -> Option<u32> {
        nest.top().map(|rank| self.material_of_rank[rank as usize])
    }

    /// The nearest surface that the ray can cross, with all that are in contact with it.
    fn nearest(&self, origin: Vec3, direction: Vec3, nest: Nest) -> Option<Crossing> {
        let hit = self.cast(origin, direction, nest).or_else(|| self.rescue(origin, direction, nest))?;
        let plane = *self.plane(&hit);
        let distance = self.distance(&plane, hit.t, origin, direction);
        let after = self.with_contacts(origin, direction, distance, &plane, nest);
        let normal = if plane.normal.dot(direction) > 0.0 { -plane.normal } else { plane.normal };
        Some(Crossing { distance, normal, before: nest, after })
    }

    /// The nearest triangle whose surface the ray can cross.
    #[inline]
    fn cast(&self, origin: Vec3, direction: Vec3, nest: Nest) -> Option<Hit> {
        let hit = self.closest(origin, direction, nest, -self.rounding.behind)?;
        if self.close_up && hit.t <= 0.0 && self.is_left_at_start(origin, direction, nest, &hit) {
            return self.closest(origin, direction, nest, f32::MIN_POSITIVE);
        }
        Some(hit)
    }

    /// Whether a surface behind the start enters a stone that the ray leaves again where it starts. So it is beside an
    /// edge: the ray comes from one of its facets and runs away from both.
    #[cold]
    fn is_left_at_start(&self, origin: Vec3, direction: Vec3, nest: Nest, entry: &Hit) -> bool {
        let rank = self.plane(entry).rank;
        let ray = Ray { origin, direction, t_min: entry.t, t_max: self.rounding.behind };
        let exit = |hit: &Hit| {
            let plane = self.plane(hit);
            let gap = plane.offset - plane.normal.dot(origin);
            plane.rank == rank && plane.normal.dot(direction) > 0.0 && gap.abs() <= self.rounding.margin
        };
        !nest.contains(rank) && self.bvh.closest(&ray, exit).is_some()
    }

    /// The nearest triangle from `t_min` on.
    #[inline]
    fn closest(&self, origin: Vec3, direction: Vec3, nest: Nest, t_min: f32) -> Option<Hit> {
        let ray = Ray { origin, direction, t_min, t_max: f32::INFINITY };
        self.bvh.closest(&ray, |hit| {
            let plane = self.plane(hit);
            let leaving = plane.normal.dot(direction) > 0.0;
            let gap = plane.offset - plane.normal.dot(origin);
            let ahead = if leaving { gap } else { -gap };
            leaving == nest.contains(plane.rank) && ahead >= -self.rounding.margin
        })
    }

    /// A ray inside a stone always meets a surface, but one reflected within rounding of an edge can start
    /// outside and run past the corner. From a point a few margins to the side it does meet the face it
    /// should leave by; about one segment in 10⁷ needs this.
    #[cold]
    fn rescue(&self, origin: Vec3, direction: Vec3, nest: Nest) -> Option<Hit> {
        if nest.is_empty() {
            return None;
        }
        let sides = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        Rounding::RESCUE.into_iter().find_map(|step| {
            sides
                .iter()
                .find_map(|&side| self.cast(origin + side * (step * self.rounding.margin), direction, nest))
        })
    }

    /// Distance to the exact plane; the triangle's own where the ray is too nearly parallel to say.
    fn distance(&self, plane: &Plane, t: f32, origin: Vec3, direction: Vec3) -> f32 {
        let towards = plane.normal.dot(direction);
        let exact = (plane.offset - plane.normal.dot(origin)) / towards;
        let slack = self.rounding.margin / towards.abs().max(Rounding::GRAZING);
        (if (exact - t).abs() <= slack { exact } else { t }).max(0.0)
    }

    /// The nest after crossing `first` and every face of another stone that lies on it.
    fn with_contacts(&self, origin: Vec3, direction: Vec3, distance: f32, first: &Plane, nest: Nest) -> Nest {
        let mut after = nest.toggled(first.rank);
        if !first.touched {
            return after;
        }
        let towards = first.normal.dot(direction).abs().max(Rounding::GRAZING);
        let window = self.rounding.contact / towards;
        let ray = Ray { origin, direction, t_min: distance - window, t_max: distance + window };
        let mut crossed = Nest::default().toggled(first.rank);
        for _ in 1..Nest::CAPACITY {
            let contact = self.bvh.closest(&ray, |hit| {
                let plane = self.plane(hit);
                let leaving = plane.normal.dot(direction) > 0.0;
                !crossed.contains(plane.rank)
                    && leaving == after.contains(plane.rank)
                    && plane.normal.dot(first.normal).abs() > Rounding::PARALLEL
            });
            let Some(hit) = contact else { break };
            let rank = self.plane(&hit).rank;
            crossed = crossed.toggled(rank);
            after = after.toggled(rank);
        }
        after
    }

    #[inline]
    fn plane(&self, hit: &Hit) -> &Plane {
        &self.planes[self.facet_of[hit.triangle as usize] as usize]
    }
}

/// Accepts the surfaces that rays with a nest can cross: from inside those of stones they are in, from outside those of
/// others, and only ahead of their starts, within rounding.
struct Passable<'a, V> {
    surfaces: &'a Surfaces,
    origin: Triple<V>,
    direction: Triple<V>,
    nest: Nest,
}

impl<V: Lanes> Accept<V> for Passable<'_, V> {
    #[inline(always)]
    fn accept(&self, triangle: u32, hit: V::Mask) -> V::Mask {
        let surfaces = self.surfaces;
        let plane = &surfaces.planes[surfaces.facet_of[triangle as usize] as usize];
        let normal = Triple::splat(plane.normal.to_array());
        let leaving = V::splat(0.0).lt(normal.dot(self.direction));
        let gap = V::splat(plane.offset) - normal.dot(self.origin);
        let margin = V::splat(-surfaces.rounding.margin);
        if self.nest.contains(plane.rank) {
            hit & leaving & !gap.lt(margin)
        } else {
            hit & !leaving & !(-gap).lt(margin)
        }
    }
}
