//! Tristimulus values and RGB: colour spaces from their primaries, the response of a grid, colour differences, and how
//! colours are shown that a screen cannot show.
//!
//! An RGB space consists of three primaries and a white. Let the columns of P be the chromaticities of the primaries,
//! (x/y, 1, z/y) each. The columns of the matrix from linear RGB to XYZ are the primaries, scaled so that (1, 1, 1) gives
//! the white w:
//!
//! > M(w) = P·diag(P⁻¹·w).
//!
//! XYZ here is always relative to D65, the white of sRGB, P3 and Rec. 2020. ACEScg has another white, so its matrix is
//! followed by a Bradford adaptation, which maps one white to the other by scaling cone-like responses: A =
//! B⁻¹·diag(B·w_D65 / B·w)·B (Lam 1985; B as in ICC.1:2022, annex E).
//!
//! ```
//! use spectral_core::color::{RgbSpace, matrix::apply};
//! let white = apply(&RgbSpace::AcesCg.to_xyz(), [1.0; 3]);
//! let rgb = apply(&RgbSpace::Srgb.from_xyz(), white);
//! assert!(rgb.iter().all(|c| (c - 1.0).abs() < 1e-12)); // white stays white
//! ```

mod difference;
pub mod matrix;
mod oklab;
mod response;
mod tone;

pub use difference::{delta_e_2000, lab};
pub use oklab::Oklab;
pub use response::Response;
pub use tone::{Tone, ViewTransform};

use crate::Error;
use matrix::{IDENTITY, Matrix, apply, inverse, product, scale_rows, transpose};

/// The chromaticity (x, y) of D65 as the RGB standards round it (IEC 61966-2-1, ITU-R BT.2020).
const D65_WHITE: [f64; 2] = [0.3127, 0.3290];

/// The Bradford cone response.
const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// A linear RGB space, or XYZ itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum RgbSpace {
    /// sRGB and Rec. 709 (IEC 61966-2-1).
    #[default]
    Srgb,
    /// Display P3: DCI-P3 primaries with D65 (SMPTE EG 432-1).
    P3,
    /// Rec. 2020 (ITU-R BT.2020).
    Rec2020,
    /// ACEScg: AP1 primaries with the ACES white near D60 (S-2014-004).
    AcesCg,
    /// CIE XYZ, whose white for D65 is [`white_xyz`](RgbSpace::white_xyz).
    Xyz,
}

impl RgbSpace {
    /// Every space.
    pub const ALL: [RgbSpace; 5] =
        [RgbSpace::Srgb, RgbSpace::P3, RgbSpace::Rec2020, RgbSpace::AcesCg, RgbSpace::Xyz];

    /// The name on a command line.
    pub fn name(self) -> &'static str {
        match self {
            RgbSpace::Srgb => "srgb",
            RgbSpace::P3 => "p3",
            RgbSpace::Rec2020 => "rec2020",
            RgbSpace::AcesCg => "acescg",
            RgbSpace::Xyz => "xyz",
        }
    }

    /// The space of a name, in either case.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing the names.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        let lower = name.to_ascii_lowercase();
        let found = Self::ALL.into_iter().find(|space| space.name() == lower);
        found.ok_or_else(|| Error::unknown("colour space", name, Self::ALL.map(Self::name)))
    }

    /// The chromaticities (x, y) of the red, green and blue primary.
    pub fn primaries(self) -> [[f64; 2]; 3] {
        match self {
            RgbSpace::Srgb => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]],
            RgbSpace::P3 => [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06]],
            RgbSpace::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]],
            RgbSpace::AcesCg => [[0.713, 0.293], [0.165, 0.830], [0.128, 0.044]],
            RgbSpace::Xyz => [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]],
        }
    }

    /// The chromaticity (x, y) of the space's own white; for XYZ that of D65.
    pub fn white(self) -> [f64; 2] {
        match self {
            RgbSpace::AcesCg => [0.32168, 0.33767],
            _ => D65_WHITE,
        }
    }

    /// [X, Y, Z] of the space's own white, with Y = 1.
    pub fn white_xyz(self) -> [f64; 3] {
        xy_to_xyz(self.white())
    }

    /// The matrix from this linear RGB to XYZ under the space's own white, as standards publish it.
    pub fn native_to_xyz(self) -> Matrix {
        match self {
            RgbSpace::Xyz => IDENTITY,
            _ => builtin(rgb_to_xyz(self.primaries(), self.white_xyz())),
        }
    }

    /// The matrix from this linear RGB to XYZ under D65, adapted by Bradford where the white differs.
    pub fn to_xyz(self) -> Matrix {
        let native = self.native_to_xyz();
        if self.white() == D65_WHITE {
            return native;
        }
        product(&builtin(bradford(self.white_xyz(), xy_to_xyz(D65_WHITE))), &native)
    }

    /// The matrix from XYZ under D65 to this linear RGB: the inverse of [`to_xyz`](Self::to_xyz).
    pub fn from_xyz(self) -> Matrix {
        match self {
            RgbSpace::Xyz => IDENTITY,
            _ => builtin(inverse(&self.to_xyz()).ok_or_else(|| singular(self.primaries()))),
        }
    }

    /// The matrix from this linear space to linear sRGB; the identity for sRGB itself.
    pub fn to_linear_srgb(self) -> Matrix {
        match self {
            RgbSpace::Srgb => IDENTITY,
            _ => product(&RgbSpace::Srgb.from_xyz(), &self.to_xyz()),
        }
    }

    /// The matrix from linear sRGB to this linear space; the identity for sRGB itself.
    pub fn from_linear_srgb(self) -> Matrix {
        match self {
            RgbSpace::Srgb => IDENTITY,
            _ => product(&self.from_xyz(), &RgbSpace::Srgb.to_xyz()),
        }
    }
}

