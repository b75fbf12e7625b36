//! Colour by absorption.
//!
//! Coefficients are Napierian and per millimetre: a length ℓ transmits exp(−αℓ) (Beer and Lambert). The literature often
//! has decadic absorbance A or cm⁻¹: α = ln 10 · A/ℓ, and 1 cm⁻¹ = 0.1 mm⁻¹.
//!
//! ```
//! use spectral_core::absorption::{Absorption, Term};
//! let pink = Absorption::new(vec![
//!     Term::Gaussian { centre: 553.0, sigma: 38.0, peak: 0.9 },
//!     Term::Constant(0.015),
//! ])?;
//! assert!((pink.coefficient(553.0) - 0.915).abs() < 1e-15);
//! assert!((pink.transmittance(553.0, 2.0) - (-1.83_f64).exp()).abs() < 1e-15);
//! # Ok::<(), spectral_core::Error>(())
//! ```

mod colour;

use crate::Error;
use crate::spectrum::Tabulated;

/// One term of an absorption spectrum. Peaks and constants are in 1/mm and not negative.
#[derive(Debug, Clone, PartialEq)]
pub enum Term {
    /// The same at every wavelength, 1/mm.
    Constant(f64),
    /// A Gaussian in wavelength: peak · exp(−((λ − centre)/sigma)²/2).
    Gaussian {
        /// Wavelength of the maximum, nm.
        centre: f64,
        /// Standard deviation, nm.
        sigma: f64,
        /// Coefficient at the maximum, 1/mm.
        peak: f64,
    },
    /// A Gaussian in wavenumber ν = 10⁷/λ, as spectroscopists fit broad bands:
    /// peak · exp(−4 ln 2 ((ν − ν₀)/fwhm)²).
    GaussianWavenumber {
        /// Wavelength of the maximum, nm; ν₀ = 10⁷/centre.
        centre: f64,
        /// Full width at half maximum, cm⁻¹.
        fwhm_cm1: f64,
        /// Coefficient at the maximum, 1/mm.
        peak: f64,
    },
    /// A measured curve, 1/mm.
    Table(Tabulated),
}

impl Term {
    /// The coefficient in 1/mm at a wavelength in nm.
    pub fn coefficient(&self, nm: f64) -> f64 {
        match self {
            Term::Constant(value) => *value,
            Term::Gaussian { centre, sigma, peak } => peak * (-0.5 * ((nm - centre) / sigma).powi(2)).exp(),
            Term::GaussianWavenumber { centre, fwhm_cm1, peak } => {
                let offset = (1e7 / nm - 1e7 / centre) / fwhm_cm1;
                peak * (-4.0 * std::f64::consts::LN_2 * offset * offset).exp()
            }
            Term::Table(table) => table.at(nm),
        }
    }

    fn scaled(self, factor: f64) -> Self {
        match self {
            Term::Constant(value) => Term::Constant(value * factor),
            Term::Gaussian { centre, sigma, peak } => Term::Gaussian { centre, sigma, peak: peak * factor },
            Term::GaussianWavenumber { centre, fwhm_cm1, peak } => {
                Term::GaussianWavenumber { centre, fwhm_cm1, peak: peak * factor }
            }
            Term::Table(table) => Term::Table(table.scaled(factor)),
        }
    }

    fn check(&self, what: &str) -> Result<(), Error> {
        let valid = |name: &str, value: f64, valid: bool, expected: &str| match valid && value.is_finite() {
            true => Ok(()),
            false => Err(Error::value(format!("{what}.{name}"), value, expected)),
        };
        let amount = |name: &str, value: f64| {
            valid(name, value, value >= 0.0, "give a finite number of at least 0, in 1/mm")
        };
        let width = |name: &str, value: f64, unit: &str| {
            valid(name, value, value > 0.0, &format!("give a number above 0, in {unit}"))
        };
        match self {
            Term::Constant(value) => amount("constant", *value),
            Term::Gaussian { centre, sigma, peak } => {
                width("centre", *centre, "nm")?;
                width("sigma", *sigma, "nm")?;
                amount("peak", *peak)
            }
            Term::GaussianWavenumber { centre, fwhm_cm1, peak } => {
                width("centre", *centre, "nm")?;
                width("fwhm_cm1", *fwhm_cm1, "cm⁻¹")?;
                amount("peak", *peak)
            }
            Term::Table(table) => {
                let negative = table.nm().iter().zip(table.values()).find(|(_, value)| **value < 0.0);
                negative.map_or(Ok(()), |(nm, value)| {
                    Err(Error::value(
                        format!("{what} at {nm} nm"),
                        value,
                        "a stone cannot add light: absorption is at least 0 everywhere (1/mm)",
                    ))
                })
            }
        }
    }
}

/// An absorption spectrum: a sum of [`Term`]s. The default is a colourless stone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Absorption {
    terms: Vec<Term>,
}

impl Absorption {
    /// The sum of `terms`; without terms a colourless stone.
    ///
    /// # Errors
    /// [`Error::Value`] naming the first term that is negative, not finite or has no width.
    pub fn new(terms: Vec<Term>) -> Result<Self, Error> {
        for (i, term) in terms.iter().enumerate() {
            term.check(&format!("absorption[{i}]"))?;
        }
        Ok(Absorption { terms })
    }

    /// The mean of the three axes of a crystal; three times the same comes out as it is.
    pub(crate) fn mean(axes: [&Absorption; 3]) -> Self {
        if axes.iter().all(|axis| *axis == axes[0]) {
            return axes[0].clone();
        }
        let third = |term: &Term| term.clone().scaled(1.0 / 3.0);
        Absorption { terms: axes.iter().flat_map(|axis| &axis.terms).map(third).collect() }
    }

    /// The terms.
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// Whether there are no terms, so that nothing is absorbed.
    pub fn is_none(&self) -> bool {
        self.terms.is_empty()
    }

    /// The Napierian coefficient α in 1/mm at a wavelength in nm.
    pub fn coefficient(&self, nm: f64) -> f64 {
        // A fold rather than `sum`, whose zero is -0.0.
        self.terms.iter().fold(0.0, |sum, term| sum + term.coefficient(nm))
    }

    /// The share of light transmitted through `length_mm`: exp(−αℓ).
    pub fn transmittance(&self, nm: f64, length_mm: f64) -> f64 {
        (-self.coefficient(nm) * length_mm).exp()
    }
}
