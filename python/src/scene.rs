//! Scenes: documents, from a file or from Python, and what they name.

use crate::cut::Solid;
use crate::error::Failure;
use gemtrace::scene_file::{self, Assets, Draft, LoadedScene};
use gemtrace::{Error, import, output};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use spectral_core::environment::LatLong;
use spectral_core::mesh::Mesh;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A light or a solid that was made in memory, for scenes to name.
#[pyclass(frozen, module = "gemtrace._gemtrace")]
#[derive(Clone)]
pub struct Made(scene_file::Made);

#[pymethods]
impl Made {
    /// A light from linear sRGB texels, row by row.
    #[staticmethod]
    fn light(
        py: Python<'_>,
        rows: u32,
        columns: u32,
        texels: PyReadonlyArray1<'_, f32>,
    ) -> Result<Self, Failure> {
        let texels = texels.as_array().to_vec();
        py.detach(|| {
            let bytes: Vec<u8> = texels.iter().flat_map(|value| value.to_le_bytes()).collect();
            let texels = texels.as_chunks().0.to_vec();
            let (light, warnings) = LatLong::new(columns, rows, texels)?;
            let contents = [&rows.to_le_bytes()[..], &columns.to_le_bytes(), &bytes].concat();
            Ok(Made(scene_file::Made::new(light, &contents, warnings)))
        })
    }

    /// A solid.
    #[staticmethod]
    fn solid(solid: &Solid) -> Self {
        let mesh = solid.mesh();
        let places = mesh.positions().iter().flat_map(|place| place.to_array());
        let planes = mesh
            .facets()
            .iter()
            .flat_map(|f| [f.plane.normal.x, f.plane.normal.y, f.plane.normal.z, f.plane.offset]);
        let figures = places.chain(planes).flat_map(f64::to_le_bytes);
        let corners = mesh.triangles().iter().flatten().flat_map(|corner| corner.to_le_bytes());
        let contents: Vec<u8> = figures.chain(corners).collect();
        Made(scene_file::Made::new(mesh.clone(), &contents, solid.warnings().to_vec()))
    }

    /// Writes it into a file whose name is `stem` and an extension; returns the name.
    fn save(&self, py: Python<'_>, stem: PathBuf) -> Result<PathBuf, Failure> {
        py.detach(|| {
            if let Some(light) = self.0.contents::<LatLong>() {
                let path = stem.with_added_extension("exr");
                output::write_light(&path, &light)?;
                return Ok(path);
            }
            let path = stem.with_added_extension("obj");
            if let Some(mesh) = self.0.contents::<Mesh>() {
                output::write_mesh(&path, &mesh)?;
            }
            Ok(path)
        })
    }

    /// The name by which a scene names it.
    #[getter]
    fn name(&self) -> String {
        self.0.name()
    }
}

/// A scene that has been read.
#[pyclass(frozen, module = "gemtrace._gemtrace")]
pub struct Scene {
    pub loaded: LoadedScene,
    draft: Draft,
    made: Vec<Made>,
    /// What files of this scene, and of those derived from it, were decoded to.
    assets: Arc<Mutex<Assets>>,
}

impl Scene {
    fn new(draft: Draft, made: Vec<Made>, assets: Arc<Mutex<Assets>>) -> Result<Self, Error> {
        let mut known = assets.lock().unwrap_or_else(PoisonError::into_inner);
        known.offer(made.iter().map(|made| made.0.clone()));
        let loaded = draft.load(&mut known).map_err(|error| placed(error, &draft))?;
        drop(known);
        Ok(Scene { loaded, draft, made, assets })
    }

    /// The scene file and what it names: what no picture may be written over.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let named = self.loaded.files.iter().map(|file| file.path.clone());
        named.chain([self.draft.path.clone()]).filter(|path| path.exists()).collect()
    }
}

