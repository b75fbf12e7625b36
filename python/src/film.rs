//! Films: what was rendered, as arrays and files.

use crate::error::Failure;
use gemtrace::output::{self, Depth, Options, Picture, Target};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use spectral_core::color::{RgbSpace, Tone};
use spectral_core::tracer::TraceReport;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A rendered picture, finished or not.
#[pyclass(frozen, module = "gemtrace._gemtrace")]
pub struct Film {
    picture: Mutex<Picture>,
    report: TraceReport,
    reason: String,
    warnings: Vec<String>,
    /// What it must not be written over.
    inputs: Vec<PathBuf>,
    size: [usize; 2],
    /// Exposure and tone of the scene.
    own: Options,
}

impl Film {
    pub fn new(
        picture: Picture,
        report: TraceReport,
        reason: String,
        warnings: Vec<String>,
        inputs: Vec<PathBuf>,
    ) -> Self {
        let size = [picture.film.height() as usize, picture.film.width() as usize];
        let own = picture.options;
        Film { picture: Mutex::new(picture), report, reason, warnings, inputs, size, own }
    }

    /// Held by nobody who waits for the interpreter.
    fn picture(&self) -> MutexGuard<'_, Picture> {
        self.picture.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The number of samples of all pixels.
    pub fn total(&self) -> u64 {
        self.picture().film.total_samples()
    }

    /// Row by row, as an array of rows, columns and `N` values, without a copy.
    fn planes<'py, const N: usize>(
        &self,
        py: Python<'py>,
        values: Vec<[f32; N]>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let [height, width] = self.size;
        PyArray1::from_vec(py, values.into_flattened()).reshape([height, width, N])
    }

    fn plane<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        values: Vec<T>,
    ) -> PyResult<Bound<'py, PyArray2<T>>> {
        PyArray1::from_vec(py, values).reshape(self.size)
    }
}

#[pymethods]
impl Film {
    /// Whether every sample is there.
    #[getter]
    pub fn finished(&self) -> bool {
        self.report.finished
    }

    /// Rows and columns.
    #[getter]
    fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Colours in a linear space.
    fn rgb<'py>(&self, py: Python<'py>, space: &str) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let space = RgbSpace::by_name(space).map_err(Failure::from)?;
        let pixels =
            py.detach(|| self.picture().linear(space).into_iter().map(|[r, g, b, _]| [r, g, b]).collect());
        self.planes(py, pixels)
    }

    /// The alpha of the EXR.
    fn alpha<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let alpha =
            py.detach(|| self.picture().linear(RgbSpace::Xyz).into_iter().map(|[.., alpha]| alpha).collect());
        self.plane(py, alpha)
    }

    /// The share of each pixel that shows a stone.
    fn coverage<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let coverage = py.detach(|| {
            let film = &self.picture().film;
            (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| film.coverage(x, y))).collect()
        });
        self.plane(py, coverage)
    }

    /// Radiance at every wavelength; nothing unless the film is spectral.
    fn spectral<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let [height, width] = self.size;
        let (spectra, count) = py.detach(|| {
            let picture = self.picture();
            (picture.film.spectra(), picture.wavelengths.len())
        });
        PyArray1::from_vec(py, spectra).reshape([height, width, count])
    }

    /// The wavelengths of the spectra, nm.
    fn wavelengths<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let wavelengths = py.detach(|| self.picture().wavelengths.clone());
        PyArray1::from_vec(py, wavelengths)
    }

    /// The number of samples of each pixel.
    fn samples<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let counts = py.detach(|| self.picture().film.counts().to_vec());
        self.plane(py, counts)
    }

    /// Where the light went, as JSON.
    fn energy(&self) -> String {
        output::energy(&self.report.energy).to_string()
    }

    /// Everything that goes into a header, as JSON.
    fn facts(&self, py: Python<'_>) -> String {
        py.detach(|| self.picture().provenance.to_json().to_string())
    }

    /// Why this device was taken.
    #[getter]
    fn reason(&self) -> &str {
        &self.reason
    }

    /// Remarks of the scene and of the render.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Seconds that the light took.
    #[getter]
    fn seconds(&self) -> f64 {
        self.report.trace.as_secs_f64()
    }

    /// Writes a PNG or an EXR.
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        space: &str,
        bits: u32,
        exposure: f64,
        tone: Option<&str>,
    ) -> Result<u64, Failure> {
        let space = RgbSpace::by_name(space)?;
        let tone = tone.map(Tone::by_name).transpose()?;
        let depth = Depth::of_bits(bits)
            .ok_or_else(|| spectral_core::Error::value("bits", bits, "8 or 16 bits a channel of a PNG"))?;
        let target = Target::new(path)?;
        py.detach(|| {
            output::prepare(&[target.path()], self.inputs.iter().map(PathBuf::as_path))?;
            let mut picture = self.picture();
            let tone = tone.or(self.own.tone);
            picture.set_options(Options { space, depth, exposure: self.own.exposure + exposure, tone });
            Ok(picture.write(&target)?)
        })
    }

    /// The bytes of its PNG.
    fn png<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyBytes>, Failure> {
        let bytes = py.detach(|| {
            let mut picture = self.picture();
            picture.set_options(self.own);
            picture.png()
        })?;
        Ok(PyBytes::new(py, &bytes))
    }
}
