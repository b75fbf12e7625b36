//! The facet planes of one convex stone, and where rays inside it meet them.
//!
//! A ray inside a convex solid leaves through the plane that it meets first. **Search** compares all planes for
//! one ray, sixteen planes at a time. **Verify** takes a facet that may be the one for sixteen rays at a time: if
//! a ray meets the facet's plane inside the facet's polygon, it is the one, since the polygon is part of the
//! solid's surface. Wavelengths of one camera ray stay together for many reflections, so one search mostly serves
//! them all.
//!
//! A guess is believed only where the point is inside the polygon by a margin that covers the rounding of both
//! ways. Elsewhere the ray is searched for. So what a ray meets never depends on who guessed, and the picture not
//! on how rays were grouped.

use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH};
use spectral_core::prepare::{FacetPlane, Geometry, PreparedStone};
use std::collections::HashMap;
use std::ops::Range;

/// The sides of a facet are tested so many at a time: few facets have as many as two groups, so the processor
/// mostly guesses right where the loop ends.
const UNROLLED: usize = 4;

/// Sixteen facet planes, one row a coordinate.
#[derive(Debug, Clone, Copy)]
struct Block {
    normal: [Row; 3],
    offset: Row,
}

/// A facet: its plane n · x = d, and the planes around it.
#[derive(Debug, Clone)]
struct Facet {
    normal: [f32; 3],
    offset: f32,
    /// In groups of [`UNROLLED`].
    around: Range<usize>,
}

/// A plane, n and d, moved inwards by the margin.
#[derive(Debug, Clone, Copy)]
struct Side {
    normal: [f32; 3],
    offset: f32,
}

/// The half-spaces whose intersection is the stone.
#[derive(Debug, Clone)]
pub(crate) struct Planes {
    blocks: Vec<Block>,
    facets: Vec<Facet>,
    sides: Vec<[Side; UNROLLED]>,
}

/// Where rays inside the stone meet its surface.
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
    /// Takes over the lanes whose bit is set; returns them.
    #[inline(always)]
    fn accept(&mut self, other: &Self, lanes: u16) -> u16 {
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
        let margin = geometry.rounding().margin;
        let facets = &geometry.facets[stone.facets.start as usize..stone.facets.end as usize];
        let adjacent = adjacent(geometry, stone);
        let mut sides = Vec::new();
        let facet = |(plane, around): (&FacetPlane, &Vec<usize>)| {
            let first = sides.len() / UNROLLED;
            sides.extend(around.iter().map(|&j| Side {
                normal: facets[j].normal.as_vec3().to_array(),
                offset: facets[j].offset as f32 - margin,
            }));
            // A side that every point is inside of.
            let nowhere = Side { normal: [0.0; 3], offset: 1.0 };
            sides.resize(sides.len().next_multiple_of(UNROLLED), nowhere);
            let normal = plane.normal.as_vec3().to_array();
            Facet { normal, offset: plane.offset as f32, around: first..sides.len() / UNROLLED }
        };
        let facets_around: Vec<Facet> = facets.iter().zip(&adjacent).map(facet).collect();
        let sides = sides.as_chunks().0.to_vec();
        Planes { blocks: blocks(facets), facets: facets_around, sides }
    }

    /// The unit outward normal of a facet.
    pub fn normal(&self, facet: usize) -> [f32; 3] {
        self.facets[facet].normal
    }

    /// Where rays inside the stone that are `alive` leave it; other lanes hold any finite values. `guess` is a
    /// facet to try first, and afterwards the last one met.
    ///
    /// No epsilon: a ray never runs towards the facet it has just been reflected by, and a start that rounding
    /// put beyond a plane leaves through it at distance 0.
    #[inline(always)]
    pub fn exits<V: Lanes>(
        &self,
        origin: Triple<V>,
        direction: Triple<V>,
        alive: u16,
        guess: &mut usize,
    ) -> Exit<V> {
        let zero = V::splat(0.0);
        let nowhere = Triple { x: zero, y: zero, z: zero };
        let mut exit = Exit { point: origin, normal: nowhere, cosine: V::splat(1.0), distance: zero };
        let mut open = alive;
        let (met, inside) = self.verify(origin, direction, *guess);
        open &= !exit.accept(&met, open & inside);
        if open == 0 {
            return exit;
        }
        let rows = [origin.stored(), direction.stored()];
        while open != 0 {
            // The first and the last wavelength differ most; their searches run side by side.
            let lanes = [open.trailing_zeros(), 15 - open.leading_zeros()];
            let found = self.search::<V>(lanes.map(|lane| {
                let lane = lane as usize % WIDTH;
                rows.each_ref().map(|row| row.each_ref().map(|coordinate| coordinate.0[lane]))
            }));
            for (lane, facet) in lanes.into_iter().zip(found) {
                let (met, inside) = self.verify(origin, direction, facet);
                // What a search has found needs no second opinion.
                open &= !exit.accept(&met, open & (inside | 1 << lane));
                *guess = facet;
                if open == 0 {
                    return exit;
                }
            }
        }
        exit
    }

    /// Where rays meet the plane of a facet, and, as bits, which of them do so well inside its polygon.
    #[inline(always)]
    fn verify<V: Lanes>(&self, origin: Triple<V>, direction: Triple<V>, facet: usize) -> (Exit<V>, u16) {
        let Facet { normal, offset, around } = &self.facets[facet];
        let normal = Triple::splat(*normal);
        // What becomes of the ray is computed unfused, as the shaders do it: two backends that round alike pass the
        // edges of facets on the same side, after however many reflections.
        let cosine = normal.dot_unfused(direction);
        let zero = V::splat(0.0);
        let gap = (V::splat(*offset) - normal.dot_unfused(origin)).max(zero);
        let distance = gap / cosine;
        let point = direction.scaled(distance).plus(origin);
        let mut inside = zero.lt(cosine);
        for group in &self.sides[around.clone()] {
            for side in group {
                let [x, y, z] = side.normal;
                let beyond = V::splat(z)
                    .fma(point.z, V::splat(y).fma(point.y, V::splat(x).fma(point.x, V::splat(-side.offset))));
                inside = inside & beyond.lt(zero);
            }
        }
        (Exit { point, normal, cosine, distance }, inside.bits())
    }

    /// The facets whose planes two rays from inside (origin, direction) meet first. Each is a pure function of its
    /// ray.
    #[inline(always)]
    fn search<V: Lanes>(&self, rays: [[[f32; 3]; 2]; 2]) -> [usize; 2] {
        let [first, second] = rays;
        let (mut first, mut second) = (Search::<V>::new(first), Search::<V>::new(second));
        let mut number = 0.0;
        for block in &self.blocks {
            first.compare(block, number);
            second.compare(block, number);
            number += 1.0;
        }
        // Only a direction that is no number runs towards no plane.
        let sound = |facet: usize| if facet < self.facets.len() { facet } else { 0 };
        [sound(first.nearest()), sound(second.nearest())]
    }
}

