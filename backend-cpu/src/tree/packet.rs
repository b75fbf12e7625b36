//! Packets of sixteen wavelengths on their way through any scene.
//!
//! The wavelengths of a block start together. At each surface event those that go on between the same media stay
//! together, the others part. Whatever rays an event sends on are put on an explicit stack, the refracted one last, so
//! that it is followed first. The order of a wavelength's events is that of its own tree, whichever wavelengths share
//! its packet, so its sum does not depend on how packets are put together. (With the weaker ray first, as in the GPU
//! kernels, the order would depend on the other wavelengths.)

use super::{Arrival, Tree, carrier::Carrier};
use crate::{
    account::{Account, Fate},
    block::Block,
    environment::{Light, Lookup},
    medium::{Interface, Medium},
    schedule::Stop,
    surface::Crossing,
};
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, Work, put};
use accel::packet::Pending;
use spectral_core::{
    prepare::{Nest, Rank},
    settings::Leftover,
    stokes::any_axis,
};

/// Wavelengths on the same way through the same media.
#[derive(Clone, Copy)]
pub(super) struct Packet<V, T> {
    pub origin: Triple<V>,
    pub direction: Triple<V>,
    pub throughput: T,
    pub lanes: u16,
    /// The stones they are in.
    pub nest: Nest,
    /// Surface events so far.
    pub depth: u32,
    /// The way here, as a number that tells it from others: which of each event's rays it is.
    pub path: u32,
    /// The stone apart from all others that they have just left.
    pub left: Option<Rank>,
}

/// Where some wavelengths of a packet meet the same interface.
pub(super) struct Event<V> {
    pub lanes: u16,
    pub point: Triple<V>,
    /// Unit normal on the far side.
    pub normal: Triple<V>,
    pub distance: V,
    pub before: Nest,
    pub after: Nest,
}

/// The walk through the trees of one block's wavelengths after another.
pub(super) struct Walk<'a, V, T> {
    pub tree: &'a Tree,
    light: &'a Light,
    account: &'a mut Account,
    stop: &'a Stop<'a>,
    stack: Vec<Packet<V, T>>,
    /// Room for the search in the hierarchy.
    pending: Pending<V>,
    /// By a packet's path: two facets to try first. Neighbouring wavelengths and pixels mostly meet the same facets.
    guesses: [[usize; 2]; GUESSES],
}

/// Paths with a guess each; others share theirs.
const GUESSES: usize = 1 << GUESS_BITS;
const GUESS_BITS: u32 = 10;
/// At most so many rays come from an event.
const BRANCHES: u32 = 5;

/// [`Walk::arrive`] as a function of its own.
struct Arrive<'b, 'a, V, T> {
    walk: &'b mut Walk<'a, V, T>,
    block: &'b Block,
    packet: &'b Packet<V, T>,
    event: &'b Event<V>,
    sum: &'b mut V,
}

impl<V: Lanes, T: Carrier<V>> Work for Arrive<'_, '_, V, T> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        self.walk.arrive(self.block, self.packet, self.event, self.sum);
    }
}

impl<'a, V: Lanes, T: Carrier<V>> Walk<'a, V, T> {
    #[inline(always)]
    pub fn new(tree: &'a Tree, light: &'a Light, account: &'a mut Account, stop: &'a Stop<'a>) -> Self {
        Walk {
            tree,
            light,
            account,
            stop,
            stack: Vec::new(),
            pending: Vec::new(),
            guesses: [[0; 2]; GUESSES],
        }
    }

    /// Radiances towards the eye along the camera rays of a pixel's samples; `behind`: whether the light behind
    /// the stones is seen.
    #[inline(always)]
    pub fn radiance(&mut self, block: &Block, arrivals: &[Arrival], behind: bool) -> V {
        let mut rows = [[Row::default(); 3]; 4];
        let mut crossings = [None; WIDTH];
        let mut lanes = 0;
        for lane in 0..WIDTH {
            let arrival = &arrivals[block.sample[lane] as usize];
            crossings[lane] = arrival.crossing.filter(|_| block.lanes >> lane & 1 == 1);
            lanes |= u16::from(crossings[lane].is_some()) << lane;
            let direction = arrival.direction.to_array();
            let vectors = [arrival.origin.to_array(), direction, any_axis(direction), arrival.colour];
            for (rows, vector) in rows.iter_mut().zip(vectors) {
                put(rows, lane, vector);
            }
        }
        let [origin, direction, axis, colour] = &rows;
        let mut sum = V::splat(0.0);
        if behind && lanes != block.lanes {
            self.account.count(u64::from((block.lanes & !lanes).count_ones()));
            sum = V::select(V::Mask::from_bits(lanes), sum, block.basis.expand(Triple::load(colour)));
        }
        if lanes == 0 {
            return sum;
        }
        let packet = Packet {
            origin: Triple::load(origin),
            direction: Triple::load(direction),
            throughput: T::begin(Triple::load(axis), self.tree.polarized),
            lanes,
            nest: Nest::default(),
            depth: 0,
            path: 0,
            left: None,
        };
        let within = self.medium(block, self.tree.eye_nest);
        if !T::begin_in_crystal(self, &packet, within) {
            self.part(block, &packet, &crossings, &mut sum);
        }
        while let Some(packet) = self.stack.pop() {
            // A tree can be very large: a cancel does not wait for the end of the pixel.
            if (self.stop)() {
                self.stack.clear();
            } else {
                self.go_on(block, packet, &mut sum);
            }
        }
        sum
    }

