//! The dependence of the refractive index on wavelength.
//!
//! Wavelengths are nanometres in vacuum in every signature; the coefficients of the formulas are for micrometres, as in the
//! literature. The index of a transparent stone falls with wavelength (normal dispersion). [`Dispersion::check`] verifies
//! this over the range of use, which detects bad fits.
//!
//! ```
//! use spectral_core::dispersion::{Dispersion, fraunhofer};
//! // Diamond from measurements at three lines.
//! let lines = [[fraunhofer::B, 2.40728], [fraunhofer::D, 2.41726], [fraunhofer::G, 2.45173]];
//! let (diamond, warnings) = Dispersion::fit(&lines)?;
//! assert!(warnings.is_empty());
//! assert!(diamond.check([380.0, 780.0])?.is_empty());
//! assert!((diamond.index(fraunhofer::F) - 2.43554).abs() < 2e-4);
//! assert!((diamond.dispersion_bg() - 0.0444).abs() < 1e-4);
//! # Ok::<(), spectral_core::Error>(())
//! ```

mod cauchy;
pub mod fraunhofer;

use crate::spectrum::Tabulated;
use crate::{Error, Warning};

/// No transparent substance has a larger index in the visible; larger values indicate wrong units.
const LARGEST_INDEX: f64 = 10.0;

/// A model of the refractive index n(λ).
#[derive(Debug, Clone, PartialEq)]
pub enum Dispersion {
    /// The same index at every wavelength, at least 1.
    Constant(f64),
    /// Cauchy's series: n = A + B/λ² + C/λ⁴ + …, λ in µm; any number of coefficients, A first.
    ///
    /// [`Dispersion::fit`] makes one from measurements.
    Cauchy(Vec<f64>),
    /// Sellmeier's equation: n² = 1 + A₀ + Σ bᵢλ²/(λ² − cᵢ), λ in µm, cᵢ in µm² (squares of resonances).
    Sellmeier {
        /// A₀, the contribution of distant resonances; 0 in the textbook form.
        a0: f64,
        /// [bᵢ, cᵢ] for each resonance.
        terms: Vec<[f64; 2]>,
    },
    /// One pole and a polynomial: n² = A + B·N/(λ² − C) + Dλ², λ in µm, C in µm².
    Pole {
        /// A, dimensionless.
        a: f64,
        /// B: dimensionless where N = λ², µm² where N = 1.
        b: f64,
        /// C, µm².
        c: f64,
        /// D, µm⁻².
        d: f64,
        /// N = λ² rather than 1.
        squared_numerator: bool,
    },
    /// Measured indices, linearly interpolated; the ends extend.
    Table(Tabulated),
}

impl Dispersion {
    /// The index at a wavelength in nm.
    ///
    /// NaN if the model has no real index there; [`check`](Self::check) finds such wavelengths.
    pub fn index(&self, nm: f64) -> f64 {
        let square = um2(nm);
        match self {
            Dispersion::Constant(n) => *n,
            Dispersion::Cauchy(coefficients) => polynomial(coefficients, 1.0 / square),
            Dispersion::Sellmeier { a0, terms } => {
                let sum: f64 = terms.iter().map(|[b, c]| b * square / (square - c)).sum();
                (1.0 + a0 + sum).sqrt()
            }
            Dispersion::Pole { a, b, c, d, squared_numerator } => {
                let numerator = if *squared_numerator { square } else { 1.0 };
                (a + b * numerator / (square - c) + d * square).sqrt()
            }
            Dispersion::Table(table) => table.at(nm),
        }
    }

