//! A picture, small, inside a page.

use crate::batch::manifest::{Done, FileRecord};
use crate::import::{self, picture};
use crate::output::{self, Format};
use exr::prelude::{ReadChannels, ReadLayers, read};
use image::{Rgba, RgbaImage, imageops};
use spectral_core::color::{RgbSpace, Tone, ViewTransform, srgb_encode};
use std::io::Cursor;
use std::path::Path;

/// The longest edge, pixels; smaller pictures stay as they are.
const EDGE: u32 = 256;

/// An item's picture as a `data:` address: its PNG if it has one, else its EXR in the usual tone.
///
/// # Errors
/// Why there is none, for people.
pub fn of(folder: &Path, done: &Done) -> Result<String, String> {
    let file = |format: Format| {
        let extension = format!(".{}", format.extension());
        done.outputs.iter().find(|file| file.path.ends_with(&extension))
    };
    let picture = match (file(Format::Png), file(Format::Exr)) {
        (Some(png), _) => read_png(&folder.join(&png.path)).map_err(|e| complaint(png, &e))?,
        (None, Some(exr)) => read_exr(&folder.join(&exr.path)).map_err(|e| complaint(exr, &e))?,
        (None, None) => return Err("no picture".to_owned()),
    };
    let (width, height) = picture.dimensions();
    let longest = width.max(height);
    let small = if longest > EDGE {
        let edge = |pixels: u32| (u64::from(pixels) * u64::from(EDGE) / u64::from(longest)).max(1) as u32;
        imageops::thumbnail(&picture, edge(width), edge(height))
    } else {
        picture
    };
    let pixels: Vec<[u8; 4]> = small.pixels().map(|pixel| pixel.0).collect();
    output::data_url(small.width(), &pixels)
}

fn complaint(file: &FileRecord, error: &str) -> String {
    format!("{} cannot be shown: {error}", file.path)
}

fn read_png(path: &Path) -> Result<RgbaImage, String> {
    let bytes = import::read_file(path).map_err(|e| e.to_string())?;
    Ok(picture::png(&bytes)?.into_rgba8())
}

/// Linear premultiplied floats, shown as the PNG of the same picture would be.
fn read_exr(path: &Path) -> Result<RgbaImage, String> {
    let view = std::sync::Arc::new(ViewTransform::new(Tone::default(), RgbSpace::Srgb));
    let create = |size: exr::math::Vec2<usize>, _: &_| RgbaImage::new(size.0 as u32, size.1 as u32);
    let set =
        move |picture: &mut RgbaImage, at: exr::math::Vec2<usize>, (r, g, b, a): (f32, f32, f32, f32)| {
            let straight = |c: f32| if a > 0.0 { f64::from(c / a) } else { 0.0 };
            let encode = |c: f64| (255.0 * srgb_encode(c.clamp(0.0, 1.0))).round() as u8;
            let [r, g, b] = view.shown([r, g, b].map(straight)).map(encode);
            let alpha = (255.0 * a.clamp(0.0, 1.0)).round() as u8;
            picture.put_pixel(at.0 as u32, at.1 as u32, Rgba([r, g, b, alpha]));
        };
    let bytes = import::read_file(path).map_err(|e| e.to_string())?;
    import::guarded(|| {
        picture::own_exr(&bytes)?;
        let layer = read().no_deep_data().largest_resolution_level().rgba_channels(create, set);
        let reader = layer.first_valid_layer().all_attributes().non_parallel();
        let image = reader.from_buffered(Cursor::new(&bytes)).map_err(|e| e.to_string())?;
        Ok(image.layer_data.channel_data.pixels)
    })
}
