//! Sixteen rays at a time through the wide tree.
//!
//! The wavelengths of one path visit almost the same nodes, so each box and each triangle is tested for all of them at
//! once. Rays are traversed together if their directions have the same signs and the same largest component: then the
//! tests need no case distinctions. Boxes are as conservative as in `traverse`, whose derivation applies here too, and the
//! triangle test treats each ray separately. Hence the hit of a ray does not depend on the other rays of its packet.
//!
//! The triangle test is that of `triangle` with two differences: the sign of an edge function comes from the difference
//! of two products with their rounding errors (Kahan; Jeannerod, Louvet & Muller 2013) instead of double precision, and
//! the ray parameter is in single precision.
//!
//! Closures must not handle lanes here: a closure is compiled without the instruction set of the surrounding function, so
//! it would be called with all its registers in memory.

use crate::lanes::{Lanes, Mask, Row, Triple, WIDTH, Work};
use crate::slabs::{STEEPEST, ScaledRay, Slabs, WIDENING};
use crate::stack::Stack;
use crate::{Bvh, Ray, triangle::Triangle};
use glam::Vec3;
use obvhs::cwbvh::node::CwBvhNode;

/// Rays that start together.
#[derive(Clone, Copy, Debug)]
pub struct Rays<V> {
    /// Origins.
    pub origin: Triple<V>,
    /// Directions; finite and not zero in the active lanes.
    pub direction: Triple<V>,
    /// Smallest ray parameter of a hit.
    pub t_min: f32,
    /// The active lanes, lane i as bit i.
    pub lanes: u16,
}

/// The hits of a packet.
#[derive(Clone, Copy, Debug)]
pub struct Hits {
    /// Lanes with a hit.
    pub lanes: u16,
    /// Ray parameters.
    pub t: Row,
    /// Triangles.
    pub triangle: [u32; WIDTH],
}

/// Nodes still to visit, with the lanes that meet them and the slab distances at which these do. Kept from packet to
/// packet, so that none allocates.
pub type Pending<V> = Vec<(u32, u16, V)>;

/// Decides which hits are accepted.
pub trait Accept<V: Lanes> {
    /// The lanes of `hit` for which the triangle is accepted; must depend on ray and triangle alone. Must be marked
    /// `#[inline(always)]`.
    fn accept(&self, triangle: u32, hit: V::Mask) -> V::Mask;
}

impl Bvh {
    /// The nearest accepted hit of each lane; for equal parameters the lowest triangle.
    ///
    /// Agrees with [`Bvh::closest`] except for the rounding of the parameter. Must be called within a
    /// [`Task`](crate::Task).
    #[inline(always)]
    pub fn closest_of_packet<V: Lanes, A: Accept<V>>(
        &self,
        rays: &Rays<V>,
        accept: &A,
        pending: &mut Pending<V>,
    ) -> Hits {
        V::apart(Closest { bvh: self, rays, accept, pending })
    }

    #[inline(always)]
    fn nearest_of_packet<V: Lanes, A: Accept<V>>(
        &self,
        rays: &Rays<V>,
        accept: &A,
        pending: &mut Pending<V>,
    ) -> Hits {
        let mut search = Search {
            accept,
            nearest: V::splat(f32::INFINITY),
            hits: Hits { lanes: 0, t: Row([f32::INFINITY; WIDTH]), triangle: [u32::MAX; WIDTH] },
        };
        let mut open = if self.nodes.is_empty() { 0 } else { rays.lanes };
        let kinds = Kinds::new(rays.direction);
        while open != 0 {
            let (kind, lanes) = kinds.first(open);
            open &= !lanes;
            self.traverse(&Beam::new(rays, kind, lanes, self.scale), &mut search, pending);
        }
        search.nearest.store(&mut search.hits.t);
        search.hits
    }

