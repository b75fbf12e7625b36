//! Spectral maths for gemstones: what a stone does to light, wavelength by wavelength, and what an eye makes
//! of it. No files, no threads, no GPU: other programs can embed it.
//!
//! # The pipeline in a page
//!
//! **One ray, one wavelength.** What the eye sees along a ray is spectral radiance L(λ). Light paths can be
//! walked backwards, since a lossless interface conserves L/n² (Veach 1997, §5.2), so a tracer starts at the
//! eye with a throughput of 1 and asks at each surface how much comes from where.
//!
//! **Refraction.** The index n(λ) comes from [`dispersion`]: Sellmeier's n² = 1 + Σ bᵢλ²/(λ² − cᵢ), Cauchy's
//! n = A + B/λ² + C/λ⁴ fitted to measurements, or a table. Snell's law n₁ sin θ₁ = n₂ sin θ₂ then gives a
//! direction of its own to every wavelength: fire.
//!
//! **Reflection.** At an interface the amplitudes perpendicular (s) and parallel (p) to the plane of incidence
//! reflect by Fresnel's equations (Born & Wolf, *Principles of Optics*, §1.5), in [`fresnel`]:
//!
//! ```text
//! r_s = (n₁ cos θ₁ − n₂ cos θ₂)/(n₁ cos θ₁ + n₂ cos θ₂)      r_p = (n₂ cos θ₁ − n₁ cos θ₂)/(n₂ cos θ₁ + n₁ cos θ₂)
//! ```
//!
//! and 1 − |r|² goes on. Beyond the critical angle |r| = 1 and only the phases differ. The two polarisations
//! must be carried along: light that has met one surface is partly polarised when it meets the next. A path
//! therefore carries a row of four numbers, r = (1, 0, 0, 0)·M₁·M₂ ⋯, through the Mueller matrices of its
//! events ([`stokes`]); its first component is the throughput of unpolarised light. Averaging s and p at each
//! event instead, the classical shortcut, is offered as the scalar mode and is measurably wrong: an N-BK7
//! slab at 75° passes 0.592 that way, and 0.615 in truth.
//!
//! **Absorption.** Between two surfaces a length ℓ apart light fades by exp(−α(λ) ℓ), Beer and Lambert's law,
//! with the Napierian coefficient α in 1/mm ([`absorption`]): colour, and why large stones are darker.
//! [`material`] holds dispersion and absorption of gems and metals, each figure with its source.
//!
//! **Light.** The surroundings are usually an RGB photograph. A path asks for their radiance at one
//! wavelength, so each colour becomes a spectrum that shows that very colour ([`upsample`]): Smits's weighted
//! bases, refined by the iteration
//!
//! ```text
//! r₀ = Δλ Σ r̄(λᵢ) I(λᵢ)                                    (1)
//! I(λᵢ) ← max(0, I(λᵢ) + r̄(λᵢ)/(Δλ Σ r̄²) · (r − r₀))        (2)
//! ```
//!
//! for r, g and b in turn until the colour is right.
//!
//! **The eye.** Radiance at the wavelengths of a grid ([`wavelength`]) adds up to CIE XYZ = Σ x̄ȳz̄(λᵢ) L(λᵢ) Δλ
//! ([`cie`]), scaled so that daylight is white on that very grid, and from there to the RGB of any space
//! ([`color`]). A tracer follows every wavelength of the grid on its own and nothing is left to chance, so the
//! picture has no noise.
//!
//! ```
//! use spectral_core::{color::Response, fresnel::dielectric, material::Catalogue, cie::Illuminant};
//! use spectral_core::wavelength::WavelengthGrid;
//!
//! // The colour of daylight through a 5 mm window of ruby: two faces and what lies between them.
//! let ruby = Catalogue::builtin().get("ruby")?;
//! let grid = WavelengthGrid::midpoints([380.0, 740.0], 32)?;
//! let through: Vec<f64> = grid.nm().iter().map(|&nm| {
//!     let face = dielectric(1.0, 1.0 / ruby.index(nm)).transmittance();
//!     Illuminant::D65.at(nm) * face * face * (-ruby.absorption(nm) * 5.0).exp()
//! }).collect();
//! let [r, g, b] = Response::new(&grid)?.to_linear_srgb(&through);
//! assert!(r > 3.0 * g && r > 3.0 * b);
//! # Ok::<(), spectral_core::Error>(())
//! ```
//!
//! Conventions, throughout: lengths in mm, wavelengths in nm (µm inside dispersion formulas, as published),
//! right-handed frames, angles in radians unless a name or a file format says degrees, and fields as
//! exp(i(k·r − ωt)).
//!
#![cfg_attr(feature = "render", doc = include_str!("rendering.md"))]
#![forbid(unsafe_code)]

pub mod absorption;
pub mod cie;
pub mod color;
pub mod dispersion;
mod error;
pub mod fresnel;
pub mod material;
mod real;
pub mod spectrum;
pub mod stokes;
pub mod upsample;
mod warning;
pub mod wavelength;

#[cfg(feature = "render")]
pub mod camera;
#[cfg(feature = "render")]
pub mod cut;
#[cfg(feature = "render")]
pub mod environment;
#[cfg(feature = "render")]
pub mod film;
#[cfg(feature = "render")]
pub mod kernel;
#[cfg(feature = "render")]
pub mod lattice;
#[cfg(feature = "render")]
pub mod mesh;
#[cfg(feature = "render")]
pub mod prepare;
#[cfg(feature = "render")]
pub mod probe;
#[cfg(feature = "render")]
pub mod scene;
#[cfg(feature = "render")]
pub mod settings;
#[cfg(feature = "render")]
pub mod shape;
#[cfg(feature = "render")]
pub mod tracer;

pub use error::{Error, nearest_name};
pub use real::Real;
pub use warning::Warning;
