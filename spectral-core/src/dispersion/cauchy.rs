//! Fit of Cauchy's series to measured indices.

use super::{Dispersion, LARGEST_INDEX, um2};
use crate::{Error, Warning};

/// Wavelengths of measurements, in nm; others indicate wrong units.
const MEASURABLE: std::ops::RangeInclusive<f64> = 200.0..=2000.0;
/// Lines at a smaller distance, in nm, do not determine the curvature.
const SPACING: f64 = 20.0;
/// A fit without a measurement below this extrapolates the violet, in nm.
const VIOLET: f64 = 450.0;
/// A larger residual is a wrong figure rather than a measurement error.
const RESIDUAL: f64 = 1e-3;

impl Dispersion {
    /// Cauchy's n = A + B/λ² + C/λ⁴ through three measurements [nm, n], or least squares through more.
    ///
    /// With measurements at B, D and G it is within 1.2e-4 of diamond's Sellmeier curve over 380–780 nm, within 6e-4 of
    /// corundum's and within 4.5e-4 of N-BK7's. With C, D and F, measurement errors are amplified four times more at
    /// 380 nm. Substances that absorb in the violet (rutile) need a [`Dispersion::Sellmeier`].
    ///
    /// The fit uses t = 1/λ² mapped to [−1, 1], where the columns are nearly orthogonal, and an orthogonal decomposition
    /// (Givens rotations; Golub & Van Loan, *Matrix Computations*, §5.2.5).
    ///
    /// Warns if there is no measurement below 450 nm, or if the curve misses one by more than 1e-3.
    ///
    /// # Errors
    /// [`Error::Value`] naming the measurement if it is not finite, outside 200–2000 nm, has an index of at most 1 or a
    /// wavelength given twice; or if fewer than three measurements are 20 nm apart. [`Dispersion::check`] tells whether the
    /// curve is plausible on the wavelengths rendered.
    pub fn fit(measured: &[[f64; 2]]) -> Result<(Self, Vec<Warning>), Error> {
        check_measurements(measured)?;
        let inverse_squares = measured.iter().map(|&[nm, _]| 1.0 / um2(nm));
        let low = inverse_squares.clone().fold(f64::INFINITY, f64::min);
        let high = inverse_squares.fold(0.0, f64::max);
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let rows = measured.iter().map(|&[nm, n]| {
            let u = (1.0 / um2(nm) - middle) / half;
            (std::array::from_fn(|k| u.powi(k as i32)), n)
        });
        let in_u = least_squares::<3>(rows);
        let dispersion = Dispersion::Cauchy(substitute(in_u, middle, half));
        let warnings = warnings(&dispersion, measured);
        Ok((dispersion, warnings))
    }
}

fn check_measurements(measured: &[[f64; 2]]) -> Result<(), Error> {
    for (i, &[nm, n]) in measured.iter().enumerate() {
        check_measurement(nm, n)
            .map_err(|expected| Error::value(format!("measured[{i}]"), format!("[{nm}, {n}]"), expected))?;
        if let Some(j) = measured.iter().take(i).position(|m| m[0] == nm) {
            let expected = format!("measured[{j}] has the same wavelength; give each once");
            return Err(Error::value(format!("measured[{i}]"), format!("[{nm}, {n}]"), expected));
        }
    }
    if measured.len() < 3 {
        let expected = "Cauchy's formula needs three or more, for instance at the lines B (686.72 nm), \
                        D (589.29 nm) and G (430.79 nm); for fewer give `cauchy` or `index`";
        return Err(Error::value("measured", format!("{} measurements", measured.len()), expected));
    }
    check_spacing(measured)
}

fn check_measurement(nm: f64, n: f64) -> Result<(), String> {
    if !nm.is_finite() || !n.is_finite() {
        return Err("both figures must be finite numbers: [wavelength in nm, index]".to_owned());
    }
    if !MEASURABLE.contains(&nm) {
        let hint = if MEASURABLE.contains(&n) {
            "; the wavelength comes first: [nm, index]".to_owned()
        } else if MEASURABLE.contains(&(nm * 1e3)) {
            format!("; this looks like micrometres: {nm} µm = {} nm", nm * 1e3)
        } else if MEASURABLE.contains(&(nm * 0.1)) {
            format!("; this looks like ångströms: {nm} Å = {} nm", nm * 0.1)
        } else {
            String::new()
        };
        return Err(format!("wavelengths are in nm, from 200 to 2000{hint}"));
    }
    if n <= 1.0 || n > LARGEST_INDEX {
        return Err(format!("an index of refraction is greater than 1 (and below {LARGEST_INDEX})"));
    }
    Ok(())
}

