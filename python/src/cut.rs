//! Solids: cuts and meshes, as arrays.

use crate::error::Failure;
use crate::scene::table;
use gemtrace::{import, tier};
use glam::DVec3;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use serde_json::json;
use spectral_core::cut::{Cut, CutFacet};
use spectral_core::mesh::{Mesh, MeshOptions, Plane};
use spectral_core::shape::ShapeSpec;
use spectral_core::{Error, Warning};
use std::path::PathBuf;

/// A closed solid, and the design that it was made from.
#[pyclass(frozen, module = "gemtrace._gemtrace")]
pub struct Solid {
    mesh: Mesh,
    cut: Option<Cut>,
    warnings: Vec<Warning>,
}

impl Solid {
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    fn of_cut(cut: Cut, mut warnings: Vec<Warning>) -> Result<Self, Error> {
        let (mesh, more) = cut.solid()?;
        warnings.extend(more);
        Ok(Solid { mesh, cut: Some(cut), warnings })
    }
}

/// Rows of three.
fn points(flat: &PyReadonlyArray1<'_, f64>) -> Vec<DVec3> {
    flat.as_array().to_vec().as_chunks().0.iter().map(|&point| DVec3::from_array(point)).collect()
}

#[pymethods]
impl Solid {
    /// A cut or a mesh from a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> Result<Self, Failure> {
        py.detach(|| {
            let bytes = import::read_file(&path)?;
            if import::mesh::Format::of(&path).is_some() {
                let (mesh, warnings) = import::mesh::read(&path, bytes)?;
                return Ok(Solid { mesh, cut: None, warnings });
            }
            let (cut, warnings) = import::cut::read(&path, &bytes)?;
            Ok(Solid::of_cut(cut, warnings).map_err(|error| gemtrace::Error::file(&path, error))?)
        })
    }

    /// A shape with its parameters, as JSON.
    #[staticmethod]
    fn shape(name: &str, parameters: &str) -> Result<Self, Failure> {
        ShapeSpec::by_name(name)?;
        let mut table = table(parameters)?;
        table.insert("name".to_owned(), name.into());
        let message = |e: toml::de::Error| gemtrace::Error::Item(format!("shape '{name}': {}", e.message()));
        let spec: ShapeSpec = table.try_into().map_err(message)?;
        Ok(Solid::of_cut(spec.cut()?, Vec::new())?)
    }

    /// The solid behind planes.
    #[staticmethod]
    fn planes(
        py: Python<'_>,
        normals: PyReadonlyArray1<'_, f64>,
        offsets: Vec<f64>,
        names: Vec<Option<String>>,
    ) -> Result<Self, Failure> {
        let normals = points(&normals);
        py.detach(|| {
            let facet = |((&normal, &offset), name): ((&DVec3, &f64), Option<String>)| {
                Ok(CutFacet { name, ..CutFacet::from(Plane::new(normal, offset)?) })
            };
            let names = names.into_iter().chain(std::iter::repeat(None));
            let facets: Result<_, Error> = normals.iter().zip(&offsets).zip(names).map(facet).collect();
            Ok(Solid::of_cut(Cut { facets: facets?, ..Cut::default() }, Vec::new())?)
        })
    }

    /// A mesh.
    #[staticmethod]
    fn triangles(
        py: Python<'_>,
        vertices: PyReadonlyArray1<'_, f64>,
        triangles: PyReadonlyArray1<'_, u32>,
    ) -> Result<Self, Failure> {
        let (vertices, triangles) = (points(&vertices), triangles.as_array().to_vec());
        py.detach(|| {
            let triangles = triangles.as_chunks().0.to_vec();
            let (mesh, warnings) = Mesh::from_triangles(vertices, triangles, &MeshOptions::default())?;
            Ok(Solid { mesh, cut: None, warnings })
        })
    }

    /// Unit normals of the facets.
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let normals: Vec<f64> =
            self.mesh.facets().iter().flat_map(|facet| facet.plane.normal.to_array()).collect();
        PyArray1::from_vec(py, normals).reshape([self.mesh.facets().len(), 3])
    }

    /// Their distances from the origin.
    fn offsets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.mesh.facets().iter().map(|facet| facet.plane.offset).collect())
    }

    /// The corners.
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let places: Vec<f64> = self.mesh.positions().iter().flat_map(|place| place.to_array()).collect();
        PyArray1::from_vec(py, places).reshape([self.mesh.positions().len(), 3])
    }

    /// Three corners a triangle.
    fn corners<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let corners = self.mesh.triangles().to_vec().into_flattened();
        PyArray1::from_vec(py, corners).reshape([self.mesh.triangles().len(), 3])
    }

    /// The facet of each triangle.
    fn facet_of<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_vec(py, self.mesh.facet_of().to_vec())
    }

    /// Names, tiers, proportions and what the design says, as JSON.
    fn facts(&self) -> String {
        let facets = self.mesh.facets();
        let planes: Vec<_> = facets.iter().map(|facet| (&facet.plane, facet.name.as_deref())).collect();
        let cut = self.cut.as_ref();
        json!({
            "names": facets.iter().map(|facet| facet.name.as_deref()).collect::<Vec<_>>(),
            "tiers": tier::group(&planes).iter().map(tier::Tier::json).collect::<Vec<_>>(),
            "proportions": tier::proportions(&self.mesh),
            "title": cut.map(|cut| &cut.title),
            "footnotes": cut.map(|cut| &cut.footnotes),
            "gear": cut.and_then(|cut| cut.gear),
            "index_of_refraction": cut.and_then(|cut| cut.index_of_refraction),
            "warnings": self.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        })
        .to_string()
    }
}
