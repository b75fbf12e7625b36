//! Files that are either complete or not there.

use super::temporary::{self, Temporary};
use crate::Error;
use spectral_core::shown_lines;
use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

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
        // Reading, too, since a pipe that is only written to waits for a reader.
        return match OpenOptions::new().read(true).write(true).open(path) {
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
    match Temporary::new(&folder, path) {
        Ok(_) => Ok(()),
        Err(e) => refuse(format!("the folder {} cannot be written to ({e})", folder.display())),
    }
}

/// Writes a file through `fill` and returns its size: under a temporary name beside `path`, flushed to
/// the disk, then renamed. On failure nothing is left behind, and an older file of this name stays. A link stays, and
/// the file that it stands for is replaced.
pub fn write(path: &Path, fill: impl FnOnce(&mut File) -> Result<(), String>) -> Result<u64, Error> {
    let written = if is_special(path) { write_special(path, fill) } else { place(&real(path), fill) };
    written.map_err(|message| cannot_be_written(path, &message))
}

/// The same for a name that comes from a file: a link of this name is replaced, wherever it leads.
#[cfg(feature = "batch")]
pub fn replace(path: &Path, fill: impl FnOnce(&mut File) -> Result<(), String>) -> Result<u64, Error> {
    place(path, fill).map_err(|message| cannot_be_written(path, &message))
}

/// Writes a file into the folder for temporary files, under a new name that ends like that of `path`. Returns the place
/// and the size.
pub fn rescue(
    path: &Path,
    fill: impl FnOnce(&mut File) -> Result<(), String>,
) -> Result<(PathBuf, u64), Error> {
    let (temporary, bytes) =
        filled(&std::env::temp_dir(), path, fill).map_err(|message| cannot_be_written(path, &message))?;
    let place = temporary.keep(path).map_err(|e| cannot_be_written(path, &e.to_string()))?;
    Ok((place, bytes))
}

fn cannot_be_written(path: &Path, message: &str) -> Error {
    Error::output(path, format!("cannot be written ({message})"))
}

/// A device or a pipe cannot be replaced by renaming, and must not be.
fn write_special(path: &Path, fill: impl FnOnce(&mut File) -> Result<(), String>) -> Result<u64, String> {
    let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(|e| e.to_string())?;
    fill(&mut file).map(|()| 0)
}

fn place(path: &Path, fill: impl FnOnce(&mut File) -> Result<(), String>) -> Result<u64, String> {
    let folder = folder(path);
    let (temporary, bytes) = filled(&folder, path, fill)?;
    temporary.persist(path).map_err(|e| e.to_string())?;
    // The rename itself must reach the disk too; where folders cannot be opened (Windows) it does so alone.
    if let Ok(folder) = File::open(&folder) {
        folder.sync_all().ok();
    }
    Ok(bytes)
}

/// A temporary file with its contents on the disk, and its size.
fn filled(
    folder: &Path,
    path: &Path,
    fill: impl FnOnce(&mut File) -> Result<(), String>,
) -> Result<(Temporary, u64), String> {
    let text = |e: io::Error| e.to_string();
    let mut temporary = Temporary::new(folder, path).map_err(text)?;
    fill(temporary.file())?;
    let file = temporary.file();
    file.sync_all().map_err(text)?;
    let bytes = file.metadata().map_err(text)?.len();
    Ok((temporary, bytes))
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

/// What is to be done about outputs before any work: none may be an input or another output, each must be writable, and
/// what runs that were killed left of them is cleared away.
///
/// # Errors
/// As [`refuse_overlap`] and [`check`].
pub fn prepare<'a>(outputs: &[&'a Path], inputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Error> {
    refuse_overlap(outputs.iter().copied(), inputs)?;
    outputs.iter().try_for_each(|path| check(path))?;
    remove_leftovers(&outputs.iter().map(|&path| path.to_owned()).collect::<Vec<_>>());
    Ok(())
}

