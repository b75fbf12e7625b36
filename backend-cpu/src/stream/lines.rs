//! The spectral lines of a pixel's samples, and what rays of any sixteen of them meet.

use crate::crystal::{FIGURES, Frame, Optics};
use accel::lanes::{Lanes, Row, WIDTH};
use spectral_core::{crystal::Crystal, lattice::order, prepare::PreparedScene, upsample::BASES};
use std::ops::Range;

/// All lines of the samples of a pixel, wavelengths innermost.
pub(super) struct Lines<'a> {
    /// Of each line: the bases of light, then the crystal's figures.
    records: Vec<Record>,
    /// How many of a record's numbers are in use.
    used: usize,
    exact: Vec<&'a Crystal>,
    /// Of each line: its sample, counted from the first, and the sample's place among the choices.
    samples: Vec<u32>,
    orders: Vec<f32>,
    frame: &'a Frame,
    count: usize,
}

/// In fours.
const RECORD: usize = (BASES + FIGURES).div_ceil(4);
type Record = [[f32; 4]; RECORD];

/// The records of sixteen lines, a lane each.
pub(super) type Gathered = [Row; 4 * RECORD];

impl<'a> Lines<'a> {
    pub fn new(scene: &'a PreparedScene, samples: Range<u32>, material: usize, frame: &'a Frame) -> Self {
        let mut lines = Lines {
            records: Vec::new(),
            used: BASES + frame.count(),
            exact: Vec::new(),
            samples: Vec::new(),
            orders: Vec::new(),
            frame,
            count: samples.len(),
        };
        for (number, sample) in (0..).zip(samples) {
            let table = scene.table(sample);
            for (basis, medium) in table.basis.iter().zip(&table.media[material]) {
                // Without a crystal this scene would not be a stream.
                let Some(line) = &medium.crystal else { continue };
                let mut record = [[0.0; 4]; RECORD];
                let figures = basis.iter().map(|b| *b as f32).chain(frame.figures(line));
                record
                    .as_flattened_mut()
                    .iter_mut()
                    .zip(figures)
                    .for_each(|(number, figure)| *number = figure);
                lines.records.push(record);
                lines.exact.push(&line.0);
                lines.samples.push(number);
                lines.orders.push(order(sample) as f32);
            }
        }
        lines
    }

    /// How many lines.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// How many samples.
    pub fn samples(&self) -> usize {
        self.count
    }

    /// How many packets the lines make.
    pub fn blocks(&self) -> usize {
        self.len().div_ceil(WIDTH)
    }

    /// The lines of a packet of camera rays; lanes that are left repeat the last one.
    pub fn of_block(&self, block: usize) -> ([u32; WIDTH], u16) {
        let (first, last) = (block * WIDTH, self.len() - 1);
        let lines = std::array::from_fn(|lane| (first + lane).min(last) as u32);
        (lines, ((1u32 << (self.len() - first).min(WIDTH)) - 1) as u16)
    }

    pub fn sample(&self, line: u32) -> usize {
        self.samples[line as usize] as usize
    }

    pub fn order(&self, line: u32) -> f32 {
        self.orders[line as usize]
    }

    /// In double precision.
    pub fn exact(&self, line: u32) -> &'a Crystal {
        self.exact[line as usize]
    }

    /// The records of sixteen lines, given by the bits of their numbers.
    #[inline(always)]
    pub fn gather<V: Lanes>(&self, lines: &Row, rows: &mut Gathered) {
        let mut records = [&self.records[0]; WIDTH];
        for (record, line) in records.iter_mut().zip(lines.0) {
            *record = &self.records[line.to_bits() as usize];
        }
        for (place, rows) in rows.as_chunks_mut::<4>().0[..self.used.div_ceil(4)].iter_mut().enumerate() {
            for (row, number) in rows.iter_mut().zip(V::fours(&records, place)) {
                number.store(row);
            }
        }
    }

    /// The bases and the optics of sixteen lines.
    #[inline(always)]
    pub fn optics<'b>(&'b self, rows: &'b Gathered) -> (&'b [Row; BASES], Optics<'b>) {
        let (bases, figures) = rows.split_first_chunk().expect("bases come first");
        (bases, self.frame.at(&figures[..self.used - BASES]))
    }
}
