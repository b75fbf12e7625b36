//! A material as a file describes it, before its figures are checked.

use serde::Deserialize;
use serde::de::{self, Deserializer, SeqAccess, Visitor};

use super::{Axis, Catalogue, Kind, Material, named, prefixed, within};
use crate::absorption::{Absorption, Term};
use crate::cie::Illuminant;
use crate::dispersion::Dispersion;
use crate::spectrum::{Ends, Tabulated};
use crate::{Error, Warning};

/// A `[material.NAME]` table. Unknown keys are errors.
///
/// The index comes from exactly one of `index`, `cauchy`, `measured`, `sellmeier`, `pole`, `index_table`,
/// `conductor` and `like`; with `like`, another of them may be given too and replaces that part.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialSpec {
    /// A material of the catalogue to start from.
    pub like: Option<String>,
    /// A constant index.
    pub index: Option<f64>,
    /// n = A + B/λ² + C/λ⁴ + …, λ in µm.
    pub cauchy: Option<Vec<f64>>,
    /// Three or more [nm, n], to which Cauchy's series is fitted.
    pub measured: Option<Vec<[f64; 2]>>,
    /// Sellmeier's equation, λ in µm.
    pub sellmeier: Option<SellmeierSpec>,
    /// n² = A + B·N/(λ² − C) + Dλ², λ in µm.
    pub pole: Option<PoleSpec>,
    /// [nm, n] rows joined by straight lines.
    pub index_table: Option<Vec<[f64; 2]>>,
    /// A metal.
    pub conductor: Option<ConductorSpec>,
    /// The colour, by its absorption.
    pub absorption: Option<AbsorptionSpec>,
    /// The colour, as it is seen through a thickness; in place of `absorption`.
    pub color: Option<ColorSpec>,
    /// The extraordinary ray of a uniaxial crystal: its index and absorption; the rest of the table is then the ordinary
    /// ray's.
    pub extraordinary: Option<Box<MaterialSpec>>,
    /// A biaxial crystal: index and absorption along its axes x, y and z, in place of the table's own.
    pub principal: Option<Vec<MaterialSpec>>,
    /// Density in g/cm³.
    pub density: Option<f64>,
}

/// `sellmeier = { b = […], c = […] }`: n² = 1 + a0 + Σ bᵢλ²/(λ² − cᵢ), λ in µm, cᵢ in µm².
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SellmeierSpec {
    /// A₀.
    #[serde(default)]
    pub a0: f64,
    /// bᵢ.
    pub b: Vec<f64>,
    /// cᵢ in µm², as many as `b`.
    pub c: Vec<f64>,
}

/// `pole = { a, b, c, d, squared_numerator }`: see [`Dispersion::Pole`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoleSpec {
    /// A.
    pub a: f64,
    /// B.
    pub b: f64,
    /// C, µm².
    pub c: f64,
    /// D, µm⁻².
    #[serde(default)]
    pub d: f64,
    /// Whether the numerator is λ² rather than 1.
    #[serde(default)]
    pub squared_numerator: bool,
}

/// `color = { rgb = [r, g, b], at = mm }`: see [`Absorption::showing`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColorSpec {
    /// Linear sRGB.
    pub rgb: [f64; 3],
    /// The thickness, mm.
    pub at: f64,
}

/// `conductor = { table = [[nm, n, k], …] }`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConductorSpec {
    /// [nm, n, k] rows in ascending order, joined by straight lines; one row is a constant.
    pub table: Vec<[f64; 3]>,
}

/// One part of an absorption: `{ constant }`, `{ centre, sigma, peak }` or `{ centre, fwhm_cm1, peak }`.
///
/// Wavelengths in nm, coefficients Napierian in 1/mm; see [`Term`].
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BandSpec {
    /// The same at every wavelength.
    pub constant: Option<f64>,
    /// Wavelength of the maximum.
    pub centre: Option<f64>,
    /// Standard deviation in nm.
    pub sigma: Option<f64>,
    /// Full width at half maximum in cm⁻¹.
    pub fwhm_cm1: Option<f64>,
    /// Coefficient at the maximum.
    pub peak: Option<f64>,
}

/// `absorption = [bands]` or `absorption = "table.csv"`.
#[derive(Debug, Clone, PartialEq)]
pub enum AbsorptionSpec {
    /// Parts that add up.
    Bands(Vec<BandSpec>),
    /// A table (nm, 1/mm) that the caller reads: this crate opens no files.
    File(String),
}