/// The matrix from linear RGB to XYZ for primaries given by their chromaticities (x, y), in which (1, 1, 1) is
/// the `white` [X, Y, Z].
///
/// # Errors
/// [`Error::Value`] if the primaries lie on a line, so that they span no colours.
pub fn rgb_to_xyz(primaries: [[f64; 2]; 3], white: [f64; 3]) -> Result<Matrix, Error> {
    let weights = primary_weights(primaries, white).ok_or_else(|| singular(primaries))?;
    Ok(transpose(&scale_rows(weights, &primaries.map(xyz_of_unit_sum))))
}

/// The Bradford adaptation of XYZ from one white to another (as [X, Y, Z]).
///
/// # Errors
/// [`Error::Value`] if a cone response of the `from` white is zero.
pub fn bradford(from: [f64; 3], to: [f64; 3]) -> Result<Matrix, Error> {
    let (source, target) = (apply(&BRADFORD, from), apply(&BRADFORD, to));
    let gains: [f64; 3] = std::array::from_fn(|cone| target[cone] / source[cone]);
    let back = inverse(&BRADFORD).filter(|_| gains.iter().all(|g| g.is_finite()));
    let back = back.ok_or_else(|| {
        Error::value("white point", format!("{from:?}"), "all three cones must respond to it")
    })?;
    Ok(product(&back, &scale_rows(gains, &BRADFORD)))
}

/// The sRGB transfer function: a linear component to the encoded one, 0–1 to 0–1 (IEC 61966-2-1).
///
/// It is odd, as in extended-range sRGB, so values outside the gamut survive a round trip.
///
/// ```
/// use spectral_core::color::{srgb_decode, srgb_encode};
/// assert!((srgb_encode(0.5) - 0.735_356_983_052_449).abs() < 1e-12);
/// assert!((srgb_decode(srgb_encode(0.18)) - 0.18).abs() < 1e-12);
/// ```
pub fn srgb_encode(linear: f64) -> f64 {
    let x = linear.abs();
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    encoded.copysign(linear)
}

/// The inverse sRGB transfer function: an encoded component to the linear one.
pub fn srgb_decode(encoded: f64) -> f64 {
    let x = encoded.abs();
    let linear = if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    linear.copysign(encoded)
}

/// The factors of the primaries whose sum is `white`: P⁻¹w, in units of x + y + z = 1.
fn primary_weights(primaries: [[f64; 2]; 3], white: [f64; 3]) -> Option<[f64; 3]> {
    let columns = transpose(&primaries.map(xyz_of_unit_sum));
    Some(apply(&inverse(&columns)?, white))
}

/// [x, y, 1 − x − y].
fn xyz_of_unit_sum([x, y]: [f64; 2]) -> [f64; 3] {
    [x, y, 1.0 - x - y]
}

/// [X, Y, Z] with Y = 1 of a chromaticity.
fn xy_to_xyz([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

fn singular(primaries: [[f64; 2]; 3]) -> Error {
    Error::value("RGB primaries", format!("{primaries:?}"), "they must span a triangle")
}

/// The matrix of a built-in space, whose constants are valid.
fn builtin(matrix: Result<Matrix, Error>) -> Matrix {
    matrix.expect("the primaries of the built-in spaces span triangles")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transfer_function_round_trips_and_meets_at_the_knee() {
        for i in -200..=200 {
            let linear = f64::from(i) / 100.0;
            assert!((srgb_decode(srgb_encode(linear)) - linear).abs() < 1e-12, "{linear}");
        }
        // IEC 61966-2-1: 8-bit 188 is about half of white's light, and the two branches meet within 1e-7.
        assert_eq!((srgb_encode(0.5) * 255.0).round(), 188.0);
        assert!((12.92f64 * 0.003_130_8 - (1.055 * 0.003_130_8f64.powf(1.0 / 2.4) - 0.055)).abs() < 1e-7);
    }

    #[test]
    fn names_are_found_and_misspellings_answered() {
        for space in RgbSpace::ALL {
            assert_eq!(RgbSpace::by_name(&space.name().to_uppercase()).unwrap(), space);
        }
        let message = RgbSpace::by_name("rec202").unwrap_err().to_string();
        assert_eq!(message, "unknown colour space 'rec202'; did you mean 'rec2020'?");
    }

    #[test]
    fn primaries_on_a_line_are_refused() {
        let message = rgb_to_xyz([[0.1, 0.1], [0.2, 0.2], [0.4, 0.4]], [1.0; 3]).unwrap_err().to_string();
        assert!(message.contains("must span a triangle"), "{message}");
        assert!(bradford([0.0; 3], [1.0; 3]).is_err());
    }

    #[test]
    fn bradford_takes_one_white_to_the_other() {
        let (a, b) = ([1.0985, 1.0, 0.3558], RgbSpace::Srgb.white_xyz());
        let adapted = apply(&bradford(a, b).unwrap(), a);
        assert!((0..3).all(|c| (adapted[c] - b[c]).abs() < 1e-14));
    }
}
