//! The files that a view may read: those of the folder that it was started in, those that were named when it was started,
//! and those that were dropped onto the page.

use super::hub::locked;
use super::message::Refusal;
use crate::Error;
use crate::output::is_plain_name;
use crate::scene_file::Gate;
use sha2::{Digest, Sha256};
use spectral_core::shown;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use tempfile::TempDir;

/// The largest file that is taken, bytes.
pub const LARGEST: u64 = 64 << 20;
/// The most that all dropped files together may take, bytes, and their number.
const MOST: u64 = 1 << 30;
const MOST_FILES: usize = 1000;

pub struct Store {
    /// The folder that the program was started in.
    start: PathBuf,
    /// Where dropped files lie, each in a folder of its own; what it is really called.
    drops: PathBuf,
    /// Removes it.
    _drops: TempDir,
    kept: Mutex<Kept>,
}

#[derive(Default)]
struct Kept {
    /// Files beyond the folder that may be read.
    granted: Vec<PathBuf>,
    /// Dropped files, the latest last.
    dropped: Vec<PathBuf>,
    bytes: u64,
}

impl Store {
    /// Reads files of `start`, and keeps what is dropped among the temporary files of `temporary`.
    ///
    /// # Errors
    /// [`Error::File`] and [`Error::Output`] for folders that cannot be used.
    pub fn new(start: &Path, temporary: &Path) -> Result<Self, Error> {
        let start = start.canonicalize().map_err(|e| Error::file(start, format!("cannot be used: {e}")))?;
        let unfit = |e| Error::output(temporary, format!("cannot be used: {e}"));
        let folder =
            tempfile::Builder::new().prefix("gemtrace-view-").tempdir_in(temporary).map_err(unfit)?;
        // The way to it may be a link, which is followed before a file is compared with it.
        let drops = folder.path().canonicalize().map_err(unfit)?;
        Ok(Store { start, drops, _drops: folder, kept: Mutex::default() })
    }

    pub fn start(&self) -> &Path {
        &self.start
    }

    /// Removes what was dropped.
    pub fn clear(&self) {
        // What cannot be removed lies among temporary files.
        drop(std::fs::remove_dir_all(&self.drops));
    }

    /// Allows a file that the command line named, or that a scene of the command line names.
    pub fn grant(&self, path: &Path) {
        if let Ok(path) = path.canonicalize() {
            locked(&self.kept).granted.push(path);
        }
    }

    /// Says of every file that a scene names whether it may be read.
    pub fn gate(self: &Arc<Self>) -> Gate {
        let store = Arc::clone(self);
        Arc::new(move |path: &Path| store.admit(path))
    }

    /// The real place of a file that may be read. Links are followed first, so that none leads elsewhere.
    pub fn admit(&self, asked: &Path) -> Result<PathBuf, Error> {
        // A dropped scene names files as if they lay beside it.
        let inside = asked.strip_prefix(&self.drops).ok().filter(|_| !asked.exists());
        let path = inside.map(|inside| self.find(&inside.components().skip(1).collect::<PathBuf>()));
        let path = path.as_deref().unwrap_or(asked);
        let real = path.canonicalize().ok();
        // Of a file that is not there, the folder decides whether that may be known.
        let place = real.clone().or_else(|| path.parent().unwrap_or(path).canonicalize().ok());
        let allowed = place.is_some_and(|place| {
            [&self.start, &self.drops].iter().any(|folder| place.starts_with(folder))
                || locked(&self.kept).granted.contains(&place)
        });
        if allowed {
            Ok(real.unwrap_or_else(|| path.to_owned()))
        } else {
            Err(Error::file(path, self.allowed()))
        }
    }

    fn allowed(&self) -> String {
        let start = self.start.display();
        format!(
            "may not be read: only files of {start} may, where the view was started, and files that were dropped"
        )
    }

