//! Many packets of rays at a time: guesses for all, then verification of all, and the same again for packets with remaining
//! rays. No step waits for a decision, so the processor overlaps the arithmetic of several packets.

use super::{Exit, Planes};
use accel::lanes::{Lanes, Row, Triple, WIDTH};

/// Packets processed together.
pub(crate) const BATCH: usize = 64;
/// With at most this many rays in sixteen lanes, single searches are faster.
const FEW: usize = 7;

/// Sixteen rays inside a stone.
#[derive(Debug, Clone, Copy, Default)]
pub struct Beam {
    /// mm.
    pub origin: [Row; 3],
    /// Unit vectors.
    pub direction: [Row; 3],
    /// The active rays, as bits; the other lanes are finite.
    pub alive: u16,
}

impl Beam {
    #[inline(always)]
    fn coordinates(&self, lane: usize) -> [[f32; 3]; 2] {
        let lane = lane % WIDTH;
        [&self.origin, &self.direction].map(|rows| [rows[0].0[lane], rows[1].0[lane], rows[2].0[lane]])
    }
}

/// What travels inside a stone, sixteen rays at a time.
pub(crate) trait Travellers<V: Lanes> {
    /// What is known of the places where they meet the surface.
    type Met;
    /// The active rays, as bits.
    fn alive(&self) -> u16;
    /// Origin and direction of one.
    fn ray(&self, lane: usize) -> [[f32; 3]; 2];
    /// Where they meet the plane of a facet, and as bits which of them do so well inside its polygon.
    fn verify(&self, planes: &Planes, facet: u16) -> (Self::Met, u16);
    /// Copies the lanes whose bit is set; returns them.
    fn accept(met: &mut Self::Met, other: &Self::Met, lanes: u16) -> u16;
}

impl<V: Lanes> Travellers<V> for Beam {
    type Met = Exit<V>;

    #[inline(always)]
    fn alive(&self) -> u16 {
        self.alive
    }

    #[inline(always)]
    fn ray(&self, lane: usize) -> [[f32; 3]; 2] {
        self.coordinates(lane)
    }

    #[inline(always)]
    fn verify(&self, planes: &Planes, facet: u16) -> (Exit<V>, u16) {
        planes.verify(Triple::load(&self.origin), Triple::load(&self.direction), usize::from(facet))
    }

    #[inline(always)]
    fn accept(met: &mut Exit<V>, other: &Exit<V>, lanes: u16) -> u16 {
        met.accept(other, lanes)
    }
}

/// The round of guessing. Only later rounds include small facets, and search for a lead near an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Round {
    First,
    Second,
    Later,
}

/// One ray of each packet with remaining rays.
struct Leads {
    rays: [[[Row; 3]; 2]; BATCH / WIDTH],
    /// The packet.
    packet: [u8; BATCH],
    /// The lane of the ray, as a bit.
    lane: [u16; BATCH],
    /// The guessed facet.
    facet: [u16; BATCH],
    count: usize,
}

impl Leads {
    /// The middle one of the set lanes: its facet is right for most of them.
    #[inline(always)]
    fn middle(open: u16) -> usize {
        let open = u32::from(open);
        let (first, last) = (open.trailing_zeros(), 31 - (open | 1).leading_zeros());
        let half = (first + last).div_ceil(2) % 16;
        (open >> half << half).trailing_zeros() as usize % WIDTH
    }

    /// Takes a lead from each listed packet.
    #[inline(always)]
    fn choose<V: Lanes, R: Travellers<V>>(&mut self, beams: &[R], open: &[u16; BATCH]) {
        for i in 0..self.count {
            let packet = usize::from(self.packet[i]) % BATCH;
            let lane = Self::middle(open[packet]);
            self.lane[i] = 1 << lane;
            let [origin, direction] = beams[packet].ray(lane);
            let rays = &mut self.rays[i / WIDTH];
            for axis in 0..3 {
                rays[0][axis].0[i % WIDTH] = origin[axis];
                rays[1][axis].0[i % WIDTH] = direction[axis];
            }
        }
    }
}