    /// Follows a packet to its next surfaces.
    #[inline(always)]
    fn go_on(&mut self, block: &Block, mut packet: Packet<V, T>, sum: &mut V) {
        if let Some((rank, planes)) = self.tree.planes(packet.nest) {
            // Fibonacci hashing; stones have facets in different numbers.
            let slot = packet.path.wrapping_add(rank).wrapping_mul(0x9e37_79b9) >> (32 - GUESS_BITS);
            let guess = &mut self.guesses[slot as usize];
            let last = planes.count() - 1;
            *guess = [guess[0].min(last), guess[1].min(last)];
            let exit = planes.exit(packet.origin, packet.direction, packet.lanes, guess);
            let event = Event {
                lanes: packet.lanes,
                point: exit.point,
                normal: exit.normal,
                distance: exit.distance,
                before: packet.nest,
                after: Nest::default(),
            };
            V::apart(Arrive { walk: self, block, packet: &packet, event: &event, sum });
            return;
        }
        let near = packet.lanes & self.near(&packet);
        let surfaces = &self.tree.surfaces;
        let crossings =
            surfaces.next_of_packet(packet.origin, packet.direction, packet.nest, near, &mut self.pending);
        let mut met = 0;
        for (lane, crossing) in crossings.iter().enumerate() {
            met |= u16::from(crossing.is_some()) << lane;
        }
        self.leave(block, &packet, packet.lanes & !met, sum);
        packet.lanes = met;
        self.part(block, &packet, &crossings, sum);
    }

    /// Lanes that may meet a stone: inside a stone all of them; outside those that come near a stone other than the
    /// convex one that they have just left.
    #[inline(always)]
    fn near(&self, packet: &Packet<V, T>) -> u16 {
        if !packet.nest.is_empty() || self.tree.spheres.is_empty() {
            return packet.lanes;
        }
        let mut near = 0;
        for (rank, (centre, radius2)) in self.tree.spheres.iter().enumerate() {
            if packet.left == Some(rank as Rank) {
                continue;
            }
            let to = packet.origin.fma(V::splat(-1.0), Triple::splat(centre.to_array()));
            let (along, distance2) = (to.dot(packet.direction), to.dot(to));
            let radius2 = V::splat(*radius2);
            let passes = along.fnma(along, distance2).lt(radius2);
            let ahead = !along.lt(V::splat(0.0)) | distance2.lt(radius2);
            near |= (passes & ahead).bits();
        }
        near
    }

    /// Divides a packet whose lanes all cross a surface into groups that cross between the same media.
    #[inline(always)]
    fn part(
        &mut self,
        block: &Block,
        packet: &Packet<V, T>,
        crossings: &[Option<Crossing>; WIDTH],
        sum: &mut V,
    ) {
        let mut normal = [Row::default(); 3];
        let mut distance = Row::default();
        for (lane, crossing) in crossings.iter().enumerate() {
            if let Some(crossing) = crossing {
                put(&mut normal, lane, (-crossing.normal).to_array());
                distance.0[lane] = crossing.distance;
            }
        }
        let distance = V::load(&distance);
        let point = packet.direction.scaled(distance).plus(packet.origin);
        let mut open = packet.lanes;
        while open != 0 {
            let Some(first) = crossings[open.trailing_zeros() as usize] else { return };
            let (before, after) = (first.before, first.after);
            let mut lanes = 0;
            for (lane, crossing) in crossings.iter().enumerate() {
                let same = crossing.is_some_and(|c| c.before == before && c.after == after);
                lanes |= u16::from(same) << lane;
            }
            lanes &= open;
            open &= !lanes;
            let event = Event { lanes, point, normal: Triple::load(&normal), distance, before, after };
            V::apart(Arrive { walk: self, block, packet, event: &event, sum });
        }
    }

    /// A surface event: fades the wavelengths, and stacks the rays that it sends on.
    #[inline(always)]
    fn arrive(&mut self, block: &Block, packet: &Packet<V, T>, event: &Event<V>, sum: &mut V) {
        let Event { mut lanes, before, after, .. } = *event;
        let media = Interface { here: self.medium(block, before), beyond: self.medium(block, after) };
        self.account.count(u64::from(lanes.count_ones()));
        let mut packet = *packet;
        if let Some(here) = media.here {
            packet.throughput.fade(here, packet.direction, event.distance);
            // Inside a metal nothing travels.
            if here.opaque {
                return;
            }
        }
        if packet.depth == self.tree.max_depth {
            self.at_limit(block, &packet, event, &media, sum);
            return;
        }
        if before.is_empty() {
            lanes = self.surviving(lanes, packet.throughput.intensity());
        }
        if !T::send_on_at_crystal(self, block, &packet, event, lanes, &media) {
            self.send_on(&packet, event, lanes, &media);
        }
    }

