//! Pictures inside a page.

use gemtrace::output;
use spectral_core::color::{RgbSpace, Tone, ViewTransform, srgb_encode};
use spectral_core::film::Film;

/// How much a difference is enlarged to be seen.
pub const GAIN: f32 = 100.0;

/// The picture as a `data:` address. `None` if it cannot be encoded.
pub fn of(film: &Film) -> Option<String> {
    encode(film, &film.to_space(RgbSpace::Srgb), 1.0, Tone::default())
}

/// The difference of two films' colours without its sign, [`GAIN`] times enlarged, as a `data:` address.
pub fn of_difference(expected: &Film, found: &Film) -> Option<String> {
    let [a, b] = [expected, found].map(|film| film.to_space(RgbSpace::Srgb));
    let apart: Vec<[f32; 4]> =
        a.iter().zip(&b).map(|(a, b)| [0, 1, 2, 3].map(|c| (a[c] - b[c]).abs())).collect();
    encode(found, &apart, GAIN, Tone::Clip)
}

/// Linear pixels as an sRGB PNG of 8 bits; where nothing is, black.
fn encode(film: &Film, pixels: &[[f32; 4]], gain: f32, tone: Tone) -> Option<String> {
    let view = ViewTransform::new(tone, RgbSpace::Srgb);
    let channel = |c: f64| (255.0 * srgb_encode(c.clamp(0.0, 1.0))).round() as u8;
    let show = |[r, g, b, _]: &[f32; 4]| view.shown([r, g, b].map(|c| f64::from(c * gain))).map(channel);
    let pixels: Vec<[u8; 3]> = pixels.iter().map(show).collect();
    output::data_url(film.width(), &pixels).ok()
}
