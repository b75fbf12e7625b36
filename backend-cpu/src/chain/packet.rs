//! Packets of sixteen wavelengths on their way through one convex stone.
//!
//! What leaves a convex stone never comes back, so a path is a chain of internal reflections. All packets of a batch make
//! their next reflection together, in phases: first exits, then Fresnel's equations, then where the light lies that
//! leaving rays see, then that light. Packets are independent, so the processor overlaps the arithmetic of one with the
//! memory access of another. Whether a ray leaves is hard to predict, so those that do are listed, without a branch.

use super::Chain;
use crate::{
    account::{Account, Fate},
    block::Block,
    environment::{Light, Lookup},
    incidence::Incidence,
    planes::{BATCH, Beam, Exit},
    throughput::Throughput,
};
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, put};
use spectral_core::settings::Leftover;

/// A camera ray's arrival at the stone, or its passing by.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Arrival {
    /// Whether it meets the stone; if not, only the colour counts.
    pub covered: bool,
    pub point: [f32; 3],
    pub direction: [f32; 3],
    /// Unit normal into the stone.
    pub inward: [f32; 3],
    /// e_s of the plane of incidence.
    pub axis: [f32; 3],
    /// Cosine of the angle of incidence.
    pub cosine: f32,
    /// The colour of the light that the first surface mirrors; of a ray that passes by, that behind the stone.
    pub colour: [f32; 3],
}

/// What sixteen wavelengths carry along their [`Beam`].
struct Packet<V, T> {
    throughput: T,
    radiance: V,
    /// What was left of the rays that were too faint to follow.
    faint: V,
    block: usize,
    /// Where the radiances of its pixels begin.
    place: usize,
    /// Surface events so far.
    depth: u32,
}

/// What a packet has just sent out of the stone.
#[derive(Clone, Copy)]
struct Outgoing<V> {
    packet: usize,
    direction: Triple<V>,
    lookup: Lookup<V>,
    intensity: V,
    lanes: u16,
}

/// The packets under way and what they need.
pub(crate) struct Batch<'a, V: Lanes, T> {
    chain: &'a Chain,
    light: &'a Light,
    blocks: &'a [Block],
    beams: Vec<Beam>,
    packets: Vec<Packet<V, T>>,
    exits: Vec<Exit<V>>,
    outgoing: Vec<Outgoing<V>>,
    /// How many of those there are.
    leaving: usize,
    /// One number a lane, of all pixels of the tile.
    radiances: &'a mut [f32],
    account: &'a mut Account,
}

impl<'a, V: Lanes, T: Throughput<V>> Batch<'a, V, T> {
    #[inline(always)]
    pub fn new(
        chain: &'a Chain,
        light: &'a Light,
        blocks: &'a [Block],
        radiances: &'a mut [f32],
        account: &'a mut Account,
    ) -> Self {
        let (zero, direction) = (V::splat(0.0), Triple::splat([0.0; 3]));
        let lookup = Lookup::nowhere();
        let nothing = Outgoing { packet: 0, direction, lookup, intensity: zero, lanes: 0 };
        let (beams, packets) = (Vec::with_capacity(BATCH), Vec::with_capacity(BATCH));
        let (exits, outgoing) = (vec![Exit::nowhere(); BATCH], vec![nothing; BATCH]);
        Batch { chain, light, blocks, beams, packets, exits, outgoing, leaving: 0, radiances, account }
    }

