//! Meshes: OBJ, STL (text and binary), PLY and glTF.

#[cfg(feature = "formats")]
use super::look::Object;
use super::soup::Soup;
use super::{about, blame, extension, guarded, obj};
#[cfg(feature = "formats")]
use super::{gltf, ply, stl};
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
    /// glTF 2.0, text (.gltf) or binary (.glb).
    Gltf,
}

impl Format {
    /// The format of a file by its extension, if it is one.
    pub fn of(path: &Path) -> Option<Self> {
        match extension(path).as_str() {
            "obj" => Some(Format::Obj),
            "stl" => Some(Format::Stl),
            "ply" => Some(Format::Ply),
            "glb" | "gltf" => Some(Format::Gltf),
            _ => None,
        }
    }
}

/// What is made of a mesh file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Selection {
    /// The object, group or material whose triangles are taken; all without it.
    pub object: Option<String>,
    /// Take the convex hull.
    pub hull: bool,
    /// It is of a metal, which needs no inside: see [`Mesh::opaque`].
    pub opaque: bool,
}

/// Gives the bytes of a file that a mesh names, by its path from the mesh's folder.
pub(crate) type Open<'a> = &'a dyn Fn(&str) -> Result<Vec<u8>, String>;

/// A closed mesh from the bytes of the file `path`, in the file's own units and frame. The bytes are dropped as soon as
/// they are parsed: a large file would weigh as much as the mesh. The files that a glTF names are read from its folder.
///
/// # Errors
/// [`Error::File`] for a format that is not known, a file that is not complete, vertices that are not
/// finite, and surfaces that bound no solid.
pub fn read(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(Mesh, Vec<Warning>), Error> {
    read_part(path, bytes, &Selection::default())
}

/// The same of a part of the file.
///
/// # Errors
/// As [`read`], and for an object that the file does not name.
pub fn read_part(
    path: &Path,
    bytes: impl AsRef<[u8]>,
    selection: &Selection,
) -> Result<(Mesh, Vec<Warning>), Error> {
    read_with(path, bytes, selection, &beside(path))
}

/// Reads files from a mesh's folder.
pub(crate) fn beside(path: &Path) -> impl Fn(&str) -> Result<Vec<u8>, String> {
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    move |name| super::read_file(&folder.join(name)).map_err(|e| e.to_string())
}

pub(crate) fn read_with(
    path: &Path,
    bytes: impl AsRef<[u8]>,
    selection: &Selection,
    open: Open,
) -> Result<(Mesh, Vec<Warning>), Error> {
    let mut soup = soup(path, bytes.as_ref(), open)?;
    drop(bytes);
    let remark = match &selection.object {
        Some(object) => soup.select(object).map(|()| None).map_err(|message| Error::file(path, message))?,
        None => soup.remark(),
    };
    let options = MeshOptions::default();
    let solid = match selection {
        Selection { hull: true, .. } => {
            let mut used: Vec<u32> = soup.triangles.into_iter().flatten().collect();
            used.sort_unstable();
            used.dedup();
            Mesh::convex_hull(used.iter().map(|v| soup.positions[*v as usize]).collect(), &options)
        }
        Selection { opaque: true, .. } => Mesh::opaque(soup.positions, soup.triangles, &options),
        _ => Mesh::from_triangles(soup.positions, soup.triangles, &options),
    };
    let (mesh, mut warnings) = solid.map_err(|error| match error {
        spectral_core::Error::Solid { message, place } if !selection.hull => {
            let message = format!("{message}; hull = true takes its convex hull");
            blame(path)(spectral_core::Error::Solid { message, place })
        }
        other => blame(path)(other),
    })?;
    warnings.extend(remark.map(Warning::new));
    Ok((mesh, about(path, warnings)))
}

/// The objects of a file, as [`Selection::object`] calls them.
#[cfg(feature = "formats")]
pub(super) fn objects(path: &Path, bytes: &[u8], open: Open) -> Result<Vec<Object>, Error> {
    Ok(soup(path, bytes, open)?.objects())
}

/// The loose triangles of a file.
pub(super) fn soup(path: &Path, bytes: &[u8], open: Open) -> Result<Soup, Error> {
    let format = Format::of(path).ok_or_else(|| {
        let message = "is not a mesh format; .glb, .gltf, .obj, .stl and .ply are read";
        Error::file(path, format!("'.{}' {message}", extension(path)))
    })?;
    let soup = guarded(|| match format {
        Format::Obj => obj::read(bytes),
        #[cfg(feature = "formats")]
        Format::Gltf => gltf::read(bytes, open),
        #[cfg(feature = "formats")]
        Format::Stl => stl::read(bytes),
        #[cfg(feature = "formats")]
        Format::Ply => ply::read(bytes),
        #[cfg(not(feature = "formats"))]
        _ => {
            let _ = open;
            Err("this format needs the feature 'formats'".to_owned())
        }
    });
    soup.map_err(|message| Error::file(path, message))
}
