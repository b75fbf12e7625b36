//! Environment images: OpenEXR, Radiance HDR and PNG, known by their first bytes.

mod openexr;

use super::picture::{self, incomplete};
use super::{about, blame, gibibytes, guarded};
use crate::Error;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;
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

/// A lat-long image from the bytes of the file `path`, as linear sRGB. PNG values are decoded by the sRGB
/// curve; alpha is ignored.
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
        guarded(|| hdr(bytes))
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

/// Decoded into the texels themselves.
fn hdr(bytes: &[u8]) -> Result<Decoded, String> {
    let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(incomplete)?;
    let (width, height) = decoder.dimensions();
    let size = check_size(width as usize, height as usize, bytes.len())?;
    memory::check(u64::from(width) * u64::from(height) * 12, || "the image".into())
        .map_err(|e| e.to_string())?;
    let mut texels = vec![[0.0_f32; 3]; width as usize * height as usize];
    decoder.read_image(bytemuck::cast_slice_mut(&mut texels)).map_err(incomplete)?;
    Ok(Decoded { size, texels, warnings: Vec::new() })
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
