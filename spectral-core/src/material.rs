//! What stones and settings are made of: dispersion and absorption, or a metal's complex index.
//!
//! [`Catalogue::builtin`] holds the materials that come with the crate, each from a data file that names the
//! source of every figure. [`MaterialSpec`] is the same description as a scene's own `[material.NAME]` table
//! gives it; its [`build`](MaterialSpec::build) checks the figures and fits what needs fitting.
//!
//! A doubly refracting crystal has further [`axes`](Material::axes); [`Material::isotropic`] is the same stone with one index.
//!
//! ```
//! use spectral_core::material::{Catalogue, MaterialSpec};
//! let diamond = Catalogue::builtin().get("diamond")?;
//! assert!((diamond.index(589.29) - 2.41726).abs() < 1e-5);
//!
//! let spec: MaterialSpec = toml::from_str(
//!     "cauchy = [1.5046, 0.0042]\nabsorption = [{ centre = 553.0, sigma = 38.0, peak = 0.9 }]",
//! ).unwrap();
//! let (glass, _) = spec.build("pink-glass", |file| panic!("no file was named, yet {file} is wanted"))?;
//! assert!((glass.index(589.29) - (1.5046 + 0.0042 / 0.58929_f64.powi(2))).abs() < 1e-12);
//! # Ok::<(), spectral_core::Error>(())
//! ```

mod catalogue;
mod spec;

pub use catalogue::Catalogue;
pub use spec::{AbsorptionSpec, BandSpec, ColorSpec, ConductorSpec, MaterialSpec, PoleSpec, SellmeierSpec};

use crate::absorption::Absorption;
use crate::dispersion::{Dispersion, fraunhofer};
use crate::spectrum::Tabulated;
use crate::{Error, Warning, shown};

/// What light does in a substance.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// Transparent, perhaps coloured.
    Dielectric {
        /// The refractive index.
        dispersion: Dispersion,
        /// The colour.
        absorption: Absorption,
    },
    /// Opaque, with the index n + ik (fields as exp(−iωt), so k > 0 absorbs).
    Conductor {
        /// n over nm.
        n: Tabulated,
        /// k over nm.
        k: Tabulated,
    },
}

/// Where a figure comes from.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Which figure: `"dispersion"`, `"absorption"`, `"density"`.
    pub figure: String,
    /// The publication, and the collection it was read in.
    pub source: String,
    /// The licence under which the figure was published.
    pub licence: String,
    /// The wavelengths in nm that the source covers, if it says so; elsewhere the figure is extrapolated.
    #[serde(default)]
    pub range: Option<[f64; 2]>,
    /// Whether the figure is a rough guide rather than a measurement.
    #[serde(default)]
    pub approximate: bool,
}

/// The optics along one more axis of a crystal.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// The refractive index of light polarised along it.
    pub dispersion: Dispersion,
    /// The absorption of this light.
    pub absorption: Absorption,
}

/// A substance, ready to be rendered.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name it is called by in scenes.
    pub name: String,
    /// Its optics.
    pub kind: Kind,
    /// The further axes of a doubly refracting crystal: the optic axis of a uniaxial one, whose `kind` is then the ordinary
    /// ray's; y and z of a biaxial one, whose `kind` is x's. None for what is isotropic.
    pub axes: Vec<Axis>,
    /// Density in g/cm³, for weights.
    pub density: Option<f64>,
    /// Which ray the index of `kind` belongs to: `"isotropic"`, `"ordinary"`, `"alpha"`, `"beta"`; empty for a scene's own.
    pub ray: String,
    /// What one should know before relying on it.
    pub notes: Vec<String>,
    /// Where each figure comes from; empty for a scene's own.
    pub sources: Vec<Source>,
}

impl Material {
    /// A material of which only the optics are known.
    pub fn new(name: impl Into<String>, kind: Kind) -> Self {
        let (notes, sources) = (Vec::new(), Vec::new());
        Material {
            name: name.into(),
            kind,
            axes: Vec::new(),
            density: None,
            ray: String::new(),
            notes,
            sources,
        }
    }

    /// The refractive index at a wavelength in nm; of a metal the real part.
    pub fn index(&self, nm: f64) -> f64 {
        match &self.kind {
            Kind::Dielectric { dispersion, .. } => dispersion.index(nm),
            Kind::Conductor { n, .. } => n.at(nm),
        }
    }

    /// The imaginary part k of a metal's index at a wavelength in nm; 0 for a transparent material, whose
    /// absorption is far too weak to change its reflectance.
    pub fn extinction(&self, nm: f64) -> f64 {
        match &self.kind {
            Kind::Dielectric { .. } => 0.0,
            Kind::Conductor { k, .. } => k.at(nm),
        }
    }

    /// The Napierian absorption coefficient in 1/mm at a wavelength in nm: 4πk/λ for a metal.
    pub fn absorption(&self, nm: f64) -> f64 {
        match &self.kind {
            Kind::Dielectric { absorption, .. } => absorption.coefficient(nm),
            Kind::Conductor { k, .. } => 4.0 * std::f64::consts::PI * k.at(nm) / (nm * 1e-6),
        }
    }

    /// Whether it is a doubly refracting crystal.
    pub fn is_crystal(&self) -> bool {
        !self.axes.is_empty()
    }

