//! The comparison of a backend's picture with the reference picture, and its files if the two differ too much.

use crate::cases::{Case, MEAN, MEDIAN};
use crate::image::{srgb8, write_png};
use exr::prelude::write_rgb_file;
use spectral_core::{
    color::RgbSpace,
    film::{self, Film},
};
use std::fmt;
use std::path::{Path, PathBuf};

/// How a picture of a case compares with the reference picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// The differences.
    pub found: film::Agreement,
    /// The allowed share of outliers.
    pub allowed: f64,
}

impl Comparison {
    /// Compares two pictures of a case. Pictures without a stone do not agree.
    ///
    /// # Panics
    /// If they differ in size.
    pub fn of(case: &Case, expected: &Film, found: &Film) -> Self {
        let found = film::Agreement::of(expected, found).expect("two pictures of one case");
        Comparison { found, allowed: case.outliers }
    }

    /// Whether all bounds hold.
    pub fn holds(&self) -> bool {
        let found = &self.found;
        found.median <= MEDIAN && found.off <= self.allowed && found.mean <= MEAN
    }

    /// Writes both pictures and their difference to a folder under `target/agreement/`: three EXR images, a PNG image
    /// with the three side by side (the difference times ten), and the figures as JSON. Returns the folder.
    ///
    /// # Errors
    /// Whatever keeps the files from being written.
    pub fn keep(&self, trial: &str, expected: &Film, found: &Film) -> Result<PathBuf, String> {
        let name: String = trial.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/agreement").join(name);
        std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        let [a, b] = [expected, found].map(|film| film.to_space(RgbSpace::Srgb));
        let difference: Vec<[f32; 4]> =
            a.iter().zip(&b).map(|(a, b)| [0, 1, 2, 3].map(|c| (a[c] - b[c]).abs())).collect();
        let (width, height) = (expected.width() as usize, expected.height() as usize);
        let mut strip = vec![0; 9 * width * height];
        for (column, (name, pixels, gain)) in
            [("expected", &a, 1.0), ("actual", &b, 1.0), ("difference", &difference, 10.0)]
                .into_iter()
                .enumerate()
        {
            let at = |x: usize, y: usize| pixels[y * width + x];
            let colour = |x, y| (at(x, y)[0], at(x, y)[1], at(x, y)[2]);
            write_rgb_file(folder.join(name).with_extension("exr"), width, height, colour)
                .map_err(|e| e.to_string())?;
            for (k, pixel) in pixels.iter().enumerate() {
                let place = (k / width * 3 + column) * width + k % width;
                (0..3).for_each(|c| strip[3 * place + c] = srgb8(f64::from(pixel[c]), gain));
            }
        }
        write_png(&folder.join("expected-actual-difference.png"), [3 * width, height], &strip)?;
        std::fs::write(folder.join("figures.json"), self.json(trial)).map_err(|e| e.to_string())?;
        Ok(folder)
    }

    fn json(&self, trial: &str) -> String {
        let film::Agreement { pixels, median, off, mean, worst } = self.found;
        let value = serde_json::json!({
            "trial": trial, "pixels": pixels, "median": median, "off": off, "mean": mean, "worst": worst,
            "allowed": { "median": MEDIAN, "off": self.allowed, "mean": MEAN },
        });
        format!("{value:#}\n")
    }
}

/// Every figure with its bound.
impl fmt::Display for Comparison {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{cases::cases, render::prepared};
    use spectral_core::film::{PixelSample, TileSums};

    fn grey(case: &Case, value: f32) -> Film {
        let mut film = Film::new(&prepared(&case.scene, &case.settings));
        let sample = PixelSample { xyz: [value; 3], coverage: 1.0 };
        let samples = vec![sample; (film.width() * film.height()) as usize];
        film.add(&TileSums { tile: film.tile(), samples, radiance: vec![] }).expect("the film's own tile");
        film
    }

    #[test]
    fn a_picture_agrees_only_with_itself_and_a_difference_leaves_its_files() {
        let case = &cases()[0];
        let (one, other) = (grey(case, 0.5), grey(case, 0.502));
        assert!(Comparison::of(case, &one, &one).holds());
        let differing = Comparison::of(case, &one, &other);
        let found = differing.found;
        assert!(!differing.holds() && (found.median - 4e-3).abs() < 1e-6 && found.off == 1.0, "{differing}");
        let folder = differing.keep("[self-test] artefacts", &one, &other).expect("a folder to write to");
        for name in
            ["expected.exr", "actual.exr", "difference.exr", "expected-actual-difference.png", "figures.json"]
        {
            assert!(folder.join(name).is_file(), "{name}");
        }
        std::fs::remove_dir_all(folder).expect("what was written can be removed");
    }
}
