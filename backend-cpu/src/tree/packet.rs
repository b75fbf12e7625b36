//! Packets of sixteen wavelengths on their way through any scene.
//!
//! The wavelengths of a block set out together. At each surface event those that go on between the same media
//! stay together, the others part; both children of an event are followed, the refracted one first, the other
//! kept on an explicit stack. The order of a wavelength's events is that of its own tree whoever goes with it,
//! so its sum does not depend on how packets were put together. (Going on with the stronger child, as the GPU
//! kernels do, would tie the order to the company.)

use super::{Arrival, Tree, interface::Interface};
use crate::{
    account::{Fate, Ledger},
    block::{Block, Medium},
    incidence::Flux,
    light::Light,
    schedule::Stop,
    surface::Crossing,
    texel::Aim,
};
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, Work, exp2, put};
use spectral_core::{
    prepare::{Nest, Rank},
    settings::Leftover,
    stokes::any_axis,
};

/// Wavelengths that have had the same events.
#[derive(Clone, Copy)]
struct Packet<V, F> {
    origin: Triple<V>,
    direction: Triple<V>,
    flux: F,
    lanes: u16,
    /// The stones they are in.
    nest: Nest,
    /// Surface events so far.
    depth: u32,
    /// The stone apart from all others that they have just left.
    left: Option<Rank>,
}

/// Where some wavelengths of a packet meet the same interface.
struct Event<V> {
    lanes: u16,
    point: Triple<V>,
    /// Unit normal on the far side.
    normal: Triple<V>,
    distance: V,
    before: Nest,
    after: Nest,
}

/// The walk through the trees of one block's wavelengths after another.
pub(super) struct Walk<'a, V, F> {
    tree: &'a Tree,
    light: &'a Light,
    ledger: &'a mut Ledger,
    stop: &'a Stop<'a>,
    stack: Vec<Packet<V, F>>,
    /// By rank: a facet to try first.
    guesses: Vec<usize>,
}

/// [`Walk::split`] as a function of its own.
struct Arrive<'b, 'a, V, F> {
    walk: &'b mut Walk<'a, V, F>,
    block: &'b Block,
    packet: &'b Packet<V, F>,
    event: &'b Event<V>,
    sum: &'b mut V,
}

impl<V: Lanes, F: Flux<V>> Work for Arrive<'_, '_, V, F> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        self.walk.split(self.block, self.packet, self.event, self.sum);
    }
}

