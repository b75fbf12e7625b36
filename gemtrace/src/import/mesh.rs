//! Meshes: OBJ, STL (text and binary) and PLY.

use super::{about, blame, extension, guarded, obj};
#[cfg(feature = "formats")]
use super::{ply, stl};
use crate::Error;
use spectral_core::Warning;
use spectral_core::mesh::{Mesh, MeshOptions};
use std::path::Path;

/// A mesh file format, known by the file's extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography, text or binary.
    Stl,
    /// Stanford polygons, text or binary.
    Ply,
}

impl Format {
    /// The format of a file by its extension, if it is one.
    pub fn of(path: &Path) -> Option<Self> {
        match extension(path).as_str() {
            "obj" => Some(Format::Obj),
            "stl" => Some(Format::Stl),
            "ply" => Some(Format::Ply),
            _ => None,
        }
    }
}

/// A closed mesh from the bytes of the file `path`, in the file's own units and frame. The bytes are dropped as soon as
/// they are parsed: a large file would weigh as much as the mesh.
///
/// # Errors
/// [`Error::File`] for a format that is not known, a file that is not complete, vertices that are not
/// finite, and surfaces that bound no solid.
pub fn read(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(Mesh, Vec<Warning>), Error> {
    let format = Format::of(path).ok_or_else(|| {
        Error::file(
            path,
            format!("'.{}' is not a mesh format; .obj, .stl and .ply are read", extension(path)),
        )
    })?;
    let soup = guarded(|| match format {
        Format::Obj => obj::read(bytes.as_ref()),
        #[cfg(feature = "formats")]
        Format::Stl => stl::read(bytes.as_ref()),
        #[cfg(feature = "formats")]
        Format::Ply => ply::read(bytes.as_ref()),
        #[cfg(not(feature = "formats"))]
        _ => Err("this format needs the feature 'formats'".to_owned()),
    });
    drop(bytes);
    let soup = soup.map_err(|message| Error::file(path, message))?;
    let (mesh, warnings) =
        Mesh::from_triangles(soup.positions, soup.triangles, &MeshOptions::default()).map_err(blame(path))?;
    Ok((mesh, about(path, warnings)))
}
