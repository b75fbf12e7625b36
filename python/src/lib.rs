//! What the Python package `gemtrace` calls: thin, private, and in the terms of the library. The package's own files, in
//! `python/gemtrace`, are what people see; they check arguments, name units, and turn arrays into rows.
//!
//! Nothing here holds a lock while it waits for Python, and whatever takes long runs detached from the interpreter.

mod cut;
mod error;
mod film;
mod live;
mod material;
mod optics;
mod scene;
mod session;

use pyo3::prelude::*;

/// The extension module `gemtrace._gemtrace`.
#[pymodule]
mod _gemtrace {
    #[pymodule_export]
    use super::{
        cut::Solid,
        devices,
        film::Film,
        live::Live,
        material::{Material, material_names},
        optics::{cauchy_fit, crystal, fresnel, mueller, upsample},
        scene::{Made, Scene},
        session::Session,
        version,
    };
}

/// The version of the library.
#[pyfunction]
fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// Every device of every backend, as JSON.
#[pyfunction]
fn devices(py: Python<'_>) -> String {
    py.detach(|| {
        let all = gemtrace::registry::backends().iter().flat_map(|backend| (backend.devices)());
        let all: Vec<_> = all.map(|device| gemtrace::output::device(&device)).collect();
        serde_json::Value::from(all).to_string()
    })
}