    #[inline(always)]
    fn traverse<V: Lanes, A: Accept<V>>(
        &self,
        beam: &Beam<'_, V>,
        search: &mut Search<'_, V, A>,
        stack: &mut Pending<V>,
    ) {
        stack.clear();
        stack.push((0u32, beam.lanes, beam.first));
        let mut last = beam.distance(search.nearest);
        while let Some((index, lanes, near)) = stack.pop() {
            let lanes = (!last.lt(near)).bits() & lanes;
            if lanes == 0 {
                continue;
            }
            if lanes.is_power_of_two() {
                V::apart(Alone { bvh: self, beam, lanes, index, search });
                last = beam.distance(search.nearest);
                continue;
            }
            let node = &self.nodes[index as usize];
            let inside = V::Mask::from_bits(lanes);
            let mut inner = [(0u32, 0u16, beam.first); 8];
            let mut count = 0;
            let boxes = Boxes::new(beam, node);
            for k in 0..8 {
                // Nearest first, by the signs of the direction (Ylitie et al. 2017, section 3.2).
                let child = k ^ beam.kind.octant;
                if node.child_meta[child] == 0 {
                    continue;
                }
                let (near, far) = boxes.slabs(child, beam.first, last);
                let hit = !far.lt(near) & inside;
                if hit.bits() == 0 {
                    continue;
                }
                if !node.is_leaf(child) {
                    inner[count] = (node.child_node_index(child), hit.bits(), near);
                    count += 1;
                    continue;
                }
                let (start, length) = node.child_primitives(child);
                for triangle in &self.references[start as usize..(start + length) as usize] {
                    if search.offer(beam, triangle, hit) {
                        last = beam.distance(search.nearest);
                    }
                }
            }
            stack.extend(inner[..count].iter().rev());
        }
    }
}

/// The traversal of a subtree for the one lane that is left: a node's eight boxes are tested at once, and triangles as for
/// any number of lanes.
struct Alone<'a, 'b, V, A> {
    bvh: &'a Bvh,
    beam: &'a Beam<'a, V>,
    /// One bit.
    lanes: u16,
    /// The subtree's root.
    index: u32,
    search: &'a mut Search<'b, V, A>,
}

impl<V: Lanes, A: Accept<V>> Work for Alone<'_, '_, V, A> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Alone { bvh, beam, lanes, index, search } = self;
        let lane = lanes.trailing_zeros() as usize;
        let ray = beam.ray(lane);
        let scaled = ScaledRay::new(&ray, bvh.scale);
        let slabs = V::Slabs::new(&scaled, scaled.first(ray.t_min));
        let mut last = scaled.last(search.nearest.lane(lane));
        let mut stack = Stack::new();
        let mut next = Some((f32::NEG_INFINITY, index));
        while let Some((near, index)) = next {
            // A hit found since this entry was pushed may be nearer.
            if near > last {
                next = stack.pop();
                continue;
            }
            let node = &bvh.nodes[index as usize];
            let entries = slabs.enter(node, last);
            let mut leaves = entries.hit & !u32::from(node.imask);
            while leaves != 0 {
                let (start, length) = node.child_primitives(leaves.trailing_zeros() as usize);
                leaves &= leaves - 1;
                for triangle in &bvh.references[start as usize..(start + length) as usize] {
                    if search.offer(beam, triangle, V::Mask::from_bits(lanes)) {
                        last = scaled.last(search.nearest.lane(lane));
                    }
                }
            }
            let inner = entries.hit & u32::from(node.imask);
            let child = |slot: u32| {
                let before = u32::from(node.imask) & ((1 << slot) - 1);
                (entries.near[slot as usize % 8], node.child_base_idx + before.count_ones())
            };
            next = if inner != 0 { Some(stack.push_but_nearest(inner, child)) } else { stack.pop() };
        }
    }
}

/// [`Bvh::closest_of_packet`] as a function of its own.
struct Closest<'a, V, A> {
    bvh: &'a Bvh,
    rays: &'a Rays<V>,
    accept: &'a A,
    pending: &'a mut Pending<V>,
}

impl<V: Lanes, A: Accept<V>> Work for Closest<'_, V, A> {
    type Output = Hits;

    #[inline(always)]
    fn work(self) -> Hits {
        self.bvh.nearest_of_packet(self.rays, self.accept, self.pending)
    }
}

/// What rays traversed together have in common: the signs and the largest component of their directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    /// Last the axis of the largest component.
    axes: [usize; 3],
    /// Bit 4 where x is negative, 2 for y, 1 for z.
    octant: usize,
}

/// The kinds of all lanes.
struct Kinds {
    negative: [u16; 3],
    largest: [u16; 3],
}

impl Kinds {
    #[inline(always)]
    fn new<V: Lanes>(d: Triple<V>) -> Self {
        let zero = V::splat(0.0);
        let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
        let from_x = !x.lt(y) & !x.lt(z);
        let from_y = !y.lt(z) & !from_x;
        Kinds {
            negative: [d.x.lt(zero).bits(), d.y.lt(zero).bits(), d.z.lt(zero).bits()],
            largest: [from_x.bits(), from_y.bits(), !(from_x.bits() | from_y.bits())],
        }
    }

