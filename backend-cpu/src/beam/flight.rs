//! Packets of beams on their way through the stone, from surface to surface.

use super::{
    entry::Arrivals,
    line::Line,
    packet::{Meeting, Packet},
    part::{self, Met, Part},
};
use crate::{
    account::{Account, Fate},
    chain::Chain,
    environment::{Light, Lookup},
    incidence::Incidence,
    planes::Planes,
    sums::Sums,
    throughput::Stored,
};
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, exp2, put};
use spectral_core::{beam::Limits, settings::Leftover};
use std::marker::PhantomData;

/// Packets under way.
const BATCH: usize = 32;
/// So many waiting beams are followed before others enter.
const CROWD: usize = 1024;
/// A packet with so few beams is given up, and they wait for others.
const FEW: u32 = 4;

/// What a packet has just sent out of the stone.
#[derive(Clone, Copy)]
struct Outgoing<V> {
    packet: usize,
    direction: Triple<V>,
    lookup: Lookup<V>,
    intensity: V,
    lanes: u16,
}

/// The beams under way and those that wait.
pub(super) struct Flight<'a, V: Lanes, T> {
    chain: &'a Chain,
    light: &'a Light,
    limits: Limits,
    lines: &'a [Line],
    absorbs: bool,
    /// The first ones are under way.
    packets: Vec<Packet>,
    /// How many of those there are.
    count: usize,
    meetings: Vec<Meeting<V>>,
    outgoing: Vec<Outgoing<V>>,
    /// How many of those there are.
    leaving: usize,
    waiting: Vec<Part>,
    sums: &'a mut Sums,
    account: &'a mut Account,
    throughput: PhantomData<T>,
}

impl<'a, V: Lanes, T: Stored<V>> Flight<'a, V, T> {
    #[inline(always)]
    pub fn new(
        chain: &'a Chain,
        light: &'a Light,
        limits: Limits,
        lines: &'a [Line],
        sums: &'a mut Sums,
        account: &'a mut Account,
    ) -> Self {
        let (zero, direction) = (V::splat(0.0), Triple::splat([0.0; 3]));
        let nothing = Outgoing { packet: 0, direction, lookup: Lookup::nowhere(), intensity: zero, lanes: 0 };
        Flight {
            chain,
            light,
            limits,
            lines,
            absorbs: lines.iter().any(|line| line.medium[3] > 0.0),
            packets: vec![Packet::new(); BATCH],
            count: 0,
            meetings: vec![Meeting::nowhere(); BATCH],
            outgoing: vec![nothing; BATCH],
            leaving: 0,
            waiting: Vec::with_capacity(2 * CROWD),
            sums,
            account,
            throughput: PhantomData,
        }
    }

    /// Whether another packet may enter.
    #[inline(always)]
    pub fn has_room(&self) -> bool {
        self.count < BATCH && self.waiting.len() < CROWD
    }

    /// Whether nothing is under way.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// A packet of camera rays.
    #[inline(always)]
    pub fn enter(&mut self, arrivals: &Arrivals<'_>) {
        let lanes = arrivals.lanes;
        let packet = &mut self.packets[self.count];
        for lane in 0..WIDTH {
            let line = &self.lines[usize::from(arrivals.line[lane])];
            packet.set_medium(lane, &line.medium, &line.basis);
            packet.set_polygon(lane, &arrivals.polygon[lane]);
        }
        (packet.line, packet.place) = (arrivals.line, arrivals.place);
        let at = Incidence::<V>::entering(V::load(&arrivals.cosine), &arrivals.inverse);
        let (ahead, area) = (Triple::load(&arrivals.ahead), V::load(&arrivals.area));
        let [mirrored, mean, half] = at.shares();
        let seen = packet.basis.expand(Triple::<V>::load(&arrivals.colour)) * mirrored * area;
        self.sums.add_lanes(&packet.place, &seen.stored(), lanes);
        self.account.count(u64::from(2 * lanes.count_ones()));
        packet.origin = arrivals.origin;
        packet.direction = at.refracted(Triple::load(&arrivals.direction), ahead).stored();
        packet.origin_by = arrivals.origin_by;
        // c = n·cos θ₁ − cos θ₂ is what the direction has of the normal: its derivative is n (1 − n cos θ₁/cos θ₂) that of cos θ₁.
        let bend = (at.n * at.cos_i / at.root.max(V::splat(1e-6))).fnma(at.n, at.n);
        for axis in 0..2 {
            let by = Triple::<V>::load(&arrivals.direction_by[axis]).scaled(at.n);
            let along = bend * V::load(&arrivals.cosine_by[axis]);
            packet.direction_by[axis] = ahead.fnma(along, by).stored();
        }
        let throughput = T::entering(mean * area, half * area, &arrivals.axis);
        packet.throughput = throughput.stored();
        packet.depth = Row([1.0; WIDTH]);
        let alive = self.surviving(&throughput, lanes);
        self.packets[self.count].alive = alive;
        self.count += usize::from(alive != 0);
    }

