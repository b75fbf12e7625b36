//! Environment images: OpenEXR, Radiance HDR and PNG, known by their first bytes.

use super::{about, blame, gibibytes};
use crate::Error;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, Vec2, read as read_exr};
use image::{DynamicImage, ImageFormat, ImageReader};
use spectral_core::Warning;
use spectral_core::color::srgb_decode;
use spectral_core::environment::LatLong;
use std::io::Cursor;
use std::path::Path;

/// Images that need more than this are held against their file's size.
const LARGE_BYTES: u128 = 256 << 20;
/// More texels a byte than any photograph compresses to, whatever the method.
const MAX_TEXELS_PER_BYTE: u64 = 4096;

/// A lat-long image from the bytes of the file `path`, as linear sRGB. PNG values are decoded by the sRGB
/// curve; alpha is ignored.
///
/// # Errors
/// [`Error::File`] for a format that is not known, a file that is not complete, EXR channels that are
/// neither R, G, B nor Y (naming those found), and sizes beyond [`LatLong::MAX_TEXELS`].
pub fn read(path: &Path, bytes: &[u8]) -> Result<(LatLong, Vec<Warning>), Error> {
    let decoded = if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr(bytes)
    } else if bytes.starts_with(b"\x89PNG") {
        png(bytes)
    } else if bytes.starts_with(b"#?") {
        hdr(bytes)
    } else if bytes.is_empty() {
        Err("the file is empty".into())
    } else {
        Err("not an OpenEXR, Radiance HDR or PNG image".into())
    };
    let Decoded { size: [width, height], texels, mut warnings } =
        decoded.map_err(|message| Error::file(path, message))?;
    if u64::from(width) != 2 * u64::from(height) {
        warnings.push(Warning::new(format!(
            "{width} × {height} texels are not twice as wide as high; they are stretched over the whole sphere"
        )));
    }
    let (image, more) = LatLong::new(width, height, texels).map_err(blame(path))?;
    warnings.extend(more);
    Ok((image, about(path, warnings)))
}

struct Decoded {
    size: [u32; 2],
    texels: Vec<[f32; 3]>,
    warnings: Vec<Warning>,
}

/// Refuses sizes that cannot be meant before anything is allocated for them.
fn check_size(width: usize, height: usize, file: usize) -> Result<[u32; 2], String> {
    let texels = width as u128 * height as u128;
    let need = texels * size_of::<[f32; 3]>() as u128;
    let size = format!("{width} × {height} texels");
    let (Ok(w), Ok(h)) = (u32::try_from(width), u32::try_from(height)) else {
        return Err(format!("{size} would need {}", gibibytes(need)));
    };
    if texels == 0 || texels > u128::from(LatLong::MAX_TEXELS) {
        let most = LatLong::MAX_TEXELS;
        return Err(format!("{size} would need {}; 1 to {most} texels are read", gibibytes(need)));
    }
    if need > LARGE_BYTES && texels > u128::from(MAX_TEXELS_PER_BYTE) * file as u128 {
        let need = gibibytes(need);
        return Err(format!(
            "{size} ({need}) are more than {file} bytes can hold; the file is damaged or truncated"
        ));
    }
    Ok([w, h])
}

/// What an EXR file offers of a colour.
enum Channels {
    Rgb([String; 3]),
    Luminance(String),
}

struct Canvas {
    width: usize,
    texels: Vec<[f32; 3]>,
}

impl Canvas {
    fn new(size: Vec2<usize>) -> Self {
        Canvas { width: size.0, texels: vec![[0.0; 3]; size.area()] }
    }

    fn set(&mut self, at: Vec2<usize>, texel: [f32; 3]) {
        if let Some(slot) = self.texels.get_mut(at.1 * self.width + at.0) {
            *slot = texel;
        }
    }
}