    /// The kind of the first open lane, and the open lanes of that kind.
    #[inline(always)]
    fn first(&self, open: u16) -> (Kind, u16) {
        let first = open & open.wrapping_neg();
        let (mut lanes, mut octant, mut largest) = (open, 0, 2);
        for axis in 0..3 {
            let negative = self.negative[axis];
            if negative & first != 0 {
                octant |= 4 >> axis;
                lanes &= negative;
            } else {
                lanes &= !negative;
            }
            if self.largest[axis] & first != 0 {
                largest = axis;
            }
        }
        lanes &= self.largest[largest];
        let axes = [(largest + 1) % 3, (largest + 2) % 3, largest];
        (Kind { axes, octant }, lanes)
    }
}

/// Rays of one kind, prepared for the box and triangle tests.
struct Beam<'a, V> {
    rays: &'a Rays<V>,
    kind: Kind,
    lanes: u16,
    t_min: V,
    /// In the mesh's units, axes in the kind's order.
    origin: [V; 3],
    /// The other two components of the direction over the largest one.
    slope: [V; 2],
    /// 1 / the direction's largest component.
    inverse_largest: V,
    /// In the builder's units, as in `traverse`.
    slab_origin: [V; 3],
    inverse: [V; 3],
    widening: [V; 3],
    /// Slab distance per ray parameter.
    rate: V,
    /// The smallest slab distance.
    first: V,
}

impl<'a, V: Lanes> Beam<'a, V> {
    #[inline(always)]
    fn new(rays: &'a Rays<V>, kind: Kind, lanes: u16, scale: f32) -> Self {
        let (o, d) = (rays.origin, rays.direction);
        let (origins, directions) = ([o.x, o.y, o.z], [d.x, d.y, d.z]);
        let [a, b, c] = kind.axes;
        let (dx, dy, largest) = (directions[a], directions[b], directions[c]);
        let size = largest.abs();
        let scale = V::splat(scale);
        let slab_origin = [o.x * scale, o.y * scale, o.z * scale];
        let [x, y, z] = slab_origin;
        let reach = (x.abs().max(y.abs()).max(z.abs()) + V::splat(1.0)) * V::splat(WIDENING);
        let steepest = V::splat(STEEPEST);
        let (mut inverse, mut widening) = (directions, directions);
        for axis in 0..3 {
            let x = directions[axis];
            let size = (size / x.abs()).min(steepest);
            inverse[axis] = V::select(x.lt(V::splat(0.0)), -size, size);
            widening[axis] = size * reach;
        }
        let rate = size * scale;
        let t_min = V::splat(rays.t_min);
        let first = t_min * rate;
        Beam {
            rays,
            kind,
            lanes,
            t_min,
            origin: [origins[a], origins[b], origins[c]],
            slope: [dx / largest, dy / largest],
            inverse_largest: V::splat(1.0) / largest,
            slab_origin,
            inverse,
            widening,
            rate,
            first: first - first.abs() * V::splat(ROUNDING),
        }
    }

    /// The ray of a lane.
    #[inline(always)]
    fn ray(&self, lane: usize) -> Ray {
        let Rays { origin: o, direction: d, t_min, .. } = *self.rays;
        let origin = Vec3::new(o.x.lane(lane), o.y.lane(lane), o.z.lane(lane));
        let direction = Vec3::new(d.x.lane(lane), d.y.lane(lane), d.z.lane(lane));
        Ray { origin, direction, t_min, t_max: f32::INFINITY }
    }

    /// The slab distance of a ray parameter, rounded up.
    #[inline(always)]
    fn distance(&self, t: V) -> V {
        let distance = t * self.rate;
        distance.abs().fma(V::splat(ROUNDING), distance)
    }
}

/// More than the rounding error of two products.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// The boxes of a node's children, prepared for a beam.
struct Boxes<V> {
    /// By axis: the sides at which the beam enters each child, and those at which it leaves. All are decoded at once,
    /// which takes fewer operations than one by one.
    sides: [[[f32; 8]; 2]; 3],
    step: [V; 3],
    start: [V; 3],
    end: [V; 3],
}

