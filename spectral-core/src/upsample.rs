//! RGB → spectrum: light that shows a given colour.
//!
//! A picture of the surroundings is RGB, and transport needs radiance at each wavelength. Infinitely many
//! spectra show one colour; wanted is a non-negative, plain one that shows it *exactly*, for otherwise the
//! background itself would change colour on its way through the renderer.
//!
//! **White is D65.** A texel (1, 1, 1) means daylight, so everything here is light: a reflectance-like
//! spectrum times [`Illuminant::D65`]. (A flat spectrum would show as (1.205, 0.948, 0.909).)
//!
//! 1. [`smits`]: seven plain spectra for white, the secondaries and the primaries, and a rule that writes every
//!    colour as a sum of three of them with non-negative weights. Through real matching functions they come
//!    out 5–8 % wrong.
//! 2. [`refine`]: the iteration that moves a spectrum until its colour is right to any tolerance.
//! 3. [`Upsampler`]: the two combined once for good. The rule is linear in the bases and its weights are never
//!    negative, so if each of the seven bases is exact, so is every colour in sRGB, and no spectrum is negative.
//!    The seven are refined to 10⁻¹² on the renderer's own wavelengths when a scene is prepared; textures stay
//!    RGB, and a look-up costs three products.
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

/// How many bases there are. [`radiance`] says how a colour is made of them. Beside it, only the basis modules of the
/// backends (`basis.rs`, `basis.wgsl`) know what each of them stands for.
pub const BASES: usize = smits::COUNT;

/// The radiance of a linear sRGB colour at a wavelength, given that of the bases there.
///
/// Colours must not be negative ([`Gamut`] sees to that): negative components give negative radiance.
pub fn radiance(rgb: [f64; 3], bases: &[f64; BASES]) -> f64 {
    smits::Weights::new(rgb).mix(bases)
}

/// How exactly the bases should show their colours, and the summed error up to which one is kept that stopped
/// short of it.
const BASIS_STOP: Stop = Stop { tolerance: 1e-12, max_sweeps: 40_000 };
const KEPT: f64 = 4e-3;

/// The bases refined at 5 nm over 380–780 nm, as reflectances, for grids that cannot carry their own.
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
    /// Refines the seven bases on a grid with its sensor.
    ///
    /// White is D65 itself. On 380–740 nm seven or more wavelengths carry exact bases at every jitter offset,
    /// six carry them to 10⁻⁶. With fewer, some offsets show no non-negative light of a base's colour; where
    /// the summed error would exceed 0.4 %, that base is taken from a 5 nm grid and interpolated. Its radiance
    /// is then sensible at each wavelength and its colour right in the mean over jittered grids only:
    /// [`residual`](Self::residual) tells by how much.
    ///
    /// # Errors
    /// [`Error::Value`] if the response belongs to a grid of another size.
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

    /// The same spectra under another light: each times illuminant / D65, so that a grey is exactly grey ×
    /// illuminant.
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
    /// Colours must not be negative ([`Gamut`] sees to that): negative components give negative radiance.
    pub fn radiance(&self, rgb: [f64; 3], i: usize) -> f64 {
        radiance(rgb, &self.basis.each_ref().map(|base| base.get(i).copied().unwrap_or_default()))
    }

    /// [`radiance`](Self::radiance) at every wavelength of the grid.
    pub fn spectrum(&self, rgb: [f64; 3]) -> Vec<f64> {
        (0..self.nm.len()).map(|i| self.radiance(rgb, i)).collect()
    }

    /// The largest summed error Σ|δ_c| of a base's colour under D65. As the weights of a colour add up to its
    /// largest component, no colour's error exceeds this share of that component.
    pub fn residual(&self) -> f64 {
        self.residuals.into_iter().fold(0.0, f64::max)
    }

    /// Whether every colour in sRGB comes back to within 10⁻¹¹.
    pub fn exact(&self) -> bool {
        self.residual() <= 1e-11
    }
}

/// Σ|δ_c| of a spectrum against the colour it should show, whose largest component is 1.
fn residual(response: &Response, spectrum: &[f64], rgb: [f64; 3]) -> f64 {
    response.to_linear_srgb(spectrum).iter().zip(rgb).map(|(shown, wanted)| (shown - wanted).abs()).sum()
}

/// Base `k` as a reflectance that shows its colour in the light of D65.
///
/// Refining Smits's reflectance under the rows A_c·D65, instead of its product with D65 under the rows A_c, lets
/// the base deviate from his in proportion to the light, so that none of D65's own structure is worn off.
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
