//! The facet planes of one convex stone, and their intersections with rays inside it.
//!
//! A ray inside a convex solid leaves through the plane that it meets first. **Search** compares all planes for one ray.
//! **Verify** tests a guessed facet for sixteen rays at a time: if a ray meets the facet's plane inside the facet's
//! polygon, the guess is right, since the polygon is part of the surface. The wavelengths of one camera ray stay close for
//! many reflections, so one search is usually enough for all of them.
//!
//! A guess is accepted only if the point is inside the polygon by a margin that covers the rounding of both methods.
//! Otherwise the ray is searched for. So the hit of a ray never depends on the guess, and the picture does not depend on the
//! grouping of rays.

mod batch;
mod search;

use accel::lanes::{Lanes, Mask, Triple, WIDTH};
use glam::Vec3;
use search::{Block, Candidate};
use spectral_core::prepare::{FacetPlane, Geometry, Outline, PreparedStone, Side};
use std::ops::Range;

pub use batch::Beam;
pub(crate) use batch::{BATCH, Travellers};

/// The number of sides that are tested at a time. Most facets have one such group, so the end of the loop is predictable.
const UNROLLED: usize = 8;

/// A facet: its plane n · x = d, and the planes around it.
#[derive(Debug, Clone)]
struct Facet {
    normal: [f32; 3],
    offset: f32,
    /// Groups of [`UNROLLED`] sides.
    around: Range<usize>,
}

/// The half-spaces whose intersection is the stone.
#[derive(Debug, Clone)]
pub(crate) struct Planes {
    facets: Vec<Facet>,
    sides: Vec<[Side; UNROLLED]>,
    /// All planes, for searches of one ray.
    blocks: Vec<Block>,
    /// All planes, for searches of sixteen rays, the largest facets first.
    candidates: Vec<Candidate>,
    /// How many of these cover most of the surface.
    large: usize,
    /// By how much the sides are moved inwards, mm.
    margin: f32,
    /// Of a sphere about the local origin that holds the stone, mm.
    radius: f32,
}

/// The exits of rays from the stone.
#[derive(Clone, Copy)]
pub(crate) struct Exit<V> {
    pub point: Triple<V>,
    /// Unit outward normal.
    pub normal: Triple<V>,
    /// Cosine between the ray and the normal, above 0.
    pub cosine: V,
    /// Length of the segment, mm; never negative.
    pub distance: V,
}

impl<V: Lanes> Exit<V> {
    /// At distance zero, without a position.
    #[inline(always)]
    pub fn nowhere() -> Self {
        let (zero, nowhere) = (V::splat(0.0), Triple::splat([0.0; 3]));
        Exit { point: nowhere, normal: nowhere, cosine: V::splat(1.0), distance: zero }
    }

    /// Copies the lanes whose bit is set; returns them.
    #[inline(always)]
    pub fn accept(&mut self, other: &Self, lanes: u16) -> u16 {
        let mask = V::Mask::from_bits(lanes);
        *self = Exit {
            point: Triple::select(mask, other.point, self.point),
            normal: Triple::select(mask, other.normal, self.normal),
            cosine: V::select(mask, other.cosine, self.cosine),
            distance: V::select(mask, other.distance, self.distance),
        };
        lanes
    }
}

impl Planes {
    /// The planes of a convex stone.
    pub fn new(geometry: &Geometry, stone: &PreparedStone) -> Self {
        let facets = &geometry.facets[stone.facets.start as usize..stone.facets.end as usize];
        let outlines = geometry.outlines(stone);
        let mut sides = Vec::new();
        let facet = |(plane, outline): (&FacetPlane, &Outline)| {
            let first = sides.len() / UNROLLED;
            sides.extend_from_slice(&outline.sides);
            // A side that has every point inside.
            let nowhere = Side { normal: [0.0; 3], offset: 1.0 };
            sides.resize(sides.len().next_multiple_of(UNROLLED), nowhere);
            let normal = plane.normal.as_vec3().to_array();
            Facet { normal, offset: plane.offset as f32, around: first..sides.len() / UNROLLED }
        };
        let bounded: Vec<Facet> = facets.iter().zip(&outlines).map(facet).collect();
        let (candidates, large) = search::candidates(geometry, stone);
        let sides = sides.as_chunks().0.to_vec();
        let margin = geometry.rounding().margin;
        let radius = geometry.radius as f32;
        Planes { blocks: search::blocks(facets), facets: bounded, sides, candidates, large, margin, radius }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.facets.len()
    }

    /// The unit outward normal of a facet.
    pub fn normal(&self, facet: usize) -> [f32; 3] {
        self.facets[facet].normal
    }

