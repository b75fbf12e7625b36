//! Sixteen beams inside the stone, a lane each, and where they meet its surface.

use super::part::{Part, Pencil};
use crate::{
    basis::Basis,
    planes::{Exit, Planes, Travellers},
    throughput::Rows,
};
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, put};
use spectral_core::{beam::Polygon, upsample::BASES};

/// Sixteen beams. A beam's reference ray is that of its polygon's centroid.
#[derive(Debug, Clone)]
pub(super) struct Packet {
    /// The beams under way, as bits; what the other lanes hold is finite.
    pub alive: u16,
    /// mm.
    pub origin: [Row; 3],
    /// Unit vectors.
    pub direction: [Row; 3],
    /// Derivatives of the origin by u and v.
    pub origin_by: [[Row; 3]; 2],
    /// Of the direction.
    pub direction_by: [[Row; 3]; 2],
    /// Times shares of their pixels.
    pub throughput: Rows,
    /// Half the size of a box about the centroid that holds the polygon.
    pub half: [Row; 2],
    /// Surface events so far.
    pub depth: Row,
    /// n, n² and 1 − n²; absorption to base 2, 1/mm.
    pub medium: [Row; 4],
    pub basis: Basis,
    pub polygon: [Polygon; WIDTH],
    /// The spectral line.
    pub line: [u16; WIDTH],
    /// Which sum the light belongs to.
    pub place: [u32; WIDTH],
}

impl Packet {
    /// Of no beams.
    pub fn new() -> Self {
        let (row, rows) = (Row::default(), [Row::default(); 3]);
        Packet {
            alive: 0,
            origin: rows,
            direction: rows,
            origin_by: [rows; 2],
            direction_by: [rows; 2],
            throughput: [row; 7],
            half: [row; 2],
            depth: row,
            medium: [row; 4],
            basis: Basis::default(),
            polygon: [Polygon::square(0.5); WIDTH],
            line: [0; WIDTH],
            place: [0; WIDTH],
        }
    }

    /// The pencil of a lane.
    pub fn pencil(&self, lane: usize) -> Pencil {
        let two = |rows: &[[Row; 3]; 2]| [vector(&rows[0], lane), vector(&rows[1], lane)];
        Pencil {
            origin: vector(&self.origin, lane),
            direction: vector(&self.direction, lane),
            origin_by: two(&self.origin_by),
            direction_by: two(&self.direction_by),
        }
    }

    /// Replaces the pencil of a lane.
    pub fn set_pencil(&mut self, lane: usize, pencil: &Pencil) {
        put(&mut self.origin, lane, pencil.origin.to_array());
        put(&mut self.direction, lane, pencil.direction.to_array());
        for axis in 0..2 {
            put(&mut self.origin_by[axis], lane, pencil.origin_by[axis].to_array());
            put(&mut self.direction_by[axis], lane, pencil.direction_by[axis].to_array());
        }
    }

    /// Replaces the polygon of a lane.
    pub fn set_polygon(&mut self, lane: usize, polygon: &Polygon) {
        self.polygon[lane] = *polygon;
        for axis in 0..2 {
            let most = polygon.vertices().iter().fold(0.0, |most: f64, vertex| most.max(vertex[axis].abs()));
            self.half[axis].0[lane] = most as f32;
        }
    }

    /// What a lane holds.
    pub fn part(&self, lane: usize) -> Part {
        Part {
            pencil: self.pencil(lane),
            throughput: std::array::from_fn(|k| self.throughput[k].0[lane]),
            depth: self.depth.0[lane],
            line: self.line[lane],
            place: self.place[lane],
            polygon: self.polygon[lane],
        }
    }

    /// Puts a beam into a lane.
    pub fn put(&mut self, lane: usize, part: &Part, medium: &[f32; 4], basis: &[f32; BASES]) {
        self.set_pencil(lane, &part.pencil);
        self.set_throughput(lane, &part.throughput);
        self.set_polygon(lane, &part.polygon);
        self.depth.0[lane] = part.depth;
        (self.line[lane], self.place[lane]) = (part.line, part.place);
        self.set_medium(lane, medium, basis);
        self.alive |= 1 << lane;
    }

    /// Replaces the throughput of a lane.
    pub fn set_throughput(&mut self, lane: usize, throughput: &[f32; 7]) {
        for (row, value) in self.throughput.iter_mut().zip(throughput) {
            row.0[lane] = *value;
        }
    }

    /// The optics of a lane.
    #[inline(always)]
    pub fn set_medium(&mut self, lane: usize, medium: &[f32; 4], basis: &[f32; BASES]) {
        for (row, value) in self.medium.iter_mut().zip(medium) {
            row.0[lane] = *value;
        }
        self.basis.set(lane, basis);
    }
}

fn vector(rows: &[Row; 3], lane: usize) -> glam::Vec3A {
    glam::Vec3A::new(rows[0].0[lane], rows[1].0[lane], rows[2].0[lane])
}

/// Where rays meet the stone's surface from inside.
#[derive(Clone, Copy)]
pub(crate) struct Meeting<V> {
    pub exit: Exit<V>,
    /// The facet's number.
    pub facet: V,
    /// By how much the point is inside the facet's polygon, mm; or less.
    pub inside: V,
}

impl<V: Lanes> Meeting<V> {
    /// Nowhere in particular.
    #[inline(always)]
    pub fn nowhere() -> Self {
        Meeting { exit: Exit::nowhere(), facet: V::splat(0.0), inside: V::splat(0.0) }
    }

