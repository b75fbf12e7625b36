//! OpenEXR: linear floats, spectra, and the whole provenance in the header.
//!
//! Spectral channels follow Fichet, Pacanowski & Wilkie, "An OpenEXR Layout for Spectral Images", JCGT
//! 10(3), 2021: the Stokes component S0 as channels `S0.<nm>nm`, a comma for the decimal point (a point
//! separates layers), the attribute `spectralLayoutVersion`, and the unit in `emissiveUnits`. Radiance is
//! relative: an environment of 1 under illuminant E is 1 at every wavelength.
//! Where wavelengths are jittered, a channel is the mean over its cell and is named after the cell's middle.

use super::{Picture, file};
use crate::Error;
use exr::meta::attribute::{AttributeValue, Chromaticities};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, Text, Vec2, WritableImage,
};
use serde_json::Value;
use spectral_core::color::RgbSpace;
use spectral_core::environment::LatLong;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Encodes a picture: premultiplied RGBA and, if the film keeps them, its spectral planes.
pub fn encode(picture: &Picture, file: &mut File) -> Result<(), String> {
    let size = Vec2(picture.film.width() as usize, picture.film.height() as usize);
    let mut image = image(size, layer_attributes(picture), channels(picture));
    image.attributes.chromaticities = Some(chromaticities(picture.options.space));
    finish(&image, file)
}

/// Writes the texels of a light, linear sRGB, as an OpenEXR file that scenes can name.
///
/// # Errors
/// [`Error::Output`] if it cannot be written.
pub fn write_light(path: &Path, light: &LatLong) -> Result<u64, Error> {
    let size = Vec2(light.width() as usize, light.height() as usize);
    let plane = |c: usize| light.texels().iter().map(|texel| texel[c]).collect();
    let channels = ["R", "G", "B"].into_iter().enumerate().map(|(c, name)| channel(name, plane(c)));
    let image = image(size, LayerAttributes::default(), channels);
    file::write(path, |file| finish(&image, file))
}

fn finish(image: &Image<Layer<AnyChannels<FlatSamples>>>, file: &mut File) -> Result<(), String> {
    image.write().to_unbuffered(&mut *file).map_err(|e| match e {
        exr::error::Error::Io(e) => e.to_string(),
        other => other.to_string(),
    })?;
    sort_header(file).map_err(|e| e.to_string())
}

/// One layer in scan lines, compressed without loss.
pub(crate) fn image(
    size: Vec2<usize>,
    attributes: LayerAttributes,
    channels: impl Iterator<Item = AnyChannel<FlatSamples>>,
) -> Image<Layer<AnyChannels<FlatSamples>>> {
    let (compression, blocks, line_order) = (Compression::ZIP16, Blocks::ScanLines, LineOrder::Increasing);
    let encoding = Encoding { compression, blocks, line_order };
    Image::from_layer(Layer::new(size, attributes, encoding, AnyChannels::sort(channels.collect())))
}

/// Puts the header's attributes in the order of their names, so that the same picture is the same bytes:
/// the `exr` crate keeps them in a hash map, whose order is random.
///
/// A header is the magic number and the version (8 bytes), then attributes (name, 0, type, 0, size as 4
/// bytes, value), then 0 (OpenEXR file layout). Reordering changes no offset.
fn sort_header(file: &mut File) -> std::io::Result<()> {
    const START: u64 = 8;
    let mut header = Vec::new();
    file.seek(SeekFrom::Start(START))?;
    Read::take(&mut *file, 1 << 24).read_to_end(&mut header)?;
    let mut attributes = Vec::new();
    let mut rest = header.as_slice();
    while rest.first().is_some_and(|&byte| byte != 0) {
        // A device such as /dev/null gives nothing back; what cannot be read stays as it is.
        let Some((attribute, after)) = attribute_length(rest).and_then(|n| rest.split_at_checked(n)) else {
            return Ok(());
        };
        attributes.push(attribute);
        rest = after;
    }
    attributes.sort_unstable();
    file.seek(SeekFrom::Start(START))?;
    file.write_all(&attributes.concat())
}

/// Bytes that the attribute at the start of `bytes` takes.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let name = bytes.iter().position(|&byte| byte == 0)? + 1;
    let kind = bytes.get(name..)?.iter().position(|&byte| byte == 0)? + 1;
    let size = bytes.get(name + kind..)?.first_chunk()?;
    let value = usize::try_from(i32::from_le_bytes(*size)).ok()?;
    Some(name + kind + 4 + value)
}

