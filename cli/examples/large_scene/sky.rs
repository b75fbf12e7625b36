//! An environment of any size, written as it is computed.

use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage, f16};
use std::io::Write;
use std::path::Path;

/// A smooth sky with square lamps.
pub struct Sky {
    pub width: usize,
    pub height: usize,
}

impl Sky {
    fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        let (u, v) = (x as f32 / self.width as f32, y as f32 / self.height as f32);
        let lamp = (u * 8.0).fract() < 0.125 && (v * 6.0).fract() < 0.125;
        if lamp { [40.0, 36.0, 30.0] } else { [0.3 + 0.3 * v, 0.4 + 0.2 * v, 0.6 - 0.2 * (u - 0.5).abs()] }
    }

    pub fn write_exr(&self, path: &Path) -> exr::error::UnitResult {
        let channels = SpecificChannels::rgb(|Vec2(x, y)| {
            let [r, g, b] = self.texel(x, y).map(f16::from_f32);
            (r, g, b)
        });
        let attributes = LayerAttributes::default();
        let layer =
            Layer::new((self.width, self.height), attributes, Encoding::SMALL_FAST_LOSSLESS, channels);
        Image::from_layer(layer).write().non_parallel().to_file(path)
    }

    /// Scan lines of literal runs: the largest that the format makes them.
    pub fn write_hdr(&self, mut file: impl Write) -> std::io::Result<()> {
        write!(file, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", self.height, self.width)?;
        let mut line = vec![[0_u8; 4]; self.width];
        for y in 0..self.height {
            for (x, slot) in line.iter_mut().enumerate() {
                *slot = rgbe(self.texel(x, y));
            }
            file.write_all(&[2, 2, (self.width >> 8) as u8, self.width as u8])?;
            for component in 0..4 {
                for run in line.chunks(128) {
                    file.write_all(&[run.len() as u8])?;
                    run.iter().try_for_each(|texel| file.write_all(&[texel[component]]))?;
                }
            }
        }
        file.flush()
    }
}

/// Three mantissas and their common exponent (Ward, "Real pixels", Graphics Gems II).
fn rgbe(texel: [f32; 3]) -> [u8; 4] {
    let exponent = texel.iter().fold(0.0, |most: f32, c| most.max(*c)).log2().floor() + 1.0;
    let [r, g, b] = texel.map(|c| (c / exponent.exp2() * 256.0) as u8);
    [r, g, b, (exponent + 128.0) as u8]
}
