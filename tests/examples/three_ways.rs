//! Compares the pictures of one scene by several backends with the first: figures and a picture of all of them. The last
//! step of `scripts/three_ways.sh`.
//!
//! ```text
//! three_ways OUTPUT.png MASK.exr EXPECTED.exr FOUND.exr...
//! ```
//!
//! All EXR files are written by `gemtrace render --space xyz`, in one size. The mask is the scene before a transparent
//! background; its alpha is the coverage of the stone. The output shows the pictures in a row at half their size, and
//! below each its difference from the first, [`GAIN`] times as bright.

use gemtrace_tests::image::{read_channels, srgb8, write_png};
use gemtrace_tests::render::pixels;
use spectral_core::film::{Agreement, Film, PixelSums};
use spectral_core::{Error, color::RgbSpace};

/// How much brighter than the pictures their differences are shown.
const GAIN: f64 = 1000.0;
/// Black around the pictures, pixels of the output.
const GAP: usize = 4;

/// The picture of a file, with the coverage of `mask`.
fn read(path: &str, mask: Option<&Film>) -> Result<Film, Error> {
    let (width, channels) = read_channels(path.as_ref());
    let [x, y, z, alpha] = ["R", "G", "B", "A"].map(|name| &channels[name]);
    let mut film = Film::with_size(width as u32, (x.len() / width) as u32, 0)?;
    let same_size = mask.is_none_or(|mask| mask.tile() == film.tile());
    for (k, (column, row)) in pixels(&film).enumerate() {
        let xyz = [x[k], y[k], z[k]].map(|v| v as f32);
        let coverage = mask.filter(|_| same_size).map_or(alpha[k] as f32, |mask| mask.coverage(column, row));
        film.set_sums(column, row, PixelSums { xyz, coverage, samples: 1 }, &[])?;
    }
    Ok(film)
}

/// A picture in linear sRGB at half its width and height: each pixel is the mean of four.
fn halved(film: &Film) -> Vec<[f64; 3]> {
    let (pixels, width) = (film.to_space(RgbSpace::Srgb), film.width() as usize);
    let mean = |k: usize| {
        let first = 2 * (k / (width / 2)) * width + 2 * (k % (width / 2));
        let four = [first, first + 1, first + width, first + width + 1].map(|i| pixels[i]);
        [0, 1, 2].map(|c| four.iter().map(|pixel| f64::from(pixel[c])).sum::<f64>() / 4.0)
    };
    (0..(width / 2) * (film.height() as usize / 2)).map(mean).collect()
}

/// Writes the pictures above their differences from the first.
fn write(path: &str, width: usize, pictures: &[Vec<[f64; 3]>]) -> Result<(), String> {
    let first = &pictures[0];
    let size = [GAP + pictures.len() * (width + GAP), GAP + 2 * (first.len() / width + GAP)];
    let mut bytes = vec![0; 3 * size[0] * size[1]];
    for (column, picture) in pictures.iter().enumerate() {
        for (k, (color, expected)) in picture.iter().zip(first).enumerate() {
            let difference = [0, 1, 2].map(|c| (color[c] - expected[c]).abs());
            for (row, shown, gain) in [(0, *color, 1.0), (1, difference, GAIN)] {
                let x = GAP + column * (width + GAP) + k % width;
                let y = GAP + row * (first.len() / width + GAP) + k / width;
                let encoded = shown.map(|c| srgb8(c, gain));
                bytes[3 * (y * size[0] + x)..][..3].copy_from_slice(&encoded);
            }
        }
    }
    write_png(path.as_ref(), size, &bytes)
}

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [output, mask, files @ ..] = arguments.as_slice() else {
        return Err("give an output, the mask, and the pictures to compare".to_owned());
    };
    let mask = read(mask, None).map_err(|e| e.to_string())?;
    let films = files.iter().map(|path| read(path, Some(&mask))).collect::<Result<Vec<_>, _>>();
    let films = films.map_err(|e| e.to_string())?;
    let [expected, found @ ..] = films.as_slice() else { return Err("give pictures to compare".to_owned()) };
    for (film, path) in found.iter().zip(&files[1..]) {
        let Agreement { pixels, median, off, mean, worst } =
            Agreement::of(expected, film).map_err(|e| format!("{path}: {e}"))?;
        println!(
            "{path}: {pixels} pixels, median {median:.1e}, {:.3} % off by more than {:.0e}, mean {mean:.1e}, \
             worst {worst:.1e}",
            100.0 * off,
            Agreement::TOLERANCE
        );
    }
    write(output, expected.width() as usize / 2, &films.iter().map(halved).collect::<Vec<_>>())
}
