//! RGB → spectrum: light of a given colour.
//!
//! Environment images are RGB, but transport needs radiance at each wavelength. Infinitely many spectra have one colour.
//! The one wanted is smooth and non-negative, and has the colour *exactly*: otherwise the background would change its
//! colour in the renderer.
//!
//! **White is D65.** A texel (1, 1, 1) means daylight, so every spectrum here is a reflectance-like spectrum times
//! [`Illuminant::D65`]. (A flat spectrum has the colour (1.205, 0.948, 0.909).)
//!
//! 1. [`smits`]: seven simple spectra for white, the secondaries and the primaries, and a rule that writes every colour as
//!    a sum of three of them with non-negative weights. With real matching functions the colours are off by 5–8 %.
//! 2. [`refine`]: the iteration that changes a spectrum until its colour is right to any tolerance.
//! 3. [`Upsampler`]: both combined. The rule is linear in the bases and its weights are never negative. So if the seven
//!    bases are exact, every colour in sRGB is exact, and no spectrum is negative. The bases are refined to 10⁻¹² on the
//!    renderer's wavelengths when a scene is prepared. Textures stay RGB, and a look-up costs three products.
//!
//! ```
//! use spectral_core::{color::Response, upsample::Upsampler, wavelength::WavelengthGrid};
//! let grid = WavelengthGrid::midpoints([380.0, 740.0], 16)?;
//! let response = Response::new(&grid)?;
//! let upsampler = Upsampler::new(&grid, &response)?;
//! let sky = upsampler.spectrum([0.3, 0.5, 0.9]);
//! let rgb = response.to_linear_srgb(&sky);
//! assert!((rgb[0] - 0.3).abs() + (rgb[1] - 0.5).abs() + (rgb[2] - 0.9).abs() < 1e-11);
//! # Ok::<(), spectral_core::Error>(())
//! ```

mod gamut;
mod refine;
pub mod smits;

pub use gamut::Gamut;
pub use refine::{Refinement, Stop, refine, refine_smits};

use std::sync::LazyLock;

use crate::Error;
use crate::cie::Illuminant;
use crate::color::Response;
use crate::spectrum::{Ends, Tabulated};
use crate::wavelength::WavelengthGrid;

/// The number of bases. [`radiance`] mixes them; apart from it, only the basis modules of the backends (`basis.rs`,
/// `basis.wgsl`) depend on the meaning of each.
pub const BASES: usize = smits::COUNT;

/// The radiance of a linear sRGB colour at a wavelength, given that of the bases there.
///
/// Negative components give negative radiance; [`Gamut`] removes them.
pub fn radiance(rgb: [f64; 3], bases: &[f64; BASES]) -> f64 {
    smits::Weights::new(rgb).mix(bases)
}

/// The accuracy of the bases, and the largest summed error with which an inexact one is kept.
const BASIS_STOP: Stop = Stop { tolerance: 1e-12, max_sweeps: 40_000 };
const KEPT: f64 = 4e-3;

/// The bases refined at 5 nm over 380–780 nm, as reflectances, for grids that have no exact bases.
static DENSE: LazyLock<Vec<Tabulated>> =
    LazyLock::new(|| dense_bases().expect("the bases converge on the 5 nm grid"));

/// Exact, non-negative spectra for every colour in sRGB, on one wavelength grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Upsampler {
    nm: Vec<f64>,
    basis: [Vec<f64>; smits::COUNT],
    residuals: [f64; smits::COUNT],
}

