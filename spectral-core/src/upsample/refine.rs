//! The iteration that makes a spectrum reproduce its RGB.
//!
//! Let A_c be the row of the linear-sRGB response for component c, cell width included: A_c·I is this component of the
//! colour of a spectrum I. One step sets one component,
//!
//! > r₀ = A_c·I                                   (1)
//! > I ← max(0, I + r̄_norm·(r − r₀)),             (2)
//!
//! with **r̄_norm = A_c / Σ A_c²** (in terms of the response r̄ = A/Δλ: r̄ / (Δλ Σ r̄²)). Since A_c·r̄_norm = 1, the component is
//! exact unless the maximum applies. The step is the orthogonal projection onto the plane A_c·I = r (Kaczmarz 1937). A
//! sweep treats r, g and b in turn. The rows are nearly orthogonal, so one sweep leaves about 0.03 of the error while the
//! spectrum is positive. Where it reaches zero, the sweeps are cyclic projections onto three planes and the positive
//! orthant. They converge if and only if these have a common point, that is, if the colour lies in the cone of the columns
//! of the response (Bregman 1965). On any reasonable grid all of sRGB does.
//!
//! The map is homogeneous: twice the colour takes the same sweeps and gives twice the spectrum. So the error is relative to
//! max(r, g, b), and bright texels cost no more.

use super::smits;
use crate::Error;
use crate::cie::Illuminant;
use crate::color::Response;
use crate::wavelength::WavelengthGrid;

/// The largest component accepted: far above any light, and small enough that no sum overflows.
const MAX_COMPONENT: f64 = 1e100;

/// When the iteration stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// The largest summed error Σ|δ_c|, relative to max(r, g, b), that is accepted.
    pub tolerance: f64,
    /// The most sweeps made.
    pub max_sweeps: u32,
}

impl Default for Stop {
    /// 0.4 %, which every colour of sRGB reaches in a few sweeps, and a generous limit.
    fn default() -> Self {
        Stop { tolerance: 4e-3, max_sweeps: 10_000 }
    }
}

/// A spectrum and the error of its colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// Non-negative spectral radiance at the grid's wavelengths.
    pub spectrum: Vec<f64>,
    /// The number of sweeps; 0 if the start was good enough.
    pub sweeps: u32,
    /// The summed error Σ|δ_c| relative to max(r, g, b).
    pub residual: f64,
    /// Whether the residual is within the tolerance.
    pub converged: bool,
}

/// Changes `start` until it has the linear-sRGB colour `rgb`, by equations (1) and (2) of the module.
///
/// `rows` are the three rows of the response, cell width included ([`Response::rows`]); `start` is a non-negative spectrum
/// on the same grid. The error is tested before each sweep. Black gives the zero spectrum, whatever the start. A negative
/// component is treated like any other: it converges if some light has that colour on this grid. Without convergence the
/// last spectrum is returned, with `converged` false.
///
/// # Errors
/// [`Error::Value`] for lengths that differ, a colour that is not finite, above 1e100 or without a positive component, a
/// start that is negative or not finite, or a negative tolerance.
pub fn refine(rows: [&[f64]; 3], start: &[f64], rgb: [f64; 3], stop: Stop) -> Result<Refinement, Error> {
    check(rows, start, rgb, stop)?;
    let brightest = rgb.into_iter().fold(f64::NEG_INFINITY, f64::max);
    if brightest == 0.0 {
        return Ok(Refinement {
            spectrum: vec![0.0; start.len()],
            sweeps: 0,
            residual: 0.0,
            converged: true,
        });
    }
    let norms = rows.map(|row| dot(row, row));
    let mut spectrum = start.to_vec();
    let mut sweeps = 0;
    let mut cycle = Cycle::default();
    loop {
        // Whole periods change nothing, so only the remainder of the sweeps is left.
        if let Some(period) = cycle.period(sweeps, &spectrum) {
            sweeps = stop.max_sweeps - (stop.max_sweeps - sweeps) % period;
        }
        let errors = std::array::from_fn::<f64, 3, _>(|c| (rgb[c] - dot(rows[c], &spectrum)).abs());
        let residual = errors.iter().sum::<f64>() / brightest;
        let converged = residual <= stop.tolerance;
        if converged || sweeps == stop.max_sweeps {
            return Ok(Refinement { spectrum, sweeps, residual, converged });
        }
        for ((row, norm), component) in rows.into_iter().zip(norms).zip(rgb) {
            if norm > 0.0 {
                let step = (component - dot(row, &spectrum)) / norm;
                spectrum.iter_mut().zip(row).for_each(|(i, a)| *i = (*i + a * step).max(0.0));
            }
        }
        sweeps += 1;
    }
}

