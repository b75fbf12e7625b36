//! Pictures of one scene by several backends: how far they are from the first, in figures and side by side. What
//! `scripts/three_ways.sh` ends with.
//!
//! ```text
//! three_ways OUTPUT.png MASK.exr EXPECTED.exr FOUND.exr...
//! ```
//!
//! All EXR files are what `gemtrace render --space xyz` writes, of one size; the mask is the scene before a transparent
//! background, and its alpha says where the stone is. The output has the pictures in a row at half their size, and
//! beneath each its difference from the first, [`GAIN`] times as bright.

use exr::prelude::read_first_rgba_layer_from_file;
use spectral_core::color::{RgbSpace, srgb_encode};
use std::fs::File;

/// How much brighter than the pictures their differences are shown.
const GAIN: f64 = 1000.0;
/// A pixel's relative difference beyond which it counts as off.
const TOLERANCE: f64 = 1e-3;
/// Black around the pictures, pixels of the output.
const GAP: usize = 4;

type Color = [f64; 3];

/// Colours row by row, and how much of each pixel is covered.
#[derive(Clone)]
struct Picture {
    width: usize,
    pixels: Vec<(Color, f64)>,
}

impl Picture {
    fn read(path: &str) -> Result<Self, String> {
        let image = read_first_rgba_layer_from_file(
            path,
            |size, _| Picture { width: size.width(), pixels: vec![([0.0; 3], 0.0); size.area()] },
            |picture: &mut Picture, at, (x, y, z, a): (f32, f32, f32, f32)| {
                picture.pixels[at.y() * picture.width + at.x()] = ([x, y, z].map(f64::from), f64::from(a));
            },
        );
        Ok(image.map_err(|e| format!("{path}: {e}"))?.layer_data.channel_data.pixels)
    }

    fn of_size(&self, other: &Picture, path: &str) -> Result<(), String> {
        let same = (self.width, self.pixels.len()) == (other.width, other.pixels.len());
        if same { Ok(()) } else { Err(format!("{path} is of another size than the first")) }
    }

    /// The absolute difference from another, component by component.
    fn apart(&self, other: &Picture) -> Picture {
        let pairs = self.pixels.iter().zip(&other.pixels);
        let pixels = pairs.map(|((a, _), (b, _))| ([0, 1, 2].map(|c| (a[c] - b[c]).abs()), 1.0));
        Picture { width: self.width, pixels: pixels.collect() }
    }

    /// XYZ as linear sRGB.
    fn to_srgb(&self) -> Picture {
        let matrix = RgbSpace::Srgb.from_xyz();
        let convert = |v: Color| matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
        Picture { width: self.width, pixels: self.pixels.iter().map(|(v, a)| (convert(*v), *a)).collect() }
    }

    /// Half as wide and high: each pixel the mean of four.
    fn halved(&self) -> Picture {
        let (width, height) = (self.width / 2, self.pixels.len() / self.width / 2);
        let at = |x: usize, y: usize| self.pixels[y * self.width + x].0;
        let mean = |x: usize, y: usize| {
            let four = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
            ([0, 1, 2].map(|c| four.iter().map(|v| v[c]).sum::<f64>() / 4.0), 1.0)
        };
        let pixels = (0..width * height).map(|k| mean(2 * (k % width), 2 * (k / width)));
        Picture { width, pixels: pixels.collect() }
    }
}

/// What `found` is off by where the mask shows the stone: the differences of colours (XYZ) relative to the expected
/// ones, and that of the mean colours.
fn figures(mask: &Picture, expected: &Picture, found: &Picture) -> String {
    let pairs = expected.pixels.iter().zip(&found.pixels).zip(&mask.pixels);
    let pairs: Vec<(Color, Color)> =
        pairs.filter(|(_, (_, cover))| *cover > 0.0).map(|((e, f), _)| (e.0, f.0)).collect();
    let size = |v: Color| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let apart = |e: Color, f: Color| size([0, 1, 2].map(|c| f[c] - e[c])) / size(e).max(1e-6);
    let mut errors: Vec<f64> = pairs.iter().map(|(e, f)| apart(*e, *f)).collect();
    errors.sort_by(f64::total_cmp);
    let [e, f] = pairs.iter().fold([[0.0; 3]; 2], |[e, f], pair| {
        [[0, 1, 2].map(|c| e[c] + pair.0[c]), [0, 1, 2].map(|c| f[c] + pair.1[c])]
    });
    let off = errors.iter().filter(|error| **error > TOLERANCE).count() as f64 / errors.len() as f64;
    format!(
        "{} pixels, median {:.1e}, {:.3} % off by more than {TOLERANCE:.0e}, mean {:.1e}, worst {:.1e}",
        errors.len(),
        errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN),
        100.0 * off,
        apart(e, f),
        errors.last().copied().unwrap_or(f64::NAN),
    )
}

/// The pictures in linear sRGB above their differences, as 8-bit sRGB.
fn sheet(path: &str, pictures: &[Picture]) -> Result<(), String> {
    let first = &pictures[0];
    let (width, height) = (first.width, first.pixels.len() / first.width);
    let size = [GAP + pictures.len() * (width + GAP), GAP + 2 * (height + GAP)];
    let mut bytes = vec![0; 3 * size[0] * size[1]];
    for (column, picture) in pictures.iter().enumerate() {
        for (row, (shown, gain)) in [(picture, 1.0), (&picture.apart(first), GAIN)].into_iter().enumerate() {
            for (k, (color, _)) in shown.pixels.iter().enumerate() {
                let x = GAP + column * (width + GAP) + k % width;
                let y = GAP + row * (height + GAP) + k / width;
                let encoded = color.map(|c| (255.0 * srgb_encode((c * gain).clamp(0.0, 1.0))).round() as u8);
                bytes[3 * (y * size[0] + x)..][..3].copy_from_slice(&encoded);
            }
        }
    }
    let file = File::create(path).map_err(|e| format!("{path}: {e}"))?;
    let mut encoder = png::Encoder::new(file, size[0] as u32, size[1] as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(&bytes).map_err(|e| e.to_string())
}

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [output, mask, expected, found @ ..] = arguments.as_slice() else {
        return Err("give an output, the mask, and the pictures to compare".to_owned());
    };
    let (mask, expected) = (Picture::read(mask)?, Picture::read(expected)?);
    mask.of_size(&expected, &arguments[1])?;
    let mut pictures = vec![expected];
    for path in found {
        let picture = Picture::read(path)?;
        picture.of_size(&pictures[0], path)?;
        println!("{path}: {}", figures(&mask, &pictures[0], &picture));
        pictures.push(picture);
    }
    let shown: Vec<Picture> = pictures.iter().map(|picture| picture.to_srgb().halved()).collect();
    sheet(output, &shown)
}
