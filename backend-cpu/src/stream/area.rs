//! Pixels of one convex crystal as areas: its beams (`spectral_core::beam`) are a stream too.

use super::{Stream, beams::Beams, event::Events, lines::Lines};
use crate::{
    account::Account,
    beam::{
        entry::{Arrivals, Entries},
        line::Line,
    },
    block::Block,
    environment::Light,
    schedule::{Finished, Stop, TileTracer},
    sums::Sums,
};
use accel::Task;
use accel::lanes::{Lanes, Row};
use spectral_core::{beam::Silhouette, film::Tile, prepare::PreparedScene};
use std::ops::Range;

/// Areas with the crystal and its light.
pub(crate) struct AreaTracer<'a> {
    pub silhouette: &'a Silhouette,
    pub stream: &'a Stream,
    pub scene: &'a PreparedScene,
    pub light: &'a Light,
}

/// A tile's beams, for any instruction set.
struct Areas<'a> {
    tracer: &'a AreaTracer<'a>,
    blocks: &'a [Block],
    lines: &'a Lines<'a>,
    entries: &'a mut Entries,
    sums: &'a mut Sums,
    account: &'a mut Account,
    stop: &'a Stop<'a>,
}

impl TileTracer for AreaTracer<'_> {
    fn tile(&self, tile: Tile, samples: Range<u32>, stop: &Stop<'_>) -> Option<Finished> {
        let (scene, stream) = (self.scene, self.stream);
        let blocks = Block::all(1, samples.clone().map(|sample| scene.table(sample)));
        let lines = Lines::new(scene, samples.clone(), stream.material, &stream.frame);
        let mut entries = Entries::new(self.silhouette, scene, tile);
        let count = entries.pixels() * lines.len();
        let (mut sums, mut account) = (Sums::new(stream.unit, count), Account::default());
        account.start(count);
        let finished = stream.instructions.run(Areas {
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

impl Task for Areas<'_> {
    type Output = bool;

    /// Follows all beams; false if broken off.
    #[inline(always)]
    fn run<V: Lanes>(self) -> bool {
        let AreaTracer { silhouette, stream, scene, light } = self.tracer;
        self.entries.mirror::<V>(light);
        self.entries.behind::<V>(self.blocks, self.lines.len(), self.sums, self.account);
        let limits = silhouette.limits(&scene.settings);
        let least = [limits.end, limits.choice].map(|limit| limit as f32);
        let events = Events::<V>::new(stream, light, self.lines, least, self.sums, self.account);
        let mut beams = Beams::new(events, limits);
        let all = Line::all(self.blocks, stream.material);
        let mut arrivals = Arrivals::new(self.entries, &all);
        let mut rows = [Row::default(); _];
        loop {
            while !beams.are_full() && arrivals.gather() {
                beams.enter(&arrivals, &mut rows);
            }
            if beams.are_over() {
                return true;
            }
            beams.step();
            if (self.stop)() {
                return false;
            }
        }
    }
}
