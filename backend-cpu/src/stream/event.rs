//! Surface events of a stream's rays.

use super::{
    Arrival, Stream,
    lines::{Gathered, Lines},
    rays::{LINE, PLACE, Packet, Ray, Rays, beam},
};
use crate::{
    account::{Account, Fate},
    basis::Basis,
    crystal::{self, Beam as Mode},
    environment::{Light, Lookup},
    planes::{Beam, Exit},
    sums::Sums,
    throughput::{Polarized, Throughput},
};
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, Work, exp2, put};
use spectral_core::{
    lattice::{CHOICES, MULTIPLIER, SHIFT},
    settings::Leftover,
    stokes::any_axis,
};

/// Packets followed together.
const BATCH: usize = 32;

/// The rays under way and what they need.
pub(super) struct Events<'a, V: Lanes> {
    pub stream: &'a Stream,
    pub light: &'a Light,
    pub lines: &'a Lines<'a>,
    /// Rays that carry less are dropped; of two modes of which one carries less than `choice`, one is followed for both.
    threshold: f32,
    choice: f32,
    pub rays: Rays,
    packets: Vec<Packet>,
    beams: Vec<Beam>,
    exits: Vec<Exit<V>>,
    sums: &'a mut Sums,
    pub account: &'a mut Account,
}

/// [`Events::arrive`] as a function of its own.
struct Arrive<'b, 'a, V: Lanes>(&'b mut Events<'a, V>, usize, &'b mut Gathered);

impl<V: Lanes> Work for Arrive<'_, '_, V> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        self.0.arrive(self.1, self.2);
    }
}

impl<'a, V: Lanes> Events<'a, V> {
    #[inline(always)]
    pub fn new(
        stream: &'a Stream,
        light: &'a Light,
        lines: &'a Lines<'a>,
        [threshold, choice]: [f32; 2],
        sums: &'a mut Sums,
        account: &'a mut Account,
    ) -> Self {
        let (packets, exits) = (vec![Packet::default(); BATCH], vec![Exit::nowhere(); BATCH]);
        let (rays, beams) = (Rays::new(), Vec::new());
        Events { stream, light, lines, threshold, choice, rays, packets, beams, exits, sums, account }
    }

    /// Whether there is enough to follow.
    #[inline(always)]
    pub fn are_full(&self) -> bool {
        self.rays.count() >= BATCH * WIDTH
    }

    /// Whether there is nothing to follow.
    #[inline(always)]
    pub fn are_over(&self) -> bool {
        self.rays.count() == 0
    }

    /// Follows some rays to the surface, the last of the stack.
    #[inline(always)]
    pub fn step(&mut self) {
        let mut left = self.rays.take(&mut self.packets);
        let count = left.div_ceil(WIDTH);
        self.beams.clear();
        for packet in &self.packets[..count] {
            let lanes = left.min(WIDTH);
            self.beams.push(beam(packet, ((1u32 << lanes) - 1) as u16));
            left -= lanes;
        }
        self.stream.planes.exits(&self.beams, &mut self.exits[..count]);
        let mut rows = [Row::default(); _];
        for k in 0..count {
            V::apart(Arrive(self, k, &mut rows));
        }
    }

    /// What happens to a packet at the surface.
    #[inline(always)]
    fn arrive(&mut self, k: usize, rows: &mut Gathered) {
        let (alive, exit) = (self.beams[k].alive, self.exits[k]);
        let mut ray = Ray::<V>::load(&self.packets[k]);
        let line = self.packets[k][LINE];
        let (modes, lanes) = self.meet(&mut ray, &exit, alive, &line, rows);
        let on = self.send_on(exit.point, &ray, &modes, lanes);
        let place = self.packets[k][PLACE];
        self.deliver(&place, ray.radiance, alive & !on);
    }

