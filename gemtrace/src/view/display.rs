//! Pictures as they are shown: bytes for the page's canvas, and the message around them.

use super::hub::Bytes;
use super::message::Letter;
use crate::output::pixels;
use crate::scene_file::LoadedScene;
use rayon::prelude::*;
use serde_json::{Value, json};
use spectral_core::color::{RgbSpace, srgb_encode};
use spectral_core::film::Film;
use spectral_core::scene::Background;
use std::sync::LazyLock;

/// Steps of the table of encoded values; with them the encoded value is at most a quarter of a step of 8 bits off.
const STEPS: usize = 1 << 14;

/// Encoded values of 0 to 1 in equal steps.
static ENCODED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let encode = |k: usize| (srgb_encode(k as f64 / STEPS as f64) * 255.0).round() as u8;
    (0..=STEPS).map(encode).collect()
});

/// The film of a scene as bytes, RGBA with straight alpha. The table of encoded values makes it some thirty times as fast as what is
/// written to files, which needs every bit.
pub fn rgba(film: &Film, loaded: &LoadedScene) -> Vec<u8> {
    let transparent = loaded.scene.background == Background::Transparent;
    let look = Some((loaded.exposure, loaded.tone));
    let pixels = pixels(film, transparent, loaded.backdrop, RgbSpace::Srgb, look);
    let show = |[r, g, b, alpha]: [f32; 4]| {
        let straight = if alpha > 0.0 { 1.0 / alpha } else { 0.0 };
        let encode = |c: f32| ENCODED[((c * straight).clamp(0.0, 1.0) * STEPS as f32) as usize];
        [encode(r), encode(g), encode(b), (alpha.clamp(0.0, 1.0) * 255.0).round() as u8]
    };
    let mut bytes = vec![0; 4 * pixels.len()];
    let places = bytes.par_chunks_exact_mut(4).with_min_len(1 << 14);
    places.zip(pixels).for_each(|(place, pixel)| place.copy_from_slice(&show(pixel)));
    bytes
}

/// What a message says about its picture.
pub struct Caption {
    pub side: Letter,
    pub size: [u32; 2],
    /// The newest change that it shows.
    pub answers: u64,
    pub stage: &'static str,
    pub samples: u32,
    /// Traced for each sample.
    pub wavelengths: usize,
    pub format: &'static str,
}

/// A message with a picture.
pub fn message(caption: &Caption, picture: &[u8]) -> Bytes {
    let Caption { side, size: [width, height], answers, stage, samples, wavelengths, format } = caption;
    let header: Value = json!({
        "side": side.name(), "width": width, "height": height, "answers": answers, "stage": stage,
        "samples": samples, "wavelengths": wavelengths, "format": format,
    });
    let header = header.to_string();
    let length = (header.len() as u32).to_le_bytes();
    [length.as_slice(), header.as_bytes(), picture].concat().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_as_good_as_the_curve() {
        for k in 0..=1000 {
            let c = k as f32 / 1000.0;
            let [fast, exact] =
                [ENCODED[(c * STEPS as f32) as usize], (srgb_encode(c.into()) * 255.0).round() as u8];
            assert!(fast.abs_diff(exact) <= 1, "{c}: {fast} {exact}");
        }
    }
}
