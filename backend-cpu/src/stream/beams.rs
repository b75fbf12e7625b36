//! Beams of the modes of a crystal: those that are heavy enough to be cut. The others go on as rays.

use super::{
    event::Events,
    lines::Gathered,
    rays::{Ray, triple},
};
use crate::{
    basis::Basis,
    beam::{
        entry::Arrivals,
        flight::Place,
        packet::{Meeting, met_by},
        part::{self, Divisible, Pencil},
    },
    crystal::{self, Beam as Mode},
    planes::{Planes, Travellers},
    throughput::{Polarized, Throughput},
};
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, Work};
use glam::Vec3A;
use spectral_core::{
    beam::{Limits, Polygon},
    lattice,
};

/// Packets followed together.
const BATCH: usize = 32;

/// Numbers of a beam: its ray's, as of a [`Ray`], then the derivatives of origin, direction and N by u and v, and half the size of a
/// box about the centroid that holds the polygon.
const NUMBERS: usize = 32;
/// In fours.
type Numbers = [[f32; 4]; NUMBERS / 4];
const ORIGIN: usize = 0;
const DIRECTION: usize = 3;
const WAVE: usize = 6;
const WEIGHT: usize = 9;
const DEPTH: usize = 10;
const CHOICE: usize = 11;
const ORIGIN_BY: usize = 12;
const DIRECTION_BY: usize = 18;
const WAVE_BY: usize = 24;
const HALF: usize = 30;

/// A beam of one mode of the crystal. Its reference ray is that of its polygon's centroid.
#[derive(Debug, Clone, Copy)]
struct Beam {
    numbers: Numbers,
    polygon: Polygon,
    place: u32,
    line: u32,
}

/// Sixteen beams.
#[derive(Debug, Clone)]
struct Packet {
    alive: u16,
    rows: [Row; NUMBERS],
    place: Row,
    line: Row,
}

/// The beams under way, and the rays that they have become.
pub(super) struct Beams<'a, V: Lanes> {
    pub events: Events<'a, V>,
    limits: Limits,
    waiting: Vec<Beam>,
    batch: Vec<Beam>,
    packets: Vec<Packet>,
    meetings: Vec<Meeting<V>>,
}

/// Where beams go on from: their rays, and the derivatives of their places and of their wave vectors there.
struct Start<'b, V> {
    ray: &'b Ray<V>,
    normal: Triple<V>,
    origin_by: [Triple<V>; 2],
    wave_by: [Triple<V>; 2],
    half: [V; 2],
    polygons: [&'b Polygon; WIDTH],
}

/// [`Beams::arrive`] as a function of its own.
struct Arrive<'b, 'a, V: Lanes>(&'b mut Beams<'a, V>, usize, &'b mut Gathered);

impl<V: Lanes> Work for Arrive<'_, '_, V> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        self.0.arrive(self.1, self.2);
    }
}

impl Beam {
    fn vector(&self, first: usize) -> Vec3A {
        Vec3A::from_slice(&self.numbers.as_flattened()[first..])
    }

    fn set(&mut self, first: usize, vector: Vec3A) {
        self.numbers.as_flattened_mut()[first..first + 3].copy_from_slice(&vector.to_array());
    }

    fn pencil(&self) -> Pencil {
        let two = |first: usize| [self.vector(first), self.vector(first + 3)];
        Pencil {
            origin: self.vector(ORIGIN),
            direction: self.vector(DIRECTION),
            origin_by: two(ORIGIN_BY),
            direction_by: two(DIRECTION_BY),
        }
    }
}

impl Divisible for Beam {
    fn polygon(&mut self) -> &mut Polygon {
        &mut self.polygon
    }

    fn divided(&mut self, share: f32, side: usize) -> Self {
        let mut rest = *self;
        rest.numbers.as_flattened_mut()[WEIGHT] *= 1.0 - share;
        let numbers = self.numbers.as_flattened_mut();
        numbers[WEIGHT] *= share;
        numbers[CHOICE] = lattice::part(numbers[CHOICE] as u32, side) as f32;
        rest
    }

    /// N leaves its sheet by the square of what it moves by. Its part in the next surface is what counts, and the waves there are
    /// again on their sheets.
    fn recentre(&mut self, [u, v]: [f64; 2]) {
        let pencil = self.pencil().about([u, v]);
        self.set(ORIGIN, pencil.origin);
        self.set(DIRECTION, pencil.direction);
        for k in 0..2 {
            self.set(DIRECTION_BY + 3 * k, pencil.direction_by[k]);
        }
        let [by_u, by_v] = [self.vector(WAVE_BY), self.vector(WAVE_BY + 3)];
        self.set(WAVE, self.vector(WAVE) + by_u * u as f32 + by_v * v as f32);
        self.polygon.shift([-u, -v]);
        for axis in 0..2 {
            self.numbers.as_flattened_mut()[HALF + axis] = reach(&self.polygon, axis);
        }
    }
}

