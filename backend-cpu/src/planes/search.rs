//! The plane that a ray from inside meets first.
//!
//! There are two forms. One ray against sixteen planes at a time is a pure function of the ray and gives the final answer.
//! Sixteen rays against one plane at a time is for guesses; it needs no comparison between lanes.

use super::Planes;
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH};
use spectral_core::prepare::{FacetPlane, Geometry, PreparedStone};

/// The share of the surface that the large facets have. Testing the others, mostly those of the girdle, in every search
/// would cost more than a further search for the few rays that meet them.
const MOST: f64 = 0.95;

/// Sixteen facet planes, one row a coordinate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    normal: [Row; 3],
    offset: Row,
}

/// A facet's plane and its number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    normal: [f32; 3],
    offset: f32,
    /// The bits of an integer: it is selected, never used in arithmetic.
    number: f32,
}

/// All planes in blocks.
pub(super) fn blocks(facets: &[FacetPlane]) -> Vec<Block> {
    // A padding plane has no normal, so no ray approaches it.
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

/// All planes, the largest facets first, and the number of large ones.
pub(super) fn candidates(geometry: &Geometry, stone: &PreparedStone) -> (Vec<Candidate>, usize) {
    let first = stone.facets.start as usize;
    let facets = &geometry.facets[first..stone.facets.end as usize];
    let mut areas = vec![0.0; facets.len()];
    for t in stone.triangles.start as usize..stone.triangles.end as usize {
        let [a, b, c] = geometry.triangles[t].map(|corner| geometry.positions[corner as usize]);
        areas[geometry.facet_of[t] as usize - first] += (b - a).cross(c - a).length();
    }
    let mut order: Vec<usize> = (0..facets.len()).collect();
    order.sort_by(|&i, &j| areas[j].total_cmp(&areas[i]));
    let (mut rest, mut large) = (areas.iter().sum::<f64>() * MOST, 0);
    while large < order.len() && rest > 0.0 {
        rest -= areas[order[large]];
        large += 1;
    }
    let candidate = |&i: &usize| {
        let FacetPlane { normal, offset, .. } = facets[i];
        Candidate {
            normal: normal.as_vec3().to_array(),
            offset: offset as f32,
            number: f32::from_bits(i as u32),
        }
    };
    (order.iter().map(candidate).collect(), large)
}

impl Planes {
    /// The facets whose planes two rays from inside (origin, direction) meet first. Each is a pure function of its ray.
    #[inline(always)]
    pub(super) fn search<V: Lanes>(&self, rays: [[[f32; 3]; 2]; 2]) -> [usize; 2] {
        let [first, second] = rays;
        let (mut first, mut second) = (Search::<V>::new(first), Search::<V>::new(second));
        let mut number = 0.0;
        for block in &self.blocks {
            first.compare(block, number);
            second.compare(block, number);
            number += 1.0;
        }
        // Only a NaN direction approaches no plane.
        let sound = |facet: usize| if facet < self.facets.len() { facet } else { 0 };
        [sound(first.nearest()), sound(second.nearest())]
    }

    /// The facets that sixteen rays (origins, directions) probably meet first, of all or of the large ones.
    #[inline(always)]
    pub(super) fn guesses<V: Lanes>(
        &self,
        [origins, directions]: &[[Row; 3]; 2],
        large: bool,
    ) -> [u16; WIDTH] {
        let candidates = if large { &self.candidates[..self.large] } else { &self.candidates };
        let (origins, directions) = (Triple::<V>::load(origins), Triple::load(directions));
        // Alternating, so that neither waits for its last comparison.
        let mut nearest = [Nearest::<V>::none(); 2];
        let (pairs, last) = candidates.as_chunks::<2>();
        for pair in pairs {
            nearest[0].compare(&pair[0], origins, directions);
            nearest[1].compare(&pair[1], origins, directions);
        }
        if let [last] = last {
            nearest[0].compare(last, origins, directions);
        }
        let [first, second] = nearest;
        let nearer = (second.gap * first.cosine).lt(first.gap * second.cosine);
        V::select(nearer, second.number, first.number).stored().0.map(|number| number.to_bits() as u16)
    }
}

/// The nearest plane to one ray so far, in each lane among those compared there.
#[derive(Clone, Copy)]
struct Search<V> {
    origin: Triple<V>,
    direction: Triple<V>,
    /// The distance of the plane is gap/cosine, compared without division, and infinite at first.
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

/// The nearest plane to each of sixteen rays so far. Unlike in [`Search`], a start that rounding puts beyond a plane is not
/// corrected, since a guess is verified.
#[derive(Clone, Copy)]
struct Nearest<V> {
    gap: V,
    cosine: V,
    number: V,
}

impl<V: Lanes> Nearest<V> {
    #[inline(always)]
    fn none() -> Self {
        Nearest { gap: V::splat(1.0), cosine: V::splat(0.0), number: V::splat(0.0) }
    }

    #[inline(always)]
    fn compare(&mut self, candidate: &Candidate, origins: Triple<V>, directions: Triple<V>) {
        let normal = Triple::<V>::splat(candidate.normal);
        let cosine = normal.dot(directions);
        let gap = normal.x.fnma(origins.x, V::splat(candidate.offset));
        let gap = normal.z.fnma(origins.z, normal.y.fnma(origins.y, gap));
        let nearer = (gap * self.cosine).lt(self.gap * cosine);
        self.gap = V::select(nearer, gap, self.gap);
        self.cosine = V::select(nearer, cosine, self.cosine);
        self.number = V::select(nearer, V::splat(candidate.number), self.number);
    }
}