impl<V: Lanes> Boxes<V> {
    #[inline(always)]
    fn new(beam: &Beam<'_, V>, node: &CwBvhNode) -> Self {
        let packed = [
            [&node.child_min_x, &node.child_max_x],
            [&node.child_min_y, &node.child_max_y],
            [&node.child_min_z, &node.child_max_z],
        ];
        let mut sides = [[[0.0; 8]; 2]; 3];
        let cell = node.compute_extent();
        let (mut step, mut start, mut end) = (beam.inverse, beam.inverse, beam.inverse);
        for axis in 0..3 {
            let turned = usize::from(beam.kind.octant & (4 >> axis) != 0);
            for child in 0..8 {
                sides[axis][turned][child] = f32::from(packed[axis][0][child]);
                sides[axis][1 - turned][child] = f32::from(packed[axis][1][child]);
            }
            let inverse = beam.inverse[axis];
            step[axis] = V::splat(cell[axis]) * inverse;
            let middle = (V::splat(node.p[axis]) - beam.slab_origin[axis]) * inverse;
            start[axis] = middle - beam.widening[axis];
            end[axis] = middle + beam.widening[axis];
        }
        Boxes { sides, step, start, end }
    }

    /// Slab distances at which a child is entered and left, within `first` and `last`.
    #[inline(always)]
    fn slabs(&self, child: usize, first: V, last: V) -> (V, V) {
        let (mut near, mut far) = (first, last);
        for axis in 0..3 {
            let [enter, leave] = &self.sides[axis];
            let (enter, leave) = (V::splat(enter[child]), V::splat(leave[child]));
            near = enter.fma(self.step[axis], self.start[axis]).max(near);
            far = leave.fma(self.step[axis], self.end[axis]).min(far);
        }
        (near, far)
    }
}

/// The nearest hits so far.
struct Search<'a, V, A> {
    accept: &'a A,
    /// Ray parameters, infinite without a hit.
    nearest: V,
    hits: Hits,
}

impl<V: Lanes, A: Accept<V>> Search<'_, V, A> {
    /// Takes the hits with a triangle that precede those found so far. Returns whether there are any.
    #[inline(always)]
    fn offer(&mut self, beam: &Beam<'_, V>, triangle: &Triangle, lanes: V::Mask) -> bool {
        let (hit, t) = beam.intersect(triangle);
        let hit = hit & lanes & !t.lt(beam.t_min) & !self.nearest.lt(t);
        if hit.bits() == 0 {
            return false;
        }
        let number = triangle.number();
        let taken = self.accept.accept(number, hit).bits();
        // For equal parameters the lowest triangle, whatever the order of the calls.
        let nearer = t.lt(self.nearest).bits();
        let mut better = 0;
        let mut open = taken;
        while open != 0 {
            let lane = open.trailing_zeros() as usize;
            open &= open - 1;
            if nearer >> lane & 1 == 1 || number < self.hits.triangle[lane] {
                self.hits.triangle[lane] = number;
                better |= 1 << lane;
            }
        }
        self.hits.lanes |= better;
        self.nearest = V::select(V::Mask::from_bits(better), t, self.nearest);
        better != 0
    }
}

impl<V: Lanes> Beam<'_, V> {
    /// The rays whose lines meet a triangle, and the parameters.
    #[inline(always)]
    fn intersect(&self, triangle: &Triangle) -> (V::Mask, V) {
        let [a, b, c] = triangle.corners();
        let (a, b, c) = (self.image(a), self.image(b), self.image(c));
        let zero = V::splat(0.0);
        let u = difference([c[0], b[1]], [c[1], b[0]]);
        let v = difference([a[0], c[1]], [a[1], c[0]]);
        let w = difference([b[0], a[1]], [b[1], a[0]]);
        let outside = u.min(v).min(w).lt(zero) & zero.lt(u.max(v).max(w));
        let sum = u + v + w;
        let height = w.fma(c[2], v.fma(b[2], u * a[2]));
        let t = height / sum * self.inverse_largest;
        // A triangle seen edge-on gives NaN or infinity.
        let finite = t.abs().lt(V::splat(f32::INFINITY));
        (!outside & finite, t)
    }

    /// The sheared image of a corner relative to the origins, and its distance along the largest component.
    #[inline(always)]
    fn image(&self, corner: &[f32; 3]) -> [V; 3] {
        let [x, y, z] = self.kind.axes;
        let height = V::splat(corner[z]) - self.origin[2];
        [
            self.slope[0].fnma(height, V::splat(corner[x]) - self.origin[0]),
            self.slope[1].fnma(height, V::splat(corner[y]) - self.origin[1]),
            height,
        ]
    }
}

/// a·b − c·d with the sign of its exact value.
#[inline(always)]
fn difference<V: Lanes>([a, b]: [V; 2], [c, d]: [V; 2]) -> V {
    let product = c * d;
    let error = c.fnma(d, product);
    a.fma(b, -product) + error
}
