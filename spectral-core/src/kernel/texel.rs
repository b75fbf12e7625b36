//! The environment's texels as a GPU's image takes them: four numbers each, rows from +z down.
//!
//! They are single-precision numbers where they fit [`FULL_BYTES`], else halves: those cost 1e-4 of a radiance (half
//! a unit in their last place is 2⁻¹¹ of a texel), which is more than the rest of single precision together.

use crate::environment::{LatLong, Source};
use half::f16;

/// The most memory that texels in single precision may take: an image of 8192 × 4096.
pub const FULL_BYTES: u64 = 512 << 20;
/// Texels are converted in pieces of about this many bytes.
const PIECE_BYTES: usize = 16 << 20;

/// An image in the format chosen for it.
#[derive(Debug, Clone, Copy)]
pub struct Texels<'a> {
    texels: &'a [[f32; 3]],
    /// Texels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Whether texels are single-precision numbers (true) or halves.
    pub full: bool,
    /// What a radiance is to be multiplied by: halves hold no more than 65,504, so brighter images are scaled.
    pub gain: f32,
}

impl<'a> Texels<'a> {
    /// The texels of an environment; one black texel for a uniform one, which the kernel never reads.
    pub fn of(source: &'a Source) -> Self {
        match source {
            Source::Image(image) => Self::of_image(image),
            Source::Uniform(_) => Texels { texels: &[[0.0; 3]], width: 1, height: 1, full: true, gain: 1.0 },
        }
    }

    fn of_image(image: &'a LatLong) -> Self {
        let (texels, width, height) = (image.texels(), image.width(), image.height());
        let full = u64::from(width) * u64::from(height) * 16 <= FULL_BYTES;
        Texels { texels, width, height, full, gain: if full { 1.0 } else { half_gain(texels) } }
    }

    /// Bytes of a row.
    pub fn row_bytes(&self) -> u32 {
        self.width * if self.full { 16 } else { 8 }
    }

    /// All texels as bytes in pieces of whole rows: the first row of each, and its bytes.
    pub fn pieces(&self) -> impl Iterator<Item = (u32, Vec<u8>)> + 'a {
        let Texels { full, gain, width, .. } = *self;
        let rows = (PIECE_BYTES / self.row_bytes() as usize).max(1);
        self.texels.chunks(rows * width as usize).enumerate().map(move |(piece, texels)| {
            let bytes = texels.iter().flat_map(|texel| encoded(*texel, gain, full)).collect();
            ((piece * rows) as u32, bytes)
        })
    }
}

fn encoded([r, g, b]: [f32; 3], gain: f32, full: bool) -> Vec<u8> {
    let texel = [r / gain, g / gain, b / gain, 0.0];
    if full {
        bytemuck::cast_slice(&texel).to_vec()
    } else {
        bytemuck::cast_slice(&texel.map(|c| f16::from_f32(c).to_bits())).to_vec()
    }
}

/// The power of two that brings the brightest texel into the range of halves.
fn half_gain(texels: &[[f32; 3]]) -> f32 {
    let brightest = texels.iter().flatten().copied().fold(0.0, f32::max);
    (brightest / f16::MAX.to_f32()).max(1.0).log2().ceil().exp2()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gain_is_the_least_power_of_two_that_fits_halves() {
        for (brightest, gain) in [(1.0, 1.0), (65504.0, 1.0), (65505.0, 2.0), (1e6, 16.0)] {
            assert_eq!(half_gain(&[[0.5, brightest, 0.0]]), gain, "for {brightest}");
        }
    }

    #[test]
    fn pieces_hold_every_row_once() {
        let image = LatLong::new(4, 3, (0..12).map(|k| [k as f32, 0.5, 2.0]).collect()).expect("valid").0;
        let texels = Texels::of_image(&image);
        let bytes: Vec<u8> = texels.pieces().flat_map(|(_, bytes)| bytes).collect();
        let numbers: Vec<f32> = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
        assert_eq!(numbers.len(), 48);
        assert_eq!(numbers[44..], [11.0, 0.5, 2.0, 0.0]);
    }
}