    /// Keeps a dropped file. The same file twice is kept once.
    pub fn keep(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, Refusal> {
        let refuse = |why: String, code| Refusal {
            what: format!("{} was not opened", shown(name)),
            why,
            code,
            ..Refusal::default()
        };
        if !is_plain_name(name) {
            return Err(refuse("this is no plain name of a file".to_owned(), "name"));
        }
        let digest =
            Sha256::digest(bytes).iter().take(16).fold(String::new(), |text, b| text + &format!("{b:02x}"));
        let folder = self.drops.join(digest);
        let path = folder.join(name);
        let mut kept = locked(&self.kept);
        kept.dropped.retain(|other| *other != path);
        if !path.exists() {
            if kept.bytes + bytes.len() as u64 > MOST || kept.dropped.len() >= MOST_FILES {
                let most = MOST >> 20;
                let why =
                    format!("up to {MOST_FILES} files of {most} MB in all are taken; start the view again");
                return Err(refuse(why, "size"));
            }
            let written = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, bytes));
            written.map_err(|e| refuse(format!("it cannot be kept: {e}"), "disk"))?;
            kept.bytes += bytes.len() as u64;
        }
        kept.dropped.push(path.clone());
        Ok(path)
    }

    /// Where a file is that a dropped scene names: it was dropped, too, or lies in the start folder.
    fn find(&self, path: &Path) -> PathBuf {
        let kept = locked(&self.kept);
        let last = path.file_name();
        let dropped = kept.dropped.iter().rev().find(|dropped| last.is_some() && dropped.file_name() == last);
        let inside = self.start.join(path);
        if inside.exists() { inside } else { dropped.cloned().unwrap_or(inside) }
    }

    /// Whether a file was dropped.
    pub fn is_dropped(&self, path: &Path) -> bool {
        path.starts_with(&self.drops)
    }

    /// A file as it is called in lists and messages: from the start folder, or by its name alone.
    pub fn label(&self, path: &Path) -> String {
        let inside = path.strip_prefix(&self.start);
        let name = inside.unwrap_or_else(|_| Path::new(path.file_name().unwrap_or_default()));
        name.to_string_lossy().replace('\\', "/")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with_neighbour() -> (TempDir, Store) {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [("secret.csv", "1"), ("start/own.csv", "2"), ("start/deep/own.csv", "3")] {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        // Temporary files behind a link, as on some systems.
        std::fs::create_dir(folder.path().join("real")).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink("real", folder.path().join("temporary")).unwrap();
        #[cfg(not(unix))]
        std::fs::create_dir(folder.path().join("temporary")).unwrap();
        let [start, temporary] = ["start", "temporary"].map(|name| folder.path().join(name));
        let store = Store::new(&start, &temporary).unwrap();
        (folder, store)
    }

    #[test]
    fn only_what_is_allowed_is_read() {
        let (folder, store) = folder_with_neighbour();
        let dropped = store.keep("a.asc", b"x").unwrap();
        let inside = |name: &str| store.start().join(name);
        let mut cases = vec![
            (inside("own.csv"), true),
            (inside("deep/../own.csv"), true),
            (inside("missing.csv"), true),
            (dropped, true),
            (inside("../secret.csv"), false),
            (inside("deep/../../secret.csv"), false),
            (inside("../missing.csv"), false),
            (inside("../start"), true),
            (folder.path().join("secret.csv"), false),
            (PathBuf::from("/etc/passwd"), false),
            (PathBuf::from("/no/such/place"), false),
        ];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(folder.path().join("secret.csv"), inside("link.csv")).unwrap();
            std::os::unix::fs::symlink(folder.path(), inside("up")).unwrap();
            cases.extend([
                (inside("link.csv"), false),
                (inside("up/secret.csv"), false),
                (inside("up/start/own.csv"), true),
            ]);
        }
        for (path, allowed) in cases {
            let found = store.admit(&path);
            assert_eq!(found.is_ok(), allowed, "{path:?} {found:?}");
            assert!(found.map_or_else(|e| e.to_string().contains("dropped"), |_| true));
        }
        store.grant(&folder.path().join("secret.csv"));
        assert!(store.admit(&inside("../secret.csv")).is_ok());
    }

    #[test]
    fn dropped_names_are_plain() {
        let (_folder, store) = folder_with_neighbour();
        for name in ["../a.asc", "/a", "a/b", "", "..", "c:a"] {
            assert!(store.keep(name, b"x").is_err(), "{name}");
        }
        let [first, second] = [b"x", b"y"].map(|bytes| store.keep("a.asc", bytes).unwrap());
        assert!(first != second && store.keep("a.asc", b"x").unwrap() == first && store.is_dropped(&first));
        assert_eq!(store.find("parts/a.asc".as_ref()), first);
        assert_eq!(store.find("own.csv".as_ref()), store.start().join("own.csv"));
        assert_eq!(store.label(&store.find("deep/own.csv".as_ref())), "deep/own.csv");
        assert_eq!(store.label(&first), "a.asc");
    }

    #[test]
    fn there_is_an_end_to_files() {
        let (_folder, store) = folder_with_neighbour();
        for k in 0..MOST_FILES {
            store.keep(&format!("{k}.asc"), b"x").unwrap();
        }
        assert!(store.keep("more.asc", b"x").unwrap_err().why.contains("1000 files"));
        store.keep("7.asc", b"x").unwrap();
    }
}
