//! The wavelengths of a pixel's samples in blocks of sixteen lanes: what they have in common for all pixels.

use crate::{basis::Basis, medium::Medium};
use accel::lanes::{Lanes, Row, WIDTH};
use spectral_core::{
    lattice::{chosen, order},
    prepare::SpectralTable,
};

/// Sixteen spectral lines of the samples of one pixel, or of a few pixels, sorted by wavelength. Within a pixel rays part by
/// dispersion, not by where in the pixel they began, since plane mirrors keep parallel rays parallel. So neighbours by
/// wavelength meet the same facets for longer than the lines of one sample would.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// The lanes that hold a line: the first ones.
    pub lanes: u16,
    /// Of each lane, its place among the lines of the pixels' samples, pixel by pixel, sample by sample, wavelengths
    /// innermost.
    place: [u32; WIDTH],
    /// Of each lane, its sample counted from the first pixel's first; empty lanes repeat the last.
    pub sample: [u32; WIDTH],
    /// Whether that is one and the same.
    pub together: bool,
    /// By material.
    pub media: Vec<Medium>,
    /// The light for a colour.
    pub basis: Basis,
    /// The part of each lane's sample in its choices of modes (`lattice::order`); 0 where there are no crystals.
    orders: [u32; WIDTH],
}

/// A spectral line of one sample's wavelength grid.
struct Line<'a> {
    sample: u32,
    table: &'a SpectralTable,
    index: usize,
    place: u32,
}

/// The lines of samples one after another.
fn lines<'a>(samples: impl Iterator<Item = &'a SpectralTable>) -> Vec<Line<'a>> {
    (0..)
        .zip(samples)
        .flat_map(|(sample, table)| (0..table.wavelengths.len()).map(move |index| (sample, table, index)))
        .zip(0..)
        .map(|((sample, table, index), place)| Line { sample, table, index, place })
        .collect()
}

impl Line<'_> {
    fn wavelength(&self) -> f64 {
        self.table.wavelengths[self.index]
    }
}

impl Block {
    /// The number of pixels with so many lines each that should share their blocks: empty lanes cost as much as used
    /// ones, but rays of different pixels part sooner.
    pub fn pixels(lines: usize) -> usize {
        // Pixels, and the time of a line relative to that of one pixel alone, measured on a brilliant.
        const SHARED: [(usize, f64); 3] = [(1, 1.0), (2, 1.1), (4, 1.3)];
        let cost = |&(pixels, cost): &(usize, f64)| {
            cost * (pixels * lines).next_multiple_of(WIDTH) as f64 / (pixels * lines) as f64
        };
        SHARED.iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).map_or(1, |(pixels, _)| *pixels)
    }

    /// The blocks of some pixels' samples with these tables, every pixel's the same.
    pub fn all<'a>(pixels: usize, samples: impl Iterator<Item = &'a SpectralTable> + Clone) -> Vec<Self> {
        let mut lines = lines((0..pixels).flat_map(|_| samples.clone()));
        lines.sort_by(|a, b| a.wavelength().total_cmp(&b.wavelength()));
        lines.chunks(WIDTH).map(Self::new).collect()
    }

    /// The blocks of one pixel's samples from number `first` on, where these choose modes of crystals. The wavelengths of a
    /// sample choose alike, so they stay together.
    pub fn choosing<'a>(first: u32, samples: impl Iterator<Item = &'a SpectralTable>) -> Vec<Self> {
        let mut blocks: Vec<Self> = lines(samples).chunks(WIDTH).map(Self::new).collect();
        for block in &mut blocks {
            block.orders = block.sample.map(|sample| order(first + sample));
        }
        blocks
    }

    /// A lane's place among the lines of its pixels.
    pub fn place(&self, lane: usize) -> u32 {
        self.place[lane]
    }

    /// What each lane chooses one of two modes by at a surface event with this part of the choice (`lattice::power`).
    pub fn choices(&self, power: u32) -> Row {
        Row(self.orders.map(|order| chosen(order, power) as f32))
    }

    fn new(lines: &[Line<'_>]) -> Self {
        let line = |lane: usize| &lines[lane.min(lines.len() - 1)];
        let materials = lines.first().map_or(0, |line| line.table.media.len());
        let medium = |m: usize| Medium::new(|lane| &line(lane).table.media[m][line(lane).index]);
        Block {
            lanes: ((1u32 << lines.len()) - 1) as u16,
            place: std::array::from_fn(|lane| line(lane).place),
            sample: std::array::from_fn(|lane| line(lane).sample),
            together: lines.iter().all(|line| line.sample == lines[0].sample),
            media: (0..materials).map(medium).collect(),
            orders: [0; WIDTH],
            basis: Basis::new(|lane| &line(lane).table.basis[line(lane).index]),
        }
    }

    /// Puts each line's value in its place among those of its pixels.
    #[inline(always)]
    pub fn scatter<V: Lanes>(&self, values: V, pixels: &mut [f32]) {
        let values = values.stored().0;
        for lane in 0..self.lanes.count_ones() as usize {
            pixels[self.place[lane] as usize] = values[lane];
        }
    }
}
