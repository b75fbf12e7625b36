//! Spectral maths for gemstones: how a stone changes light at each wavelength, and how an eye perceives the result. It
//! uses no files, threads or GPU, so other programs can embed it.
//!
//! # The pipeline
//!
//! **One ray, one wavelength.** The eye sees spectral radiance L(λ) along a ray. Light paths can be followed backwards,
//! since a lossless interface conserves L/n² (Veach 1997, §5.2). So a tracer starts at the eye with a throughput of 1 and
//! determines at each surface how much light comes from each direction.
//!
//! **Refraction.** The index n(λ) comes from [`dispersion`]: Sellmeier's n² = 1 + Σ bᵢλ²/(λ² − cᵢ), Cauchy's n = A + B/λ²
//! + C/λ⁴ fitted to measurements, or a table. By Snell's law n₁ sin θ₁ = n₂ sin θ₂ every wavelength has its own direction;
//! gemmologists call the effect fire.
//!
//! **Reflection.** At an interface the amplitudes perpendicular (s) and parallel (p) to the plane of incidence follow
//! Fresnel's equations (Born & Wolf, *Principles of Optics*, §1.5), in [`fresnel`]:
//!
//! ```text
//! r_s = (n₁ cos θ₁ − n₂ cos θ₂)/(n₁ cos θ₁ + n₂ cos θ₂)      r_p = (n₂ cos θ₁ − n₁ cos θ₂)/(n₂ cos θ₁ + n₁ cos θ₂)
//! ```
//!
//! and 1 − |r|² is refracted. Beyond the critical angle |r| = 1 and only the phases differ. Polarisation must be followed
//! from surface to surface, because light that has met one surface is partly polarised when it meets the next. A path
//! therefore carries a row of four numbers, r = (1, 0, 0, 0)·M₁·M₂ ⋯, through the Mueller matrices of its events
//! ([`stokes`]); the first component is the throughput of unpolarised light. The scalar mode takes the mean of s and p at
//! each event instead, as renderers usually do. It is measurably wrong: an N-BK7 slab at 75° then transmits 0.592 and not
//! 0.615.
//!
//! **Absorption.** Between two surfaces at distance ℓ light is attenuated by exp(−α(λ) ℓ), the law of Beer and Lambert,
//! with the Napierian coefficient α in 1/mm ([`absorption`]). This gives a stone its colour and makes large stones darker.
//! [`material`] has dispersion and absorption of gems and metals, each figure with its source.
//!
//! **Light.** The environment is usually an RGB photograph. A path needs its radiance at one wavelength, so each colour is
//! converted to a spectrum that shows exactly this colour ([`upsample`]): Smits's weighted bases, refined by the iteration
//!
//! ```text
//! r₀ = Δλ Σ r̄(λᵢ) I(λᵢ)                                    (1)
//! I(λᵢ) ← max(0, I(λᵢ) + r̄(λᵢ)/(Δλ Σ r̄²) · (r − r₀))        (2)
//! ```
//!
//! for r, g and b in turn until the colour is exact.
//!
//! **The eye.** Radiance at the wavelengths of a grid ([`wavelength`]) gives CIE XYZ = Σ x̄ȳz̄(λᵢ) L(λᵢ) Δλ ([`cie`]), scaled
//! so that daylight is white on this grid, and then RGB in any space ([`color`]). A tracer follows every wavelength of the
//! grid separately and uses no random numbers, so the picture has no noise.
//!
//! ```
//! use spectral_core::{color::Response, fresnel::dielectric, material::Catalogue, cie::Illuminant};
//! use spectral_core::wavelength::WavelengthGrid;
//!
//! // The colour of daylight through a 5 mm window of ruby: two surfaces and the absorption between them.
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
//! Conventions: lengths in mm, wavelengths in nm (µm in dispersion formulas, as published), right-handed frames, angles in
//! radians unless a name or a file format says degrees, fields as exp(i(k·r − ωt)).
//!
#![cfg_attr(feature = "render", doc = include_str!("rendering.md"))]
#![forbid(unsafe_code)]

pub mod absorption;
pub mod cie;
pub mod color;
pub mod crystal;
pub mod dispersion;
mod error;
pub mod fresnel;
pub mod material;
pub mod memory;
mod real;
mod shown;
pub mod spectrum;
pub mod stokes;
pub mod upsample;
mod warning;
pub mod wavelength;

#[cfg(feature = "render")]
pub mod beam;
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
pub use shown::{printable, shown, shown_lines};
pub use warning::Warning;