    /// dn/dλ in 1/nm, the derivative of the formula; for a table the slope of the segment.
    pub fn slope(&self, nm: f64) -> f64 {
        // With s = λ² in µm²: dn/dλ = (dn/ds)(ds/dλ), and ds/dλ = 2λ·10⁻³ µm²/nm.
        let s = um2(nm);
        let by_s = match self {
            Dispersion::Constant(_) => 0.0,
            Dispersion::Cauchy(coefficients) => {
                let t = 1.0 / s;
                let derivative: Vec<f64> =
                    coefficients.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect();
                -polynomial(&derivative, t) * t * t
            }
            Dispersion::Sellmeier { terms, .. } => {
                let sum: f64 = terms.iter().map(|[b, c]| -b * c / (s - c).powi(2)).sum();
                sum / (2.0 * self.index(nm))
            }
            Dispersion::Pole { b, c, d, squared_numerator, .. } => {
                let numerator = if *squared_numerator { *c } else { 1.0 };
                (d - b * numerator / (s - c).powi(2)) / (2.0 * self.index(nm))
            }
            Dispersion::Table(table) => return table_slope(table, nm),
        };
        by_s * 2.0 * nm * 1e-6
    }

    /// The Abbe number V_d = (n_d − 1)/(n_F − n_C); large for weak dispersion.
    pub fn abbe_number(&self) -> f64 {
        (self.index(fraunhofer::LOWER_D) - 1.0) / self.dispersion_cf()
    }

    /// The dispersion of gemmologists: n_G − n_B (0.044 for diamond).
    pub fn dispersion_bg(&self) -> f64 {
        self.index(fraunhofer::G) - self.index(fraunhofer::B)
    }

    /// The dispersion of opticians: n_F − n_C (0.025 for diamond).
    pub fn dispersion_cf(&self) -> f64 {
        self.index(fraunhofer::F) - self.index(fraunhofer::C)
    }

    /// Checks the model over the wavelengths (nm) of use.
    ///
    /// Warns of a table that ends inside the range or rises somewhere.
    ///
    /// # Errors
    /// [`Error::Value`] for a coefficient that is not finite, a resonance inside the range, or, anywhere in the range, an
    /// index that is at most 1 (below 1 for a constant), larger than that of any substance, or not falling with wavelength
    /// (except for tables and constants).
    pub fn check(&self, range: [f64; 2]) -> Result<Vec<Warning>, Error> {
        self.check_coefficients()?;
        self.check_resonances(range)?;
        let wavelengths = sweep(range)?;
        for &nm in &wavelengths {
            self.check_index(nm)?;
        }
        if let Dispersion::Table(table) = self {
            return Ok(table_warnings(table, range, &wavelengths));
        }
        if !self.is_constant()
            && let Some(nm) = wavelengths.into_iter().find(|&nm| self.slope(nm) >= 0.0)
        {
            let expected = format!(
                "a transparent stone's index falls as wavelength grows, over all of {}; check the figures, \
                 or give a table if they are meant",
                show(range)
            );
            return Err(Error::value(
                format!("slope of the index at {nm:.0} nm"),
                format!("{:.3e} per nm", self.slope(nm)),
                expected,
            ));
        }
        Ok(Vec::new())
    }

    /// Whether the index does not depend on the wavelength.
    fn is_constant(&self) -> bool {
        match self {
            Dispersion::Constant(_) => true,
            Dispersion::Cauchy(coefficients) => coefficients.iter().skip(1).all(|&c| c == 0.0),
            Dispersion::Sellmeier { terms, .. } => terms.iter().all(|[b, c]| b * c == 0.0),
            Dispersion::Pole { .. } | Dispersion::Table(_) => false,
        }
    }

    fn check_coefficients(&self) -> Result<(), Error> {
        let (what, coefficients) = match self {
            Dispersion::Constant(n) => ("index", vec![*n]),
            Dispersion::Cauchy(coefficients) => ("cauchy", coefficients.clone()),
            Dispersion::Sellmeier { a0, terms } => {
                ("sellmeier", std::iter::once(*a0).chain(terms.iter().flatten().copied()).collect())
            }
            Dispersion::Pole { a, b, c, d, .. } => ("pole", vec![*a, *b, *c, *d]),
            Dispersion::Table(_) => return Ok(()),
        };
        if coefficients.is_empty() {
            return Err(Error::value(what, "[]", "give at least one coefficient: [A, B, C] with λ in µm"));
        }
        match coefficients.into_iter().find(|c| !c.is_finite()) {
            Some(c) => Err(Error::value(what, c, "every coefficient must be a finite number")),
            None => Ok(()),
        }
    }