/// [`refine`] from Smits's bases, weighted by his rule, in the light of D65. The start ignores negative components.
///
/// ```
/// use spectral_core::{color::Response, upsample::{Stop, refine_smits}, wavelength::WavelengthGrid};
/// let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0)?;
/// let response = Response::new(&grid)?;
/// let stop = Stop { tolerance: 1e-6, ..Stop::default() };
/// let orange = refine_smits(&grid, &response, [1.0, 0.5, 0.1], stop)?;
/// let rgb = response.to_linear_srgb(&orange.spectrum);
/// assert!(orange.converged && (rgb[0] - 1.0).abs() <= 1e-6);
/// # Ok::<(), spectral_core::Error>(())
/// ```
///
/// # Errors
/// As [`refine`].
pub fn refine_smits(
    grid: &WavelengthGrid,
    response: &Response,
    rgb: [f64; 3],
    stop: Stop,
) -> Result<Refinement, Error> {
    check_color(rgb)?;
    let weights = smits::Weights::new(rgb.map(|c| c.max(0.0)));
    let start: Vec<f64> =
        grid.nm().iter().map(|&nm| weights.mix(&smits::boxes(nm)) * Illuminant::D65.at(nm)).collect();
    refine(response.rows(), &start, rgb, stop)
}

/// Detects sweeps that repeat bit for bit. This happens if no light has the colour, or if only the last bits of the error
/// are left.
///
/// Brent's method (BIT 20, 1980): the spectrum is kept at sweeps 1, 2, 4, … and compared with every later one. So a cycle of
/// any length is found within three times the sweeps up to its end.
#[derive(Default)]
struct Cycle {
    kept: Vec<f64>,
    at: u32,
}

