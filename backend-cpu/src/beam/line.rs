//! Spectral lines one by one: lanes of a packet of beams are of any.

use crate::block::Block;
use spectral_core::upsample::BASES;

/// A spectral line of a pixel's samples, with the optics of the stone and of the light at its wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    /// Index of refraction n, n² and 1 − n²; absorption to base 2, 1/mm.
    pub medium: [f32; 4],
    /// As `Medium` has it, of 1/n.
    pub inverse: [f32; 5],
    /// Radiance of the bases.
    pub basis: [f32; BASES],
    /// Its place among the lines of the pixel's samples, wavelengths innermost.
    pub place: u32,
}

impl Line {
    /// The lines of one pixel's blocks, by wavelength.
    pub fn all(blocks: &[Block], material: usize) -> Vec<Self> {
        let lanes = |block: &Block| 0..block.lanes.count_ones() as usize;
        let lines = blocks.iter().flat_map(|block| lanes(block).map(move |lane| (block, lane)));
        let line = |(block, lane): (&Block, usize)| Line {
            medium: block.media[material].outward(lane),
            inverse: block.media[material].inward(lane),
            basis: block.basis.of(lane),
            place: block.place(lane),
        };
        lines.map(line).collect()
    }
}
