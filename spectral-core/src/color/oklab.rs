//! Oklab: the perceptual space in which colours are brought into a gamut.
//!
//! Of spaces that predict hue about equally well (Ottosson gives errors on the data of Ebner & Fairchild, 1998: Oklab 0.49,
//! IPT 0.48, JzAzBz 0.43, CAM16-UCS 0.59, CIELAB 0.69), this one has the two properties that pictures of gems need:
//!
//! * Scaling a colour scales its coordinates. So its hue does not depend on the exposure, as it does in JzAzBz and CAM16.
//! * Blues keep their hue on the way to grey, and the hues of the spectrum never turn back from violet to red. In CIELAB, blues
//!   turn to purple, and the hue of the spectrum turns back at 430 nm.
//!
//! Source: B. Ottosson, "A perceptual color space for image processing", 2020, <https://bottosson.github.io/posts/oklab/>.

use super::RgbSpace;
use super::matrix::{Matrix, apply, inverse, product};

/// From linear sRGB to cone-like responses (Ottosson 2020; each row adds up to 1).
const LMS_OF_SRGB: Matrix = [
    [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
    [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
    [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
];

/// From the cube roots of these to L, a and b (Ottosson 2020).
const LAB_OF_ROOTS: Matrix = [
    [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
    [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
    [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
];

/// Halvings of the chroma until a colour is in: to a millionth of it.
const HALVINGS: usize = 20;

/// Oklab for the colours of one linear RGB space.
///
/// ```
/// use spectral_core::color::{Oklab, RgbSpace};
/// let oklab = Oklab::of(RgbSpace::Srgb);
/// let [l, a, b] = oklab.of_rgb([0.0, 0.0, 1.0]);
/// assert!((l - 0.452).abs() < 1e-3 && (a + 0.032).abs() < 1e-3 && (b + 0.312).abs() < 1e-3);
/// let inside = oklab.without_negatives([-0.2, 0.6, 0.4]); // a green that no screen of sRGB shows
/// assert!(inside.iter().all(|c| *c >= 0.0));
/// assert!((oklab.of_rgb(inside)[0] - oklab.of_rgb([-0.2, 0.6, 0.4])[0]).abs() < 1e-6); // as light as before
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Oklab {
    lms_of_rgb: Matrix,
    rgb_of_lms: Matrix,
    roots_of_lab: Matrix,
}

impl Oklab {
    /// For the colours of `space`.
    pub fn of(space: RgbSpace) -> Self {
        let undo = |matrix: &Matrix| inverse(matrix).expect("Oklab's matrices have inverses");
        Oklab {
            lms_of_rgb: product(&LMS_OF_SRGB, &space.to_linear_srgb()),
            rgb_of_lms: product(&space.from_linear_srgb(), &undo(&LMS_OF_SRGB)),
            roots_of_lab: undo(&LAB_OF_ROOTS),
        }
    }

    /// [L, a, b] of a linear colour of the space: 1, 0, 0 for white.
    pub fn of_rgb(&self, rgb: [f64; 3]) -> [f64; 3] {
        apply(&LAB_OF_ROOTS, apply(&self.lms_of_rgb, rgb).map(f64::cbrt))
    }

    /// The linear colour of [L, a, b].
    pub fn to_rgb(&self, lab: [f64; 3]) -> [f64; 3] {
        apply(&self.rgb_of_lms, apply(&self.roots_of_lab, lab).map(|root| root.powi(3)))
    }

    /// The colour of [L, a, b] with as much of its chroma, at the same lightness and hue, as leaves no component below 0 or
    /// above `most`, which L must not be above.
    pub(super) fn inside(&self, [l, a, b]: [f64; 3], most: f64) -> [f64; 3] {
        let colour = |share: f64| self.to_rgb([l, share * a, share * b]);
        let fits = |rgb: [f64; 3]| rgb.iter().all(|c| (0.0..=most).contains(c));
        let whole = colour(1.0);
        if fits(whole) {
            return whole;
        }
        let (mut share, mut beyond) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (share + beyond);
            *(if fits(colour(middle)) { &mut share } else { &mut beyond }) = middle;
        }
        // Grey itself may be beyond by rounding.
        colour(share).map(|c| c.clamp(0.0, most))
    }

    /// A colour that some light has, as one of the space: where a component is negative, the colour of the same lightness
    /// and hue with as much chroma as the space has. Other colours stay as they are, to the bit. What is darker than black becomes
    /// black.
    pub fn without_negatives(&self, rgb: [f64; 3]) -> [f64; 3] {
        if !rgb.iter().any(|c| *c < 0.0) {
            return rgb;
        }
        let lab = self.of_rgb(rgb);
        if lab[0] > 0.0 { self.inside(lab, f64::INFINITY) } else { [0.0; 3] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_the_published_ones() {
        // Ottosson 2020, "Table of example XYZ and Oklab pairs", rounded to three places there.
        for (xyz, lab) in [
            ([0.950, 1.000, 1.089], [1.000, 0.000, 0.000]),
            ([1.000, 0.000, 0.000], [0.450, 1.236, -0.019]),
            ([0.000, 1.000, 0.000], [0.922, -0.671, 0.263]),
            ([0.000, 0.000, 1.000], [0.153, -1.415, -0.449]),
        ] {
            let found = Oklab::of(RgbSpace::Xyz).of_rgb(xyz);
            assert!((0..3).all(|c| (found[c] - lab[c]).abs() < 1e-3), "{xyz:?}: {found:?}");
        }
    }

    #[test]
    fn colours_come_in_along_hue_and_lightness() {
        for space in RgbSpace::ALL.into_iter().filter(|space| *space != RgbSpace::Xyz) {
            let oklab = Oklab::of(space);
            // All around, from beyond the gamut to grey.
            for degrees in 0..360 {
                let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
                for chroma in [0.05, 0.2, 0.4] {
                    let rgb = oklab.to_rgb([0.6, chroma * cos, chroma * sin]);
                    let [l, a, b] = oklab.of_rgb(oklab.without_negatives(rgb));
                    assert!((l - 0.6).abs() < 1e-6, "{degrees}: {l}");
                    assert!(
                        (a * sin - b * cos).abs() < 1e-6 && a * cos + b * sin > 0.0,
                        "{degrees}: {a} {b}"
                    );
                }
            }
            assert_eq!(oklab.without_negatives([-1.0, -0.1, 0.1]), [0.0; 3]);
            assert_eq!(oklab.without_negatives([0.1, 7.0, 0.0]), [0.1, 7.0, 0.0]);
        }
    }
}
