//! Cuts: GemCad text (.asc) and binary (.gem), and Gem Cut Studio (.gcs), through `indicatrix-formats`.

mod asc;
mod gcs;
mod gem;

use super::{about, blame, extension, guarded, utf8};
use crate::Error;
use spectral_core::Warning;
use spectral_core::cut::Cut;
use spectral_core::mesh::Mesh;
use std::path::Path;

/// A cut file format, known by the file's extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// GemCad text.
    Asc,
    /// GemCad binary.
    Gem,
    /// Gem Cut Studio.
    Gcs,
}

impl Format {
    /// The format of a file by its extension, if it is one.
    pub fn of(path: &Path) -> Option<Self> {
        match extension(path).as_str() {
            "asc" => Some(Format::Asc),
            "gem" => Some(Format::Gem),
            "gcs" => Some(Format::Gcs),
            _ => None,
        }
    }
}

/// The planes of the cut file `path` from its bytes, in the file's own frame and unit: +z is the table's
/// normal, and the girdle's radius near 1.
///
/// # Errors
/// [`Error::File`] for a format that is not known or a file that does not parse. Whether the planes close is
/// for [`Cut::solid`] to say.
pub fn read(path: &Path, bytes: &[u8]) -> Result<(Cut, Vec<Warning>), Error> {
    let format = Format::of(path).ok_or_else(|| {
        Error::file(path, format!("'.{}' is not a cut format; .asc, .gem and .gcs are read", extension(path)))
    })?;
    let cut = guarded(|| match format {
        Format::Asc => asc::read(&utf8(bytes)),
        Format::Gem => gem::read(bytes),
        Format::Gcs => gcs::read(&utf8(bytes)),
    });
    let (cut, warnings) = cut.map_err(|message| Error::file(path, message))?;
    Ok((cut, about(path, warnings)))
}

/// The solid of the cut file `path`: [`read`], then [`Cut::solid`].
///
/// # Errors
/// [`Error::File`] also where the planes do not close.
pub fn solid(path: &Path, bytes: &[u8]) -> Result<(Mesh, Vec<Warning>), Error> {
    let (cut, mut warnings) = read(path, bytes)?;
    let (mesh, more) = cut.solid().map_err(blame(path))?;
    warnings.extend(about(path, more));
    Ok((mesh, warnings))
}