impl<'de> Deserialize<'de> for AbsorptionSpec {
    /// By hand, because serde's untagged enums lose the place and the reason of an error inside a band.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = AbsorptionSpec;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(
                    "a list of bands such as [{ centre = 553.0, sigma = 38.0, peak = 0.9 }, { constant = 0.015 }] \
                     or the name of a table file (nm, 1/mm)",
                )
            }

            fn visit_str<E: de::Error>(self, file: &str) -> Result<Self::Value, E> {
                Ok(AbsorptionSpec::File(file.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut bands = Vec::new();
                while let Some(band) = seq.next_element()? {
                    bands.push(band);
                }
                Ok(AbsorptionSpec::Bands(bands))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// What a description leaves to its scene.
#[derive(Clone, Copy)]
struct Resolve<'a> {
    /// Gives the table of an `absorption = "FILE"`.
    table: &'a dyn Fn(&str) -> Result<Tabulated, Error>,
    /// The light that a `color` is seen by.
    light: &'a Illuminant,
}

impl MaterialSpec {
    /// Checks the description and makes the material, with warnings about figures that were accepted.
    ///
    /// `name` is what the material is called. `resolve` gives the table of an `absorption = "FILE"` (nm, 1/mm),
    /// usually by reading the file and [`Tabulated::from_csv`]. Whether the index makes sense on the
    /// wavelengths to be rendered, [`Material::check`] tells.
    ///
    /// # Errors
    /// [`Error::Value`] for impossible figures and for a description with no index or more than one,
    /// [`Error::Unknown`] if `like` names nothing in the catalogue, and whatever `resolve` reports.
    pub fn build(
        &self,
        name: &str,
        resolve: impl Fn(&str) -> Result<Tabulated, Error>,
    ) -> Result<(Material, Vec<Warning>), Error> {
        self.build_under(&Illuminant::D65, name, resolve)
    }

    /// The same in a scene whose light is another than D65, by which a `color` is seen.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn build_under(
        &self,
        light: &Illuminant,
        name: &str,
        resolve: impl Fn(&str) -> Result<Tabulated, Error>,
    ) -> Result<(Material, Vec<Warning>), Error> {
        self.assemble(name, Resolve { table: &resolve, light }).map_err(|error| within(name, error)).map(
            |(material, warnings)| {
                let warnings = warnings.iter().map(|w| named(name, w)).collect();
                (material, warnings)
            },
        )
    }

    fn assemble(&self, name: &str, resolve: Resolve) -> Result<(Material, Vec<Warning>), Error> {
        if let Some(principal) = &self.principal {
            return self.biaxial(name, principal, resolve);
        }
        self.check_models()?;
        let absorption = self.absorption(resolve)?;
        let base = self.base(absorption.as_ref())?;
        let (kind, mut warnings) = self.kind(base.as_ref(), absorption)?;
        let extraordinary = match &self.extraordinary {
            Some(_) if matches!(kind, Kind::Conductor { .. }) => {
                return Err(Error::value("extraordinary", "given", "a metal is isotropic; leave this out"));
            }
            Some(spec) => Some(spec.axis("extraordinary", resolve, &mut warnings)?),
            None => None,
        };
        if let Some(density) = self.density.filter(|d| !(d.is_finite() && *d > 0.0)) {
            return Err(Error::value("density", density, "give a number above 0, in g/cm³"));
        }
        // The catalogue's sources cover only what was taken over from it.
        let taken_over = |figure: &str| match figure {
            "dispersion" => self.models().is_empty(),
            "absorption" => self.absorption.is_none() && self.color.is_none() && self.conductor.is_none(),
            "density" => self.density.is_none(),
            _ => true,
        };
        let mut base = base.unwrap_or_else(|| Material::new(name, kind.clone()));
        base.sources.retain(|source| taken_over(&source.figure));
        let density = self.density.or(base.density);
        let axes = extraordinary.map_or_else(|| base.axes.clone(), |axis| vec![axis]);
        Ok((Material { name: name.to_owned(), kind, axes, density, ..base }, warnings))
    }

    /// The material it is like, with what this table changes on every axis of it: an index makes it isotropic, an absorption is
    /// that of all axes.
    fn base(&self, absorption: Option<&Absorption>) -> Result<Option<Material>, Error> {
        let Some(like) = &self.like else { return Ok(None) };
        let mut base = Catalogue::builtin().get(like)?.clone();
        if !self.models().is_empty() {
            return Ok(Some(base.isotropic()));
        }
        if self.extraordinary.is_some() && base.axes.len() > 1 {
            let expected = format!("'{like}' is biaxial and has three axes; give principal without like");
            return Err(Error::value("extraordinary", "given", expected));
        }
        if let Some(absorption) = absorption {
            base.axes.iter_mut().for_each(|axis| axis.absorption = absorption.clone());
        }
        Ok(Some(base))
    }

    /// `principal = [{…}, {…}, {…}]`.
    fn biaxial(
        &self,
        name: &str,
        principal: &[MaterialSpec],
        resolve: Resolve,
    ) -> Result<(Material, Vec<Warning>), Error> {
        let [x, y, z] = principal else {
            let expected = "give three tables, along the crystal's axes x, y and z";
            return Err(Error::value("principal", format!("{} tables", principal.len()), expected));
        };
        let own = MaterialSpec { principal: None, density: None, ..self.clone() };
        if own != MaterialSpec::default() {
            let expected = "with principal, each axis has its own index and absorption; leave out the table's own, like and extraordinary";
            return Err(Error::value("principal", "given beside others", expected));
        }
        let mut warnings = Vec::new();
        let mut axis =
            |k: usize, spec: &MaterialSpec| spec.axis(&format!("principal[{k}]"), resolve, &mut warnings);
        let (Axis { dispersion, absorption }, y, z) = (axis(0, x)?, axis(1, y)?, axis(2, z)?);
        let rest = MaterialSpec { density: self.density, index: Some(1.0), ..MaterialSpec::default() };
        let (material, _) = rest.assemble(name, resolve)?;
        let kind = Kind::Dielectric { dispersion, absorption };
        Ok((Material { kind, axes: vec![y, z], ..material }, warnings))
    }

    /// The optics along one axis of a crystal.
    fn axis(&self, what: &str, resolve: Resolve, warnings: &mut Vec<Warning>) -> Result<Axis, Error> {
        let other = self.like.is_some()
            || self.density.is_some()
            || self.extraordinary.is_some()
            || self.principal.is_some();
        let expected = "an axis of a crystal has one of index, cauchy, measured, sellmeier, pole and index_table, and perhaps absorption";
        if other || self.conductor.is_some() || self.models().len() != 1 {
            return Err(Error::value(what, "this table", expected));
        }
        let field = |error| prefixed(&format!("{what}."), error);
        let (dispersion, remarks) =
            self.dispersion().map_err(field)?.ok_or_else(|| Error::value(what, "nothing", expected))?;
        warnings.extend(remarks);
        let absorption = self.absorption(resolve).map_err(field)?.unwrap_or_default();
        Ok(Axis { dispersion, absorption })
    }

    fn absorption(&self, resolve: Resolve) -> Result<Option<Absorption>, Error> {
        let term = match (&self.absorption, self.color) {
            (Some(_), Some(_)) => {
                return Err(Error::value("color", "given beside absorption", "give one of them only"));
            }
            (Some(AbsorptionSpec::Bands(bands)), None) => terms(bands)?,
            (Some(AbsorptionSpec::File(file)), None) => vec![Term::Table((resolve.table)(file)?)],
            (None, Some(ColorSpec { rgb, at })) => {
                return Absorption::showing(rgb, at, resolve.light).map(Some);
            }
            (None, None) => return Ok(None),
        };
        Absorption::new(term).map(Some)
    }

    /// The keys given that say what the index is, but for `like`.
    fn models(&self) -> Vec<&'static str> {
        let given = [
            ("index", self.index.is_some()),
            ("cauchy", self.cauchy.is_some()),
            ("measured", self.measured.is_some()),
            ("sellmeier", self.sellmeier.is_some()),
            ("pole", self.pole.is_some()),
            ("index_table", self.index_table.is_some()),
            ("conductor", self.conductor.is_some()),
        ];
        given.into_iter().filter(|(_, present)| *present).map(|(key, _)| key).collect()
    }

    fn check_models(&self) -> Result<(), Error> {
        let models = self.models();
        if models.len() > 1 {
            return Err(Error::value("index", models.join(" and "), "give one of them only"));
        }
        if models.is_empty() && self.like.is_none() {
            return Err(Error::value(
                "index",
                "nothing",
                "give one of index, cauchy, measured, sellmeier, pole, index_table, conductor, or like",
            ));
        }
        if self.conductor.is_some() && (self.absorption.is_some() || self.color.is_some()) {
            return Err(Error::value(
                if self.color.is_some() { "color" } else { "absorption" },
                "given",
                "a conductor's k is its absorption; leave this out",
            ));
        }
        Ok(())
    }

    fn kind(
        &self,
        base: Option<&Material>,
        absorption: Option<Absorption>,
    ) -> Result<(Kind, Vec<Warning>), Error> {
        if let Some(conductor) = &self.conductor {
            return Ok((conductor.build()?, Vec::new()));
        }
        let (dispersion, warnings) = match self.dispersion()? {
            Some((dispersion, warnings)) => (Some(dispersion), warnings),
            None => (None, Vec::new()),
        };
        let kind = match (dispersion, base.map(|b| &b.kind)) {
            (Some(dispersion), Some(Kind::Dielectric { absorption: own, .. })) => {
                Kind::Dielectric { dispersion, absorption: absorption.unwrap_or_else(|| own.clone()) }
            }
            (Some(dispersion), _) => {
                Kind::Dielectric { dispersion, absorption: absorption.unwrap_or_default() }
            }
            (None, Some(Kind::Dielectric { dispersion, absorption: own })) => Kind::Dielectric {
                dispersion: dispersion.clone(),
                absorption: absorption.unwrap_or_else(|| own.clone()),
            },
            (None, Some(Kind::Conductor { .. })) if absorption.is_some() => {
                let expected =
                    "the material it is like is a metal, whose k is its absorption; leave this out";
                let key = if self.color.is_some() { "color" } else { "absorption" };
                return Err(Error::value(key, "given", expected));
            }
            (None, Some(conductor)) => conductor.clone(),
            (None, None) => return Err(Error::value("index", "nothing", "say what the index is")),
        };
        Ok((kind, warnings))
    }

    /// The dispersion that is given, if any. [`Material::check`] checks it over a range.
    fn dispersion(&self) -> Result<Option<(Dispersion, Vec<Warning>)>, Error> {
        if let Some(measured) = &self.measured {
            return Dispersion::fit(measured).map(Some);
        }
        let dispersion = if let Some(n) = self.index {
            Dispersion::Constant(n)
        } else if let Some(coefficients) = &self.cauchy {
            Dispersion::Cauchy(coefficients.clone())
        } else if let Some(sellmeier) = &self.sellmeier {
            sellmeier.build()?
        } else if let Some(PoleSpec { a, b, c, d, squared_numerator }) = self.pole {
            Dispersion::Pole { a, b, c, d, squared_numerator }
        } else if let Some(rows) = &self.index_table {
            let (nm, n) = rows.iter().map(|&[nm, n]| (nm, n)).unzip();
            Dispersion::Table(Tabulated::new(nm, n, Ends::Extend)?)
        } else {
            return Ok(None);
        };
        Ok(Some((dispersion, Vec::new())))
    }
}