fn exr(bytes: &[u8]) -> Result<Decoded, String> {
    let incomplete = |e: exr::error::Error| format!("not a complete OpenEXR file: {e}");
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(incomplete)?;
    let (layer, channels) = choose(&meta.headers)?;
    let header = &meta.headers[layer];
    let size = check_size(header.layer_size.0, header.layer_size.1, bytes.len())?;
    let source = Cursor::new(bytes);
    let level = || read_exr().no_deep_data().largest_resolution_level().specific_channels();
    let canvas = match channels {
        Channels::Rgb([r, g, b]) => {
            level()
                .required(r.as_str())
                .required(g.as_str())
                .required(b.as_str())
                .collect_pixels(
                    |size, _| Canvas::new(size),
                    |canvas, at, (r, g, b): (f32, f32, f32)| canvas.set(at, [r, g, b]),
                )
                .first_valid_layer()
                .all_attributes()
                .from_buffered(source)
                .map_err(incomplete)?
                .layer_data
                .channel_data
                .pixels
        }
        Channels::Luminance(y) => {
            level()
                .required(y.as_str())
                .collect_pixels(
                    |size, _| Canvas::new(size),
                    |canvas, at, (y,): (f32,)| canvas.set(at, [y; 3]),
                )
                .first_valid_layer()
                .all_attributes()
                .from_buffered(source)
                .map_err(incomplete)?
                .layer_data
                .channel_data
                .pixels
        }
    };
    Ok(Decoded { size, texels: canvas.texels, warnings: remarks(header) })
}

/// The first layer with R, G and B, else the first with Y alone; names may follow a layer's and a point.
fn choose(headers: &[exr::meta::header::Header]) -> Result<(usize, Channels), String> {
    let flat = || headers.iter().enumerate().filter(|(_, h)| !h.deep);
    let names = |h: &exr::meta::header::Header| -> Vec<String> {
        h.channels.list.iter().map(|c| c.name.to_string()).collect()
    };
    for (index, header) in flat() {
        let names = names(header);
        let prefixes = names.iter().filter_map(|n| n.strip_suffix('R'));
        for prefix in prefixes.filter(|p| p.is_empty() || p.ends_with('.')) {
            let wanted = ["R", "G", "B"].map(|c| format!("{prefix}{c}"));
            if wanted.iter().all(|w| names.contains(w)) {
                return Ok((index, Channels::Rgb(wanted)));
            }
        }
    }
    for (index, header) in flat() {
        let names = names(header);
        if names.iter().any(|n| n == "Y") && !names.iter().any(|n| n == "RY" || n == "BY") {
            return Ok((index, Channels::Luminance("Y".into())));
        }
    }
    let found: Vec<String> = headers.iter().flat_map(names).take(20).collect();
    let found = if found.is_empty() { "none".into() } else { found.join(", ") };
    Err(format!("an environment needs the channels R, G and B, or Y alone; found: {found}"))
}

fn remarks(header: &exr::meta::header::Header) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let window = header.shared_attributes.display_window.size;
    if header.layer_size != window {
        let (data, shown) = (header.layer_size, window);
        warnings.push(Warning::new(format!(
            "its data window is {} × {}, its display window {} × {}; the data window is taken for the whole sphere",
            data.0, data.1, shown.0, shown.1
        )));
    }
    // ITU-R BT.709, which sRGB shares.
    let srgb = [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)];
    if let Some(c) = header.shared_attributes.chromaticities {
        let given = [c.red, c.green, c.blue].map(|p| (p.0, p.1));
        let near = |(a, b): (&(f32, f32), &(f32, f32))| (a.0 - b.0).abs() < 2e-3 && (a.1 - b.1).abs() < 2e-3;
        if !given.iter().zip(&srgb).all(near) {
            warnings.push(Warning::new(
                "it declares primaries other than sRGB's; its values are taken for linear sRGB",
            ));
        }
    }
    warnings
}

fn picture(bytes: &[u8], format: ImageFormat) -> Result<([u32; 2], DynamicImage), String> {
    let incomplete = |e: image::ImageError| format!("not a complete image: {e}");
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(incomplete)?;
    let size = check_size(width as usize, height as usize, bytes.len())?;
    let mut reader = reader();
    reader.no_limits();
    Ok((size, reader.decode().map_err(incomplete)?))
}

fn hdr(bytes: &[u8]) -> Result<Decoded, String> {
    let (size, image) = picture(bytes, ImageFormat::Hdr)?;
    let texels = image.into_rgb32f().pixels().map(|p| p.0).collect();
    Ok(Decoded { size, texels, warnings: Vec::new() })
}

fn png(bytes: &[u8]) -> Result<Decoded, String> {
    let (size, image) = picture(bytes, ImageFormat::Png)?;
    let transparent = image.color().has_alpha();
    let linear = |v: f32| srgb_decode(f64::from(v)) as f32;
    let texels = image.into_rgb32f().pixels().map(|p| p.0.map(linear)).collect();
    let warnings = if transparent { vec![Warning::new("its alpha channel is ignored")] } else { Vec::new() };
    Ok(Decoded { size, texels, warnings })
}
