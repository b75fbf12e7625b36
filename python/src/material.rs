//! Materials and their curves.

use crate::error::Failure;
use crate::scene::table;
use gemtrace::import;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use serde_json::json;
use spectral_core::Error;
use spectral_core::material::{self, Catalogue, MaterialSpec};
use spectral_core::spectrum::Tabulated;
use std::borrow::Cow;
use std::path::Path;

/// A substance.
#[pyclass(frozen, module = "gemtrace._gemtrace")]
pub struct Material {
    material: material::Material,
    warnings: Vec<String>,
}

/// The names of the catalogue.
#[pyfunction]
pub fn material_names() -> Vec<&'static str> {
    Catalogue::builtin().names().collect()
}

#[pymethods]
impl Material {
    /// One of the catalogue, by its name or another that it is known by.
    #[staticmethod]
    fn get(name: &str) -> Result<Self, Failure> {
        Ok(Material { material: Catalogue::builtin().get(name)?.clone(), warnings: Vec::new() })
    }

    /// One from a table as scenes have it, as JSON.
    #[staticmethod]
    fn build(name: &str, json: &str) -> Result<Self, Failure> {
        let message =
            |e: toml::de::Error| gemtrace::Error::Item(format!("material '{name}': {}", e.message()));
        let spec: MaterialSpec = table(json)?.try_into().map_err(message)?;
        let (material, warnings) = spec.build(name, curve)?;
        let mut warnings: Vec<_> = warnings.iter().map(ToString::to_string).collect();
        warnings.extend(material.check([380.0, 740.0])?.iter().map(ToString::to_string));
        Ok(Material { material, warnings })
    }

    /// The index along an axis: 0, 1 or 2.
    fn index<'py>(
        &self,
        py: Python<'py>,
        nm: PyReadonlyArray1<'_, f64>,
        axis: usize,
    ) -> Bound<'py, PyArray1<f64>> {
        self.curve(py, &nm, |nm| self.material.indices(nm)[axis.min(2)])
    }

    /// The imaginary part of a metal's index.
    fn extinction<'py>(&self, py: Python<'py>, nm: PyReadonlyArray1<'_, f64>) -> Bound<'py, PyArray1<f64>> {
        self.curve(py, &nm, |nm| self.material.extinction(nm))
    }

    /// The absorption coefficient along an axis, 1/mm.
    fn absorption<'py>(
        &self,
        py: Python<'py>,
        nm: PyReadonlyArray1<'_, f64>,
        axis: usize,
    ) -> Bound<'py, PyArray1<f64>> {
        self.curve(py, &nm, |nm| self.material.absorptions(nm)[axis.min(2)])
    }

    /// What is known of it beside its curves, as JSON.
    fn facts(&self) -> String {
        let m = &self.material;
        let source = |s: &material::Source| json!({ "figure": s.figure, "source": s.source, "licence": s.licence, "range": s.range, "approximate": s.approximate });
        json!({
            "name": m.name,
            "aliases": Catalogue::builtin().aliases(&m.name),
            "axes": m.axis_names(),
            "metal": m.is_conductor(),
            "density": m.density,
            "notes": m.notes,
            "sources": m.sources.iter().map(source).collect::<Vec<_>>(),
            "warnings": self.warnings,
        })
        .to_string()
    }
}

impl Material {
    fn curve<'py>(
        &self,
        py: Python<'py>,
        nm: &PyReadonlyArray1<'_, f64>,
        at: impl Fn(f64) -> f64,
    ) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, nm.as_array().iter().map(|&nm| at(nm)).collect())
    }
}

/// The table of an absorption that names a file.
fn curve(file: &str) -> Result<Tabulated, Error> {
    let path = Path::new(file);
    let bytes = import::read_file(path);
    let text = bytes.and_then(|bytes| import::text(path, &bytes).map(Cow::into_owned));
    Tabulated::from_csv(&text.map_err(|e| Error::value("absorption", file, e.to_string()))?, file)
}
