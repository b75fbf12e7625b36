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
use crate::slabs::{STEEPEST, WIDENING};
use crate::{Bvh, triangle::Triangle};
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
    pub fn closest_of_packet<V: Lanes, A: Accept<V>>(&self, rays: &Rays<V>, accept: &A) -> Hits {
        V::apart(Closest { bvh: self, rays, accept })
    }

    #[inline(always)]
    fn nearest_of_packet<V: Lanes, A: Accept<V>>(&self, rays: &Rays<V>, accept: &A) -> Hits {
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
            self.traverse(&Beam::new(rays, kind, lanes, self.scale), &mut search);
        }
        search.nearest.store(&mut search.hits.t);
        search.hits
    }

    #[inline(always)]
    fn traverse<V: Lanes, A: Accept<V>>(&self, beam: &Beam<V>, search: &mut Search<'_, V, A>) {
        let mut stack = Vec::new();
        let mut next = Some((0u32, beam.lanes));
        let mut last = beam.distance(search.nearest);
        while let Some((index, lanes)) = next {
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
            for entry in inner[..count].iter().rev() {
                stack.push(*entry);
            }
            next = None;
            while let Some((index, lanes, near)) = stack.pop() {
                let lanes = (!last.lt(near)).bits() & lanes;
                if lanes != 0 {
                    next = Some((index, lanes));
                    break;
                }
            }
        }
    }
}

/// [`Bvh::closest_of_packet`] as a function of its own.
struct Closest<'a, V, A> {
    bvh: &'a Bvh,
    rays: &'a Rays<V>,
    accept: &'a A,
}

impl<V: Lanes, A: Accept<V>> Work for Closest<'_, V, A> {
    type Output = Hits;

    #[inline(always)]
    fn work(self) -> Hits {
        self.bvh.nearest_of_packet(self.rays, self.accept)
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
struct Beam<V> {
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

impl<V: Lanes> Beam<V> {
    #[inline(always)]
    fn new(rays: &Rays<V>, kind: Kind, lanes: u16, scale: f32) -> Self {
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
struct Boxes<'a, V> {
    /// By axis: the sides at which the beam enters, and those at which it leaves.
    sides: [[&'a [u8; 8]; 2]; 3],
    step: [V; 3],
    start: [V; 3],
    end: [V; 3],
}

impl<'a, V: Lanes> Boxes<'a, V> {
    #[inline(always)]
    fn new(beam: &Beam<V>, node: &'a CwBvhNode) -> Self {
        let mut sides = [
            [&node.child_min_x, &node.child_max_x],
            [&node.child_min_y, &node.child_max_y],
            [&node.child_min_z, &node.child_max_z],
        ];
        let cell = node.compute_extent();
        let (mut step, mut start, mut end) = (beam.inverse, beam.inverse, beam.inverse);
        for axis in 0..3 {
            if beam.kind.octant & (4 >> axis) != 0 {
                sides[axis].swap(0, 1);
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
            let [enter, leave] = self.sides[axis];
            let (enter, leave) = (V::splat(f32::from(enter[child])), V::splat(f32::from(leave[child])));
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
    fn offer(&mut self, beam: &Beam<V>, triangle: &Triangle, lanes: V::Mask) -> bool {
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

impl<V: Lanes> Beam<V> {
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
