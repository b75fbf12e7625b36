//! Statistics for the comparison of pictures.
//!
//! At an edge of a facet, two correct renderers can take different sides, and lights are far brighter than the mean. So
//! the largest error and the RMS are useless: pictures are compared by the median error and the share of outliers.

use crate::render::Picture;
use std::fmt;

/// Relative errors of many samples, or absolute errors where the reference is below 1e-6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The number of samples.
    pub samples: usize,
    /// Their median.
    pub median: f64,
    /// The share of samples with an error above 1 %.
    pub over_1_percent: f64,
    /// The largest.
    pub worst: f64,
    /// Mean found over mean expected.
    pub mean_ratio: f64,
}

impl Difference {
    /// Compares pairs (expected, found). Without any pair the median and the largest error are infinite.
    pub fn of(pairs: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let pairs: Vec<(f64, f64)> = pairs.into_iter().collect();
        let mut errors: Vec<f64> = pairs.iter().map(|&(expected, found)| error(expected, found)).collect();
        errors.sort_by(f64::total_cmp);
        let samples = errors.len();
        let (expected, found) = pairs.iter().fold((0.0, 0.0), |(e, f), pair| (e + pair.0, f + pair.1));
        Difference {
            samples,
            median: errors.get(samples / 2).copied().unwrap_or(f64::INFINITY),
            over_1_percent: errors.iter().filter(|e| **e > 0.01).count() as f64 / samples as f64,
            worst: errors.last().copied().unwrap_or(f64::INFINITY),
            mean_ratio: found / expected,
        }
    }

    /// Compares the radiance at every wavelength in the pixels where either picture shows a stone.
    pub fn of_stones(expected: &Picture, found: &Picture) -> Self {
        let covered = expected.coverage().into_iter().zip(found.coverage()).map(|(a, b)| a + b > 0.0);
        let pixels = expected.radiances().into_iter().zip(found.radiances()).zip(covered);
        Self::of(pixels.filter(|(_, covered)| *covered).flat_map(|((e, f), _)| e.into_iter().zip(f)))
    }
}

/// A NaN counts as infinitely wrong.
fn error(expected: f64, found: f64) -> f64 {
    let difference = (found - expected).abs();
    let error = if expected > 1e-6 { difference / expected } else { difference };
    if error.is_nan() { f64::INFINITY } else { error }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Difference { samples, median, over_1_percent, worst, mean_ratio } = self;
        let percent = 100.0 * over_1_percent;
        write!(
            f,
            "{samples} samples, median {median:.1e}, {percent:.3} % off by > 1 %, worst {worst:.1e}, \
             mean ratio {mean_ratio:.6}"
        )
    }
}