/// The error of a scene that is in no file, with the stone that it is about in place of a line.
fn placed(error: Error, draft: &Draft) -> Error {
    let Error::Scene { path, line, message } = error else { return error };
    let text = toml::to_string(&draft.table).unwrap_or_default();
    let heads = |text: &mut dyn Iterator<Item = &str>| text.filter(|line| *line == "[[stone]]").count();
    let before: Vec<&str> = text.lines().take(line).collect();
    let last = before.iter().rfind(|line| line.starts_with('['));
    let message = match last {
        Some(head)
            if path.as_os_str().is_empty() && head.contains("stone") && heads(&mut text.lines()) > 1 =>
        {
            format!("{message} (stone {})", heads(&mut before.iter().copied()))
        }
        _ => message,
    };
    Error::Scene { path, line, message }
}

#[pymethods]
impl Scene {
    /// Reads a scene file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> Result<Self, Failure> {
        py.detach(|| {
            let bytes = import::read_file(&path)?;
            let text = import::text(&path, &bytes)?;
            let mut assets = Assets::default();
            // Lines in messages are those of the file.
            let loaded = assets.parse(&text, &path, path.parent().unwrap_or(Path::new("")))?;
            let draft = Draft::new(&path, &text)?;
            Ok(Scene { loaded, draft, made: Vec::new(), assets: Arc::new(Mutex::new(assets)) })
        })
    }

    /// A scene from its document, as JSON, and what it names that is in no file.
    #[staticmethod]
    fn build(py: Python<'_>, document: &str, made: Vec<PyRef<'_, Made>>) -> Result<Self, Failure> {
        let made: Vec<Made> = made.iter().map(|made| (*made).clone()).collect();
        let draft = Draft { path: PathBuf::new(), table: table(document)? };
        Ok(py.detach(|| Scene::new(draft, made, Arc::default()))?)
    }

    /// The same scene with another document; more may be named by it.
    fn derive(&self, py: Python<'_>, document: &str, made: Vec<PyRef<'_, Made>>) -> Result<Self, Failure> {
        let more = made.iter().map(|made| (*made).clone());
        let made: Vec<Made> = self.made.iter().cloned().chain(more).collect();
        let draft = Draft { path: self.draft.path.clone(), table: table(document)? };
        Ok(py.detach(|| Scene::new(draft, made, Arc::clone(&self.assets)))?)
    }

    /// Its document as JSON.
    fn document(&self) -> Result<String, Failure> {
        Ok(serde_json::to_string(&self.draft.table).map_err(|e| Error::Item(e.to_string()))?)
    }

    /// Writes a document of it as a scene file.
    fn write(&self, py: Python<'_>, path: PathBuf, document: &str) -> Result<(), Failure> {
        let text = toml::to_string(&table(document)?).map_err(|e| Error::Item(e.to_string()))?;
        py.detach(|| {
            let inputs = self.inputs();
            output::prepare(&[path.as_path()], inputs.iter().map(PathBuf::as_path))?;
            output::write_text(&path, &text)?;
            Ok(())
        })
    }

    /// What it names that is in no file.
    #[getter]
    fn made(&self) -> Vec<Made> {
        self.made.clone()
    }

    /// Where it was read from; nothing for one from Python.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        Some(self.draft.path.clone()).filter(|path| !path.as_os_str().is_empty())
    }

    /// Width and height of the picture, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.loaded.scene.width, self.loaded.scene.height)
    }

    /// Stones, the ground's slab included.
    #[getter]
    fn stones(&self) -> Vec<String> {
        self.loaded.scene.stones.iter().map(|stone| stone.name.clone()).collect()
    }

    /// What was accepted with a remark.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.loaded.warnings.iter().map(ToString::to_string).collect()
    }

    /// SHA-256 over the document and all that it names.
    #[getter]
    fn hash(&self) -> &str {
        &self.loaded.hash
    }
}

/// A document from JSON.
pub fn table(json: &str) -> Result<toml::Table, Error> {
    serde_json::from_str(json)
        .map_err(|e| Error::Item(format!("a scene holds numbers, texts, lists and tables; {e}")))
}
