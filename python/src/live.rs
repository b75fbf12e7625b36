//! The live view, for pages that embed it.

use crate::error::Failure;
use gemtrace::view::{Options, View};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A server of this process, until it is closed.
#[pyclass(frozen, module = "gemtrace._gemtrace")]
pub struct Live {
    address: String,
    stop: Arc<AtomicBool>,
}

#[pymethods]
impl Live {
    #[new]
    fn new(py: Python<'_>, file: PathBuf, backend: String, output: PathBuf) -> Result<Self, Failure> {
        py.detach(|| {
            let start = file.parent().filter(|folder| !folder.as_os_str().is_empty());
            let start = start.map_or_else(|| PathBuf::from("."), PathBuf::from);
            let view = View::open(&[file], &Options { backend, output, start, ..Options::default() })?;
            let (address, stop) = (view.address(), Arc::new(AtomicBool::new(false)));
            let asked = Arc::clone(&stop);
            let serve = move || {
                // What it could report has nobody to hear it; the page says that the line is lost.
                let _ = view.serve(&|| asked.load(Ordering::Relaxed));
            };
            let thread = std::thread::Builder::new().name("gemtrace view".to_owned());
            thread.spawn(serve).map_err(|e| gemtrace::Error::output("a thread", e))?;
            Ok(Live { address, stop })
        })
    }

    /// The address of the page, with its token.
    #[getter]
    fn address(&self) -> &str {
        &self.address
    }

    /// Stops the server.
    fn close(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.close();
    }
}