/// How far a polygon reaches from (0, 0) along an axis.
fn reach(polygon: &Polygon, axis: usize) -> f32 {
    polygon.vertices().iter().map(|vertex| vertex[axis].abs()).fold(0.0, f64::max) as f32
}

impl Packet {
    fn new() -> Self {
        Packet { alive: 0, rows: [Row::default(); NUMBERS], place: Row::default(), line: Row::default() }
    }

    /// Of up to sixteen beams; what is not in use repeats the last.
    #[inline(always)]
    fn load<V: Lanes>(&mut self, beams: &[Beam]) {
        self.alive = ((1u32 << beams.len()) - 1) as u16;
        let mut numbers = [&beams[0].numbers; WIDTH];
        for (lane, numbers) in numbers.iter_mut().enumerate() {
            let beam = &beams[lane.min(beams.len() - 1)];
            *numbers = &beam.numbers;
            self.place.0[lane] = f32::from_bits(beam.place);
            self.line.0[lane] = f32::from_bits(beam.line);
        }
        for (place, rows) in self.rows.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            for (row, number) in rows.iter_mut().zip(V::fours(&numbers, place)) {
                number.store(row);
            }
        }
    }

    #[inline(always)]
    fn vector<V: Lanes>(&self, first: usize) -> Triple<V> {
        triple(&self.rows[first..])
    }

    #[inline(always)]
    fn ray<V: Lanes>(&self) -> Ray<V> {
        Ray {
            origin: self.vector(ORIGIN),
            direction: self.vector(DIRECTION),
            wave: self.vector(WAVE),
            weight: V::load(&self.rows[WEIGHT]),
            radiance: V::splat(0.0),
            depth: V::load(&self.rows[DEPTH]),
            choice: V::load(&self.rows[CHOICE]),
            place: V::load(&self.place),
            line: V::load(&self.line),
        }
    }

    fn rows_at<const N: usize>(&self, first: usize) -> &[Row; N] {
        self.rows[first..].first_chunk().expect("a packet has all numbers")
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
        [ORIGIN, DIRECTION].map(|first| [0, 1, 2].map(|i| self.rows[first + i].0[lane % WIDTH]))
    }

    #[inline(always)]
    fn verify(&self, planes: &Planes, facet: u16) -> (Meeting<V>, u16) {
        Meeting::of(planes, facet, self.rows_at(ORIGIN), self.rows_at(DIRECTION))
    }

    #[inline(always)]
    fn accept(met: &mut Meeting<V>, other: &Meeting<V>, lanes: u16) -> u16 {
        met.accept(other, lanes)
    }
}

impl<'a, V: Lanes> Beams<'a, V> {
    #[inline(always)]
    pub fn new(events: Events<'a, V>, limits: Limits) -> Self {
        let (packets, meetings) = (vec![Packet::new(); BATCH], vec![Meeting::nowhere(); BATCH]);
        Beams { events, limits, waiting: Vec::new(), batch: Vec::new(), packets, meetings }
    }

    /// Whether there is enough to follow.
    #[inline(always)]
    pub fn are_full(&self) -> bool {
        self.waiting.len() >= BATCH * WIDTH
    }

    /// Whether there is nothing to follow.
    #[inline(always)]
    pub fn are_over(&self) -> bool {
        self.waiting.is_empty() && self.events.are_over()
    }

    /// Follows some rays or beams to the surface.
    #[inline(always)]
    pub fn step(&mut self) {
        if self.waiting.is_empty() || self.events.are_full() {
            return self.events.step();
        }
        let first = self.waiting.len().saturating_sub(BATCH * WIDTH);
        self.batch.clear();
        self.batch.extend_from_slice(&self.waiting[first..]);
        self.waiting.truncate(first);
        for (packet, beams) in self.packets.iter_mut().zip(self.batch.chunks(WIDTH)) {
            packet.load::<V>(beams);
        }
        let count = self.batch.len().div_ceil(WIDTH);
        self.events.stream.planes.exits::<V, Packet>(&self.packets[..count], &mut self.meetings);
        let mut rows = [Row::default(); _];
        for k in 0..count {
            V::apart(Arrive(self, k, &mut rows));
        }
    }