    /// The plane of a facet, n · x = d, and those around it, in groups; some of these hold every point.
    #[inline(always)]
    pub fn facet(&self, facet: usize) -> ([f32; 3], f32, &[[Side; UNROLLED]]) {
        let Facet { normal, offset, around } = &self.facets[facet];
        (*normal, *offset, &self.sides[around.clone()])
    }

    /// By how much the sides are moved inwards, mm.
    pub fn margin(&self) -> f32 {
        self.margin
    }

    /// Radius of a sphere about the local origin that holds the stone, mm.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Whether a point in a facet's plane is well inside its polygon.
    pub fn holds(&self, facet: usize, point: Vec3) -> bool {
        let groups = &self.sides[self.facets[facet].around.clone()];
        groups.as_flattened().iter().all(|side| Vec3::from(side.normal).dot(point) < side.offset)
    }

    /// The exits of the `alive` ones of sixteen rays inside the stone; other lanes have any finite values. `guesses` are
    /// facets to try first, and afterwards the last two found. [`exits`](Self::exits) is for many such packets.
    ///
    /// There is no epsilon: a ray never approaches the facet that has just reflected it, and a ray that rounding starts beyond
    /// a plane leaves through it at distance 0.
    #[inline(always)]
    pub fn exit<V: Lanes>(
        &self,
        origin: Triple<V>,
        direction: Triple<V>,
        alive: u16,
        guesses: &mut [usize; 2],
    ) -> Exit<V> {
        let mut exit = Exit { point: origin, ..Exit::nowhere() };
        let mut open = alive;
        for guess in *guesses {
            let (met, inside) = self.verify(origin, direction, guess);
            open &= !exit.accept(&met, open & inside);
            if open == 0 {
                return exit;
            }
        }
        let rows = [origin.stored(), direction.stored()];
        while open != 0 {
            // The first and the last wavelength differ most; their searches run in parallel.
            let lanes = [open.trailing_zeros(), 15 - open.leading_zeros()];
            let found = self.search::<V>(lanes.map(|lane| {
                let lane = lane as usize % WIDTH;
                rows.each_ref().map(|row| row.each_ref().map(|coordinate| coordinate.0[lane]))
            }));
            for (lane, facet) in lanes.into_iter().zip(found) {
                let (met, inside) = self.verify(origin, direction, facet);
                // The result of a search needs no verification.
                open &= !exit.accept(&met, open & (inside | 1 << lane));
                *guesses = [facet, guesses[0]];
                if open == 0 {
                    return exit;
                }
            }
        }
        exit
    }

    /// The intersections of rays with the plane of a facet, and as bits which of them are well inside its polygon.
    #[inline(always)]
    pub fn verify<V: Lanes>(&self, origin: Triple<V>, direction: Triple<V>, facet: usize) -> (Exit<V>, u16) {
        let (exit, beyond) = self.meet(origin, direction, facet);
        let inside = self.well_inside(exit.cosine, beyond);
        (exit, inside)
    }

    /// The lanes whose points are inside by enough: their error along the ray is that of the distance from the plane over the
    /// cosine, so the margin counts so many times. The sides have it once.
    #[inline(always)]
    pub fn well_inside<V: Lanes>(&self, cosine: V, beyond: V) -> u16 {
        let (margin, cosine) = (V::splat(self.margin), cosine.abs());
        beyond.fma(cosine, cosine.fnma(margin, margin)).lt(V::splat(0.0)).bits()
    }

    /// The same; instead of the bits by how much each point is beyond the nearest side, mm, which is below 0 inside. Nothing
    /// is inside for a ray that comes from the other side.
    #[inline(always)]
    pub fn meet<V: Lanes>(&self, origin: Triple<V>, direction: Triple<V>, facet: usize) -> (Exit<V>, V) {
        let Facet { normal, offset, around } = &self.facets[facet];
        let normal = Triple::splat(*normal);
        // The exit is computed without fused operations, like in the shaders: backends with equal rounding pass the edges of
        // facets on the same side after any number of reflections.
        let cosine = normal.dot_unfused(direction);
        let zero = V::splat(0.0);
        let gap = (V::splat(*offset) - normal.dot_unfused(origin)).max(zero);
        let distance = gap / cosine;
        let point = direction.scaled(distance).plus(origin);
        let mut beyond = -cosine;
        for group in &self.sides[around.clone()] {
            for side in group {
                let normal = Triple::<V>::splat(side.normal);
                let across = normal.x.fma(point.x, V::splat(-side.offset));
                beyond = beyond.max(normal.z.fma(point.z, normal.y.fma(point.y, across)));
            }
        }
        (Exit { point, normal, cosine, distance }, beyond)
    }
}
