//! Conservative traversal of the wide tree.
//!
//! # Why no hit is lost
//! The triangle test accepts a hit by its own rounded arithmetic, so a box test must not be the one to
//! disagree. Let `u = 2⁻²⁴` and let `R` be the largest distance, along one axis, of the ray's origin from a
//! point of the mesh; both are measured in the builder's units, in which the mesh reaches no further than 1
//! from zero, so `R ≤ |origin| + 1` and `R ≥ 1`. An accepted hit lies, along each axis,
//! - within `5 u R` of the ray: the sheared corners are rounded (subtraction, slope, product, subtraction);
//! - within `11 u` of a reference's box: the clipping of references is rounded once;
//! - within `11 u` of what the compressed node says: `obvhs` rounds `(box − node) / cell` before it takes the
//!   floor or ceiling, and the logarithm that gives the cell.
//!
//! The slab distance itself, `q·(cell·i) + (p − o)·i` with `i = 1/direction`, is off by at most `5 u R |i|`:
//! one rounding each of `i`, difference, product, product and sum. So every box is widened by `δ = 48 u R`,
//! which in the slab test is `δ |i|` subtracted from the entry and added to the exit distance. `|i|` is
//! clamped to `2²³ / |direction|∞`: a direction component smaller than that moves the ray by less than `2 u R`
//! on its whole way through the mesh, and zeros need no case of their own.

use glam::Vec3;
use obvhs::cwbvh::node::CwBvhNode;

use crate::stats::Counter;
use crate::triangle::Shear;
use crate::{Bvh, Hit, Ray};

/// `δ / R`, see above: 48 · 2⁻²⁴.
pub(crate) const WIDENING: f32 = 48.0 / 16_777_216.0;
/// Largest `|i|` in units of `1 / |direction|∞`.
pub(crate) const STEEPEST: f64 = 8_388_608.0;

/// A ray in the builder's units, with the direction scaled to a largest component of 1: slab distances are
/// then of the size of the mesh.
struct Slabs {
    origin: Vec3,
    inverse: Vec3,
    widening: Vec3,
    /// Slab distance per ray parameter.
    rate: f64,
    /// The interval of slab distances in which a hit may still be accepted.
    first: f32,
    last: f32,
}

impl Slabs {
    fn new(ray: &Ray, scale: f32) -> Slabs {
        let size = f64::from(ray.direction.abs().max_element());
        let inverse = ray.direction.to_array().map(|d| {
            let d = f64::from(d) / size;
            (1.0 / d.abs()).min(STEEPEST).copysign(d) as f32
        });
        let origin = ray.origin * scale;
        let inverse = Vec3::from(inverse);
        let widening = inverse.abs() * (WIDENING * (origin.abs().max_element() + 1.0));
        let rate = size * f64::from(scale);
        let mut slabs = Slabs { origin, inverse, widening, rate, first: 0.0, last: 0.0 };
        slabs.first = slabs.distance(ray.t_min).next_down();
        slabs.shorten(ray.t_max);
        slabs
    }

    fn distance(&self, t: f32) -> f32 {
        (f64::from(t) * self.rate) as f32
    }

    fn shorten(&mut self, t: f32) {
        self.last = self.distance(t).next_up();
    }

    /// Entry distances to the eight children, infinite where a child is missed or empty.
    ///
    /// The comparison is written so that an overflow to NaN counts as a hit.
    #[inline]
    fn enter(&self, node: &CwBvhNode) -> [f32; 8] {
        let mut near = [self.first; 8];
        let mut far = [self.last; 8];
        let planes = [
            (&node.child_min_x, &node.child_max_x),
            (&node.child_min_y, &node.child_max_y),
            (&node.child_min_z, &node.child_max_z),
        ];
        let cell = node.compute_extent();
        for (axis, (lo, hi)) in planes.into_iter().enumerate() {
            let inverse = self.inverse[axis];
            let step = cell[axis] * inverse;
            let start = (node.p[axis] - self.origin[axis]) * inverse;
            let (start, end) = (start - self.widening[axis], start + self.widening[axis]);
            let (lo, hi) = if inverse >= 0.0 { (lo, hi) } else { (hi, lo) };
            for i in 0..8 {
                near[i] = max(near[i], f32::from(lo[i]) * step + start);
                far[i] = min(far[i], f32::from(hi[i]) * step + end);
            }
        }
        for i in 0..8 {
            if near[i] > far[i] || node.child_meta[i] == 0 {
                near[i] = f32::INFINITY;
            }
        }
        near
    }
}

