//! Environment images: OpenEXR, Radiance HDR, PNG and JPEG, known by their first bytes.

mod chromaticity;
mod openexr;
mod radiance;

use super::picture::{self, incomplete};
use super::{about, blame, gibibytes, guarded};
use crate::Error;
use image::codecs::jpeg::JpegDecoder;
use image::{DynamicImage, ImageDecoder, RgbImage};
use moxcms::{ColorProfile, Layout, TransformOptions};
use spectral_core::color::srgb_decode;
use spectral_core::environment::LatLong;
use spectral_core::{Warning, memory};
use std::io::Cursor;
use std::path::Path;

/// Images that need more than this are held against their file's size.
const LARGE_BYTES: u128 = 64 << 20;
/// More texels a byte than any photograph compresses to, whatever the method.
const MAX_TEXELS_PER_BYTE: u64 = 4096;
/// Rows of a PNG that are turned into texels at a time.
const BAND: u32 = 64;

/// A lat-long image from the bytes of the file `path`, as linear sRGB. Primaries and exposure that an EXR or HDR declares are
/// converted; values of PNG and JPEG are decoded by the sRGB curve; alpha is ignored.
///
/// # Errors
/// [`Error::File`] for a format that is not known, a file that is not complete, EXR channels that are
/// neither R, G, B nor Y (naming those found), and sizes beyond [`LatLong::MAX_TEXELS`].
pub fn read(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(LatLong, Vec<Warning>), Error> {
    let bytes = bytes.as_ref();
    let decoded = if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        guarded(|| openexr::read(bytes))
    } else if bytes.starts_with(b"\x89PNG") {
        png(bytes)
    } else if bytes.starts_with(b"#?") {
        guarded(|| radiance::read(bytes))
    } else if bytes.starts_with(&[0xff, 0xd8, 0xff]) {
        guarded(|| jpeg(bytes))
    } else if bytes.is_empty() {
        Err("the file is empty".into())
    } else {
        Err("not an OpenEXR, Radiance HDR, PNG or JPEG image".into())
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

/// JPEG, whose values are decoded by the sRGB curve; a colour profile is converted to sRGB first.
fn jpeg(bytes: &[u8]) -> Result<Decoded, String> {
    let mut decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(incomplete)?;
    let (width, height) = decoder.dimensions();
    let size = check_size(width as usize, height as usize, bytes.len())?;
    memory::check(u64::from(width) * u64::from(height) * 24, || "the image".into())
        .map_err(|e| e.to_string())?;
    let profile = decoder.icc_profile().ok().flatten();
    let mut image = DynamicImage::from_decoder(decoder).map_err(incomplete)?.into_rgb8();
    let dim = "a JPEG holds no light brighter than white: lamps and windows light less than they did; HDR and EXR hold them";
    let mut warnings = vec![Warning::new(dim)];
    if let Some(profile) = profile
        && !managed(&mut image, &profile)
    {
        warnings.push(Warning::new("its colour profile cannot be used; its values are taken for sRGB"));
    }
    let decoded: Vec<f32> = (0..=255).map(|v| srgb_decode(f64::from(v) / 255.0) as f32).collect();
    let texels = image.pixels().map(|p| p.0.map(|v| decoded[usize::from(v)])).collect();
    Ok(Decoded { size, texels, warnings })
}

/// Converts a picture from its profile to sRGB; whether that can be done.
fn managed(image: &mut RgbImage, profile: &[u8]) -> bool {
    let convert = || {
        let profile = ColorProfile::new_from_slice(profile).ok()?;
        let to = ColorProfile::new_srgb();
        let how =
            profile.create_transform_8bit(Layout::Rgb, &to, Layout::Rgb, TransformOptions::default()).ok()?;
        let mut converted = vec![0; image.as_raw().len()];
        how.transform(image.as_raw(), &mut converted).ok()?;
        RgbImage::from_raw(image.width(), image.height(), converted)
    };
    convert().map(|converted| *image = converted).is_some()
}

fn png(bytes: &[u8]) -> Result<Decoded, String> {
    let [width, height] = picture::png_size(bytes)?;
    let size = check_size(width as usize, height as usize, bytes.len())?;
    let image = picture::png(bytes)?;
    let transparent = image.color().has_alpha();
    let linear = |v: f32| srgb_decode(f64::from(v)) as f32;
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    // In bands: the whole picture as numbers would be there twice.
    for top in (0..height).step_by(BAND as usize) {
        let band = image.crop_imm(0, top, width, BAND.min(height - top)).into_rgb32f();
        texels.extend(band.pixels().map(|p| p.0.map(linear)));
    }
    let warnings = if transparent { vec![Warning::new("its alpha channel is ignored")] } else { Vec::new() };
    Ok(Decoded { size, texels, warnings })
}