    /// Where rays meet the plane of a facet, and as bits which of them do so well inside its polygon.
    #[inline(always)]
    pub fn of(planes: &Planes, facet: u16, origin: &[Row; 3], direction: &[Row; 3]) -> (Self, u16) {
        let (origin, direction) = (Triple::<V>::load(origin), Triple::load(direction));
        let (exit, beyond) = planes.meet(origin, direction, usize::from(facet));
        // Where rays are far apart, a centroid's may begin outside of the stone: at several facets at once, or so far away that
        // the margin does not cover its rounding. Only a search of its own decides then.
        let (zero, radius) = (V::splat(0.0), planes.radius());
        let near =
            origin.dot(origin).lt(V::splat(radius * radius)) & exit.distance.lt(V::splat(2.0 * radius));
        let inside = planes.well_inside(exit.cosine, beyond) & (near & zero.lt(exit.distance)).bits();
        (Meeting { exit, facet: V::splat(f32::from(facet)), inside: -beyond }, inside)
    }

    /// Copies the lanes whose bit is set; returns them.
    #[inline(always)]
    pub fn accept(&mut self, other: &Self, lanes: u16) -> u16 {
        let mask = V::Mask::from_bits(lanes);
        self.facet = V::select(mask, other.facet, self.facet);
        self.inside = V::select(mask, other.inside, self.inside);
        self.exit.accept(&other.exit, lanes)
    }
}

impl<V: Lanes> Travellers<V> for Packet {
    type Met = Meeting<V>;

    #[inline(always)]
    fn alive(&self) -> u16 {
        self.alive
    }

    #[inline(always)]
    fn ray(&self, lane: usize) -> [[f32; 3]; 2] {
        let lane = lane % WIDTH;
        [&self.origin, &self.direction].map(|rows| [rows[0].0[lane], rows[1].0[lane], rows[2].0[lane]])
    }

    #[inline(always)]
    fn verify(&self, planes: &Planes, facet: u16) -> (Meeting<V>, u16) {
        Meeting::of(planes, facet, &self.origin, &self.direction)
    }

    #[inline(always)]
    fn accept(met: &mut Meeting<V>, other: &Meeting<V>, lanes: u16) -> u16 {
        met.accept(other, lanes)
    }
}

impl Packet {
    /// What a mirror makes of the derivatives, those of the origins being `by`.
    #[inline(always)]
    pub fn reflect<V: Lanes>(&mut self, by: &[Triple<V>; 2], normal: Triple<V>) {
        for ((by, origin_by), direction_by) in by.iter().zip(&mut self.origin_by).zip(&mut self.direction_by)
        {
            *origin_by = by.stored();
            let turn = Triple::<V>::load(direction_by);
            let along = normal.dot(turn);
            *direction_by = normal.fnma(along + along, turn).stored();
        }
    }

    /// The derivative of the meeting point by u or v.
    #[inline(always)]
    pub fn met_by<V: Lanes>(&self, axis: usize, exit: &Exit<V>) -> Triple<V> {
        let by = [Triple::load(&self.origin_by[axis]), Triple::load(&self.direction_by[axis])];
        met_by(by, Triple::load(&self.direction), exit)
    }
}

/// The derivative of a meeting point: ∂p + t ∂d + ∂t d with ∂t = −n·(∂p + t ∂d)/(n·d), of those of origin and direction.
#[inline(always)]
pub(crate) fn met_by<V: Lanes>(
    [by, turn]: [Triple<V>; 2],
    direction: Triple<V>,
    exit: &Exit<V>,
) -> Triple<V> {
    let across = turn.fma(exit.distance, by);
    let farther = exit.normal.dot(across) / exit.cosine;
    direction.fnma(farther, across)
}

impl Planes {
    /// The lanes of beams whose boxes cross a side of their facets; `by` are the derivatives of the meeting points.
    #[inline(always)]
    pub(crate) fn crossing<V: Lanes>(
        &self,
        met: &Meeting<V>,
        by: &[Triple<V>; 2],
        half: &[Row; 2],
        lanes: u16,
    ) -> u16 {
        let (half, point) = ([V::load(&half[0]), V::load(&half[1])], met.exit.point);
        // No beam is larger than this in any direction.
        let [along, down] = [by[0].dot(by[0]).sqrt(), by[1].dot(by[1]).sqrt()];
        let small = along.fma(half[0], down * half[1]).lt(met.inside);
        let facets = met.facet.stored();
        let (mut rest, mut crossing) = (lanes & !small.bits(), 0);
        while rest != 0 {
            let facet = facets.0[rest.trailing_zeros() as usize % WIDTH];
            let (.., sides) = self.facet(facet as usize);
            let mut beyond = V::splat(-1.0);
            for group in sides {
                for side in group {
                    let normal = Triple::<V>::splat(side.normal);
                    let at = normal.x.fma(point.x, V::splat(-side.offset));
                    let at = normal.z.fma(point.z, normal.y.fma(point.y, at));
                    let reach = normal.dot(by[0]).abs().fma(half[0], at);
                    beyond = beyond.max(normal.dot(by[1]).abs().fma(half[1], reach));
                }
            }
            let facet = V::splat(facet);
            let other = (met.facet.lt(facet) | facet.lt(met.facet)).bits();
            crossing |= V::splat(0.0).lt(beyond).bits() & rest & !other;
            rest &= other;
        }
        crossing
    }
}