impl Planes {
    /// The exits of rays inside the stone: [`exit`](Self::exit) for at most [`BATCH`] packets.
    #[inline(always)]
    pub fn exits<V: Lanes, R: Travellers<V>>(&self, beams: &[R], exits: &mut [R::Met]) {
        let (beams, exits) = (&beams[..beams.len().min(BATCH)], &mut exits[..beams.len()]);
        let mut open = [0; BATCH];
        let mut leads = Leads {
            rays: [[[Row::default(); 3]; 2]; BATCH / WIDTH],
            packet: std::array::from_fn(|i| i as u8),
            lane: [0; BATCH],
            facet: [0; BATCH],
            count: beams.len(),
        };
        for (open, beam) in open.iter_mut().zip(beams) {
            *open = beam.alive();
        }
        let mut round = Round::First;
        while leads.count > 0 {
            leads.choose::<V, R>(beams, &open);
            self.guess::<V>(&mut leads, round);
            if round == Round::First {
                self.begin(beams, exits, &mut open, &mut leads);
                round = Round::Second;
            } else {
                self.settle(beams, exits, &mut open, &mut leads, round);
                round = Round::Later;
            }
        }
    }

    /// Verifies the first guesses, of which there is one for each packet.
    #[inline(always)]
    fn begin<V: Lanes, R: Travellers<V>>(
        &self,
        beams: &[R],
        exits: &mut [R::Met],
        open: &mut [u16; BATCH],
        leads: &mut Leads,
    ) {
        leads.count = 0;
        for (k, (beam, exit)) in beams.iter().zip(exits).enumerate() {
            let (met, inside) = beam.verify(self, leads.facet[k]);
            *exit = met;
            open[k] &= !inside;
            leads.packet[leads.count] = k as u8;
            leads.count += usize::from(open[k] != 0);
        }
    }

    /// Verifies the guesses, and keeps the packets with remaining rays.
    #[inline(always)]
    fn settle<V: Lanes, R: Travellers<V>>(
        &self,
        beams: &[R],
        exits: &mut [R::Met],
        open: &mut [u16; BATCH],
        leads: &mut Leads,
        round: Round,
    ) {
        let mut kept = 0;
        for i in 0..leads.count {
            let k = usize::from(leads.packet[i]) % BATCH;
            let (mut facet, mut found) = (leads.facet[i], 0);
            loop {
                let (met, inside) = beams[k].verify(self, facet);
                // The result of a search needs no verification.
                open[k] &= !R::accept(&mut exits[k], &met, open[k] & (inside | found));
                if round != Round::Later || open[k] & leads.lane[i] == 0 {
                    break;
                }
                // Near an edge: one ray in ten thousand.
                found = leads.lane[i];
                let ray = beams[k].ray(found.trailing_zeros() as usize);
                facet = self.search::<V>([ray; 2])[0] as u16;
            }
            leads.packet[kept] = k as u8;
            kept += usize::from(open[k] != 0);
        }
        leads.count = kept;
    }

    /// Guesses a facet for every lead.
    #[inline(always)]
    fn guess<V: Lanes>(&self, leads: &mut Leads, round: Round) {
        let Leads { rays, facet, count, .. } = leads;
        for (group, (rays, facets)) in rays.iter().zip(facet.as_chunks_mut::<WIDTH>().0).enumerate() {
            let count = count.saturating_sub(group * WIDTH);
            if count == 0 {
                break;
            }
            if round == Round::First || count > FEW {
                *facets = self.guesses::<V>(rays, round != Round::Later);
                continue;
            }
            let ray = |lane: usize| rays.each_ref().map(|rows| rows.each_ref().map(|row| row.0[lane]));
            for lane in (0..count).step_by(2) {
                let found = self.search::<V>([ray(lane), ray(lane + 1)]);
                facets[lane] = found[0] as u16;
                facets[lane + 1] = found[1] as u16;
            }
        }
    }
}