    /// What rays of some lines send back into the crystal where they meet its surface, and the lanes of those that may go on. The
    /// rays fade on their way, and see what is beyond the surface.
    #[inline(always)]
    pub fn meet(
        &mut self,
        ray: &mut Ray<V>,
        exit: &Exit<V>,
        alive: u16,
        line: &Row,
        rows: &mut Gathered,
    ) -> ([Mode<V>; 2], u16) {
        self.lines.gather::<V>(line, rows);
        let (bases, optics) = self.lines.optics(rows);
        let second = ray.depth.lt(V::splat(0.0));
        if let Some(exponent) = optics.fading(second, ray.wave, ray.direction, exit.distance) {
            ray.weight = ray.weight * exp2(exponent);
        }
        ray.depth = ray.depth.abs();
        let last = !ray.depth.lt(V::splat(self.stream.max_depth as f32));
        let lines = self.lines;
        let exact = |lane: usize| lines.exact(line.0[lane].to_bits());
        let going = alive & !last.bits();
        let sent = crystal::leave(optics, exact, second, (ray.wave, ray.weight), exit.normal, None, going);
        // At the depth limit a ray goes straight on with all it has.
        let seen = V::select(last, ray.weight, sent.row.intensity());
        let direction = Triple::select(last, ray.direction, sent.direction);
        let (mut out, last) = (alive & V::splat(0.0).lt(seen).bits(), alive & last.bits());
        if last != 0 {
            let drop = self.stream.leftover == Leftover::Drop;
            out &= if drop { !last } else { u16::MAX };
            let fate = if drop { Fate::DroppedDepth } else { Fate::LeftAtLimit };
            self.account.add_few(fate, &ray.weight.stored(), last);
        }
        if out != 0 {
            let colours = Lookup::new(self.light, exit.point, direction).colours(self.light, out);
            let light = Basis::expand_by(bases, colours).fma(seen, ray.radiance);
            ray.radiance = V::select(V::Mask::from_bits(out), light, ray.radiance);
        }
        self.account.count(u64::from(alive.count_ones() + out.count_ones()));
        (sent.back, alive & !last)
    }

    /// Stacks the rays that go on in the crystal; returns which of those that arrived have done so.
    #[inline(always)]
    fn send_on(&mut self, point: Triple<V>, ray: &Ray<V>, modes: &[Mode<V>; 2], lanes: u16) -> u16 {
        let ([first, second], next) = self.chosen(modes, ray.choice);
        let (ones, twos) = (self.surviving(lanes, first), self.surviving(lanes, second));
        let zero = V::splat(0.0);
        let depth = ray.depth + V::splat(1.0);
        // The first mode takes along what has been seen.
        let takes = V::Mask::from_bits(ones);
        let heir = Ray {
            origin: point,
            direction: Triple::select(takes, modes[0].ray, modes[1].ray),
            wave: Triple::select(takes, modes[0].normal, modes[1].normal),
            weight: V::select(takes, first, second),
            depth: V::select(takes, depth, -depth),
            choice: next,
            ..*ray
        };
        self.rays.push(&heir, ones | twos);
        if ones & twos != 0 {
            let (direction, wave) = (modes[1].ray, modes[1].normal);
            let other = Ray { direction, wave, weight: second, radiance: zero, depth: -depth, ..heir };
            self.rays.push(&other, ones & twos);
        }
        ones | twos
    }

    /// The weights of two modes, and the place of the next choice. If one is lighter than `choice` only one of them is followed,
    /// with the weight of both: each is chosen in proportion to its weight.
    #[inline(always)]
    pub fn chosen(&self, modes: &[Mode<V>; 2], place: V) -> ([V; 2], V) {
        let [first, second] = [modes[0].weight, modes[1].weight];
        let (least, zero) = (V::splat(self.choice), V::splat(0.0));
        let chooses = first.min(second).lt(least);
        let sum = first + second;
        let (choice, next) = chosen(place);
        let takes_first = (choice * sum).lt(first);
        let weights = [
            V::select(chooses, V::select(takes_first, sum, zero), first),
            V::select(chooses, V::select(takes_first, zero, sum), second),
        ];
        (weights, next)
    }

    /// The lanes whose weight is not below the threshold; what the others carry is dropped.
    #[inline(always)]
    pub fn surviving(&mut self, lanes: u16, weight: V) -> u16 {
        let lanes = lanes & V::splat(0.0).lt(weight).bits();
        let faint = weight.lt(V::splat(self.threshold)).bits() & lanes;
        if faint != 0 {
            self.account.add_few(Fate::DroppedThreshold, &weight.stored(), faint);
        }
        lanes & !faint
    }