    /// Whether the next packet must wait.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.packets.len() >= BATCH
    }

    /// A packet of camera rays, `arrivals` being those of its pixel's samples; `behind`: whether the light
    /// behind the stone is seen.
    #[inline(always)]
    pub fn enter(&mut self, block: usize, place: usize, arrivals: &[Arrival], behind: bool) {
        let lines = &self.blocks[block];
        let gathered = Gathered::new(lines, arrivals);
        let colours = Triple::<V>::load(&gathered.colour);
        let seen = lines.basis.expand(colours);
        let covered = V::Mask::from_bits(gathered.lanes);
        let background = if behind { seen } else { V::splat(0.0) };
        let at = lines.media[self.chain.material].entered(V::load(&gathered.cosine));
        let [mirrored, mean, half] = at.shares();
        let radiance = V::select(covered, seen * mirrored, background);
        let missed = if behind { (lines.lanes & !gathered.lanes).count_ones() } else { 0 };
        self.account.count(u64::from(missed + 2 * gathered.lanes.count_ones()));
        let throughput = T::entering(mean, half, &gathered.axis);
        let direction = Triple::load(&gathered.direction);
        let direction = at.refracted(direction, Triple::load(&gathered.inward));
        let (intensity, threshold) = (throughput.intensity(), self.chain.threshold);
        let (alive, faint) = surviving(gathered.lanes, intensity, V::splat(0.0), threshold);
        let packet = Packet { throughput, radiance, faint, block, place, depth: 1 };
        if alive == 0 {
            self.deliver(&packet);
        } else {
            self.beams.push(Beam { origin: gathered.point, direction: direction.stored(), alive });
            self.packets.push(packet);
        }
    }

    /// Whether there is nothing to follow.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.packets.is_empty()
    }

    /// Follows every packet to its next surface.
    #[inline(always)]
    pub fn step(&mut self) {
        self.chain.planes.exits(&self.beams, &mut self.exits);
        self.leaving = 0;
        for k in 0..self.packets.len() {
            if self.packets[k].depth < self.chain.max_depth {
                self.reflect(k);
            } else {
                self.end(k);
            }
        }
        self.gather();
        self.retire();
    }

    /// One internal reflection of a packet.
    #[inline(always)]
    fn reflect(&mut self, k: usize) {
        let at = self.arrive(k);
        let (beam, exit, packet) = (&mut self.beams[k], &self.exits[k], &mut self.packets[k]);
        let direction = Triple::load(&beam.direction);
        let (throughput, leaving) = packet.throughput.reflected(direction, exit.normal, &at);
        let alive = beam.alive;
        let out = alive & !at.total.bits();
        beam.origin = exit.point.stored();
        beam.direction = at.reflected(direction, exit.normal).stored();
        packet.throughput = throughput;
        packet.depth += 1;
        let (intensity, threshold) = (throughput.intensity(), self.chain.threshold);
        (beam.alive, packet.faint) = surviving(alive, intensity, packet.faint, threshold);
        self.account.count(u64::from(alive.count_ones() + out.count_ones()));
        self.send(k, at.refracted(direction, exit.normal), leaving, out);
    }

    /// What becomes of rays that would make one event too many.
    #[inline(always)]
    fn end(&mut self, k: usize) {
        let at = self.arrive(k);
        let (beam, exit) = (&mut self.beams[k], &self.exits[k]);
        let lanes = std::mem::take(&mut beam.alive);
        let left = self.packets[k].throughput.intensity();
        self.account.count(u64::from(lanes.count_ones()));
        if self.chain.leftover == Leftover::Drop {
            self.account.add(Fate::DroppedDepth, &left.only(lanes));
            return;
        }
        self.account.add(Fate::LeftAtLimit, &left.only(lanes));
        let direction = Triple::load(&beam.direction);
        let out = Triple::select(at.total, direction, at.refracted(direction, exit.normal));
        beam.origin = exit.point.stored();
        self.send(k, out, left, lanes);
    }

    /// Lists rays that leave the stone, if there are any.
    #[inline(always)]
    fn send(&mut self, packet: usize, direction: Triple<V>, intensity: V, lanes: u16) {
        let outgoing = &mut self.outgoing[self.leaving];
        (outgoing.packet, outgoing.lanes) = (packet, lanes);
        (outgoing.direction, outgoing.intensity) = (direction, intensity);
        self.leaving += usize::from(lanes != 0);
    }

    /// A packet's arrival at the surface, faded by the way.
    #[inline(always)]
    fn arrive(&mut self, k: usize) -> Incidence<V> {
        let (exit, packet) = (&self.exits[k], &mut self.packets[k]);
        let medium = &self.blocks[packet.block].media[self.chain.material];
        medium.fade(&mut packet.throughput, exit.distance);
        medium.left(exit.cosine)
    }

    /// Adds the light of what has just left the stone.
    #[inline(always)]
    fn gather(&mut self) {
        let outgoing = &mut self.outgoing[..self.leaving];
        for out in outgoing.iter_mut() {
            let origin = Triple::load(&self.beams[out.packet].origin);
            out.lookup = Lookup::new(self.light, origin, out.direction);
        }
        for out in outgoing {
            let packet = &mut self.packets[out.packet];
            let light = self.blocks[packet.block].basis.expand(out.lookup.colours(self.light, out.lanes));
            let lanes = V::Mask::from_bits(out.lanes);
            packet.radiance = V::select(lanes, light.fma(out.intensity, packet.radiance), packet.radiance);
        }
    }

    /// Hands over the packets of which nothing is left.
    #[inline(always)]
    fn retire(&mut self) {
        let mut k = 0;
        while k < self.packets.len() {
            if self.beams[k].alive == 0 {
                self.beams.swap_remove(k);
                let packet = self.packets.swap_remove(k);
                self.deliver(&packet);
            } else {
                k += 1;
            }
        }
    }

    #[inline(always)]
    fn deliver(&mut self, packet: &Packet<V, T>) {
        self.account.add(Fate::DroppedThreshold, &packet.faint.stored().0);
        self.blocks[packet.block].scatter(packet.radiance, &mut self.radiances[packet.place..]);
    }
}

