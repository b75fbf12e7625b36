//! How far a backend's picture is from the oracle's, and what is left of it when it is too far.

use crate::gallery::{Exhibit, MEAN, MEDIAN};
use exr::prelude::write_rgb_file;
use spectral_core::{
    color::RgbSpace,
    film::{self, Film},
};
use std::fmt;
use std::path::{Path, PathBuf};

/// How a picture of an exhibit compares with the oracle's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// The differences.
    pub found: film::Agreement,
    /// The share of pixels that may be off.
    pub allowed: f64,
}

impl Agreement {
    /// Compares two pictures of an exhibit. Pictures without a stone do not agree.
    ///
    /// # Panics
    /// If they are not of one size.
    pub fn of(exhibit: &Exhibit, expected: &Film, found: &Film) -> Self {
        let found = film::Agreement::of(expected, found).expect("two pictures of one exhibit");
        Agreement { found, allowed: exhibit.outliers }
    }

    /// Whether all bounds hold.
    pub fn holds(&self) -> bool {
        let found = &self.found;
        found.median <= MEDIAN && found.off <= self.allowed && found.mean <= MEAN
    }

    /// Leaves both pictures and their difference under `target/agreement/`: three EXR images, a PNG image with the
    /// three side by side (the difference tenfold), and the figures as JSON. Returns the folder.
    ///
    /// # Errors
    /// Whatever keeps the files from being written, in words.
    pub fn keep(&self, trial: &str, expected: &Film, found: &Film) -> Result<PathBuf, String> {
        let name: String = trial.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/agreement").join(name);
        std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        let [a, b] = [expected, found].map(|film| film.to_space(RgbSpace::Srgb));
        let apart: Vec<[f32; 4]> =
            a.iter().zip(&b).map(|(a, b)| [0, 1, 2, 3].map(|c| (a[c] - b[c]).abs())).collect();
        let (width, height) = (expected.width() as usize, expected.height() as usize);
        for (name, pixels) in [("expected", &a), ("actual", &b), ("difference", &apart)] {
            let at = |x: usize, y: usize| pixels[y * width + x];
            let colour = |x, y| (at(x, y)[0], at(x, y)[1], at(x, y)[2]);
            write_rgb_file(folder.join(name).with_extension("exr"), width, height, colour)
                .map_err(|e| e.to_string())?;
        }
        let strip = [(&a, 1.0), (&b, 1.0), (&apart, 10.0)];
        let bytes: Vec<u8> = (0..height)
            .flat_map(|y| {
                strip.iter().flat_map(move |(pixels, gain)| row(&pixels[y * width..][..width], *gain))
            })
            .collect();
        let size = [3 * expected.width(), expected.height()];
        write_png(&folder.join("expected-actual-difference.png"), size, &bytes)?;
        std::fs::write(folder.join("figures.json"), self.json(trial)).map_err(|e| e.to_string())?;
        Ok(folder)
    }

    fn json(&self, trial: &str) -> String {
        let allowed = self.allowed;
        let film::Agreement { pixels, median, off, mean, worst } = self.found;
        let value = serde_json::json!({
            "trial": trial, "pixels": pixels, "median": median, "off": off, "mean": mean, "worst": worst,
            "allowed": { "median": MEDIAN, "off": allowed, "mean": MEAN },
        });
        format!("{value:#}\n")
    }
}

/// Worst and allowed, figure by figure.
impl fmt::Display for Agreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let film::Agreement { pixels, median, mean, worst, off } = self.found;
        let [off, allowed] = [off, self.allowed].map(|share| 100.0 * share);
        let tolerance = film::Agreement::TOLERANCE;
        write!(
            f,
            "{pixels} pixels, median {median:.1e}/{MEDIAN:.0e}, {off:.2}/{allowed:.2} % off by {tolerance:.0e}, \
             mean {mean:.1e}/{MEAN:.0e}, worst {worst:.1e}"
        )
    }
}

/// Pixels as 8-bit sRGB.
fn row(pixels: &[[f32; 4]], gain: f32) -> Vec<u8> {
    let encode = |c: f32| {
        let c = (c * gain).clamp(0.0, 1.0);
        let curve = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (255.0 * curve).round() as u8
    };
    pixels.iter().flat_map(|p| [encode(p[0]), encode(p[1]), encode(p[2])]).collect()
}

fn write_png(path: &Path, [width, height]: [u32; 2], bytes: &[u8]) -> Result<(), String> {
    let file = std::fs::File::create(path).map_err(|e| e.to_string())?;
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(bytes).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gallery::gallery;
    use spectral_core::{film::PixelSample, film::Tile, film::TileSums, prepare::PreparedScene};

    fn grey(exhibit: &Exhibit, value: f32) -> Film {
        let scene = PreparedScene::new(&exhibit.scene, &exhibit.settings).expect("a valid scene");
        let mut film = Film::new(&scene);
        let tile = Tile { x: 0, y: 0, width: film.width(), height: film.height() };
        let sample = PixelSample { xyz: [value; 3], coverage: 1.0 };
        let samples = vec![sample; tile.width as usize * tile.height as usize];
        film.add(&TileSums { tile, samples, radiance: vec![] }).expect("a tile of the film");
        film
    }

    #[test]
    fn a_picture_agrees_with_itself_alone_and_leaves_its_artefacts() {
        let exhibit = &gallery()[0];
        let (one, other) = (grey(exhibit, 0.5), grey(exhibit, 0.502));
        assert!(Agreement::of(exhibit, &one, &one).holds());
        let apart = Agreement::of(exhibit, &one, &other);
        assert!(
            !apart.holds() && (apart.found.median - 4e-3).abs() < 1e-6 && apart.found.off == 1.0,
            "{apart}"
        );
        let folder = apart.keep("[self-test] artefacts", &one, &other).expect("a folder to write to");
        for name in
            ["expected.exr", "actual.exr", "difference.exr", "expected-actual-difference.png", "figures.json"]
        {
            assert!(folder.join(name).is_file(), "{name}");
        }
        std::fs::remove_dir_all(folder).expect("what was written can be removed");
    }
}
