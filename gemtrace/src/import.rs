//! Reads cuts, meshes, environments and tables from files.
//!
//! Every reader takes bytes, so that what is read is what is hashed into a picture's provenance, and hands
//! plain data to the core, which knows no file formats. Files are refused by their size before they are
//! read, and pictures by the memory they would need before it is taken.

pub mod cut;
mod decoder;
#[cfg(feature = "formats")]
pub mod environment;
#[cfg(feature = "formats")]
pub(crate) mod gltf;
#[cfg(feature = "formats")]
pub(crate) mod look;
pub mod mesh;
mod obj;
#[cfg(feature = "formats")]
pub(crate) mod picture;
#[cfg(feature = "formats")]
mod ply;
mod soup;
#[cfg(feature = "formats")]
mod stl;

use crate::Error;
pub(crate) use decoder::guarded;
pub use decoder::is_decoding;
use spectral_core::{Warning, memory, nearest_name, shown};
use std::borrow::Cow;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::str::Utf8Error;

/// The largest file that is read, bytes (4 GiB).
pub const MAX_FILE_BYTES: u64 = 4 << 30;

/// The whole of a file.
///
/// # Errors
/// [`Error::File`] for one that is missing (naming the nearest name in its folder), unreadable, not a
/// regular file, or larger than [`MAX_FILE_BYTES`]; [`Error::Core`] where there is not enough memory for it.
pub fn read_file(path: &Path) -> Result<Vec<u8>, Error> {
    let refuse = |e: std::io::Error| Error::file(path, describe(path, &e));
    // The kind is looked up before opening: opening a pipe would wait for a writer.
    let kind = std::fs::metadata(path).map_err(refuse)?;
    if kind.is_dir() {
        return Err(Error::file(path, "this is a folder, where a file is expected"));
    }
    if !kind.is_file() {
        return Err(Error::file(path, "this is not a regular file"));
    }
    if kind.len() > MAX_FILE_BYTES {
        return Err(Error::file(path, too_large(kind.len())));
    }
    let file = File::open(path).map_err(refuse)?;
    let name = || path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut bytes = memory::reserved(kind.len() as usize, name)?;
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(refuse)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(Error::file(path, too_large(bytes.len() as u64)));
    }
    Ok(bytes)
}

fn too_large(bytes: u64) -> String {
    format!("{} is more than the {} that are read", gibibytes(bytes.into()), gibibytes(MAX_FILE_BYTES.into()))
}

/// A size for people: `"1.5 GiB"`.
pub(crate) fn gibibytes(bytes: u128) -> String {
    format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30))
}

fn describe(path: &Path, error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => format!("no such file{}", neighbour(path)),
        ErrorKind::PermissionDenied => "no permission to read it".into(),
        ErrorKind::InvalidInput => "this is not a file name".into(),
        _ => format!("cannot be read: {error}"),
    }
}

fn neighbour(path: &Path) -> String {
    let Some(name) = path.file_name().and_then(|n| n.to_str()) else { return String::new() };
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return format!(" (nor a folder {})", folder.display());
    };
    let mut names: Vec<String> = entries
        .flatten()
        .take(10_000)
        .filter(|e| e.file_type().is_ok_and(|t| !t.is_dir()))
        .filter_map(|e| e.file_name().into_string().ok())
        .collect();
    names.sort();
    match nearest_name(name, names.iter().map(String::as_str)) {
        Some(near) => format!("; did you mean '{}'?", shown(near)),
        None => String::new(),
    }
}

/// A file's text: UTF-8, with or without a byte-order mark, or UTF-16 with one.
///
/// # Errors
/// [`Error::File`] naming the line with the first byte that is neither.
pub fn text<'a>(path: &Path, bytes: &'a [u8]) -> Result<Cow<'a, str>, Error> {
    let fault = |bytes: &[u8], e: Utf8Error| {
        let line = bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
        Error::file(path, format!("line {line} is not UTF-8 text"))
    };
    match utf8(bytes) {
        Cow::Borrowed(bytes) => std::str::from_utf8(bytes).map(Cow::Borrowed).map_err(|e| fault(bytes, e)),
        Cow::Owned(bytes) => {
            String::from_utf8(bytes).map(Cow::Owned).map_err(|e| fault(e.as_bytes(), e.utf8_error()))
        }
    }
}

/// Text without its byte-order mark, UTF-16 of either order as UTF-8. What is no UTF-16 becomes a byte that is no UTF-8
/// either. What begins with no mark stays as it is.
fn utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    let (units, big) = match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => return rest.into(),
        [0xFE, 0xFF, rest @ ..] => (rest, true),
        [0xFF, 0xFE, rest @ ..] => (rest, false),
        _ => return bytes.into(),
    };
    let read = |pair: [u8; 2]| if big { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) };
    let (pairs, left) = units.as_chunks::<2>();
    let mut text = Vec::with_capacity(units.len());
    for character in char::decode_utf16(pairs.iter().map(|pair| read(*pair))) {
        match character {
            Ok(character) => text.extend(character.encode_utf8(&mut [0; 4]).as_bytes()),
            Err(_) => text.push(0xFF),
        }
    }
    text.resize(text.len() + left.len(), 0xFF);
    text.into()
}

/// The extension in lower case; empty if there is none.
fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// A core error as one about this file.
fn blame(path: &Path) -> impl Fn(spectral_core::Error) -> Error {
    move |e| Error::file(path, e)
}

/// Warnings with the file's name in front.
fn about(path: &Path, warnings: Vec<Warning>) -> Vec<Warning> {
    let name = path.display();
    warnings.into_iter().map(|w| Warning::new(format!("{name}: {}", w.message))).collect()
}
