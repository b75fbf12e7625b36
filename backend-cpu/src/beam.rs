//! Pixels of one convex stone as areas: what enters by one facet is a beam, a convex polygon of the pixel's area that is
//! followed as a whole and cut where facets meet (`spectral_core::beam`). So the edges of facets cost no samples, and what
//! is left to sample is the wavelength.
//!
//! Sixteen beams make a packet, a lane each. All that a beam needs is in its lane: packets are put together from any pixels
//! and wavelengths, and the parts that are cut off wait until sixteen of them are a packet. What a lane computes does not
//! depend on its neighbours, and sums are in fixed point, so the picture does not depend on who travels with whom.

pub(crate) mod entry;
pub(crate) mod flight;
pub(crate) mod line;
pub(crate) mod packet;
pub(crate) mod part;

use crate::{
    account::Account,
    block::Block,
    chain::Chain,
    environment::Light,
    schedule::{Finished, Stop, TileTracer},
    sums::Sums,
    throughput::{Mean, Polarized, Stored},
};
use accel::Task;
use accel::lanes::Lanes;
use entry::{Arrivals, Entries};
use flight::Flight;
use line::Line;
use spectral_core::{beam::Silhouette, film::Tile, prepare::PreparedScene};
use std::ops::Range;

/// Areas with the stone, its light and its spectral lines.
pub(crate) struct BeamTracer<'a> {
    pub silhouette: &'a Silhouette,
    /// Parts of a unit of radiance.
    pub unit: f64,
    pub chain: &'a Chain,
    pub scene: &'a PreparedScene,
    pub light: &'a Light,
}

/// A tile's beams, for any instruction set.
struct Beams<'a> {
    tracer: &'a BeamTracer<'a>,
    blocks: &'a [Block],
    lines: &'a [Line],
    entries: &'a mut Entries,
    sums: &'a mut Sums,
    account: &'a mut Account,
    stop: &'a Stop<'a>,
}

impl TileTracer for BeamTracer<'_> {
    fn tile(&self, tile: Tile, samples: Range<u32>, stop: &Stop<'_>) -> Option<Finished> {
        let (scene, material) = (self.scene, self.chain.material);
        let blocks = Block::all(1, samples.clone().map(|sample| scene.table(sample)));
        let lines = Line::all(&blocks, material);
        let mut entries = Entries::new(self.silhouette, scene, tile);
        let mut sums = Sums::new(self.unit, entries.pixels() * lines.len());
        let mut account = Account::default();
        account.start(entries.pixels() * lines.len());
        let finished = self.chain.instructions.run(Beams {
            tracer: self,
            blocks: &blocks,
            lines: &lines,
            entries: &mut entries,
            sums: &mut sums,
            account: &mut account,
            stop,
        });
        let coverage = entries.coverage(samples.len());
        finished.then(|| Finished::new(scene, tile, samples, sums.radiances(), &coverage, account))
    }
}

impl Task for Beams<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<V: Lanes>(self) -> bool {
        self.entries.mirror::<V>(self.tracer.light);
        self.entries.behind::<V>(self.blocks, self.lines.len(), self.sums, self.account);
        if self.tracer.scene.settings.polarized {
            self.follow::<V, Polarized<V>>()
        } else {
            self.follow::<V, Mean<V>>()
        }
    }
}

impl Beams<'_> {
    /// Follows all beams; false if broken off.
    #[inline(always)]
    fn follow<V: Lanes, T: Stored<V>>(self) -> bool {
        let BeamTracer { chain, light, silhouette, scene, .. } = self.tracer;
        let limits = silhouette.limits(&scene.settings);
        let mut flight = Flight::<V, T>::new(chain, light, limits, self.lines, self.sums, self.account);
        let mut arrivals = Arrivals::new(self.entries, self.lines);
        loop {
            let mut ended = false;
            while !ended && flight.has_room() {
                ended = !arrivals.gather();
                if !ended {
                    flight.enter(&arrivals);
                }
            }
            flight.board(ended);
            if flight.is_empty() {
                return true;
            }
            flight.step();
            if (self.stop)() {
                return false;
            }
        }
    }
}