    /// Packets of beams that have waited, if there are enough, or `all`.
    #[inline(always)]
    pub fn board(&mut self, all: bool) {
        while self.count < BATCH && (self.waiting.len() >= WIDTH || all && !self.waiting.is_empty()) {
            let first = self.waiting.len().saturating_sub(WIDTH);
            let packet = &mut self.packets[self.count];
            for lane in 0..WIDTH {
                // What is not in use repeats the last.
                let part = &self.waiting[(first + lane).min(self.waiting.len() - 1)];
                let line = &self.lines[usize::from(part.line)];
                packet.put(lane, part, &line.medium, &line.basis);
            }
            packet.alive = ((1u32 << (self.waiting.len() - first)) - 1) as u16;
            self.waiting.truncate(first);
            self.count += 1;
        }
    }

    /// Follows every packet to its next surface.
    #[inline(always)]
    pub fn step(&mut self) {
        self.chain.planes().exits::<V, Packet>(&self.packets[..self.count], &mut self.meetings);
        self.leaving = 0;
        for k in 0..self.count {
            self.arrive(k);
        }
        self.gather();
        self.retire();
    }

    /// The derivatives of a packet's meeting points, where any of its beams is heavy enough to be cut; cuts those that meet
    /// more than one facet.
    #[inline(always)]
    fn cut(&mut self, k: usize) -> Option<[Triple<V>; 2]> {
        let (packet, met, planes) = (&self.packets[k], &self.meetings[k], self.chain.planes());
        let weight = T::load(&packet.throughput).intensity();
        let heavy = packet.alive & !weight.lt(V::splat(self.limits.split as f32)).bits();
        if heavy == 0 {
            return None;
        }
        let mut by = [packet.met_by(0, &met.exit), packet.met_by(1, &met.exit)];
        let mut lanes = planes.crossing(met, &by, &packet.half, heavy);
        if lanes != 0 {
            let mut place = Place::of(met, &by);
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize % WIDTH;
                lanes &= lanes - 1;
                cut(planes, &mut self.packets[k], lane, &mut place, &mut self.waiting);
            }
            by = place.to(&mut self.meetings[k]);
        }
        Some(by)
    }

    /// One internal reflection of a packet, and what leaves there.
    #[inline(always)]
    fn arrive(&mut self, k: usize) {
        let by = self.cut(k);
        let (packet, met) = (&mut self.packets[k], &self.meetings[k].exit);
        let direction = Triple::load(&packet.direction);
        let [n, n2, one_less, absorption] = &packet.medium;
        let mut throughput = T::load(&packet.throughput);
        if self.absorbs {
            throughput = throughput.scaled(exp2(-(V::load(absorption) * met.distance)));
        }
        let at = Incidence::new(met.cosine, V::load(n), V::load(n2), V::load(one_less));
        let (kept, leaving) = throughput.reflected(direction, met.normal, &at);
        let depth = V::load(&packet.depth);
        let ending = !depth.lt(V::splat(self.chain.max_depth as f32));
        let (alive, limit) = (packet.alive, packet.alive & ending.bits());
        let intensity = V::select(ending, throughput.intensity(), leaving);
        let straight = at.total & ending;
        let out = Triple::select(straight, direction, at.refracted(direction, met.normal));
        packet.origin = met.point.stored();
        packet.direction = at.reflected(direction, met.normal).stored();
        if let Some(by) = by {
            packet.reflect(&by, met.normal);
        }
        packet.throughput = kept.stored();
        packet.depth = (depth + V::splat(1.0)).stored();
        let mut leaves = (alive & !at.total.bits()) | limit;
        self.account.count(u64::from((alive & !limit).count_ones() + leaves.count_ones()));
        if limit != 0 {
            leaves = self.end(limit, leaves, intensity);
        }
        let outgoing = &mut self.outgoing[self.leaving];
        (outgoing.packet, outgoing.lanes) = (k, leaves);
        (outgoing.direction, outgoing.intensity) = (out, intensity);
        self.leaving += usize::from(leaves != 0);
        self.packets[k].alive = self.surviving(&kept, alive & !limit);
    }

    /// Accounts for rays at the depth limit; returns the lanes that leave.
    #[inline(always)]
    fn end(&mut self, limit: u16, leaves: u16, intensity: V) -> u16 {
        if self.chain.leftover == Leftover::Drop {
            self.account.add(Fate::DroppedDepth, &intensity.only(limit));
            return leaves & !limit;
        }
        self.account.add(Fate::LeftAtLimit, &intensity.only(limit));
        leaves
    }

    /// The lanes that are worth following; the others are dropped.
    #[inline(always)]
    fn surviving(&mut self, throughput: &T, lanes: u16) -> u16 {
        let weight = throughput.intensity();
        let faint = weight.lt(V::splat(self.limits.end as f32)).bits() & lanes;
        if faint != 0 {
            self.account.add(Fate::DroppedThreshold, &weight.only(faint));
        }
        lanes & !faint
    }

    /// Adds the light of what has just left the stone.
    #[inline(always)]
    fn gather(&mut self) {
        let outgoing = &mut self.outgoing[..self.leaving];
        for out in outgoing.iter_mut() {
            let origin = Triple::load(&self.packets[out.packet].origin);
            out.lookup = Lookup::new(self.light, origin, out.direction);
        }
        for out in outgoing {
            let packet = &self.packets[out.packet];
            let light = packet.basis.expand(out.lookup.colours(self.light, out.lanes)) * out.intensity;
            self.sums.add_lanes(&packet.place, &light.stored(), out.lanes);
        }
    }

    /// Gives up the packets of which little is left.
    #[inline(always)]
    fn retire(&mut self) {
        let mut k = 0;
        while k < self.count {
            let packet = &self.packets[k];
            let beams = packet.alive.count_ones();
            if beams > FEW || beams > 0 && self.waiting.len() < 2 * WIDTH {
                k += 1;
                continue;
            }
            for lane in (0..WIDTH).filter(|lane| packet.alive >> lane & 1 == 1) {
                self.waiting.push(packet.part(lane));
            }
            self.count -= 1;
            if k < self.count {
                let (first, last) = self.packets.split_at_mut(self.count);
                first[k].clone_from(&last[0]);
            }
        }
    }
}

