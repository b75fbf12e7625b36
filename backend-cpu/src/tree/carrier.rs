//! What packets carry in a scene: throughputs alone, or modes as well where there are crystals.

use super::packet::{Event, Packet, Walk};
use crate::{
    block::Block,
    crystal::{self, Beam, Mode, Scattered},
    incidence::{Incidence, Reflection},
    medium::{Interface, Medium},
    throughput::{Mean, Polarized, Throughput},
};
use accel::lanes::{Lanes, Mask, Row, Triple, exp2};

/// A throughput with what crystals ask for. Without crystals nothing of it is compiled.
pub(super) trait Carrier<V: Lanes>: Throughput<V> {
    /// At an eye in air or in an isotropic medium.
    #[inline(always)]
    fn begin(axis: Triple<V>, _polarized: bool) -> Self {
        Self::eye(axis)
    }

    /// At an eye that looks along `direction` in a crystal: its modes, each with its ray; false in any other medium.
    #[inline(always)]
    fn begin_in_crystal(
        _walk: &mut Walk<'_, V, Self>,
        _packet: &Packet<V, Self>,
        _within: Option<&Medium>,
    ) -> bool {
        false
    }

    /// Leaves what is not absorbed over `distance`, mm, along a ray.
    #[inline(always)]
    fn fade(&mut self, medium: &Medium, _ray: Triple<V>, distance: V) {
        medium.fade(self, distance);
    }

    /// Whether it is a mode of a crystal.
    #[inline(always)]
    fn is_mode(&self) -> bool {
        false
    }

    /// Stacks the rays that an event at a crystal sends on; false if it is no such event.
    #[inline(always)]
    fn send_on_at_crystal(
        _walk: &mut Walk<'_, V, Self>,
        _block: &Block,
        _packet: &Packet<V, Self>,
        _event: &Event<V>,
        _lanes: u16,
        _media: &Interface<'_>,
    ) -> bool {
        false
    }
}

impl<V: Lanes> Carrier<V> for Mean<V> {}
impl<V: Lanes> Carrier<V> for Polarized<V> {}

/// A Stokes row outside crystals, a mode within.
#[derive(Clone, Copy)]
pub(super) struct Mixed<V> {
    /// Of a mode only the intensity counts.
    row: Polarized<V>,
    /// N of a mode.
    wave: Triple<V>,
    mode: Option<Mode>,
    /// Whether rows keep more than their intensity.
    polarized: bool,
}

impl<V: Lanes> Mixed<V> {
    #[inline(always)]
    fn with(self, row: Polarized<V>) -> Self {
        let i = row.row[0];
        let zero = V::splat(0.0);
        let row = if self.polarized { row } else { Polarized { row: [i, zero, zero, zero], ..row } };
        Mixed { row, ..self }
    }

    #[inline(always)]
    fn in_mode(self, mode: Mode, wave: Triple<V>, weight: V) -> Self {
        let zero = V::splat(0.0);
        let row = Polarized { row: [weight, zero, zero, zero], ..self.row };
        Mixed { row, wave, mode: Some(mode), ..self }
    }
}

impl<V: Lanes> Throughput<V> for Mixed<V> {
    #[inline(always)]
    fn entering(mean: V, half: V, axis: &[Row; 3]) -> Self {
        let row = Polarized::entering(mean, half, axis);
        Mixed { row, wave: row.axis, mode: None, polarized: true }
    }

    #[inline(always)]
    fn intensity(&self) -> V {
        self.row.intensity()
    }

    #[inline(always)]
    fn scaled(self, factor: V) -> Self {
        Mixed { row: self.row.scaled(factor), ..self }
    }

    #[inline(always)]
    fn eye(axis: Triple<V>) -> Self {
        Mixed { row: Polarized::eye(axis), wave: axis, mode: None, polarized: true }
    }

    #[inline(always)]
    fn split(self, direction: Triple<V>, normal: Triple<V>, at: &Incidence<V>) -> [Self; 2] {
        let [back, on] = self.row.split(direction, normal, at);
        [self.with(back), self.with(on)]
    }

    #[inline(always)]
    fn mirrored(self, direction: Triple<V>, normal: Triple<V>, reflection: &Reflection<V>) -> Self {
        if self.is_mode() { self } else { self.with(self.row.mirrored(direction, normal, reflection)) }
    }

    #[inline(always)]
    fn reflected(self, direction: Triple<V>, normal: Triple<V>, at: &Incidence<V>) -> (Self, V) {
        let (row, through) = self.row.reflected(direction, normal, at);
        (self.with(row), through)
    }
}

/// The lanes of the second mode, where all are of one.
#[inline(always)]
fn in_lanes<V: Lanes>(mode: Mode) -> V::Mask {
    V::Mask::from_bits(if mode == 0 { 0 } else { u16::MAX })
}

impl<V: Lanes> Carrier<V> for Mixed<V> {
    #[inline(always)]
    fn begin(axis: Triple<V>, polarized: bool) -> Self {
        Mixed { polarized, ..Self::eye(axis) }
    }