/// Removes what processes that were killed left of these files: temporary ones, never those under their own names.
pub fn remove_leftovers(paths: &[PathBuf]) {
    let real: Vec<PathBuf> = paths.iter().map(|path| real(path)).collect();
    temporary::remove_leftovers(real.iter().map(|path| (folder(path), path.as_path())));
}

/// The same place under any of its names.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| {
        let folder = folder(path);
        folder.canonicalize().unwrap_or(folder).join(path.file_name().unwrap_or_default())
    })
}

/// Refuses outputs that are inputs, or one another: each would be lost.
///
/// # Errors
/// [`Error::Usage`] naming both.
pub fn refuse_overlap<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), Error> {
    let inputs: HashMap<PathBuf, &Path> = inputs.into_iter().map(|path| (identity(path), path)).collect();
    let mut seen = HashMap::new();
    for (number, path) in outputs.into_iter().enumerate() {
        // A device takes as many as there are.
        if is_special(path) {
            continue;
        }
        let (identity, told) = (identity(path), shown_lines(&path.display().to_string()));
        if let Some(input) = inputs.get(&identity) {
            let input = shown_lines(&input.display().to_string());
            return Err(Error::Usage(format!("the output {told} is an input: {input}; choose another name")));
        }
        if let Some(first) = seen.insert(identity, number + 1) {
            return Err(Error::Usage(format!("output {} is output {first} again: {told}", number + 1)));
        }
    }
    Ok(())
}

/// Whether a text names a file and nothing else: no folder, no drive, no control character. What comes from a file may
/// name no other place to write to.
#[cfg(feature = "batch")]
pub fn is_plain_name(name: &str) -> bool {
    use std::path::Component;
    let mut components = Path::new(name).components();
    let only = (components.next(), components.next());
    matches!(only, (Some(Component::Normal(only)), None) if only == name)
        && !name.contains(['/', '\\', ':'])
        && !name.chars().any(char::is_control)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_name_stays_in_its_folder() {
        for good in ["a.png", ".a", "größe 2.exr", "a..b"] {
            assert!(is_plain_name(good), "{good}");
        }
        for bad in ["", ".", "..", "a/", "/a", "a/b", "../a", "a\\b", "c:a", "a\0", "a\n"] {
            assert!(!is_plain_name(bad), "{bad:?}");
        }
    }

    #[test]
    fn what_is_rescued_has_a_name_that_nobody_could_foresee() {
        let fill = |file: &mut File| io::Write::write_all(file, b"abc").map_err(|e| e.to_string());
        let long = format!("{}.png", "x".repeat(250));
        let [a, b] = [(); 2].map(|()| rescue(Path::new(&long), fill).unwrap());
        for (path, bytes) in [&a, &b] {
            let name = path.file_name().unwrap().to_str().unwrap();
            assert!(name.starts_with("gemtrace-") && name.ends_with("x.png"), "{name}");
            assert_eq!((fs::read(path).unwrap(), *bytes), (b"abc".to_vec(), 3));
            fs::remove_file(path).unwrap();
        }
        assert_ne!(a.0, b.0);
    }

    #[cfg(unix)]
    #[test]
    fn what_another_process_is_writing_is_no_leftover() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut written = Temporary::new(folder.path(), &path).unwrap();
        let left = folder.path().join(".gemtrace-a.png-aB3xYz.tmp");
        fs::write(&left, "half").unwrap();
        remove_leftovers(std::slice::from_ref(&path));
        assert!(!left.exists());
        io::Write::write_all(written.file(), b"whole").unwrap();
        written.persist(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_of_a_name_from_a_file_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let [link, other] = ["link", "other"].map(|name| folder.path().join(name));
        fs::write(&other, "mine").unwrap();
        std::os::unix::fs::symlink(&other, &link).unwrap();
        replace(&link, |file| io::Write::write_all(file, b"new").map_err(|e| e.to_string())).unwrap();
        assert_eq!(
            (fs::read(&other).unwrap(), fs::read(&link).unwrap()),
            (b"mine".to_vec(), b"new".to_vec())
        );
    }
}