// One instruction each, and the running value survives a NaN in the other.
#[inline]
fn max(running: f32, other: f32) -> f32 {
    if other > running { other } else { running }
}

#[inline]
fn min(running: f32, other: f32) -> f32 {
    if other < running { other } else { running }
}

/// Nodes still to visit, the nearest on top. The place in line holds what any sane tree needs; deeper ones
/// spill.
struct Stack {
    place: [(f32, u32); Stack::PLACE],
    len: usize,
    spill: Vec<(f32, u32)>,
}

impl Stack {
    const PLACE: usize = 64;

    fn new() -> Stack {
        Stack { place: [(0.0, 0); Stack::PLACE], len: 0, spill: Vec::new() }
    }

    #[inline]
    fn push(&mut self, entry: (f32, u32)) {
        if let Some(place) = self.place.get_mut(self.len) {
            *place = entry;
            self.len += 1;
        } else {
            self.spill.push(entry);
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<(f32, u32)> {
        if let Some(entry) = self.spill.pop() {
            return Some(entry);
        }
        self.len = self.len.checked_sub(1)?;
        Some(self.place[self.len])
    }
}

/// The running search: the interval and the best hit so far.
pub(crate) struct Search<'a, A> {
    ray: &'a Ray,
    accept: A,
    pub best: Option<Hit>,
}

impl<'a, A: FnMut(&Hit) -> bool> Search<'a, A> {
    pub fn new(ray: &'a Ray, accept: A) -> Self {
        Search { ray, accept, best: None }
    }

    /// Takes a hit if it lies in the interval, precedes the best so far and is accepted. The order is by
    /// parameter, then by triangle, so that the outcome does not depend on the order of the offers.
    #[inline]
    pub fn offer(&mut self, hit: Hit) -> bool {
        let precedes = match &self.best {
            None => self.ray.t_min <= hit.t && hit.t <= self.ray.t_max,
            Some(best) => {
                self.ray.t_min <= hit.t
                    && (hit.t < best.t || (hit.t == best.t && hit.triangle < best.triangle))
            }
        };
        if precedes && (self.accept)(&hit) {
            self.best = Some(hit);
            return true;
        }
        false
    }
}

/// The nearest accepted hit, counting the work in `counter`.
pub(crate) fn closest(
    bvh: &Bvh,
    ray: &Ray,
    accept: impl FnMut(&Hit) -> bool,
    counter: &mut impl Counter,
) -> Option<Hit> {
    let shear = Shear::new(ray)?;
    if bvh.nodes.is_empty() {
        return None;
    }
    let mut slabs = Slabs::new(ray, bvh.scale);
    let mut search = Search::new(ray, accept);
    let mut stack = Stack::new();
    let mut next = Some((f32::NEG_INFINITY, 0));
    while let Some((distance, index)) = next {
        if distance <= slabs.last {
            let node = &bvh.nodes[index as usize];
            counter.node();
            let near = slabs.enter(node);
            let mut inner = [(0.0f32, 0u32); 8];
            let mut count = 0;
            for (child, &near) in near.iter().enumerate() {
                if near == f32::INFINITY {
                    continue;
                }
                if !node.is_leaf(child) {
                    let mut place = count;
                    while place > 0 && inner[place - 1].0 < near {
                        inner[place] = inner[place - 1];
                        place -= 1;
                    }
                    inner[place] = (near, node.child_node_index(child));
                    count += 1;
                    continue;
                }
                let (start, length) = node.child_primitives(child);
                for triangle in &bvh.references[start as usize..(start + length) as usize] {
                    counter.triangle();
                    if let Some(hit) = shear.intersect(triangle)
                        && search.offer(hit)
                    {
                        slabs.shorten(hit.t);
                    }
                }
            }
            inner[..count].iter().for_each(|&entry| stack.push(entry));
        }
        next = stack.pop();
    }
    search.best
}