    /// What happens to a packet at the surface.
    #[inline(always)]
    fn arrive(&mut self, k: usize, rows: &mut Gathered) {
        let origin_by = self.cut(k);
        let (packet, exit) = (&self.packets[k], self.meetings[k].exit);
        let mut ray = packet.ray::<V>();
        let (modes, lanes) = self.events.meet(&mut ray, &exit, packet.alive, &packet.line, rows);
        ray.origin = exit.point;
        self.events.deliver(&packet.place, ray.radiance, packet.alive);
        ray.radiance = V::splat(0.0);
        let beams = &self.batch[k * WIDTH..];
        let from = Start {
            ray: &ray,
            normal: exit.normal,
            origin_by,
            wave_by: [packet.vector(WAVE_BY), packet.vector(WAVE_BY + 3)],
            half: [V::load(&packet.rows[HALF]), V::load(&packet.rows[HALF + 1])],
            polygons: std::array::from_fn(|lane| &beams[lane.min(beams.len() - 1)].polygon),
        };
        send_on(&mut self.events, &mut self.waiting, self.limits.split, &from, &modes, lanes, rows);
    }

    /// The derivatives of a packet's meeting points; cuts the beams that meet more than one facet.
    #[inline(always)]
    fn cut(&mut self, k: usize) -> [Triple<V>; 2] {
        let (packet, met, planes) = (&self.packets[k], &self.meetings[k], &self.events.stream.planes);
        let direction = packet.vector(DIRECTION);
        let by = [
            met_by([packet.vector(ORIGIN_BY), packet.vector(DIRECTION_BY)], direction, &met.exit),
            met_by([packet.vector(ORIGIN_BY + 3), packet.vector(DIRECTION_BY + 3)], direction, &met.exit),
        ];
        let weight = V::load(&packet.rows[WEIGHT]);
        let heavy = packet.alive & !weight.lt(V::splat(self.limits.split as f32)).bits();
        let mut lanes = planes.crossing(met, &by, packet.rows_at(HALF), heavy);
        if lanes == 0 {
            return by;
        }
        let mut place = Place::of(met, &by);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % WIDTH;
            lanes &= lanes - 1;
            let beam = &mut self.batch[k * WIDTH + lane];
            cut(planes, beam, &mut self.packets[k], lane, &mut place, &mut self.waiting);
        }
        place.to(&mut self.meetings[k])
    }

    /// A packet of camera rays.
    #[inline(always)]
    pub fn enter(&mut self, arrivals: &Arrivals<'_>, rows: &mut Gathered) {
        let (events, lanes) = (&mut self.events, arrivals.lanes);
        let lines = events.lines;
        let numbers = arrivals.place.map(|place| place % lines.len() as u32);
        let line = Row(numbers.map(f32::from_bits));
        lines.gather::<V>(&line, rows);
        let (bases, optics) = lines.optics(rows);
        let (direction, normal) = (Triple::<V>::load(&arrivals.direction), Triple::load(&arrivals.ahead));
        let zero = V::splat(0.0);
        let row = Polarized {
            row: [V::load(&arrivals.area), zero, zero, zero],
            axis: Triple::load(&arrivals.axis),
        };
        let exact = |lane: usize| lines.exact(numbers[lane]);
        let sent = crystal::enter(optics, exact, row, [direction, normal], None, lanes);
        let place = Row(arrivals.place.map(f32::from_bits));
        let mirrored = Basis::expand_by(bases, Triple::<V>::load(&arrivals.colour)) * sent.row.intensity();
        events.deliver(&place, mirrored, lanes);
        events.account.count(u64::from(2 * lanes.count_ones()));
        let ray = Ray {
            origin: Triple::load(&arrivals.origin),
            direction,
            wave: direction,
            weight: row.row[0],
            radiance: zero,
            depth: zero,
            choice: V::load(&Row(numbers.map(|number| lines.order(number)))),
            place: V::load(&place),
            line: V::load(&line),
        };
        let mut half = [Row::default(); 2];
        for (lane, polygon) in arrivals.polygon.iter().enumerate() {
            for (axis, half) in half.iter_mut().enumerate() {
                half.0[lane] = reach(polygon, axis);
            }
        }
        let from = Start {
            ray: &ray,
            normal,
            origin_by: [Triple::load(&arrivals.origin_by[0]), Triple::load(&arrivals.origin_by[1])],
            wave_by: [Triple::load(&arrivals.direction_by[0]), Triple::load(&arrivals.direction_by[1])],
            half: [V::load(&half[0]), V::load(&half[1])],
            polygons: arrivals.polygon.each_ref(),
        };
        send_on(events, &mut self.waiting, self.limits.split, &from, &sent.on, lanes, rows);
    }
}

