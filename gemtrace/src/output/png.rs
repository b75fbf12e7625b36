//! PNG: what a screen shows.

use super::{Depth, Picture, png_space};
use png::{
    BitDepth, ColorType, Compression, Encoder, ScaledFloat, SourceChromaticities, SrgbRenderingIntent,
    chunk::ChunkType,
};
use spectral_core::color::{RgbSpace, srgb_encode};
use std::io::{BufWriter, Write};

/// Encodes a picture: straight alpha, sRGB transfer, in its tone.
pub fn encode(picture: &Picture, file: &mut impl Write) -> Result<(), String> {
    let mut buffer = BufWriter::new(file);
    try_encode(picture, &mut buffer).map_err(|e| match e {
        png::EncodingError::IoError(e) => e.to_string(),
        other => other.to_string(),
    })?;
    buffer.flush().map_err(|e| e.to_string())
}

fn try_encode(picture: &Picture, output: &mut impl Write) -> Result<(), png::EncodingError> {
    let (width, height) = (picture.film.width(), picture.film.height());
    let space = png_space(picture.options.space);
    let mut encoder = Encoder::new(output, width, height);
    encoder.set_color(ColorType::Rgba);
    // A picture of one sample a pixel would wait for its file for a quarter of its time; fast compression makes the file a
    // fifteenth to two fifths larger.
    if picture.film.total_samples() <= u64::from(width) * u64::from(height) {
        encoder.set_compression(Compression::Fast);
    }
    encoder.set_depth(match picture.options.depth {
        Depth::Eight => BitDepth::Eight,
        Depth::Sixteen => BitDepth::Sixteen,
    });
    label(&mut encoder, space);
    encoder.add_text_chunk("Software".to_owned(), picture.provenance.software())?;
    encoder.add_itxt_chunk("gemtrace".to_owned(), picture.provenance.to_json().to_string())?;
    let mut writer = encoder.write_header()?;
    if let Some(primaries) = code_point(space) {
        // ITU-T H.273: these primaries, transfer 13 (sRGB), matrix 0 (RGB), full range. PNG 3, 11.3.2.6.
        writer.write_chunk(ChunkType(*b"cICP"), &[primaries, 13, 0, 1])?;
    }
    let mut rows = writer.stream_writer()?;
    for row in picture.shown(space).chunks(width as usize) {
        let samples = row.iter().flat_map(|pixel| displayed(*pixel));
        let bytes: Vec<u8> = match picture.options.depth {
            Depth::Eight => samples.map(|v| (v * 255.0).round() as u8).collect(),
            Depth::Sixteen => samples.flat_map(|v| ((v * 65_535.0).round() as u16).to_be_bytes()).collect(),
        };
        rows.write_all(&bytes)?;
    }
    rows.finish()
}

/// Encodes 8-bit sRGB pixels as they are, row by row: RGB, or RGBA with straight alpha.
pub fn encode_pixels<const N: usize>(
    width: u32,
    pixels: &[[u8; N]],
    compression: Compression,
    output: &mut impl Write,
) -> Result<(), String> {
    let mut buffer = BufWriter::new(output);
    let mut encoder = Encoder::new(&mut buffer, width, pixels.len() as u32 / width.max(1));
    encoder.set_color(if N == 4 { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(compression);
    encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(pixels.as_flattened()).map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    buffer.flush().map_err(|e| e.to_string())
}

/// Linear premultiplied to encoded straight values, 0 to 1.
pub(super) fn displayed([r, g, b, alpha]: [f32; 4]) -> [f64; 4] {
    let straight = if alpha > 0.0 { 1.0 / f64::from(alpha) } else { 0.0 };
    let [r, g, b] = [r, g, b].map(|c| srgb_encode((f64::from(c) * straight).clamp(0.0, 1.0)));
    [r, g, b, f64::from(alpha).clamp(0.0, 1.0)]
}

fn label<W: Write>(encoder: &mut Encoder<W>, space: RgbSpace) {
    if space == RgbSpace::Srgb {
        encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
        return;
    }
    // For readers older than cICP: the primaries, and the gamma nearest to sRGB's curve.
    let pair = |[x, y]: [f64; 2]| (x as f32, y as f32);
    let [red, green, blue] = space.primaries().map(pair);
    encoder.set_source_chromaticities(SourceChromaticities::new(pair(space.white()), red, green, blue));
    encoder.set_source_gamma(ScaledFloat::new(1.0 / 2.2));
}

/// The space's number in ITU-T H.273, table 2.
fn code_point(space: RgbSpace) -> Option<u8> {
    match space {
        RgbSpace::P3 => Some(12),
        RgbSpace::Rec2020 => Some(9),
        _ => None,
    }
}
