//! The response of a wavelength grid: the contribution of each wavelength to X, Y and Z.

use super::matrix::{Matrix, apply, scale_rows};
use super::{RgbSpace, primary_weights};
use crate::Error;
use crate::cie::{Illuminant, color_matching, luminous_integral};
use crate::wavelength::WavelengthGrid;

/// The largest ratio between the factors that balance a grid's three channels. Grids of four or more wavelengths over the
/// visible range are below it at every jitter offset; above it, a channel is almost invisible.
const LARGEST_IMBALANCE: f64 = 8.0;

/// The eye on one wavelength grid: XYZ = Σ wᵢ·L(λᵢ), with D65 exactly white.
///
/// The sum x̄ȳz̄·L·Δ over a coarse grid differs slightly from the integral, and differently in each channel, so D65 would be
/// tinted: by 1.4 % at 20 nm. To correct this, the RGB→XYZ matrix of the sRGB primaries P is computed with the white of
/// *this grid*, w_grid = Σ x̄ȳz̄·D65·Δ, in place of the standard white:
///
/// > M(w) = P·diag(P⁻¹w),  wᵢ = M(w_std)·M(w_grid)⁻¹·x̄ȳz̄(λᵢ)·Δᵢ.
///
/// This scales the channel of each primary by the error of its sum. Then D65 as normalised by [`Illuminant::at`] is exactly
/// w_std (Y = 1), and linear sRGB is M(w_grid)⁻¹·x̄ȳz̄·L·Δ, in which D65 is exactly (1, 1, 1).
///
/// The standard white is that of IEC 61966-2-1, x = 0.3127, y = 0.3290. The published sRGB, P3 and Rec. 2020 matrices use
/// it too, so they convert these XYZ to RGB exactly.
///
/// ```
/// use spectral_core::{cie::Illuminant, color::Response, wavelength::WavelengthGrid};
/// let grid = WavelengthGrid::midpoints([380.0, 740.0], 16)?;
/// let rgb = Response::new(&grid)?.to_linear_srgb(&Illuminant::D65.sample(&grid));
/// assert!(rgb.iter().all(|c| (c - 1.0).abs() < 1e-14));
/// # Ok::<(), spectral_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    xyz: Vec<[f64; 3]>,
    rows: [Vec<f64>; 3],
    white_exact: bool,
}

impl Response {
    /// The response of a grid.
    ///
    /// # Errors
    /// [`Error::Value`] if the grid has no visible wavelength (360–830 nm).
    pub fn new(grid: &WavelengthGrid) -> Result<Self, Error> {
        let cells: Vec<[f64; 3]> = grid
            .nm()
            .iter()
            .zip(grid.widths())
            .map(|(&nm, &width)| color_matching(nm).map(|bar| bar * width))
            .collect();
        let d65 = Illuminant::D65.sample(grid);
        let white = weighted_sum(&cells, &d65);
        if white[1] <= 0.0 {
            let [min, max] = grid.range();
            let expected = "include wavelengths that the eye sees (360 to 830 nm)";
            return Err(Error::value("wavelengths", format!("{min} to {max} nm"), expected));
        }
        let standard = RgbSpace::Srgb.to_xyz();
        let from_xyz = RgbSpace::Srgb.from_xyz();
        let (to_rgb, white_exact) = match grid_matrix(white) {
            Some(matrix) => (matrix, true),
            None => {
                let luminance = if grid.can_jitter() { luminous_integral() } else { white[1] };
                (from_xyz.map(|row| row.map(|x| x / luminance)), false)
            }
        };
        let rgb: Vec<[f64; 3]> = cells.iter().map(|&cell| apply(&to_rgb, cell)).collect();
        let xyz = rgb.iter().map(|&c| apply(&standard, c)).collect();
        let rows = std::array::from_fn(|channel| rgb.iter().map(|c| c[channel]).collect());
        Ok(Response { xyz, rows, white_exact })
    }

    /// The weights wᵢ: the contribution of unit radiance at each wavelength to [X, Y, Z], cell width included.
    pub fn xyz(&self) -> &[[f64; 3]] {
        &self.xyz
    }

    /// The three rows of the linear-sRGB response, cell width included: `rows()[channel][wavelength]`.
    ///
    /// They have negative lobes, since most spectral lights lie outside the sRGB triangle.
    pub fn rows(&self) -> [&[f64]; 3] {
        self.rows.each_ref().map(Vec::as_slice)
    }

    /// Whether D65 is exactly the standard white on this grid.
    ///
    /// False if the three channels cannot be balanced by positive factors of similar size, as on a grid of one or two
    /// wavelengths. A grid that cannot jitter then keeps the luminance of D65 exact (Y = 1), with a tint. A grid that can
    /// jitter is summed without correction: white is then exact in the mean over the offsets. Normalising each offset
    /// would let offsets at the ends of the spectrum dominate.
    pub fn white_exact(&self) -> bool {
        self.white_exact
    }

