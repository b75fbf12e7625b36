//! The comparison of two pictures of one scene.

use super::Film;
use crate::Error;

/// Relative differences of the colours (CIE XYZ) of two pictures, over the pixels in which either shows a stone. The
/// difference of two colours is their Euclidean distance over the length of the expected one.
///
/// All backends use the same samples and wavelengths, so their pictures can be compared in this way. Pictures with
/// different numbers of samples cannot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// The number of pixels.
    pub pixels: usize,
    /// The median difference.
    pub median: f64,
    /// The share of pixels, 0 to 1, with a difference above [`Agreement::TOLERANCE`].
    pub off: f64,
    /// The difference of the mean colours.
    pub mean: f64,
    /// The largest difference.
    pub worst: f64,
}

impl Agreement {
    /// The relative difference above which a pixel counts as an outlier.
    pub const TOLERANCE: f64 = 1e-3;

    /// Compares two pictures. If neither shows a stone, the median and the largest difference are infinite and all pixels
    /// count as outliers.
    ///
    /// # Errors
    /// [`Error::Value`] for pictures of different sizes.
    pub fn of(expected: &Film, found: &Film) -> Result<Self, Error> {
        if (expected.width, expected.height) != (found.width, found.height) {
            let size = |film: &Film| format!("{} × {}", film.width, film.height);
            let wanted = format!("a picture of {} pixels, as the one it is compared with", size(expected));
            return Err(Error::value("film size", size(found), wanted));
        }
        let places = (0..expected.height).flat_map(|y| (0..expected.width).map(move |x| (x, y)));
        let pairs: Vec<_> = places
            .filter(|&(x, y)| expected.coverage(x, y) + found.coverage(x, y) > 0.0)
            .map(|(x, y)| (expected.xyz(x, y).map(f64::from), found.xyz(x, y).map(f64::from)))
            .collect();
        let mut errors: Vec<f64> = pairs.iter().map(|(e, f)| difference(*e, *f)).collect();
        errors.sort_by(f64::total_cmp);
        let sum = pairs.iter().fold(([0.0; 3], [0.0; 3]), |(e, f), pair| {
            ([0, 1, 2].map(|c| e[c] + pair.0[c]), [0, 1, 2].map(|c| f[c] + pair.1[c]))
        });
        let off = errors.iter().filter(|e| **e > Self::TOLERANCE).count();
        Ok(Agreement {
            pixels: errors.len(),
            median: errors.get(errors.len() / 2).copied().unwrap_or(f64::INFINITY),
            off: if errors.is_empty() { 1.0 } else { off as f64 / errors.len() as f64 },
            mean: difference(sum.0, sum.1),
            worst: errors.last().copied().unwrap_or(f64::INFINITY),
        })
    }
}

/// Distance of two colours relative to the expected one; infinite for NaN.
fn difference(expected: [f64; 3], found: [f64; 3]) -> f64 {
    let size = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let error = size([0, 1, 2].map(|c| found[c] - expected[c])) / size(expected).max(1e-6);
    if error.is_nan() { f64::INFINITY } else { error }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One row of grey pixels, all on a stone.
    fn row(values: &[f32]) -> Film {
        let (xyz, ones) = (values.iter().map(|v| [*v; 3]).collect(), vec![1.0; values.len()]);
        let samples = vec![1; values.len()];
        Film { xyz, coverage: ones, samples, ..Film::empty(values.len() as u32, 1, 0).expect("a small film") }
    }

    #[test]
    fn differences_are_relative_to_the_expected_colour() {
        let expected = row(&[1.0, 2.0, 4.0, 1.0]);
        assert_eq!(Agreement::of(&expected, &expected).unwrap().worst, 0.0);
        let found = Agreement::of(&expected, &row(&[1.0, 2.5, 3.0, 1.0])).unwrap();
        let wanted = Agreement { pixels: 4, median: 0.25, off: 0.5, mean: 0.0625, worst: 0.25 };
        let apart = [(found.median, wanted.median), (found.mean, wanted.mean), (found.worst, wanted.worst)];
        assert!(apart.iter().all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        assert_eq!((found.pixels, found.off), (wanted.pixels, wanted.off));
        let broken = Agreement::of(&expected, &row(&[f32::NAN, 2.0, 4.0, 1.0])).unwrap();
        assert_eq!((broken.worst, broken.mean), (f64::INFINITY, f64::INFINITY));
    }

    #[test]
    fn pictures_without_a_stone_do_not_agree_and_other_sizes_are_refused() {
        let empty = Film { coverage: vec![0.0; 2], ..row(&[1.0, 1.0]) };
        let found = Agreement::of(&empty, &empty).unwrap();
        assert_eq!((found.pixels, found.median, found.off), (0, f64::INFINITY, 1.0));
        let error = Agreement::of(&empty, &row(&[1.0; 3])).unwrap_err().to_string();
        assert!(error.contains("3 × 1") && error.contains("2 × 1"), "{error}");
    }
}