impl Cycle {
    /// The period, if `spectrum` after `sweeps` sweeps repeats the kept one.
    fn period(&mut self, sweeps: u32, spectrum: &[f64]) -> Option<u32> {
        if sweeps > self.at && self.kept == spectrum {
            return Some(sweeps - self.at);
        }
        if sweeps.is_power_of_two() {
            self.kept.clear();
            self.kept.extend_from_slice(spectrum);
            self.at = sweeps;
        }
        None
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn check(rows: [&[f64]; 3], start: &[f64], rgb: [f64; 3], stop: Stop) -> Result<(), Error> {
    if let Some(row) = rows.iter().find(|row| row.len() != start.len()) {
        let found = format!("{} wavelengths", row.len());
        return Err(Error::value("response", found, format!("the start has {}", start.len())));
    }
    if let Some(value) = start.iter().find(|x| !(x.is_finite() && **x >= 0.0)) {
        return Err(Error::value("start spectrum", value, "it must be finite and not negative"));
    }
    if !(stop.tolerance >= 0.0 && stop.tolerance.is_finite()) {
        return Err(Error::value("tolerance", stop.tolerance, "it must be finite and not negative"));
    }
    check_color(rgb)
}

fn check_color(rgb: [f64; 3]) -> Result<(), Error> {
    let refuse = |expected: &str| Err(Error::value("colour", format!("{rgb:?}"), expected));
    if !rgb.iter().all(|c| c.abs() <= MAX_COMPONENT) {
        return refuse("the components must be finite numbers up to 1e100");
    }
    if rgb.iter().all(|c| *c <= 0.0) && rgb.iter().any(|c| *c != 0.0) {
        return refuse("no light has this colour: at least one component must be positive");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensor() -> (WavelengthGrid, Response) {
        let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0).unwrap();
        let response = Response::new(&grid).unwrap();
        (grid, response)
    }

    #[test]
    fn one_step_sets_its_component_exactly() {
        // A flat start far from zero: after one sweep blue, the last component, is exact. With unit-area rows or without Δλ
        // in the norm it would be off by a factor of 2 to 5.
        let (grid, response) = sensor();
        let start = vec![1.0; grid.len()];
        let stop = Stop { tolerance: 0.0, max_sweeps: 1 };
        let rgb = [1.1, 1.0, 1.05];
        let once = refine(response.rows(), &start, rgb, stop).unwrap();
        let shown = response.to_linear_srgb(&once.spectrum);
        assert!((shown[2] - rgb[2]).abs() < 1e-14, "{shown:?}");
        // A second sweep leaves about 0.03 of the error.
        let twice = refine(response.rows(), &once.spectrum, rgb, stop).unwrap();
        assert!(twice.residual < 0.1 * once.residual, "{} {}", once.residual, twice.residual);
    }

    #[test]
    fn the_iteration_is_homogeneous() {
        let (grid, response) = sensor();
        let stop = Stop { tolerance: 1e-6, ..Stop::default() };
        let base = refine_smits(&grid, &response, [0.9, 0.2, 0.05], stop).unwrap();
        for scale in [1e6, 1e-6, 2f64.powi(300)] {
            let scaled = refine_smits(&grid, &response, [0.9, 0.2, 0.05].map(|c| c * scale), stop).unwrap();
            assert!(scaled.converged);
            assert_eq!(scaled.sweeps, base.sweeps);
            assert!((scaled.residual / base.residual - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn black_is_dark_and_the_limit_is_kept() {
        let (grid, response) = sensor();
        let black = refine(response.rows(), &vec![5.0; grid.len()], [0.0; 3], Stop::default()).unwrap();
        assert!(black.converged && black.spectrum.iter().all(|x| *x == 0.0));
        let stop = Stop { tolerance: 0.0, max_sweeps: 3 };
        let cut = refine_smits(&grid, &response, [1.0, 0.0, 0.0], stop).unwrap();
        assert!(!cut.converged && cut.sweeps == 3 && cut.residual > 0.0);
    }

    #[test]
    fn real_colours_outside_srgb_converge_and_imaginary_ones_do_not() {
        let (grid, response) = sensor();
        let stop = Stop { tolerance: 1e-6, max_sweeps: 5000 };
        assert!(refine_smits(&grid, &response, [-0.1, 1.0, 1.0], stop).unwrap().converged);
        assert!(!refine_smits(&grid, &response, [-5.0, 1.0, 1.0], stop).unwrap().converged);
    }

    #[test]
    fn skipping_repeated_sweeps_changes_nothing() {
        // Too few wavelengths for these colours. With one sweep a call, no call can detect a cycle.
        for (count, color) in [(1, 4), (2, 5), (3, 1), (4, 5), (6, 6)] {
            let grid = WavelengthGrid::midpoints([380.0, 740.0], count).unwrap();
            let response = Response::new(&grid).unwrap();
            let rgb = smits::COLORS[color];
            let start: Vec<f64> = grid.nm().iter().map(|&nm| smits::boxes(nm)[color]).collect();
            let limit = |max_sweeps| Stop { tolerance: 0.0, max_sweeps };
            let mut spectrum = start.clone();
            for _ in 0..5001 {
                spectrum = refine(response.rows(), &spectrum, rgb, limit(1)).unwrap().spectrum;
            }
            let whole = refine(response.rows(), &start, rgb, limit(5001)).unwrap();
            assert_eq!(whole.spectrum, spectrum, "{count} wavelengths");
            assert!(whole.converged || whole.sweeps == 5001);
        }
    }

    #[test]
    fn bad_input_is_refused_with_the_reason() {
        let (grid, response) = sensor();
        let message = |rgb| refine_smits(&grid, &response, rgb, Stop::default()).unwrap_err().to_string();
        assert!(message([f64::NAN, 0.0, 0.0]).contains("colour: [NaN, 0.0, 0.0]"));
        assert!(message([f64::INFINITY, 0.0, 0.0]).contains("finite numbers up to 1e100"));
        assert!(message([-1.0, 0.0, 0.0]).contains("no light has this colour"));
        let start = vec![1.0; grid.len()];
        let refused = |start: &[f64], tolerance| {
            let stop = Stop { tolerance, ..Stop::default() };
            refine(response.rows(), start, [1.0; 3], stop).unwrap_err().to_string()
        };
        assert!(refused(&start[1..], 1e-3).contains("81 wavelengths is not valid; the start has 80"));
        assert!(refused(&vec![-1.0; 81], 1e-3).contains("start spectrum: -1"));
        assert!(refused(&start, f64::NAN).contains("tolerance: NaN"));
    }
}