impl<'a, V: Lanes, F: Flux<V>> Walk<'a, V, F> {
    #[inline(always)]
    pub fn new(tree: &'a Tree, light: &'a Light, ledger: &'a mut Ledger, stop: &'a Stop<'a>) -> Self {
        Walk { tree, light, ledger, stop, stack: Vec::new(), guesses: vec![0; tree.alone.len()] }
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
            self.ledger.count(u64::from((block.lanes & !lanes).count_ones()));
            sum = V::select(V::Mask::from_bits(lanes), sum, block.expand(Triple::load(colour)));
        }
        if lanes == 0 {
            return sum;
        }
        let packet = Packet {
            origin: Triple::load(origin),
            direction: Triple::load(direction),
            flux: F::eye(Triple::load(axis)),
            lanes,
            nest: Nest::default(),
            depth: 0,
            left: None,
        };
        self.part(block, &packet, &crossings, &mut sum);
        while let Some(packet) = self.stack.pop() {
            // A tree can be vast: breaking off must not wait for the pixel.
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
    fn go_on(&mut self, block: &Block, mut packet: Packet<V, F>, sum: &mut V) {
        if let Some((rank, planes)) = self.tree.planes(packet.nest) {
            let guess = &mut self.guesses[rank as usize];
            let exit = planes.exit(packet.origin, packet.direction, packet.lanes, guess);
            let event = Event {
                lanes: packet.lanes,
                point: exit.point,
                normal: exit.normal,
                distance: exit.distance,
                before: packet.nest,
                after: Nest::default(),
            };
            self.arrive(block, &packet, event, sum);
            return;
        }
        let near = packet.lanes & self.near(&packet);
        let surfaces = &self.tree.surfaces;
        let crossings = surfaces.next_of_packet(packet.origin, packet.direction, packet.nest, near);
        let mut met = 0;
        for (lane, crossing) in crossings.iter().enumerate() {
            met |= u16::from(crossing.is_some()) << lane;
        }
        self.leave(block, &packet, packet.lanes & !met, sum);
        packet.lanes = met;
        self.part(block, &packet, &crossings, sum);
    }

    /// Lanes that may meet a stone: all of those inside of one, and outside those that come near a stone other
    /// than a convex one that they have just left.
    #[inline(always)]
    fn near(&self, packet: &Packet<V, F>) -> u16 {
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

    /// Parts a packet whose lanes all cross a surface into those that cross between the same media.
    #[inline(always)]
    fn part(
        &mut self,
        block: &Block,
        packet: &Packet<V, F>,
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
            self.arrive(block, packet, event, sum);
        }
    }

    /// A surface event: fades the wavelengths, splits them, and stacks the children.
    #[inline(always)]
    fn arrive(&mut self, block: &Block, packet: &Packet<V, F>, event: Event<V>, sum: &mut V) {
        V::apart(Arrive { walk: self, block, packet, event: &event, sum });
    }

    #[inline(always)]
    fn split(&mut self, block: &Block, packet: &Packet<V, F>, event: &Event<V>, sum: &mut V) {
        let Event { mut lanes, normal, before, after, .. } = *event;
        let media = Interface { here: self.medium(block, before), beyond: self.medium(block, after) };
        self.ledger.count(u64::from(lanes.count_ones()));
        let mut packet = *packet;
        if let Some(here) = media.here {
            if here.absorbs {
                packet.flux = packet.flux.scaled(exp2(-(V::load(&here.fade) * event.distance)));
            }
            // Inside a metal nothing travels.
            if here.metal {
                return;
            }
        }
        if packet.depth == self.tree.max_depth {
            self.at_limit(block, &packet, event, &media, sum);
            return;
        }
        if before.is_empty() {
            lanes = self.surviving(lanes, packet.flux.intensity());
        }
        let Packet { direction, flux, .. } = packet;
        let child = Packet { origin: event.point, depth: packet.depth + 1, left: None, ..packet };
        let cosine = normal.dot_unfused(direction);
        if media.is_opaque() {
            let flux = flux.mirrored(direction, normal, &media.metal(cosine));
            let direction = normal.fnma(cosine + cosine, direction).renormalized();
            self.push(Packet { direction, flux, lanes, nest: before, ..child });
            return;
        }
        let at = media.incidence(cosine);
        let [back, on] = flux.divide(direction, normal, &at);
        let mirrored = at.reflected(direction, normal);
        self.push(Packet { direction: mirrored, flux: back, lanes, nest: before, ..child });
        let through = lanes & !at.total.bits();
        if through != 0 {
            let left = self.tree.planes(before).filter(|_| after.is_empty()).map(|(rank, _)| rank);
            let direction = at.refracted(direction, normal);
            self.push(Packet { direction, flux: on, lanes: through, nest: after, left, ..child });
        }
    }

    /// Stacks what is worth following: inside a stone only what is above the threshold, and never nothing.
    #[inline(always)]
    fn push(&mut self, mut packet: Packet<V, F>) {
        let intensity = packet.flux.intensity();
        packet.lanes &= V::splat(0.0).lt(intensity).bits();
        if !packet.nest.is_empty() {
            packet.lanes = self.surviving(packet.lanes, intensity);
        }
        if packet.lanes != 0 {
            self.stack.push(packet);
        }
    }

    /// Those of the lanes whose intensity is worth following; what the others carry is dropped.
    #[inline(always)]
    fn surviving(&mut self, lanes: u16, intensity: V) -> u16 {
        let faint = intensity.lt(V::splat(self.tree.threshold)).bits() & lanes;
        if faint != 0 {
            self.ledger.add(Fate::DroppedThreshold, &intensity.only(faint));
        }
        lanes & !faint
    }

    /// What becomes of rays that would make one event too many.
    #[inline(always)]
    fn at_limit(
        &mut self,
        block: &Block,
        packet: &Packet<V, F>,
        event: &Event<V>,
        media: &Interface<'_>,
        sum: &mut V,
    ) {
        let (mut direction, mut flux) = (packet.direction, packet.flux);
        if self.tree.leftover == Leftover::Drop {
            self.ledger.add(Fate::DroppedDepth, &flux.intensity().only(event.lanes));
            return;
        }
        let cosine = event.normal.dot(direction);
        if media.is_opaque() {
            // A metal lets nothing through: the rest leaves as the metal reflects it.
            flux = flux.mirrored(direction, event.normal, &media.metal(cosine));
            direction = event.normal.fnma(cosine + cosine, direction).renormalized();
        } else if media.here.is_some() {
            let at = Interface { here: media.here, beyond: None }.incidence(cosine);
            let out = at.refracted(direction, event.normal);
            direction = Triple::select(at.total, direction, out);
        }
        self.ledger.add(Fate::LeftAtLimit, &flux.intensity().only(event.lanes));
        self.shine(block, [event.point, direction], flux.intensity(), event.lanes, sum);
    }

    /// Rays that meet nothing more.
    #[inline(always)]
    fn leave(&mut self, block: &Block, packet: &Packet<V, F>, lanes: u16, sum: &mut V) {
        if lanes == 0 {
            return;
        }
        self.ledger.count(u64::from(lanes.count_ones()));
        let intensity = packet.flux.intensity();
        if !packet.nest.is_empty() {
            self.ledger.add(Fate::Lost, &intensity.only(lanes));
        }
        self.shine(block, [packet.origin, packet.direction], intensity, lanes, sum);
    }

    /// Adds the light that is seen along rays, origin and direction.
    #[inline(always)]
    fn shine(&mut self, block: &Block, ray: [Triple<V>; 2], intensity: V, lanes: u16, sum: &mut V) {
        let [origin, direction] = ray;
        let light = block.expand(Aim::new(self.light, origin, direction).colours(self.light, lanes));
        *sum = V::select(V::Mask::from_bits(lanes), light.fma(intensity, *sum), *sum);
    }

    #[inline(always)]
    fn medium<'b>(&self, block: &'b Block, nest: Nest) -> Option<&'b Medium> {
        nest.top().map(|rank| &block.media[self.tree.surfaces.material(rank)])
    }
}