fn channels(picture: &Picture) -> impl Iterator<Item = AnyChannel<FlatSamples>> {
    let pixels = picture.linear(picture.options.space);
    let colours = ["R", "G", "B", "A"].into_iter().enumerate();
    let colours: Vec<_> =
        colours.map(|(c, name)| channel(name, pixels.iter().map(|pixel| pixel[c]).collect())).collect();
    let spectra = channel_names(&picture.wavelengths).into_iter().zip(planes(picture));
    colours.into_iter().chain(spectra.map(|(name, plane)| channel(&name, plane)))
}

/// 32-bit floats under a name.
pub(crate) fn channel(name: &str, samples: Vec<f32>) -> AnyChannel<FlatSamples> {
    AnyChannel::new(text(name), FlatSamples::F32(samples))
}

/// The film's radiance, one plane a wavelength.
fn planes(picture: &Picture) -> Vec<Vec<f32>> {
    let film = &picture.film;
    let pixels = film.width() as usize * film.height() as usize;
    let mut planes = vec![vec![0.0; pixels]; film.wavelength_count()];
    for i in 0..if planes.is_empty() { 0 } else { pixels } {
        let (x, y) = (i % film.width() as usize, i / film.width() as usize);
        let radiance = film.radiance(x as u32, y as u32);
        planes.iter_mut().zip(radiance).for_each(|(plane, value)| plane[i] = value);
    }
    planes
}

/// `S0.550nm`, `S0.391,25nm`: as few decimals as are needed, at most six unless two names would be equal.
fn channel_names(wavelengths: &[f64]) -> Vec<String> {
    let name = |number: String| format!("S0.{}nm", number.replace('.', ","));
    let rounded = |nm: &f64| name(((nm * 1e6).round() / 1e6).to_string());
    let mut names: Vec<String> = wavelengths.iter().map(rounded).collect();
    if names.windows(2).any(|pair| pair[0] == pair[1]) {
        names = wavelengths.iter().map(|nm| name(nm.to_string())).collect();
    }
    names
}

fn layer_attributes(picture: &Picture) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        software_name: Some(text(&picture.provenance.software())),
        ..LayerAttributes::default()
    };
    let facts = picture.provenance.facts();
    attributes.other.extend(facts.map(|(key, value)| (text(&format!("gemtrace.{key}")), attribute(value))));
    if picture.film.wavelength_count() > 0 {
        let layout = [("spectralLayoutVersion", "1.0"), ("emissiveUnits", "W.m^-2.sr^-1")];
        attributes.other.extend(layout.map(|(key, value)| (text(key), AttributeValue::Text(text(value)))));
    }
    attributes
}

/// EXR has no truth values and no whole numbers beyond 32 bits: those become text and doubles.
fn attribute(value: &Value) -> AttributeValue {
    match value {
        Value::Number(n) => AttributeValue::F64(n.as_f64().unwrap_or(f64::NAN)),
        Value::String(s) => AttributeValue::Text(text(s)),
        other => AttributeValue::Text(text(&other.to_string())),
    }
}

/// EXR text as UTF-8; a zero byte would end it.
pub(crate) fn text(s: &str) -> Text {
    Text::from_slice_unchecked(s.replace('\0', " ").as_bytes())
}

/// XYZ is an RGB space whose primaries are the axes and whose white is equal energy (the OpenEXR standard).
fn chromaticities(space: RgbSpace) -> Chromaticities {
    let pair = |[x, y]: [f64; 2]| Vec2(x as f32, y as f32);
    let [red, green, blue] = space.primaries().map(pair);
    let white = if space == RgbSpace::Xyz { [1.0 / 3.0; 2] } else { space.white() };
    Chromaticities { red, green, blue, white: pair(white) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wavelengths_are_named_as_the_layout_has_it() {
        assert_eq!(
            channel_names(&[420.0, 391.25, 1e3 / 2.4]),
            ["S0.420nm", "S0.391,25nm", "S0.416,666667nm"]
        );
        let close = channel_names(&[500.0, 500.000_000_1]);
        assert_eq!(close, ["S0.500nm", "S0.500,0000001nm"]);
    }
}