/// The lanes whose intensity is not below the threshold; and `faint` with that of the others, which happens once for
/// each lane.
#[inline(always)]
fn surviving<V: Lanes>(lanes: u16, intensity: V, faint: V, threshold: f32) -> (u16, V) {
    let below = intensity.lt(V::splat(threshold)).bits() & lanes;
    (lanes & !below, V::select(V::Mask::from_bits(below), intensity, faint))
}

/// Arrivals, a lane each.
struct Gathered {
    /// The lanes that meet the stone.
    lanes: u16,
    point: [Row; 3],
    direction: [Row; 3],
    /// Unit normal into the stone.
    inward: [Row; 3],
    axis: [Row; 3],
    colour: [Row; 3],
    cosine: Row,
}

/// The same vector in every lane.
#[inline(always)]
fn everywhere([x, y, z]: [f32; 3]) -> [Row; 3] {
    [Row([x; WIDTH]), Row([y; WIDTH]), Row([z; WIDTH])]
}

impl Gathered {
    #[inline(always)]
    fn new(block: &Block, arrivals: &[Arrival]) -> Self {
        let first = &arrivals[block.sample[0] as usize];
        let mut gathered = Gathered {
            lanes: if first.covered { block.lanes } else { 0 },
            point: everywhere(first.point),
            direction: everywhere(first.direction),
            inward: everywhere(first.inward),
            axis: everywhere(first.axis),
            colour: everywhere(first.colour),
            cosine: Row([first.cosine; WIDTH]),
        };
        if !block.together {
            gathered.each(block, arrivals);
        }
        gathered
    }

    /// Where the lanes are of different samples.
    #[inline(always)]
    fn each(&mut self, block: &Block, arrivals: &[Arrival]) {
        self.lanes = 0;
        for lane in 0..WIDTH {
            let arrival = &arrivals[block.sample[lane] as usize];
            put(&mut self.point, lane, arrival.point);
            put(&mut self.direction, lane, arrival.direction);
            put(&mut self.inward, lane, arrival.inward);
            put(&mut self.axis, lane, arrival.axis);
            put(&mut self.colour, lane, arrival.colour);
            self.cosine.0[lane] = arrival.cosine;
            self.lanes |= u16::from(arrival.covered) << lane;
        }
        self.lanes &= block.lanes;
    }
}
