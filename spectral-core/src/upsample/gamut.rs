//! Colours of other spaces than sRGB.

use crate::Warning;
use crate::color::matrix::{Matrix, apply};
use crate::color::{Oklab, RgbSpace};

/// The share of max(r, g, b) by which rounding may make a component negative.
const ROUNDING: f64 = 1e-6;

/// Converts colours of any linear RGB space to the gamut of sRGB, and counts those outside.
///
/// The bases reproduce every colour with non-negative components in sRGB. Other spaces have more colours; 1 % of Rec.
/// 2020's cube and 6 % of ACEScg's are the colour of no light at all. Where a component of linear sRGB is negative, the colour
/// keeps hue and lightness and loses chroma ([`Oklab::without_negatives`]). [`warning`](Self::warning) reports how many and by
/// how much.
///
/// ```
/// use spectral_core::{color::RgbSpace, upsample::Gamut};
/// let mut gamut = Gamut::new(RgbSpace::Rec2020);
/// let [r, g, b] = gamut.convert([0.0, 1.0, 0.0]); // a green beyond sRGB
/// assert!(r < 1e-3 && g > 0.8 && b > 0.0 && gamut.clipped() == 1);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Gamut {
    matrix: Matrix,
    oklab: Oklab,
    seen: u64,
    clipped: u64,
    farthest: f64,
}

impl Gamut {
    /// A converter from `space`.
    pub fn new(space: RgbSpace) -> Self {
        let oklab = Oklab::of(RgbSpace::Srgb);
        Gamut { matrix: space.to_linear_srgb(), oklab, seen: 0, clipped: 0, farthest: 0.0 }
    }

    /// A colour as non-negative linear sRGB. One that is not finite becomes black.
    pub fn convert(&mut self, rgb: [f64; 3]) -> [f64; 3] {
        self.seen += 1;
        let srgb = apply(&self.matrix, rgb);
        if !srgb.iter().all(|c| c.is_finite()) {
            return [0.0; 3];
        }
        let brightest = srgb.into_iter().fold(0.0, f64::max);
        let below = -srgb.into_iter().fold(0.0, f64::min);
        if below > ROUNDING * brightest {
            self.clipped += 1;
            let share = if brightest > 0.0 { below / brightest } else { 1.0 };
            self.farthest = self.farthest.max(share);
        }
        self.oklab.without_negatives(srgb)
    }

    /// Adds the counts of another converter, for instance of another thread.
    pub fn merge(&mut self, other: &Gamut) {
        self.seen += other.seen;
        self.clipped += other.clipped;
        self.farthest = self.farthest.max(other.farthest);
    }

    /// The colours converted.
    pub fn seen(&self) -> u64 {
        self.seen
    }

    /// The colours that had a negative component beyond rounding (10⁻⁶ of the brightest).
    pub fn clipped(&self) -> u64 {
        self.clipped
    }

    /// The largest negative component, as a share of its colour's brightest component.
    pub fn farthest(&self) -> f64 {
        self.farthest
    }

    /// A sentence about the clipped colours; `None` if there are none.
    pub fn warning(&self) -> Option<Warning> {
        (self.clipped > 0).then(|| {
            let share = 100.0 * self.clipped as f64 / self.seen as f64;
            Warning::new(format!(
                "{} of {} colours ({share:.2} %) lie outside sRGB, by up to {:.2} % of their brightest component; \
                 they lost as much chroma as sRGB does not have",
                self.clipped,
                self.seen,
                100.0 * self.farthest
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_inside_pass_and_rounding_is_not_counted() {
        let mut gamut = Gamut::new(RgbSpace::AcesCg);
        for color in [[1.0; 3], [0.0; 3], [0.5, 0.4, 0.3]] {
            let rgb = gamut.convert(color);
            let back = apply(&RgbSpace::AcesCg.from_linear_srgb(), rgb);
            assert!((0..3).all(|c| (back[c] - color[c]).abs() < 1e-12));
        }
        assert_eq!((gamut.seen(), gamut.clipped(), gamut.warning()), (3, 0, None));
    }

    #[test]
    fn colours_outside_are_clipped_counted_and_reported() {
        let mut gamut = Gamut::new(RgbSpace::Srgb);
        let inside = gamut.convert([1.0, -0.25, 0.0]);
        assert!(inside.iter().all(|c| *c >= 0.0) && inside[0] > 0.2, "{inside:?}");
        let mut other = Gamut::new(RgbSpace::Srgb);
        other.convert([-1.0, 0.0, 0.0]);
        other.convert([1.0, 1.0, 1.0]);
        assert_eq!(other.convert([f64::NAN, 1.0, 1.0]), [0.0; 3]);
        gamut.merge(&other);
        assert_eq!((gamut.seen(), gamut.clipped(), gamut.farthest()), (4, 2, 1.0));
        let message = gamut.warning().unwrap().message;
        assert!(message.starts_with("2 of 4 colours (50.00 %) lie outside sRGB"), "{message}");
    }
}