impl SellmeierSpec {
    fn build(&self) -> Result<Dispersion, Error> {
        if self.b.len() != self.c.len() || self.b.is_empty() {
            let found = format!("{} in b and {} in c", self.b.len(), self.c.len());
            return Err(Error::value(
                "sellmeier",
                found,
                "give as many coefficients in b as in c, at least one",
            ));
        }
        let terms = self.b.iter().zip(&self.c).map(|(&b, &c)| [b, c]).collect();
        Ok(Dispersion::Sellmeier { a0: self.a0, terms })
    }
}

impl ConductorSpec {
    fn build(&self) -> Result<Kind, Error> {
        for (i, &[nm, n, k]) in self.table.iter().enumerate() {
            if !(n.is_finite() && n > 0.0 && k.is_finite() && k >= 0.0) {
                let expected = "rows are [nm, n, k] with n above 0 and k at least 0";
                return Err(Error::value(
                    format!("conductor.table[{i}]"),
                    format!("[{nm}, {n}, {k}]"),
                    expected,
                ));
            }
        }
        let column = |j: usize| self.table.iter().map(move |row| row[j]).collect::<Vec<f64>>();
        Ok(Kind::Conductor {
            n: Tabulated::new(column(0), column(1), Ends::Extend)?,
            k: Tabulated::new(column(0), column(2), Ends::Extend)?,
        })
    }
}

