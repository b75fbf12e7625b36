//! Files under temporary names: deleted unless they are finished, by whatever the process ends.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// The files that this process is writing.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether a file is being written.
pub fn is_writing() -> bool {
    !unfinished().is_empty()
}

/// Deletes every file that is not finished, and lets no other be begun: for a process that is about to end.
pub fn abandon() {
    let files = unfinished();
    for path in files.iter() {
        // What cannot be deleted is cleared away by the next run.
        fs::remove_file(path).ok();
    }
    std::mem::forget(files);
}

const SUFFIX: &str = ".tmp";
/// Characters of a file's name that its temporary companions carry: any file system takes four bytes for each.
const NAME: usize = 48;

/// How the names of a file's temporary companions begin; hidden.
fn prefix(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!(".gemtrace-{}-", name.chars().take(NAME).collect::<String>())
}

/// A file that is deleted unless it is renamed. Its name is random, and it was not there before; it has the permissions
/// of any new file. It is locked, so that other processes know that it is being written.
pub(super) struct Temporary {
    file: NamedTempFile,
    /// Dropped after the file.
    _listed: Listed,
}

/// An entry of [`UNFINISHED`].
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

impl Temporary {
    /// In `folder`, for a file that is to have the name of `path`.
    pub fn new(folder: &Path, path: &Path) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        let prefix = prefix(path);
        builder.prefix(&prefix).suffix(SUFFIX);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut files = unfinished();
        let file = builder.tempfile_in(folder)?;
        files.push(file.path().to_owned());
        let listed = Listed(file.path().to_owned());
        // Elsewhere a locked file cannot be renamed.
        if cfg!(unix) {
            file.as_file().try_lock().ok();
        }
        Ok(Temporary { file, _listed: listed })
    }

    pub fn file(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// Gives it its name; what had this name is replaced.
    pub fn persist(self, path: &Path) -> io::Result<()> {
        self.file.persist(path).map(drop).map_err(|e| e.error)
    }

    /// Gives it a name of its own, as random as its temporary one, that nothing has: `gemtrace-aB3xYz-NAME`.
    pub fn keep(self, path: &Path) -> io::Result<PathBuf> {
        let own = self.file.path().file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let random = own.rsplit('-').next().unwrap_or_default();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let end = name.chars().count().saturating_sub(NAME);
        let name: String = name.chars().skip(end).collect();
        let kept = self.file.path().with_file_name(format!("gemtrace-{random}-{name}"));
        self.file.persist_noclobber(&kept).map_err(|e| e.error)?;
        Ok(kept)
    }
}

/// Deletes what processes that were killed left of these files: temporary ones, never those under their own names, nor
/// those that another process is writing.
pub(super) fn remove_leftovers<'a>(files: impl Iterator<Item = (PathBuf, &'a Path)>) {
    let mut expected: HashMap<PathBuf, HashSet<String>> = HashMap::new();
    for (folder, path) in files {
        expected.entry(folder).or_default().insert(prefix(path));
    }
    for (folder, prefixes) in &expected {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let name = name.to_str().and_then(|name| name.strip_suffix(SUFFIX));
            // What follows the prefix is random, without a hyphen.
            let left = name.and_then(|name| name.rfind('-').map(|hyphen| &name[..=hyphen]));
            let ours = left.is_some_and(|prefix| prefixes.contains(prefix));
            if ours && entry.file_type().is_ok_and(|kind| kind.is_file()) && !is_locked(&entry.path()) {
                // If it cannot be deleted, it does no harm.
                fs::remove_file(entry.path()).ok();
            }
        }
    }
}

/// Whether a process has the file; not where the file system has no locks.
fn is_locked(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}