/// The nearest plane to one ray, so far: in each lane one of those that it has been compared with.
#[derive(Clone, Copy)]
struct Search<V> {
    origin: Triple<V>,
    direction: Triple<V>,
    /// The plane is gap/cosine away: compared without division, and at first infinitely far.
    gap: V,
    cosine: V,
    block: V,
}

impl<V: Lanes> Search<V> {
    #[inline(always)]
    fn new([origin, direction]: [[f32; 3]; 2]) -> Self {
        let (origin, direction) = (Triple::splat(origin), Triple::splat(direction));
        Search { origin, direction, gap: V::splat(1.0), cosine: V::splat(0.0), block: V::splat(0.0) }
    }

    #[inline(always)]
    fn compare(&mut self, block: &Block, number: f32) {
        let normal = Triple::<V>::load(&block.normal);
        let cosine = normal.dot(self.direction);
        let gap = (V::load(&block.offset) - normal.dot(self.origin)).max(V::splat(0.0));
        let nearer = (gap * self.cosine).lt(self.gap * cosine);
        self.gap = V::select(nearer, gap, self.gap);
        self.cosine = V::select(nearer, cosine, self.cosine);
        self.block = V::select(nearer, V::splat(number), self.block);
    }

    #[inline(always)]
    fn nearest(&self) -> usize {
        let distance = self.gap / self.cosine;
        let nearest = !V::splat(distance.least()).lt(distance);
        let lane = nearest.bits().trailing_zeros() as usize % WIDTH;
        self.block.lane(lane) as usize * WIDTH + lane
    }
}

fn blocks(facets: &[FacetPlane]) -> Vec<Block> {
    // A padding plane has no direction, so that no ray ever runs towards it.
    let empty = Block { normal: [Row::default(); 3], offset: Row([1.0; WIDTH]) };
    let mut blocks = vec![empty; facets.len().div_ceil(WIDTH)];
    for (i, facet) in facets.iter().enumerate() {
        let (block, lane) = (&mut blocks[i / WIDTH], i % WIDTH);
        for (axis, coordinate) in facet.normal.to_array().into_iter().enumerate() {
            block.normal[axis].0[lane] = coordinate as f32;
        }
        block.offset.0[lane] = facet.offset as f32;
    }
    blocks
}

/// For each facet of a stone, counted from its first, in ascending order the facets that bound its polygon: those
/// that it shares an edge with, and, so that a margin on the former holds for the latter too, those that it shares
/// only a corner with and that are nearly parallel to it.
fn adjacent(geometry: &Geometry, stone: &PreparedStone) -> Vec<Vec<usize>> {
    /// Cosine of the angle below which planes are nearly parallel.
    const NEARLY: f64 = 0.98;
    let (first, last) = (stone.facets.start as usize, stone.facets.end as usize);
    let facets = &geometry.facets[first..last];
    let mut corners: HashMap<u32, Vec<usize>> = HashMap::new();
    let mut edges = HashMap::new();
    for t in stone.triangles.start as usize..stone.triangles.end as usize {
        let (triangle, facet) = (geometry.triangles[t], geometry.facet_of[t] as usize - first);
        for k in 0..3 {
            edges.insert((triangle[k], triangle[(k + 1) % 3]), facet);
            corners.entry(triangle[k]).or_default().push(facet);
        }
    }
    let mut adjacent = vec![Vec::new(); facets.len()];
    for (&(from, to), &facet) in &edges {
        adjacent[facet].extend(edges.get(&(to, from)));
    }
    for around in corners.values() {
        for &facet in around {
            let normal = facets[facet].normal;
            adjacent[facet].extend(around.iter().filter(|&&j| facets[j].normal.dot(normal) > NEARLY));
        }
    }
    for (facet, list) in adjacent.iter_mut().enumerate() {
        list.sort_unstable();
        list.dedup();
        list.retain(|&j| j != facet);
    }
    adjacent
}