/// What a cut reads and writes of a meeting, in memory.
pub(crate) struct Place {
    point: [Row; 3],
    by: [[Row; 3]; 2],
    cosine: Row,
    distance: Row,
    pub facet: Row,
}

impl Place {
    #[inline(always)]
    pub fn of<V: Lanes>(met: &Meeting<V>, by: &[Triple<V>; 2]) -> Self {
        Place {
            point: met.exit.point.stored(),
            by: [by[0].stored(), by[1].stored()],
            cosine: met.exit.cosine.stored(),
            distance: met.exit.distance.stored(),
            facet: met.facet.stored(),
        }
    }

    #[inline(always)]
    pub fn to<V: Lanes>(&self, met: &mut Meeting<V>) -> [Triple<V>; 2] {
        met.exit.point = Triple::load(&self.point);
        (met.exit.cosine, met.exit.distance) = (V::load(&self.cosine), V::load(&self.distance));
        [Triple::load(&self.by[0]), Triple::load(&self.by[1])]
    }

    pub fn met(&self, lane: usize) -> Met {
        let vector = |rows: &[Row; 3]| glam::Vec3A::new(rows[0].0[lane], rows[1].0[lane], rows[2].0[lane]);
        Met {
            point: vector(&self.point),
            by: [vector(&self.by[0]), vector(&self.by[1])],
            cosine: self.cosine.0[lane],
            distance: self.distance.0[lane],
        }
    }

    pub fn set(&mut self, lane: usize, met: &Met) {
        put(&mut self.point, lane, met.point.to_array());
        for axis in 0..2 {
            put(&mut self.by[axis], lane, met.by[axis].to_array());
        }
        (self.cosine.0[lane], self.distance.0[lane]) = (met.cosine, met.distance);
    }
}

/// Cuts one beam where its facet ends. What is beyond waits; what is left goes on about its own centroid.
#[inline(never)]
fn cut(planes: &Planes, packet: &mut Packet, lane: usize, place: &mut Place, waiting: &mut Vec<Part>) {
    let facet = place.facet.0[lane] as usize;
    let mut part = packet.part(lane);
    if !part::cut(&mut part, planes, facet, &place.met(lane), waiting) {
        return;
    }
    packet.set_pencil(lane, &part.pencil);
    packet.set_polygon(lane, &part.polygon);
    packet.set_throughput(lane, &part.throughput);
    let (normal, offset, _) = planes.facet(facet);
    place.set(lane, &part.pencil.met(normal.into(), offset));
}
