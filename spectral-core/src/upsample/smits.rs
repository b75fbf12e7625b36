//! Smits's seven spectra and his rule for combining them.
//!
//! Smits, "An RGB to spectrum conversion for reflectances", Journal of Graphics Tools 4 (1999). The ten numbers of a base
//! are constant over boxes of 34 nm from 380 to 720 nm. (With linear interpolation the round trip is off by 9 %.)

/// The number of bases.
pub const COUNT: usize = 7;

/// The linear-sRGB colour of each base: white, cyan, magenta, yellow, red, green, blue.
pub const COLORS: [[f64; 3]; COUNT] = [
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];

/// Lower edge of the first box and the width of each, in nm.
const FIRST_EDGE: f64 = 380.0;
const BOX_WIDTH: f64 = 34.0;

/// The published numbers, in the order of [`COLORS`].
#[rustfmt::skip]
const BOXES: [[f64; 10]; COUNT] = [
    [1.0000, 1.0000, 0.9999, 0.9993, 0.9992, 0.9998, 1.0000, 1.0000, 1.0000, 1.0000],
    [0.9710, 0.9426, 1.0007, 1.0007, 1.0007, 1.0007, 0.1564, 0.0000, 0.0000, 0.0000],
    [1.0000, 1.0000, 0.9685, 0.2229, 0.0000, 0.0458, 0.8369, 1.0000, 1.0000, 0.9959],
    [0.0001, 0.0000, 0.1088, 0.6651, 1.0000, 1.0000, 0.9996, 0.9586, 0.9685, 0.9840],
    [0.1012, 0.0515, 0.0000, 0.0000, 0.0000, 0.0000, 0.8325, 1.0149, 1.0149, 1.0149],
    [0.0000, 0.0000, 0.0273, 0.7937, 1.0000, 0.9418, 0.1719, 0.0000, 0.0000, 0.0025],
    [1.0000, 1.0000, 0.8916, 0.3323, 0.0000, 0.0000, 0.0003, 0.0369, 0.0483, 0.0496],
];

/// All seven bases at a wavelength in nm, as reflectances; the end boxes extend beyond 380–720 nm.
///
/// ```
/// use spectral_core::upsample::smits::boxes;
/// assert_eq!(boxes(413.9)[1], 0.9710); // cyan's first box ends at 414 nm
/// assert_eq!(boxes(414.0)[1], 0.9426);
/// ```
pub fn boxes(nm: f64) -> [f64; COUNT] {
    // `as` takes NaN and negative numbers to 0.
    let index = (((nm - FIRST_EDGE) / BOX_WIDTH).floor() as usize).min(9);
    BOXES.map(|base| base[index])
}

/// A colour as a sum of at most three bases.
///
/// With the sorted components min ≤ mid ≤ max, a colour is min of white, (mid − min) of the secondary that contains both
/// larger components, and (max − mid) of the primary of the largest. The sum of [`COLORS`] with these weights is exactly
/// the colour, and for non-negative colours no weight is negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// The bases: indices into [`COLORS`], always white, a secondary (1–3) and a primary (4–6).
    pub base: [usize; 3],
    /// How much of each.
    pub weight: [f64; 3],
}

impl Weights {
    /// The weights of a linear-sRGB colour.
    ///
    /// ```
    /// use spectral_core::upsample::smits::Weights;
    /// let orange = Weights::new([1.0, 0.5, 0.125]);
    /// assert_eq!(orange.base, [0, 3, 4]); // white, yellow, red
    /// assert_eq!(orange.weight, [0.125, 0.375, 0.5]);
    /// ```
    pub fn new(rgb: [f64; 3]) -> Self {
        let [r, g, b] = rgb;
        let smallest = if r <= g && r <= b { 0 } else { 2 - usize::from(g <= b) };
        let largest = if r >= g && r >= b { 0 } else { 2 - usize::from(g >= b) };
        let (min, max) = (rgb[smallest], rgb[largest]);
        let mid = r.min(g).max(r.max(g).min(b));
        Weights { base: [0, 1 + smallest, 4 + largest], weight: [min, mid - min, max - mid] }
    }

    /// Σ weight·values\[base\].
    pub fn mix(&self, values: &[f64; COUNT]) -> f64 {
        self.base.iter().zip(self.weight).map(|(&base, weight)| weight * values[base]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_of_components_is_exact() {
        let levels = [0.0, 0.25, 0.5, 1.0, 1e6];
        for r in levels {
            for g in levels {
                for b in levels {
                    let weights = Weights::new([r, g, b]);
                    assert!(weights.weight.iter().all(|w| *w >= 0.0), "{r} {g} {b}");
                    for (c, expected) in [r, g, b].into_iter().enumerate() {
                        assert_eq!(weights.mix(&COLORS.map(|color| color[c])), expected, "{r} {g} {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn boxes_include_their_lower_edges_and_extend_beyond_the_ends() {
        assert_eq!(boxes(200.0), boxes(380.0));
        assert_eq!(boxes(2000.0), boxes(719.9));
        assert_eq!(boxes(686.0)[6], 0.0496);
        assert_eq!(boxes(685.99)[6], 0.0483);
        assert_eq!(boxes(f64::NAN), boxes(380.0));
    }

    #[test]
    fn invalid_colours_do_not_panic() {
        Weights::new([f64::NAN, 1.0, -2.0]);
        Weights::new([f64::INFINITY, f64::NAN, f64::NAN]);
    }
}
