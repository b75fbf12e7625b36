//! Pictures decoded by other crates, with the memory that they take bounded by the picture before it is taken.

use super::{gibibytes, guarded};
use exr::compression::Compression;
use exr::meta::{BlockDescription, MetaData, header::Header};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// What a PNG may carry beside its pixels, bytes: colour profiles and texts, decompressed.
const EXTRAS: u64 = 16 << 20;
/// The most bytes that deflate makes of one (RFC 1951: 258 bytes of two bits).
const MOST_PER_BYTE: u128 = 1032;

/// Width and height of a PNG, which its first chunk says. (PNG 3, 11.2.1.)
pub(crate) fn png_size(bytes: &[u8]) -> Result<[u32; 2], String> {
    let figure = |at: usize| bytes.get(at..)?.first_chunk().map(|b| u32::from_be_bytes(*b));
    match (bytes.get(12..16), figure(16), figure(20)) {
        (Some(b"IHDR"), Some(width), Some(height)) => Ok([width, height]),
        _ => Err("not a complete image: it does not begin with its size".into()),
    }
}

/// A PNG of any kind. Profiles and texts may take no more memory than the pixels and a little more.
pub(crate) fn png(bytes: &[u8]) -> Result<DynamicImage, String> {
    check_palette(bytes)?;
    let [width, height] = png_size(bytes)?;
    // From a single bit up to four numbers of two bytes.
    let pixels = u128::from(width) * u128::from(height);
    let need = pixels * 8;
    if pixels > 8 * MOST_PER_BYTE * bytes.len() as u128 {
        return Err(too_large([width, height].map(u128::from), need, bytes.len()));
    }
    guarded(|| {
        let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(u64::try_from(need).map_or(u64::MAX, |need| need.saturating_add(EXTRAS)));
        reader.limits(limits);
        reader.decode().map_err(incomplete)
    })
}

fn too_large([width, height]: [u128; 2], need: u128, bytes: usize) -> String {
    let need = gibibytes(need);
    format!(
        "{width} × {height} pixels ({need}) are more than {bytes} bytes can hold; the file is damaged or truncated"
    )
}

/// Another crate's complaint about a picture.
pub(crate) fn incomplete(error: image::ImageError) -> String {
    format!("not a complete image: {error}")
}

/// `png` 0.18 panics where a palette is not of whole colours, three bytes each. (PNG 3, 5.3: a chunk is its length, its
/// type, its data and a check sum.)
fn check_palette(bytes: &[u8]) -> Result<(), String> {
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let Some((head, after)) = rest.split_first_chunk::<8>() {
        let [a, b, c, d, kind @ ..] = *head;
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        match &kind {
            b"PLTE" if !length.is_multiple_of(3) || length > 768 => {
                return Err(format!(
                    "its palette has {length} bytes, where up to 256 colours of 3 are expected"
                ));
            }
            b"IDAT" => break,
            _ => rest = after.get(length.saturating_add(4)..).unwrap_or_default(),
        }
    }
    Ok(())
}

/// The header of an OpenEXR as this program writes them: one flat layer in scan lines, compressed by deflate. Anything
/// else is no file of ours, and a file that is too short for its size is none that is whole.
pub(crate) fn own_exr(bytes: &[u8]) -> Result<Header, String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    let header = match meta.headers.as_slice() {
        [header] => header.clone(),
        headers => return Err(format!("it has {} layers, where one is expected", headers.len())),
    };
    let deflated = matches!(header.compression, Compression::ZIP16 | Compression::ZIP1);
    if header.deep || !deflated || header.blocks != BlockDescription::ScanLines {
        return Err("it is not in scan lines that are compressed by ZIP, as this program writes them".into());
    }
    let (width, height) = (header.layer_size.0 as u128, header.layer_size.1 as u128);
    let need = width.saturating_mul(height).saturating_mul(header.channels.bytes_per_pixel as u128);
    if need > MOST_PER_BYTE * bytes.len() as u128 {
        return Err(too_large([width, height], need, bytes.len()));
    }
    Ok(header)
}