    #[inline(always)]
    fn begin_in_crystal(
        walk: &mut Walk<'_, V, Self>,
        packet: &Packet<V, Self>,
        within: Option<&Medium>,
    ) -> bool {
        let Some(crystal) = within.and_then(|medium| medium.crystal.as_deref()) else { return false };
        let modes = crystal.of_eye(&packet.direction.stored());
        for mode in [1, 0] {
            let [wave, ray] = &modes[mode];
            let throughput = packet.throughput.in_mode(mode, Triple::load(wave), V::splat(0.5));
            let nest = walk.tree.eye_nest;
            walk.push(Packet { direction: Triple::load(ray), throughput, nest, ..*packet }, mode as u32);
        }
        true
    }

    #[inline(always)]
    fn fade(&mut self, medium: &Medium, ray: Triple<V>, distance: V) {
        match (self.mode, &medium.crystal) {
            (Some(mode), Some(crystal)) => {
                let second = in_lanes::<V>(mode);
                if let Some(exponent) = crystal.optics().fading(second, self.wave, ray, distance) {
                    *self = self.scaled(exp2(exponent));
                }
            }
            _ => medium.fade(self, distance),
        }
    }

    #[inline(always)]
    fn is_mode(&self) -> bool {
        self.mode.is_some()
    }

    #[inline(always)]
    fn send_on_at_crystal(
        walk: &mut Walk<'_, V, Self>,
        block: &Block,
        packet: &Packet<V, Self>,
        event: &Event<V>,
        lanes: u16,
        media: &Interface<'_>,
    ) -> bool {
        let [here, beyond] = [media.here, media.beyond].map(|medium| medium?.crystal.as_deref());
        let carried = &packet.throughput;
        let choice = V::load(&block.choices(walk.tree.powers[packet.depth as usize]));
        match (carried.mode, here, beyond) {
            (Some(mode), Some(crystal), other) => {
                let beam = (carried.wave, carried.intensity());
                let (optics, exact) = (crystal.optics(), |lane: usize| crystal.exact(lane));
                let second = in_lanes::<V>(mode);
                let sent = crystal::leave(optics, exact, second, beam, event.normal, media.beyond, lanes);
                walk.push_modes(choice, packet, event, &sent.back, lanes, false);
                if other.is_some() {
                    walk.push_modes(choice, packet, event, &sent.on, lanes, true);
                } else {
                    walk.push_row(packet, event, &sent, lanes, true);
                }
            }
            (None, _, Some(crystal)) => {
                let (optics, exact) = (crystal.optics(), |lane: usize| crystal.exact(lane));
                let ways = [packet.direction, event.normal];
                let sent = crystal::enter(optics, exact, carried.row, ways, media.here, lanes);
                walk.push_row(packet, event, &sent, lanes, false);
                walk.push_modes(choice, packet, event, &sent.on, lanes, true);
            }
            // A mode travels in a crystal only.
            (None, _, None) | (Some(_), None, _) => return false,
        }
        true
    }
}

impl<V: Lanes> Walk<'_, V, Mixed<V>> {
    /// A ray from an event, which goes through the surface or not.
    #[inline(always)]
    fn child(packet: &Packet<V, Mixed<V>>, event: &Event<V>, through: bool) -> Packet<V, Mixed<V>> {
        let nest = if through { event.after } else { event.before };
        Packet { origin: event.point, depth: packet.depth + 1, left: None, nest, ..*packet }
    }

    #[inline(always)]
    fn push_row(
        &mut self,
        packet: &Packet<V, Mixed<V>>,
        event: &Event<V>,
        sent: &Scattered<V>,
        lanes: u16,
        through: bool,
    ) {
        let left = self.tree.planes(event.before).filter(|_| through && event.after.is_empty());
        let throughput = Mixed { mode: None, ..packet.throughput }.with(sent.row);
        let child = Self::child(packet, event, through);
        let left = left.map(|(rank, _)| rank);
        self.push(Packet { direction: sent.direction, throughput, lanes, left, ..child }, 4);
    }

    /// Stacks two modes on one side of a surface. If one is lighter than `split` only one of them is followed, with the weight
    /// of both: each is chosen in proportion to its weight.
    #[inline(always)]
    fn push_modes(
        &mut self,
        choice: V,
        packet: &Packet<V, Mixed<V>>,
        event: &Event<V>,
        beams: &[Beam<V>; 2],
        lanes: u16,
        through: bool,
    ) {
        let [first, second] = [beams[0].weight, beams[1].weight];
        let (split, zero) = (V::splat(self.tree.split), V::splat(0.0));
        let chooses = first.min(second).lt(split);
        let sum = first + second;
        let takes_first = (choice * sum).lt(first);
        let weights = [
            V::select(chooses, V::select(takes_first, sum, zero), first),
            V::select(chooses, V::select(takes_first, zero, sum), second),
        ];
        // The first mode is followed first.
        for mode in [1, 0] {
            let Beam { normal, ray, .. } = beams[mode];
            let throughput = packet.throughput.in_mode(mode, normal, weights[mode]);
            let child = Self::child(packet, event, through);
            let branch = 2 * u32::from(through) + mode as u32;
            self.push(Packet { direction: ray, throughput, lanes, ..child }, branch);
        }
    }
}