    /// Stacks the rays that an event sends on: what a metal reflects, or at an isotropic interface the reflected and the
    /// refracted ray.
    #[inline(always)]
    fn send_on(&mut self, packet: &Packet<V, T>, event: &Event<V>, lanes: u16, media: &Interface<'_>) {
        let Event { normal, before, after, .. } = *event;
        let Packet { direction, throughput, .. } = *packet;
        let child = Packet { origin: event.point, depth: packet.depth + 1, left: None, ..*packet };
        let cosine = normal.dot_unfused(direction);
        if media.is_opaque() {
            let throughput = throughput.mirrored(direction, normal, &media.metal(cosine));
            let direction = normal.fnma(cosine + cosine, direction).renormalized();
            self.push(Packet { direction, throughput, lanes, nest: before, ..child }, 0);
            return;
        }
        let at = media.incidence(cosine);
        let [back, on] = throughput.split(direction, normal, &at);
        let mirrored = at.reflected(direction, normal);
        self.push(Packet { direction: mirrored, throughput: back, lanes, nest: before, ..child }, 0);
        let through = lanes & !at.total.bits();
        if through != 0 {
            let left = self.tree.planes(before).filter(|_| after.is_empty()).map(|(rank, _)| rank);
            let direction = at.refracted(direction, normal);
            self.push(Packet { direction, throughput: on, lanes: through, nest: after, left, ..child }, 1);
        }
    }

    /// Stacks a packet, ray `branch` of its event, without the lanes that carry nothing and, inside a stone, without those below the threshold.
    #[inline(always)]
    pub fn push(&mut self, mut packet: Packet<V, T>, branch: u32) {
        packet.path = packet.path.wrapping_mul(BRANCHES).wrapping_add(branch);
        let intensity = packet.throughput.intensity();
        packet.lanes &= V::splat(0.0).lt(intensity).bits();
        if !packet.nest.is_empty() {
            packet.lanes = self.surviving(packet.lanes, intensity);
        }
        if packet.lanes != 0 {
            self.stack.push(packet);
        }
    }

    /// The lanes whose intensity is not below the threshold; what the others carry is dropped.
    #[inline(always)]
    fn surviving(&mut self, lanes: u16, intensity: V) -> u16 {
        let faint = intensity.lt(V::splat(self.tree.threshold)).bits() & lanes;
        if faint != 0 {
            self.account.add(Fate::DroppedThreshold, &intensity.only(faint));
        }
        lanes & !faint
    }

    /// What becomes of rays that would make one event too many.
    #[inline(always)]
    fn at_limit(
        &mut self,
        block: &Block,
        packet: &Packet<V, T>,
        event: &Event<V>,
        media: &Interface<'_>,
        sum: &mut V,
    ) {
        let (mut direction, mut throughput) = (packet.direction, packet.throughput);
        if self.tree.leftover == Leftover::Drop {
            self.account.add(Fate::DroppedDepth, &throughput.intensity().only(event.lanes));
            return;
        }
        let cosine = event.normal.dot(direction);
        if media.is_opaque() {
            // A metal lets nothing through: the rest leaves as the metal reflects it.
            throughput = throughput.mirrored(direction, event.normal, &media.metal(cosine));
            direction = event.normal.fnma(cosine + cosine, direction).renormalized();
        } else if media.here.is_some() && !throughput.is_mode() {
            let at = Interface { here: media.here, beyond: None }.incidence(cosine);
            let out = at.refracted(direction, event.normal);
            direction = Triple::select(at.total, direction, out);
        }
        self.account.add(Fate::LeftAtLimit, &throughput.intensity().only(event.lanes));
        self.add_light(block, [event.point, direction], throughput.intensity(), event.lanes, sum);
    }

    /// Rays that meet nothing more.
    #[inline(always)]
    fn leave(&mut self, block: &Block, packet: &Packet<V, T>, lanes: u16, sum: &mut V) {
        if lanes == 0 {
            return;
        }
        self.account.count(u64::from(lanes.count_ones()));
        let intensity = packet.throughput.intensity();
        if !packet.nest.is_empty() {
            self.account.add(Fate::Lost, &intensity.only(lanes));
        }
        self.add_light(block, [packet.origin, packet.direction], intensity, lanes, sum);
    }

    /// Adds the light that is seen along rays, origin and direction.
    #[inline(always)]
    fn add_light(&mut self, block: &Block, ray: [Triple<V>; 2], intensity: V, lanes: u16, sum: &mut V) {
        let [origin, direction] = ray;
        let light = block.basis.expand(Lookup::new(self.light, origin, direction).colours(self.light, lanes));
        *sum = V::select(V::Mask::from_bits(lanes), light.fma(intensity, *sum), *sum);
    }

    #[inline(always)]
    fn medium<'b>(&self, block: &'b Block, nest: Nest) -> Option<&'b Medium> {
        nest.top().map(|rank| &block.media[self.tree.surfaces.material(rank)])
    }
}