/// Stacks what goes on in the crystal, as beams or where it is lighter than `split` as rays; `rows` are the optics of its lines.
#[inline(always)]
fn send_on<V: Lanes>(
    events: &mut Events<'_, V>,
    waiting: &mut Vec<Beam>,
    split: f64,
    from: &Start<'_, V>,
    modes: &[Mode<V>; 2],
    lanes: u16,
    rows: &Gathered,
) {
    let (weights, choice) = events.chosen(modes, from.ray.choice);
    let depth = from.ray.depth + V::splat(1.0);
    let (_, optics) = events.lines.optics(rows);
    for second in [false, true] {
        let (mode, weight) = (&modes[usize::from(second)], weights[usize::from(second)]);
        let on = events.surviving(lanes, weight);
        let heavy = on & !weight.lt(V::splat(split as f32)).bits();
        let depth = if second { -depth } else { depth };
        let ray = Ray { direction: mode.ray, wave: mode.normal, weight, depth, choice, ..*from.ray };
        if on & !heavy != 0 {
            events.rays.push(&ray, on & !heavy);
        }
        if heavy != 0 {
            // ∂N' = ∂q + ∂ζ' n with ŝ'·∂N' = 0: `spectral_core::beam::Vectors`.
            let steep = V::splat(1.0) / mode.ray.dot(from.normal);
            let wave_by = [from.sent(0, mode.ray, steep), from.sent(1, mode.ray, steep)];
            let direction_by = optics.rays_by(second, [mode.normal, mode.ray], &wave_by);
            push(waiting, from, &ray, [from.origin_by, direction_by, wave_by], heavy);
        }
    }
}

impl<V: Lanes> Start<'_, V> {
    /// A derivative of the wave vector that goes with a ray: what is tangential stays.
    #[inline(always)]
    fn sent(&self, k: usize, ray: Triple<V>, steep: V) -> Triple<V> {
        let tangential = self.normal.fnma(self.normal.dot(self.wave_by[k]), self.wave_by[k]);
        self.normal.fnma(ray.dot(tangential) * steep, tangential)
    }
}

/// Stacks the beams of some lanes.
#[inline(always)]
fn push<V: Lanes>(
    waiting: &mut Vec<Beam>,
    from: &Start<'_, V>,
    ray: &Ray<V>,
    by: [[Triple<V>; 2]; 3],
    mut lanes: u16,
) {
    let mut rows = [Row::default(); NUMBERS];
    let vectors = [ray.origin, ray.direction, ray.wave];
    for (first, vector) in [ORIGIN, DIRECTION, WAVE].into_iter().zip(vectors) {
        rows[first..first + 3].copy_from_slice(&vector.stored());
    }
    rows[WEIGHT] = ray.weight.stored();
    rows[DEPTH] = ray.depth.stored();
    rows[CHOICE] = ray.choice.stored();
    for (first, by) in [ORIGIN_BY, DIRECTION_BY, WAVE_BY].into_iter().zip(by) {
        rows[first..first + 3].copy_from_slice(&by[0].stored());
        rows[first + 3..first + 6].copy_from_slice(&by[1].stored());
    }
    rows[HALF] = from.half[0].stored();
    rows[HALF + 1] = from.half[1].stored();
    let (places, lines) = (ray.place.stored(), ray.line.stored());
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize % WIDTH;
        lanes &= lanes - 1;
        let mut numbers: Numbers = Default::default();
        for (number, row) in numbers.as_flattened_mut().iter_mut().zip(&rows) {
            *number = row.0[lane];
        }
        let (place, line) = (places.0[lane].to_bits(), lines.0[lane].to_bits());
        waiting.push(Beam { numbers, polygon: *from.polygons[lane], place, line });
    }
}

/// Cuts one beam where its facet ends. What is beyond waits; what is left goes on about its own centroid.
#[inline(never)]
fn cut(
    planes: &Planes,
    beam: &mut Beam,
    packet: &mut Packet,
    lane: usize,
    place: &mut Place,
    waiting: &mut Vec<Beam>,
) {
    let facet = place.facet.0[lane] as usize;
    if !part::cut(beam, planes, facet, &place.met(lane), waiting) {
        return;
    }
    for (row, number) in packet.rows.iter_mut().zip(beam.numbers.as_flattened()) {
        row.0[lane] = *number;
    }
    let (normal, offset, _) = planes.facet(facet);
    place.set(lane, &beam.pencil().met(normal.into(), offset));
}
