//! The library's errors as the package's exceptions, with the same messages.

use pyo3::prelude::*;
use pyo3::types::PyType;

/// An error on its way to Python.
#[derive(Debug)]
pub struct Failure(gemtrace::Error);

impl From<gemtrace::Error> for Failure {
    fn from(error: gemtrace::Error) -> Self {
        Failure(error)
    }
}

impl From<spectral_core::Error> for Failure {
    fn from(error: spectral_core::Error) -> Self {
        Failure(error.into())
    }
}

impl From<Failure> for PyErr {
    fn from(Failure(error): Failure) -> Self {
        Python::attach(|py| exception(py, &error).unwrap_or_else(|unusual| unusual))
    }
}

/// The class of the package that an error belongs to, with its message.
fn exception(py: Python<'_>, error: &gemtrace::Error) -> PyResult<PyErr> {
    let class = py.import("gemtrace._errors")?.getattr(class(error))?.cast_into::<PyType>()?;
    Ok(PyErr::from_type(class, message(error)))
}

fn class(error: &gemtrace::Error) -> &'static str {
    use gemtrace::Error::{Core, File, Interrupted, Output, Render};
    match error {
        File { .. } => "FileError",
        Output { .. } => "OutputError",
        Render { .. } | Core(spectral_core::Error::Device { .. }) => "DeviceError",
        Core(spectral_core::Error::Memory { .. }) => "OutOfMemoryError",
        Core(spectral_core::Error::Unknown { .. }) => "UnknownNameError",
        Interrupted => "Interrupted",
        _ => "InputError",
    }
}

/// The message; a scene that is in no file has no lines that its author has seen.
fn message(error: &gemtrace::Error) -> String {
    match error {
        gemtrace::Error::Scene { path, message, .. } if path.as_os_str().is_empty() => message.clone(),
        other => other.to_string(),
    }
}