/// Three measurements must be 20 nm apart; others between them do not harm a least-squares fit.
fn check_spacing(measured: &[[f64; 2]]) -> Result<(), Error> {
    let mut wavelengths: Vec<f64> = measured.iter().map(|m| m[0]).collect();
    wavelengths.sort_by(f64::total_cmp);
    let mut apart = 0;
    let mut last = f64::NEG_INFINITY;
    for &nm in &wavelengths {
        if nm - last >= SPACING {
            apart += 1;
            last = nm;
        }
    }
    if apart >= 3 {
        return Ok(());
    }
    let gap = |w: &&[f64]| w[1] - w[0];
    let nearest = wavelengths.windows(2).min_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or(&[]);
    let shown: Vec<String> = nearest.iter().map(|nm| format!("{nm} nm")).collect();
    Err(Error::value(
        "measured",
        shown.join(" and "),
        "at least three wavelengths must be 20 nm apart or more, or errors of measurement take over",
    ))
}

fn warnings(fit: &Dispersion, measured: &[[f64; 2]]) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let shortest = measured.iter().map(|m| m[0]).fold(f64::INFINITY, f64::min);
    if shortest >= VIOLET {
        warnings.push(Warning::new(format!(
            "The shortest wavelength measured is {shortest} nm: the index in the violet is extrapolated; add a \
             measurement below {VIOLET} nm, such as the line G (430.79 nm)."
        )));
    }
    let residual = |m: &[f64; 2]| (fit.index(m[0]) - m[1]).abs();
    let worst = measured.iter().max_by(|a, b| residual(a).total_cmp(&residual(b)));
    if let Some(m) = worst.filter(|m| residual(m) > RESIDUAL) {
        warnings.push(Warning::new(format!(
            "The fitted curve misses the index measured at {} nm, {}, by {:.4}; check that figure.",
            m[0],
            m[1],
            residual(m)
        )));
    }
    warnings
}

/// The x that minimises |Ax − b|, from the rows of (A | b), by Givens rotations to an upper triangle. A must have full
/// column rank, as it has for distinct wavelengths.
fn least_squares<const N: usize>(rows: impl Iterator<Item = ([f64; N], f64)>) -> [f64; N] {
    let mut triangle = [[0.0_f64; N]; N];
    let mut rhs = [0.0; N];
    for (mut row, mut b) in rows {
        for k in 0..N {
            let radius = triangle[k][k].hypot(row[k]);
            if radius == 0.0 {
                continue;
            }
            let (cos, sin) = (triangle[k][k] / radius, row[k] / radius);
            for j in k..N {
                (triangle[k][j], row[j]) =
                    (cos * triangle[k][j] + sin * row[j], cos * row[j] - sin * triangle[k][j]);
            }
            (rhs[k], b) = (cos * rhs[k] + sin * b, cos * b - sin * rhs[k]);
        }
    }
    let mut x = [0.0; N];
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|j| triangle[k][j] * x[j]).sum();
        x[k] = (rhs[k] - known) / triangle[k][k];
    }
    x
}

/// The coefficients in t of a polynomial in u = (t − middle)/half, by Horner's rule on polynomials.
fn substitute<const N: usize>(in_u: [f64; N], middle: f64, half: f64) -> Vec<f64> {
    let mut in_t = vec![0.0; N];
    for &coefficient in in_u.iter().rev() {
        for k in (0..N).rev() {
            let shifted = if k > 0 { in_t[k - 1] } else { 0.0 };
            in_t[k] = (shifted - middle * in_t[k]) / half;
        }
        in_t[0] += coefficient;
    }
    in_t
}

#[cfg(test)]
mod tests {
    use super::super::polynomial;
    use super::*;

    #[test]
    fn least_squares_solves_the_normal_equations() {
        let points = [(0.0, 1.0), (1.0, 3.0), (2.0, 4.0), (3.0, 4.5)];
        let [a, b] = least_squares(points.iter().map(|&(x, y)| ([1.0, x], y)));
        // Σx = 6, Σx² = 14, Σy = 12.5, Σxy = 24.5, by hand.
        assert!((b - (4.0 * 24.5 - 6.0 * 12.5) / (4.0 * 14.0 - 36.0)).abs() < 1e-14);
        assert!((a - (12.5 - 6.0 * b) / 4.0).abs() < 1e-14);
    }

    #[test]
    fn substitution_keeps_the_polynomial() {
        let in_u = [1.5, -0.25, 0.125];
        let in_t = substitute(in_u, 3.0, 0.5);
        for t in [2.5, 2.9, 3.4] {
            let u = (t - 3.0) / 0.5;
            assert!((polynomial(&in_t, t) - polynomial(&in_u, u)).abs() < 1e-13);
        }
    }
}