    /// Adds what some lanes have seen.
    #[inline(always)]
    pub fn deliver(&mut self, places: &Row, radiance: V, mut lanes: u16) {
        if lanes == 0 {
            return;
        }
        let radiance = radiance.stored();
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % WIDTH;
            lanes &= lanes - 1;
            self.sums.add(places.0[lane].to_bits() as usize, radiance.0[lane]);
        }
    }

    /// The camera rays of a packet of lines of one pixel, `arrivals` being those of its samples; `behind`: whether the
    /// light behind the stone is seen.
    #[inline(always)]
    pub fn enter(&mut self, pixel: usize, arrivals: &[Arrival], block: usize, behind: bool) {
        let (lines, all) = self.lines.of_block(block);
        let [mut point, mut direction, mut inward, mut axis, mut colour] = [[Row::default(); 3]; 5];
        let [mut place, mut line, mut order] = [Row::default(); 3];
        let mut covered = 0;
        for (lane, &number) in lines.iter().enumerate() {
            let arrival = &arrivals[self.lines.sample(number)];
            put(&mut point, lane, arrival.point);
            put(&mut direction, lane, arrival.direction);
            put(&mut inward, lane, arrival.inward);
            put(&mut axis, lane, any_axis(arrival.direction));
            put(&mut colour, lane, arrival.colour);
            place.0[lane] = f32::from_bits((pixel * self.lines.len()) as u32 + number);
            line.0[lane] = f32::from_bits(number);
            order.0[lane] = self.lines.order(number);
            covered |= u16::from(arrival.covered) << lane;
        }
        let lanes = all & covered;
        let mut rows = [Row::default(); _];
        self.lines.gather::<V>(&line, &mut rows);
        let (bases, optics) = self.lines.optics(&rows);
        if behind && lanes != all {
            self.account.count(u64::from((all & !lanes).count_ones()));
            self.deliver(&place, Basis::expand_by(bases, Triple::<V>::load(&colour)), all & !lanes);
        }
        if lanes == 0 {
            return;
        }
        let (point, direction) = (Triple::<V>::load(&point), Triple::load(&direction));
        let (number, normal) = (self.lines, Triple::load(&inward));
        let exact = |lane: usize| number.exact(lines[lane]);
        let row = Polarized::eye(Triple::load(&axis));
        let sent = crystal::enter(optics, exact, row, [direction, normal], None, lanes);
        let seen = sent.row.intensity();
        let out = lanes & V::splat(0.0).lt(seen).bits();
        let colours = Lookup::new(self.light, point, sent.direction).colours(self.light, out);
        let radiance =
            V::select(V::Mask::from_bits(out), Basis::expand_by(bases, colours) * seen, V::splat(0.0));
        self.account.count(u64::from(lanes.count_ones() + out.count_ones()));
        let zero = V::splat(0.0);
        let ray = Ray {
            origin: point,
            direction,
            wave: direction,
            weight: V::splat(1.0),
            radiance,
            depth: zero,
            choice: V::load(&order),
            place: V::load(&place),
            line: V::load(&line),
        };
        let on = self.send_on(point, &ray, &sent.on, lanes);
        self.deliver(&place, radiance, lanes & !on);
    }
}

/// By what rays choose one of two modes, and the place of their next choice: the twin of `lattice::chosen`.
#[inline(always)]
fn chosen<V: Lanes>(place: V) -> (V, V) {
    let count = V::splat(CHOICES as f32);
    let (one, zero) = (V::splat(1.0), V::splat(0.0));
    let both = count + count;
    let shifted = place + V::splat(SHIFT as f32);
    let middle = shifted + shifted + count;
    let choice = V::select(middle.lt(both), middle, middle - both) / both;
    // All numbers are whole and below 2²⁴.
    let product = place * V::splat(MULTIPLIER as f32);
    let next = (product * (one / count)).floor().fnma(count, product);
    let next = V::select(next.lt(zero), next + count, next);
    (choice, V::select(next.lt(count), next, next - count))
}
