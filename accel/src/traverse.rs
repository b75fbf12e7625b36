//! Conservative traversal of the wide tree.
//!
//! # Why no hit is lost
//! The box test must not reject a hit that the triangle test accepts in its own rounded arithmetic. Let `u = 2⁻²⁴`, and
//! let `R` be the largest distance along one axis between the ray's origin and a point of the mesh, in the builder's
//! units. The mesh extends no further than 1 from zero, so `R ≤ |origin| + 1` and `R ≥ 1`. Along each axis an accepted
//! hit lies
//! - within `5 u R` of the ray: the sheared corners are rounded (subtraction, slope, product, subtraction);
//! - within `11 u` of the box of a reference: the clipping of references is rounded once;
//! - within `11 u` of the box in the compressed node: `(box − node) / cell` is rounded before floor or ceiling, and so is
//!   the logarithm that gives the cell.
//!
//! The slab distance itself has an error of at most `5 u R |i|`, with `i = 1/direction`. `slabs` computes it in two
//! forms, each with five roundings of numbers no larger than `R |i|`: as `q·(cell·i) + (p − o)·i`, with one rounding
//! each for `i`, the difference, the two products and the sum; and fused as `q·(cell·i) + (p·i + (−o·i ∓ δ|i|))`, with
//! one each for `i`, the product `o·i` and the three sums. (`cell` is a power of two.) So every box is widened by
//! `δ = 48 u R`: the slab test subtracts `δ |i|` from the entry distance and adds it to the exit distance. `|i|` is
//! clamped to `2²³ / |direction|∞`: a smaller direction component moves the ray by less than `2 u R` on its whole way
//! through the mesh. Zeros then need no special case.
//!
//! # Performance
//! A ray through a large mesh waits for memory at every node. So children are prefetched as soon as they are known, and
//! the triangles of a node together with the node. Otherwise the time goes to a dependency chain, since the address of
//! each node follows from the box test before it, and to unpredictable branches, which are kept few and short.

use obvhs::cwbvh::node::CwBvhNode;

use crate::instructions::Task;
use crate::lanes::{Lanes, Work};
use crate::slabs::{ScaledRay, Slabs};
use crate::stack::Stack;
use crate::stats::Counter;
use crate::triangle::Shear;
use crate::{Bvh, Hit, Ray};

/// The interval of the search and the best hit so far.
pub(crate) struct Search<'a, A> {
    ray: &'a Ray,
    accept: A,
    pub best: Option<Hit>,
}

impl<'a, A: FnMut(&Hit) -> bool> Search<'a, A> {
    pub fn new(ray: &'a Ray, accept: A) -> Self {
        Search { ray, accept, best: None }
    }

    /// Takes a hit if it lies in the interval, precedes the best so far and is accepted. Hits are ordered by parameter,
    /// then by triangle, so the result does not depend on the order of the calls.
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

/// The search for the nearest accepted hit, counting the work in `counter`.
pub(crate) struct Closest<'a, A, C> {
    pub bvh: &'a Bvh,
    pub ray: &'a Ray,
    pub accept: A,
    pub counter: &'a mut C,
}

impl<A: FnMut(&Hit) -> bool, C: Counter> Task for Closest<'_, A, C> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<V: Lanes>(self) -> Option<Hit> {
        let Closest { bvh, ray, accept, counter } = self;
        if !ray.is_proper() || bvh.nodes.is_empty() {
            return None;
        }
        let scaled = ScaledRay::new(ray, bvh.scale);
        let slabs = V::Slabs::new(&scaled, scaled.first(ray.t_min));
        let last = scaled.last(ray.t_max);
        let mut leaves =
            Leaves { bvh, ray, scaled, shear: None, last, search: Search::new(ray, accept), counter };
        V::apart(Walk::<A, C, V> { slabs: &slabs, leaves: &mut leaves });
        leaves.search.best
    }
}

/// The traversal of the nodes, nearest first.
struct Walk<'a, 'b, A, C, V: Lanes> {
    slabs: &'a V::Slabs,
    leaves: &'a mut Leaves<'b, A, C>,
}

impl<A: FnMut(&Hit) -> bool, C: Counter, V: Lanes> Work for Walk<'_, '_, A, C, V> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Walk { slabs, leaves } = self;
        let bvh = leaves.bvh;
        let mut stack = Stack::new();
        let mut next = Some((f32::NEG_INFINITY, 0));
        while let Some((near, index)) = next {
            // A hit found since this entry was pushed may be nearer.
            if near > leaves.last {
                next = stack.pop();
                continue;
            }
            let node = &bvh.nodes[index as usize];
            leaves.counter.node();
            V::Slabs::prefetch(&bvh.references, node.primitive_base_idx as usize);
            let entries = slabs.enter(node, leaves.last);
            let inner = entries.hit & u32::from(node.imask);
            let child = |slot: u32| {
                let before = u32::from(node.imask) & ((1 << slot) - 1);
                let index = node.child_base_idx + before.count_ones();
                V::Slabs::prefetch(&bvh.nodes, index as usize);
                (entries.near[slot as usize % 8], index)
            };
            let nearest = (inner != 0).then(|| stack.push_but_nearest(inner, child));
            let hit = entries.hit & !u32::from(node.imask);
            if hit != 0 {
                V::apart(Test { leaves, node, hit });
            }
            next = if nearest.is_some() { nearest } else { stack.pop() };
        }
    }
}

/// The search among triangles.
struct Leaves<'a, A, C> {
    bvh: &'a Bvh,
    ray: &'a Ray,
    scaled: ScaledRay,
    /// Computed at the first leaf: most rays that miss the mesh reach none.
    shear: Option<Shear>,
    /// The largest slab distance of an acceptable hit.
    last: f32,
    search: Search<'a, A>,
    counter: &'a mut C,
}

/// The test of a node's leaves.
struct Test<'a, 'b, A, C> {
    leaves: &'a mut Leaves<'b, A, C>,
    node: &'a CwBvhNode,
    /// The children to test, child i as bit i. Empty children have no triangles.
    hit: u32,
}

impl<A: FnMut(&Hit) -> bool, C: Counter> Work for Test<'_, '_, A, C> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Test { leaves, node, mut hit } = self;
        let ray = leaves.ray;
        let shear = leaves.shear.get_or_insert_with(|| Shear::of(ray));
        while hit != 0 {
            let (start, length) = node.child_primitives(hit.trailing_zeros() as usize);
            hit &= hit - 1;
            for triangle in &leaves.bvh.references[start as usize..(start + length) as usize] {
                leaves.counter.triangle();
                if let Some(hit) = shear.intersect(triangle)
                    && leaves.search.offer(hit)
                {
                    leaves.last = leaves.scaled.last(hit.t);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
