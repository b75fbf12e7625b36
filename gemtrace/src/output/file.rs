//! Files that are either complete or not there.

use crate::Error;
use std::collections::{HashMap, HashSet};
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Whether a file can be written there, tried before any work is done.
///
/// # Errors
/// [`Error::Output`] where the folder is missing or not writable, or the name is a folder's.
pub fn check(path: &Path) -> Result<(), Error> {
    let refuse = |message: String| Err(Error::output(path, message));
    if path.is_dir() {
        return refuse("this is a folder; give the name of a file in it".to_owned());
    }
    if is_special(path) {
        return match OpenOptions::new().write(true).open(path) {
            Ok(_) => Ok(()),
            Err(e) => refuse(format!("cannot be written ({e})")),
        };
    }
    let folder = folder(&real(path));
    match fs::metadata(&folder) {
        Ok(data) if !data.is_dir() => return refuse(format!("{} is a file, not a folder", folder.display())),
        Err(e) if e.kind() == io::ErrorKind::NotADirectory => {
            return refuse(format!("a part of the path {} is a file, not a folder", folder.display()));
        }
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            return refuse(format!("the folder {} does not exist; create it first", folder.display()));
        }
        Err(e) => return refuse(format!("the folder {} cannot be used ({e})", folder.display())),
        Ok(_) => {}
    }
    match temporary(&folder, path) {
        Ok(_) => Ok(()),
        Err(e) => refuse(format!("the folder {} cannot be written to ({e})", folder.display())),
    }
}

/// Writes a file through `fill` and returns its size: under a temporary name beside `path`, flushed to
/// the disk, then renamed. On failure nothing is left behind, and an older file of this name stays.
pub fn write(path: &Path, fill: impl FnOnce(&mut File) -> Result<(), String>) -> Result<u64, Error> {
    try_write(path, fill).map_err(|message| Error::output(path, format!("cannot be written ({message})")))
}

fn try_write(path: &Path, fill: impl FnOnce(&mut File) -> Result<(), String>) -> Result<u64, String> {
    let text = |e: io::Error| e.to_string();
    if is_special(path) {
        // A device or a pipe cannot be replaced by renaming, and must not be.
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(text)?;
        fill(&mut file)?;
        return Ok(0);
    }
    let path = real(path);
    let folder = folder(&path);
    let mut temporary = temporary(&folder, &path).map_err(text)?;
    fill(temporary.as_file_mut())?;
    let file = temporary.as_file();
    file.sync_all().map_err(text)?;
    let bytes = file.metadata().map_err(text)?.len();
    temporary.persist(&path).map_err(|e| e.error.to_string())?;
    // The rename itself must reach the disk too; where folders cannot be opened (Windows) it does so alone.
    if let Ok(folder) = File::open(&folder) {
        folder.sync_all().ok();
    }
    Ok(bytes)
}

/// The file that a symbolic link stands for, so that the link survives the rename.
fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|data| !data.is_file() && !data.is_dir())
}

/// Removes what a process that was killed left of these files: temporary ones, never those under their own names.
pub fn remove_leftovers(paths: &[PathBuf]) {
    let mut expected: HashMap<PathBuf, HashSet<String>> = HashMap::new();
    for path in paths {
        let path = real(path);
        expected.entry(folder(&path)).or_default().insert(prefix(&path));
    }
    for (folder, prefixes) in &expected {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let name = name.to_str().and_then(|name| name.strip_suffix(SUFFIX));
            // What follows the prefix is random, without a hyphen.
            let left = name.and_then(|name| name.rfind('-').map(|hyphen| &name[..=hyphen]));
            if left.is_some_and(|prefix| prefixes.contains(prefix)) {
                // If it cannot be removed, it does no harm.
                fs::remove_file(entry.path()).ok();
            }
        }
    }
}

const SUFFIX: &str = ".tmp";

/// How the names of a file's temporary companions begin; hidden, and short enough for any file system.
fn prefix(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!(".gemtrace-{}-", name.chars().take(60).collect::<String>())
}

/// A file that is deleted unless it is renamed; it has the permissions of any new file.
fn temporary(folder: &Path, path: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    let prefix = prefix(path);
    builder.prefix(&prefix).suffix(SUFFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}