impl Upsampler {
    /// Refines the seven bases on a grid with its response.
    ///
    /// White is D65 itself. On 380–740 nm, seven or more wavelengths allow exact bases at every jitter offset, and six allow
    /// bases exact to 10⁻⁶. With fewer, no non-negative light has the colour of a base at some offsets. If the summed error
    /// would exceed 0.4 %, this base is interpolated from a 5 nm grid: its radiance is then plausible at each wavelength,
    /// but its colour is right only in the mean over jittered grids. [`residual`](Self::residual) is the error.
    ///
    /// # Errors
    /// [`Error::Value`] if the response has another number of wavelengths.
    pub fn new(grid: &WavelengthGrid, response: &Response) -> Result<Self, Error> {
        let white = Illuminant::D65.sample(grid);
        let mut basis: [Vec<f64>; smits::COUNT] = Default::default();
        for (k, base) in basis.iter_mut().enumerate().skip(1) {
            let refined = refine_base(k, grid, response)?;
            let reflectance = if refined.residual <= KEPT { refined.spectrum } else { DENSE[k].sample(grid) };
            *base = reflectance.iter().zip(&white).map(|(r, light)| r * light).collect();
        }
        basis[0] = white;
        let residuals = std::array::from_fn(|k| residual(response, &basis[k], smits::COLORS[k]));
        Ok(Upsampler { nm: grid.nm().to_vec(), basis, residuals })
    }

    /// The same spectra under another light: each times illuminant / D65, so a grey is exactly grey × illuminant.
    #[must_use]
    pub fn with_illuminant(mut self, illuminant: &Illuminant) -> Self {
        for (i, &nm) in self.nm.iter().enumerate() {
            let (old, new) = (self.basis[0][i], illuminant.at(nm));
            for base in &mut self.basis[1..] {
                base[i] *= new / old;
            }
            self.basis[0][i] = new;
        }
        self
    }

    /// The seven bases at the grid's wavelengths, in the order of [`smits::COLORS`]: spectral radiance for one
    /// unit of [`Weights`](smits::Weights).
    pub fn basis(&self) -> &[Vec<f64>; smits::COUNT] {
        &self.basis
    }

    /// The spectral radiance of a linear-sRGB colour at wavelength number `i`; zero beyond the grid.
    ///
    /// Negative components give negative radiance; [`Gamut`] removes them.
    pub fn radiance(&self, rgb: [f64; 3], i: usize) -> f64 {
        radiance(rgb, &self.basis.each_ref().map(|base| base.get(i).copied().unwrap_or_default()))
    }

    /// [`radiance`](Self::radiance) at every wavelength of the grid.
    pub fn spectrum(&self, rgb: [f64; 3]) -> Vec<f64> {
        (0..self.nm.len()).map(|i| self.radiance(rgb, i)).collect()
    }

    /// The largest summed error Σ|δ_c| of a base's colour under D65. The weights of a colour add up to its largest
    /// component, so its error is at most this share of that component.
    pub fn residual(&self) -> f64 {
        self.residuals.into_iter().fold(0.0, f64::max)
    }

    /// Whether every colour in sRGB is reproduced to 10⁻¹¹.
    pub fn exact(&self) -> bool {
        self.residual() <= 1e-11
    }
}

/// Σ|δ_c| of a spectrum against its intended colour, whose largest component is 1.
fn residual(response: &Response, spectrum: &[f64], rgb: [f64; 3]) -> f64 {
    response.to_linear_srgb(spectrum).iter().zip(rgb).map(|(shown, wanted)| (shown - wanted).abs()).sum()
}

/// Base `k` as a reflectance that has its colour in the light of D65.
///
/// The reflectance is refined under the rows A_c·D65, not its product with D65 under the rows A_c. So it deviates from
/// Smits's in proportion to the light, and the structure of D65 is preserved.
fn refine_base(k: usize, grid: &WavelengthGrid, response: &Response) -> Result<Refinement, Error> {
    let light = Illuminant::D65.sample(grid);
    let lit = response.rows().map(|row| row.iter().zip(&light).map(|(a, l)| a * l).collect::<Vec<f64>>());
    let start: Vec<f64> = grid.nm().iter().map(|&nm| smits::boxes(nm)[k]).collect();
    refine(lit.each_ref().map(Vec::as_slice), &start, smits::COLORS[k], BASIS_STOP)
}

fn dense_bases() -> Result<Vec<Tabulated>, Error> {
    let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0)?;
    let response = Response::new(&grid)?;
    (0..smits::COUNT)
        .map(|k| {
            let refined = refine_base(k, &grid, &response)?;
            Tabulated::new(grid.nm().to_vec(), refined.spectrum, Ends::Extend)
        })
        .collect()
}