    /// [X, Y, Z] of a spectrum sampled on the grid; D65 has Y = 1. Excess samples are ignored.
    pub fn to_xyz(&self, spectrum: &[f64]) -> [f64; 3] {
        weighted_sum(&self.xyz, spectrum)
    }

    /// Linear sRGB of a spectrum sampled on the grid; D65 is (1, 1, 1).
    pub fn to_linear_srgb(&self, spectrum: &[f64]) -> [f64; 3] {
        self.rows.each_ref().map(|row| row.iter().zip(spectrum).map(|(r, s)| r * s).sum())
    }
}

/// Σ weightᵢ·valueᵢ.
fn weighted_sum(weights: &[[f64; 3]], values: &[f64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (weight, value) in weights.iter().zip(values) {
        sum.iter_mut().zip(weight).for_each(|(s, w)| *s += w * value);
    }
    sum
}

/// XYZ→RGB of the sRGB primaries under the white of a grid. `None` if this white needs a negative primary, or channel
/// factors with a ratio above [`LARGEST_IMBALANCE`].
fn grid_matrix(white: [f64; 3]) -> Option<Matrix> {
    let weights = primary_weights(RgbSpace::Srgb.primaries(), white)?;
    let standard = primary_weights(RgbSpace::Srgb.primaries(), RgbSpace::Srgb.white_xyz())?;
    // M(w_grid)⁻¹ = diag(weights)⁻¹·P⁻¹ = diag(standard/weights)·M(w_std)⁻¹.
    let gains: [f64; 3] = std::array::from_fn(|c| standard[c] / weights[c]);
    let [min, max] = [gains.into_iter().fold(f64::INFINITY, f64::min), gains.into_iter().fold(0.0, f64::max)];
    let balanced = min > 0.0 && max.is_finite() && max <= LARGEST_IMBALANCE * min;
    balanced.then(|| scale_rows(gains, &RgbSpace::Srgb.from_xyz()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn d65_is_the_standard_white_on_any_grid_of_three_or_more() {
        for count in 3..=100 {
            let grid = WavelengthGrid::midpoints([380.0, 740.0], count).unwrap();
            let response = Response::new(&grid).unwrap();
            assert!(response.white_exact(), "{count}");
            let xyz = response.to_xyz(&Illuminant::D65.sample(&grid));
            let white = RgbSpace::Srgb.white_xyz();
            assert!((0..3).all(|c| (xyz[c] - white[c]).abs() < 1e-13), "{count}: {xyz:?}");
        }
    }

    #[test]
    fn a_grid_that_cannot_balance_three_channels_keeps_the_luminance() {
        for list in [vec![550.0], vec![450.0, 600.0], vec![380.0]] {
            let grid = WavelengthGrid::list(list).unwrap();
            let response = Response::new(&grid).unwrap();
            assert!(!response.white_exact());
            assert!((response.to_xyz(&Illuminant::D65.sample(&grid))[1] - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn grids_too_coarse_to_balance_are_white_in_the_mean_over_their_offsets() {
        for count in [1, 2] {
            let grid = WavelengthGrid::midpoints([380.0, 780.0], count).unwrap();
            let mut mean = [0.0; 3];
            for sample in 0..987 {
                let offset = grid.jittered(sample);
                let xyz = Response::new(&offset).unwrap().to_xyz(&Illuminant::D65.sample(&offset));
                mean.iter_mut().zip(xyz).for_each(|(m, x)| *m += x / 987.0);
            }
            let white = RgbSpace::Srgb.white_xyz();
            assert!((0..3).all(|c| (mean[c] - white[c]).abs() < 0.01), "{count}: {mean:?}");
        }
    }

    #[test]
    fn an_invisible_grid_is_refused() {
        let grid = WavelengthGrid::midpoints([900.0, 1000.0], 8).unwrap();
        let message = Response::new(&grid).unwrap_err().to_string();
        assert!(message.contains("wavelengths: 900 to 1000 nm"), "{message}");
    }

    #[test]
    fn xyz_and_rgb_agree() {
        let grid = WavelengthGrid::midpoints([390.0, 720.0], 9).unwrap();
        let response = Response::new(&grid).unwrap();
        let light = Illuminant::A.sample(&grid);
        let back = apply(&RgbSpace::Srgb.from_xyz(), response.to_xyz(&light));
        let rgb = response.to_linear_srgb(&light);
        assert!((0..3).all(|c| (back[c] - rgb[c]).abs() < 1e-13), "{back:?} {rgb:?}");
    }
}
