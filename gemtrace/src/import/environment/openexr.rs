//! OpenEXR, through the crate `exr`.

use super::{Decoded, check_size, chromaticity};
use exr::block::chunk::CompressedBlock;
use exr::compression::Compression;
use exr::meta::attribute::{Chromaticities, EnvironmentMap};
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, Vec2, read as read_exr};
use spectral_core::{Warning, shown};
use std::io::Cursor;

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

/// The colours of the first layer that has them, or what is wrong with the file.
pub(super) fn read(bytes: &[u8]) -> Result<Decoded, String> {
    let incomplete = |e: exr::error::Error| format!("not a complete OpenEXR file: {e}");
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(incomplete)?;
    if meta.headers.iter().all(|header| header.deep) {
        return Err("it holds deep data (its type is 'deepscanline' or 'deeptile'), which is not read: give an image \
                    with one value a pixel"
            .to_owned());
    }
    let (layer, channels) = choose(&meta.headers)?;
    let header = &meta.headers[layer];
    if header.own_attributes.environment_map == Some(EnvironmentMap::Cube) {
        return Err(
            "it is a cube map (its attribute 'envmap' says so), which is not read: give a lat-long image"
                .to_owned(),
        );
    }
    let size = check_size(header.layer_size.0, header.layer_size.1, bytes.len())?;
    check_chunks(bytes, &meta.headers).map_err(incomplete)?;
    let source = Cursor::new(bytes);
    let level = || read_exr().no_deep_data().largest_resolution_level().specific_channels();
    let is_rgb = matches!(channels, Channels::Rgb(_));
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
                .non_parallel()
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
                .non_parallel()
                .from_buffered(source)
                .map_err(incomplete)?
                .layer_data
                .channel_data
                .pixels
        }
    };
    let (mut texels, mut warnings) = (canvas.texels, remarks(header));
    let declared = header.shared_attributes.chromaticities.filter(|_| is_rgb);
    if let Some(Chromaticities { red, green, blue, white }) = declared {
        let given = [red, green, blue, white].map(|Vec2(x, y)| [x, y].map(f64::from));
        if let Err(fault) = chromaticity::convert(&mut texels, &given) {
            warnings.push(Warning::new(format!("{fault}; its values are taken for linear sRGB")));
        }
    }
    Ok(Decoded { size, texels, warnings })
}

/// The first layer with R, G and B, else the first with Y alone; names may follow a layer's and a point.
fn choose(headers: &[Header]) -> Result<(usize, Channels), String> {
    let flat = || headers.iter().enumerate().filter(|(_, h)| !h.deep);
    let names = |h: &Header| -> Vec<String> { h.channels.list.iter().map(|c| c.name.to_string()).collect() };
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
    let found: Vec<String> = headers.iter().flat_map(names).take(20).map(|name| shown(&name)).collect();
    let found = if found.is_empty() { "none".into() } else { found.join(", ") };
    Err(format!("an environment needs the channels R, G and B, or Y alone; found: {found}"))
}

fn remarks(header: &Header) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let window = header.shared_attributes.display_window.size;
    if header.layer_size != window {
        let (data, shown) = (header.layer_size, window);
        warnings.push(Warning::new(format!(
            "its data window is {} × {}, its display window {} × {}; the data window is taken for the whole sphere",
            data.0, data.1, shown.0, shown.1
        )));
    }
    warnings
}

/// `exr` takes the sizes at the head of a DWA chunk on trust and reserves that much memory, which ends the process where
/// a damaged file asks for terabytes. They are held against the block's size first. (OpenEXR, `DataSizesSingle` in
/// internal_dwa_compressor.h: eleven little-endian u64.)
fn check_chunks(bytes: &[u8], headers: &[Header]) -> exr::error::UnitResult {
    let dwa = |h: &Header| matches!(h.compression, Compression::DWAA(_) | Compression::DWAB(_));
    if !headers.iter().any(dwa) {
        return Ok(());
    }
    for chunk in exr::block::read(Cursor::new(bytes), false)?.all_chunks(false)? {
        let chunk = chunk?;
        let Some(header) = headers.get(chunk.layer_index).filter(|h| dwa(h)) else { continue };
        let pixels = match &chunk.compressed_block {
            CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
            CompressedBlock::Tile(block) => &block.compressed_pixels_le,
            _ => continue,
        };
        let block = header.get_block_data_indices(&chunk.compressed_block)?;
        let size = header.get_absolute_block_pixel_coordinates(block)?.size;
        let (width, height) = (size.0 as u128, size.1 as u128);
        if pixels.len() as u128 == width * height * header.channels.bytes_per_pixel as u128 {
            // Stored as it is, because compression did not pay.
            continue;
        }
        // Whole blocks of 8 × 8, twice the bytes of the widest sample: run lengths may double what they fail to pack.
        let most = (width + 8) * (height + 8) * header.channels.list.len() as u128 * 8;
        let counters =
            pixels.chunks_exact(8).take(10).filter_map(|c| c.try_into().ok()).map(u64::from_le_bytes);
        if counters.skip(1).any(|counter| u128::from(counter) > most) {
            return Err(exr::error::Error::Invalid("DWA section size".into()));
        }
    }
    Ok(())
}
