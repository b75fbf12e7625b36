//! The facet planes of one convex stone, laid out for the compiler to take several at a time.
//!
//! Inside a convex solid the exit facet maximises (n·d)/(offset − n·o): a linear programme on the polar dual,
//! whose vertices are the facets and whose edges are the solid's edges. A facet that beats its edge-adjacent
//! neighbours is therefore the one, and a good guess, such as the facet that the next wavelength met, costs a
//! handful of planes to verify instead of all of them.

use glam::{DVec3, Vec3};
use multiversion::multiversion;
use spectral_core::prepare::FacetPlane;

/// Planes are handled in blocks of this many, padded with planes that are never met.
const BLOCK: usize = 16;

/// A block of facet planes, one array a coordinate.
#[derive(Debug, Clone, Copy)]
struct Block {
    normal: [[f32; BLOCK]; 3],
    offset: [f32; BLOCK],
}

/// The half-spaces whose intersection is the stone.
#[derive(Debug, Clone)]
pub(crate) struct Planes {
    blocks: Vec<Block>,
    /// For each facet the planes of its edge-adjacent neighbours.
    neighbours: Vec<Vec<Block>>,
    normals: Vec<Vec3>,
    exact: Vec<FacetPlane>,
}

/// Where a ray leaves a convex stone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exit {
    /// Length of the segment, mm; never negative.
    pub distance: f32,
    /// Index of the facet.
    pub facet: usize,
}

/// Where a camera ray enters a convex stone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    pub point: DVec3,
    pub facet: usize,
}

impl Planes {
    /// The planes of a convex stone, and for each facet those it shares an edge with.
    pub fn new(facets: &[FacetPlane], adjacent: &[Vec<usize>]) -> Self {
        let around = |list: &Vec<usize>| blocks(list.iter().map(|&j| &facets[j]));
        Planes {
            blocks: blocks(facets.iter()),
            neighbours: adjacent.iter().map(around).collect(),
            normals: facets.iter().map(|f| f.normal.as_vec3()).collect(),
            exact: facets.to_vec(),
        }
    }

    /// The unit outward normal of a facet.
    #[inline]
    pub fn normal(&self, facet: usize) -> Vec3 {
        self.normals[facet]
    }

    /// The facet through which a ray from inside leaves: the nearest plane that it runs towards.
    ///
    /// No epsilon: a ray never runs towards the facet it has just been reflected by, and a start that
    /// rounding put beyond a plane leaves through it at distance 0. Ties go to the lowest index.
    #[inline]
    pub fn exit(&self, origin: Vec3, direction: Vec3) -> Exit {
        nearest_plane(&self.blocks, origin.to_array(), direction.to_array())
    }

    /// [`exit`](Self::exit), given a facet that may be the one.
    #[inline]
    pub fn exit_near(&self, origin: Vec3, direction: Vec3, guess: usize) -> Exit {
        let Some(plane) = self.exact.get(guess).map(|_| self.normals[guess]) else {
            return self.exit(origin, direction);
        };
        let towards = plane.dot(direction);
        let gap = self.offset(guess) - plane.dot(origin);
        let (o, d) = (origin.to_array(), direction.to_array());
        if towards > 0.0 && gap >= 0.0 && beats(&self.neighbours[guess], [gap, towards], o, d) {
            return Exit { distance: gap / towards, facet: guess };
        }
        self.exit(origin, direction)
    }

    #[inline]
    fn offset(&self, facet: usize) -> f32 {
        self.blocks[facet / BLOCK].offset[facet % BLOCK]
    }

    /// Where a camera ray from outside meets the stone, in double precision: it is done once a sample.
    pub fn entry(&self, origin: DVec3, direction: DVec3) -> Option<Entry> {
        let (mut near, mut far) = ((0.0, usize::MAX), f64::INFINITY);
        for (index, plane) in self.exact.iter().enumerate() {
            let towards = plane.normal.dot(direction);
            let gap = plane.offset - plane.normal.dot(origin);
            if towards < 0.0 {
                if gap / towards > near.0 {
                    near = (gap / towards, index);
                }
            } else if towards > 0.0 {
                far = far.min(gap / towards);
            } else if gap < 0.0 {
                return None;
            }
        }
        let (distance, facet) = near;
        (facet != usize::MAX && distance <= far)
            .then(|| Entry { point: origin + direction * distance, facet })
    }
}

fn blocks<'a>(facets: impl ExactSizeIterator<Item = &'a FacetPlane>) -> Vec<Block> {
    // A padding plane has no direction, so that no ray ever runs towards it.
    let empty = Block { normal: [[0.0; BLOCK]; 3], offset: [1.0; BLOCK] };
    let mut blocks = vec![empty; facets.len().div_ceil(BLOCK)];
    for (i, facet) in facets.enumerate() {
        let (block, lane) = (&mut blocks[i / BLOCK], i % BLOCK);
        for (axis, coordinate) in facet.normal.to_array().into_iter().enumerate() {
            block.normal[axis][lane] = coordinate as f32;
        }
        block.offset[lane] = facet.offset as f32;
    }
    blocks
}