    fn check_resonances(&self, range: [f64; 2]) -> Result<(), Error> {
        let poles: Vec<f64> = match self {
            Dispersion::Sellmeier { terms, .. } => {
                terms.iter().filter(|[b, _]| *b != 0.0).map(|[_, c]| *c).collect()
            }
            Dispersion::Pole { b, c, .. } if *b != 0.0 => vec![*c],
            _ => Vec::new(),
        };
        let inside = |c: &f64| (range[0]..=range[1]).contains(&(c.max(0.0).sqrt() * 1e3));
        match poles.into_iter().find(inside) {
            Some(c) => Err(Error::value(
                "resonance c",
                format!("{c} µm² ({:.0} nm)", c.sqrt() * 1e3),
                format!(
                    "the index is infinite at a resonance, so none may lie within {}; c is the square of a \
                     wavelength in µm",
                    show(range)
                ),
            )),
            None => Ok(()),
        }
    }

    fn check_index(&self, nm: f64) -> Result<(), Error> {
        let n = self.index(nm);
        let fault = |expected: &str| Err(Error::value(format!("index at {nm:.0} nm"), n, expected));
        if !n.is_finite() {
            return fault("the formula gives no real index here; check its coefficients (λ in µm)");
        }
        if n > LARGEST_INDEX {
            return fault(
                "no gem's index exceeds 10; coefficients are for λ in µm, so B for nm must be divided by 10⁶",
            );
        }
        match self {
            Dispersion::Constant(_) if n < 1.0 => fault("an index is at least 1 (vacuum)"),
            Dispersion::Constant(_) => Ok(()),
            _ if n <= 1.0 => fault("an index must be greater than 1 at every wavelength rendered"),
            _ => Ok(()),
        }
    }
}

/// λ² in µm² from nm.
fn um2(nm: f64) -> f64 {
    let um = nm * 1e-3;
    um * um
}

/// Horner's rule, constant term first.
fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

fn table_slope(table: &Tabulated, nm: f64) -> f64 {
    let knots: Vec<(f64, f64)> = table.nm().iter().copied().zip(table.values().iter().copied()).collect();
    knots
        .windows(2)
        .find(|w| w[0].0 <= nm && nm <= w[1].0)
        .map_or(0.0, |w| (w[1].1 - w[0].1) / (w[1].0 - w[0].0))
}

fn table_warnings(table: &Tabulated, range: [f64; 2], wavelengths: &[f64]) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let (first, last) = (table.nm().first().copied(), table.nm().last().copied());
    if let (Some(first), Some(last)) = (first, last)
        && (range[0] < first || range[1] > last)
    {
        warnings.push(Warning::new(format!(
            "The index table covers {first}–{last} nm but {} is rendered; its end values are used beyond.",
            show(range)
        )));
    }
    let rise = wavelengths.windows(2).find(|w| table.at(w[1]) > table.at(w[0]));
    if let Some(w) = rise {
        warnings.push(Warning::new(format!(
            "The index table rises with wavelength at {:.0} nm; a transparent stone's index falls.",
            w[0]
        )));
    }
    warnings
}

/// Wavelengths every nanometre or finer through a range, both ends included.
fn sweep(range: [f64; 2]) -> Result<Vec<f64>, Error> {
    const MOST: f64 = 20_000.0;
    let [start, end] = range;
    if !(start > 0.0 && end >= start && end <= MOST) {
        return Err(Error::value(
            "wavelength range",
            show(range),
            "give two wavelengths in nm, the shorter first, such as [380, 740]",
        ));
    }
    let steps = (end - start).ceil().max(1.0) as usize;
    Ok((0..=steps).map(|i| start + (end - start) * i as f64 / steps as f64).collect())
}

fn show(range: [f64; 2]) -> String {
    format!("{}–{} nm", range[0], range[1])
}
