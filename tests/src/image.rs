//! Files of pictures.

use exr::prelude::{ReadChannels, ReadLayers};
use spectral_core::color::srgb_encode;
use std::{collections::HashMap, fs::File, path::Path};

/// A linear component times `gain` as 8-bit sRGB.
pub fn srgb8(linear: f64, gain: f64) -> u8 {
    (255.0 * srgb_encode((linear * gain).clamp(0.0, 1.0))).round() as u8
}

/// Writes 8-bit sRGB, three bytes a pixel.
///
/// # Errors
/// Whatever keeps the file from being written.
pub fn write_png(path: &Path, [width, height]: [usize; 2], bytes: &[u8]) -> Result<(), String> {
    let file = File::create(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut encoder = png::Encoder::new(file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(bytes).map_err(|e| e.to_string())
}

/// The width of an EXR image and its channels by name, row by row.
///
/// # Panics
/// If the file is not there or is no EXR image.
pub fn read_channels(path: &Path) -> (usize, HashMap<String, Vec<f64>>) {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    // The reader takes the part of a name before its last point for a layer.
    let layer = image.layer_data.attributes.layer_name.map(|name| format!("{name}.")).unwrap_or_default();
    let channels = image.layer_data.channel_data.list.into_iter();
    let values = channels
        .map(|c| (format!("{layer}{}", c.name), c.sample_data.values_as_f32().map(f64::from).collect()))
        .collect();
    (image.layer_data.size.width(), values)
}