/// Whether a plane `gap` away that a ray runs towards with the cosine `towards` is met before all of `others`:
/// gap/towards < gapⱼ/towardsⱼ, multiplied out.
#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512bw+avx512dq+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn beats(others: &[Block], [gap, towards]: [f32; 2], o: [f32; 3], d: [f32; 3]) -> bool {
    let mut beaten = 0;
    for block in others {
        let ([x, y, z], offset) = (&block.normal, &block.offset);
        for lane in 0..BLOCK {
            let other_towards = x[lane] * d[0] + y[lane] * d[1] + z[lane] * d[2];
            let other_gap = offset[lane] - (x[lane] * o[0] + y[lane] * o[1] + z[lane] * o[2]);
            beaten += u32::from(other_gap * towards <= gap * other_towards);
        }
    }
    beaten == 0
}

/// [`Planes::exit`] in the widest registers that the machine has. No operation is fused or reordered, so the
/// bits are the same in all of them.
#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512bw+avx512dq+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn nearest_plane(blocks: &[Block], o: [f32; 3], d: [f32; 3]) -> Exit {
    let mut nearest = [f32::INFINITY; BLOCK];
    let mut place = [0u32; BLOCK];
    for (b, block) in blocks.iter().enumerate() {
        let ([x, y, z], offset) = (&block.normal, &block.offset);
        for lane in 0..BLOCK {
            let towards = x[lane] * d[0] + y[lane] * d[1] + z[lane] * d[2];
            let gap = offset[lane] - (x[lane] * o[0] + y[lane] * o[1] + z[lane] * o[2]);
            let ahead = if gap > 0.0 { gap } else { 0.0 };
            // Divided whether or not it counts: a select is cheaper than a branch in every lane.
            let quotient = ahead / towards;
            let distance = if towards > 0.0 { quotient } else { f32::INFINITY };
            let closer = distance < nearest[lane];
            nearest[lane] = if closer { distance } else { nearest[lane] };
            place[lane] = if closer { b as u32 } else { place[lane] };
        }
    }
    let mut best = Exit { distance: f32::INFINITY, facet: usize::MAX };
    for lane in 0..BLOCK {
        let facet = place[lane] as usize * BLOCK + lane;
        if nearest[lane] < best.distance || (nearest[lane] == best.distance && facet < best.facet) {
            best = Exit { distance: nearest[lane], facet };
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Planes {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let facets: Vec<_> = axes
            .into_iter()
            .flat_map(|n| [n, -n])
            .map(|normal| FacetPlane { normal, offset: 1.0, stone: 0 })
            .collect();
        let opposite = |i: usize| i ^ 1;
        let adjacent: Vec<_> =
            (0..6).map(|i| (0..6).filter(|&j| j != i && j != opposite(i)).collect()).collect();
        Planes::new(&facets, &adjacent)
    }

    #[test]
    fn rays_enter_and_leave_a_cube_where_they_should() {
        let cube = cube();
        let entry = cube.entry(DVec3::new(0.25, 0.0, 5.0), -DVec3::Z).unwrap();
        assert_eq!((entry.point, entry.facet), (DVec3::new(0.25, 0.0, 1.0), 4));
        assert!(cube.entry(DVec3::new(1.25, 0.0, 5.0), -DVec3::Z).is_none());
        assert!(cube.entry(DVec3::new(0.0, 0.0, -5.0), -DVec3::Z).is_none());
        let exit = cube.exit(Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.6, 0.0, 0.8));
        assert_eq!(exit.facet, 0);
        assert!((exit.distance - 0.5 / 0.6).abs() < 1e-6);
    }

    #[test]
    fn a_start_beyond_a_plane_leaves_through_it_at_once() {
        let exit = cube().exit(Vec3::new(1.000_001, 0.0, 0.0), Vec3::new(0.01, 1.0, 0.0).normalize());
        assert_eq!((exit.facet, exit.distance), (0, 0.0));
    }

    #[test]
    fn a_right_guess_is_kept_and_a_wrong_one_is_not_believed() {
        let (cube, origin) = (cube(), Vec3::new(0.1, -0.2, 0.3));
        for k in 0..1000 {
            let angle = 0.1 * k as f32;
            let direction = Vec3::new(angle.cos(), angle.sin(), 0.003 * k as f32 - 1.5).normalize();
            let exit = cube.exit(origin, direction);
            for guess in [0, 1, 2, 3, 4, 5, usize::MAX] {
                let near = cube.exit_near(origin, direction, guess);
                assert_eq!((near.facet, near.distance), (exit.facet, exit.distance));
            }
        }
    }
}