fn terms(bands: &[BandSpec]) -> Result<Vec<Term>, Error> {
    let term = |(i, band): (usize, &BandSpec)| {
        let BandSpec { constant, centre, sigma, fwhm_cm1, peak } = *band;
        match (constant, centre, sigma, fwhm_cm1, peak) {
            (Some(value), None, None, None, None) => Ok(Term::Constant(value)),
            (None, Some(centre), Some(sigma), None, Some(peak)) => Ok(Term::Gaussian { centre, sigma, peak }),
            (None, Some(centre), None, Some(fwhm_cm1), Some(peak)) => {
                Ok(Term::GaussianWavenumber { centre, fwhm_cm1, peak })
            }
            _ => Err(Error::value(
                format!("absorption[{i}]"),
                band.keys(),
                "a band has { centre, sigma, peak } or { centre, fwhm_cm1, peak }, or { constant } alone",
            )),
        }
    };
    bands.iter().enumerate().map(term).collect()
}

impl BandSpec {
    /// The keys that are given, as they stand in the file.
    fn keys(&self) -> String {
        let given = [
            ("constant", self.constant),
            ("centre", self.centre),
            ("sigma", self.sigma),
            ("fwhm_cm1", self.fwhm_cm1),
            ("peak", self.peak),
        ];
        let keys: Vec<&str> = given.iter().filter(|(_, v)| v.is_some()).map(|(key, _)| *key).collect();
        format!("{{ {} }}", keys.join(", "))
    }
}