    /// The refractive index along each axis of the crystal, the optic axis of a uniaxial one last; three times the same
    /// if it is isotropic.
    pub fn indices(&self, nm: f64) -> [f64; 3] {
        self.by_axis(self.index(nm), |axis| axis.dispersion.index(nm))
    }

    /// The absorption coefficient in 1/mm along each axis, as [`indices`](Self::indices).
    pub fn absorptions(&self, nm: f64) -> [f64; 3] {
        self.by_axis(self.absorption(nm), |axis| axis.absorption.coefficient(nm))
    }

    /// What the crystal's axes are called: o and e, or x, y and z; with their place in [`indices`](Self::indices). None of
    /// what is isotropic.
    pub fn axis_names(&self) -> &'static [(&'static str, usize)] {
        match self.axes.len() {
            0 => &[],
            1 => &[("o", 0), ("e", 2)],
            _ => &[("x", 0), ("y", 1), ("z", 2)],
        }
    }

    /// The same with one index and one absorption: the index of a uniaxial crystal's ordinary ray, of a biaxial one's middle
    /// axis at 589.3 nm (β), and the mean absorption of the three axes.
    ///
    /// ```
    /// use spectral_core::{dispersion::fraunhofer, material::Catalogue};
    /// let quartz = Catalogue::builtin().get("quartz")?;
    /// assert_eq!(quartz.isotropic().index(fraunhofer::D), quartz.indices(fraunhofer::D)[0]);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    #[must_use]
    pub fn isotropic(&self) -> Material {
        let mut one = Material { axes: Vec::new(), ..self.clone() };
        let Kind::Dielectric { dispersion, absorption } = &mut one.kind else { return one };
        match self.axes.as_slice() {
            [] => {}
            [extraordinary] => {
                *absorption = Absorption::mean([absorption, absorption, &extraordinary.absorption]);
            }
            [second, third, ..] => {
                *absorption = Absorption::mean([absorption, &second.absorption, &third.absorption]);
                let [x, y, z] = self.indices(fraunhofer::D);
                if (x - y) * (y - z) >= 0.0 {
                    *dispersion = second.dispersion.clone();
                } else if (x - z) * (z - y) >= 0.0 {
                    *dispersion = third.dispersion.clone();
                }
                one.ray = if self.ray.is_empty() { String::new() } else { "beta".to_owned() };
            }
        }
        one
    }

    /// The keys of a material's axes in a file, before the name of a figure.
    fn axis_keys(&self) -> &'static [&'static str] {
        match self.axes.len() {
            0 | 1 => &["", "extraordinary."],
            _ => &["principal[0].", "principal[1].", "principal[2]."],
        }
    }

    fn by_axis(&self, first: f64, figure: impl Fn(&Axis) -> f64) -> [f64; 3] {
        match self.axes.as_slice() {
            [] => [first; 3],
            [extraordinary] => [first, first, figure(extraordinary)],
            [y, z, ..] => [first, figure(y), figure(z)],
        }
    }

    /// Whether it is opaque, with a complex index.
    pub fn is_conductor(&self) -> bool {
        matches!(self.kind, Kind::Conductor { .. })
    }

    /// Whether some figure is a rough guide rather than a measurement.
    pub fn is_approximate(&self) -> bool {
        self.sources.iter().any(|source| source.approximate)
    }

    /// Checks the material over the wavelengths (nm) it is to be rendered at: see [`Dispersion::check`].
    ///
    /// Returns warnings, too, where a range goes beyond what the sources cover.
    ///
    /// # Errors
    /// Those of [`Dispersion::check`], with the material's name in front.
    pub fn check(&self, range: [f64; 2]) -> Result<Vec<Warning>, Error> {
        let mut warnings = Vec::new();
        let names = self.axis_keys();
        let first = match &self.kind {
            Kind::Dielectric { dispersion, .. } => Some(dispersion),
            Kind::Conductor { .. } => None,
        };
        let further = self.axes.iter().map(|axis| &axis.dispersion);
        for (key, dispersion) in names.iter().zip(first.into_iter().chain(further)) {
            let checked = dispersion.check(range).map_err(|error| prefixed(key, error));
            warnings.extend(checked.map_err(|error| within(&self.name, error))?);
        }
        for source in &self.sources {
            if let Some([start, end]) = source.range
                && (range[0] < start || range[1] > end)
            {
                warnings.push(Warning::new(format!(
                    "The {} is known from {start} to {end} nm; {}–{} nm is rendered, so some is extrapolated.",
                    source.figure,
                    range[0],
                    range[1]
                )));
            }
        }
        Ok(warnings.into_iter().map(|w| named(&self.name, &w)).collect())
    }
}

/// The error with the material it is about in front.
fn within(name: &str, error: Error) -> Error {
    prefixed(&format!("material '{}': ", shown(name)), error)
}

/// The error with something in front of what it is about.
fn prefixed(prefix: &str, error: Error) -> Error {
    match error {
        Error::Value { what, value, expected } => {
            Error::Value { what: format!("{prefix}{what}"), value, expected }
        }
        Error::Data { what, line, message } => Error::Data { what: format!("{prefix}{what}"), line, message },
        other => other,
    }
}

/// The warning with the material it is about in front.
fn named(name: &str, warning: &Warning) -> Warning {
    Warning::new(format!("material '{}': {warning}", shown(name)))
}
