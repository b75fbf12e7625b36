//! What has been done: JSON Lines, one fact a line, only ever appended to.
//!
//! A run, or a shard of it, has a manifest of its own in the output folder: `manifest.jsonl`, or
//! `manifest-3-of-8.jsonl`. A line is written whole and reaches the disk before the next item is begun, and the pictures
//! are there before the line that says so. So a process can be killed at any moment: the last line may be torn, which
//! is then as if it were not there. Whoever looks for what is done reads all manifests of a folder, so that another
//! number of shards finds what an earlier one left.

use crate::scene_file::{SourceFile, source::sha256};
use crate::shard::Shard;
use crate::{Error, import};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write as _;
use std::path::{Component, Path, PathBuf};

/// One line of a manifest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "status", rename_all = "lowercase")]
pub enum Event {
    /// Work on an item has begun. With no other line after it, the process ended before the item did.
    Started {
        /// The item's name.
        item: String,
        /// See [`Plan::identity`](super::Plan::identity).
        identity: String,
    },
    /// An item's pictures are on the disk.
    Done(Box<Done>),
    /// An item could not be rendered or written.
    Failed {
        /// The item's name.
        item: String,
        /// See [`Plan::identity`](super::Plan::identity).
        identity: String,
        /// What sets it apart.
        #[serde(default)]
        values: Map<String, Value>,
        /// Why, for people.
        message: String,
        /// What the program would have returned for it alone (see [`Error::exit_code`]).
        exit_code: u8,
    },
}

/// An item that is done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Its name.
    pub item: String,
    /// What it was made from but for the inputs; see [`Plan::identity`](super::Plan::identity).
    pub identity: String,
    /// What sets it apart.
    #[serde(default)]
    pub values: Map<String, Value>,
    /// The files that its scene names, below the plan's folder.
    pub inputs: Vec<FileRecord>,
    /// Its pictures, below the output folder.
    pub outputs: Vec<FileRecord>,
    /// SHA-256 over the scene and all that it names, as in the pictures' headers.
    pub scene_hash: String,
    /// Size and settings of the render, under the names that scene files use.
    pub settings: Value,
    /// This program's version.
    pub version: String,
    /// The devices that rendered it.
    pub devices: Value,
    /// Why the last of them was taken.
    pub choice: String,
    /// Segments traced.
    pub rays: u64,
    /// Shares of the energy that started: dropped at the threshold or the depth limit, and the like.
    pub energy: Value,
    /// How long it took.
    pub seconds: Seconds,
    /// What was accepted with a remark.
    #[serde(default)]
    pub warnings: Vec<String>,
}

/// Times of an item, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Seconds {
    /// From reading the scene to the last file.
    pub total: f64,
    /// Building acceleration structures.
    pub build: f64,
    /// Tracing rays.
    pub trace: f64,
}

/// A file as it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FileRecord {
    /// Its path, with `/` between folders.
    pub path: String,
    /// Its size.
    pub bytes: u64,
    /// SHA-256 of its contents, in hexadecimal.
    pub sha256: String,
}

impl FileRecord {
    /// The record of a file as it is now; `path` is what is recorded, `place` is where it is.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be read.
    pub fn of(path: &str, place: &Path) -> Result<Self, Error> {
        let contents = import::read_file(place)?;
        Ok(FileRecord { path: path.to_owned(), bytes: contents.len() as u64, sha256: sha256(&contents) })
    }

    /// The record of a file that a scene names; its path is relative to `folder` where it is below it.
    pub fn of_source(file: &SourceFile, folder: &Path) -> Self {
        let path = file.path.strip_prefix(folder).unwrap_or(&file.path);
        let path = path.to_string_lossy().replace('\\', "/");
        FileRecord { path, bytes: file.bytes, sha256: file.sha256.clone() }
    }

    /// Whether the file is still as it was.
    pub fn holds(&self, place: &Path) -> bool {
        std::fs::metadata(place).is_ok_and(|data| data.len() == self.bytes)
            && FileRecord::of(&self.path, place).is_ok_and(|now| now.sha256 == self.sha256)
    }
}

impl Event {
    /// The item that it is about.
    pub fn item(&self) -> &str {
        match self {
            Event::Started { item, .. } | Event::Failed { item, .. } => item,
            Event::Done(done) => &done.item,
        }
    }

    /// What the item was made from; see [`Plan::identity`](super::Plan::identity).
    pub fn identity(&self) -> &str {
        match self {
            Event::Started { identity, .. } | Event::Failed { identity, .. } => identity,
            Event::Done(done) => &done.identity,
        }
    }
}

/// The manifest's name: of a whole run, or of a shard.
pub fn name(shard: Shard) -> String {
    match shard {
        Shard::WHOLE => "manifest.jsonl".to_owned(),
        _ => format!("manifest-{}-of-{}.jsonl", shard.index() + 1, shard.count()),
    }
}

/// The shard whose manifest has this name.
pub fn shard_of(name: &str) -> Option<Shard> {
    let inner = name.strip_prefix("manifest")?.strip_suffix(".jsonl")?;
    match inner.strip_prefix('-') {
        None => inner.is_empty().then_some(Shard::WHOLE),
        Some(numbers) => {
            let (index, count) = numbers.split_once("-of-")?;
            Shard::new(index.parse::<u32>().ok()?.checked_sub(1)?, count.parse().ok()?)
        }
    }
}

/// All manifests of a folder, by their names.
///
/// # Errors
/// [`Error::File`] if the folder cannot be read.
pub fn all(folder: &Path) -> Result<Vec<(Shard, PathBuf)>, Error> {
    let refuse = |e: std::io::Error| Error::file(folder, format!("cannot be read: {e}"));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(refuse)? {
        let entry = entry.map_err(refuse)?;
        if let Some(shard) = entry.file_name().to_str().and_then(shard_of) {
            found.push((shard, entry.path()));
        }
    }
    found.sort();
    Ok(found)
}

/// The lines of one manifest; those that are no lines of a manifest, such as a torn last one, are left out.
///
/// # Errors
/// [`Error::File`] if it cannot be read.
pub fn read(path: &Path) -> Result<Vec<Event>, Error> {
    Ok(parse(&import::read_file(path)?))
}

/// The lines of a manifest from its bytes. A line that names an output outside of its folder is none of ours.
pub fn parse(bytes: &[u8]) -> Vec<Event> {
    let line = |line: &[u8]| serde_json::from_slice(line).ok().filter(stays_inside);
    bytes.split(|byte| *byte == b'\n').filter_map(line).collect()
}

/// Whether all outputs are below the folder: they are read, compared and shown.
fn stays_inside(event: &Event) -> bool {
    let plain = |file: &FileRecord| {
        Path::new(&file.path).components().all(|part| matches!(part, Component::Normal(_)))
    };
    !matches!(event, Event::Done(done) if !done.outputs.iter().all(plain))
}

/// The lines of all manifests of a folder by their items, those of one manifest in order.
///
/// # Errors
/// [`Error::File`] if one cannot be read.
pub fn read_all(folder: &Path) -> Result<HashMap<String, Vec<Event>>, Error> {
    let mut known: HashMap<String, Vec<Event>> = HashMap::new();
    for (_, path) in all(folder)? {
        for line in read(&path)? {
            known.entry(line.item().to_owned()).or_default().push(line);
        }
    }
    Ok(known)
}

/// A manifest that is being written.
#[derive(Debug)]
pub struct Manifest {
    path: PathBuf,
    file: File,
    /// Lines that could not be written yet.
    pending: String,
}

impl Manifest {
    /// Opens a shard's manifest in a folder, and keeps others from working on the same shard meanwhile, as far as the
    /// file system has locks. They end with the process.
    ///
    /// # Errors
    /// [`Error::Output`] if it cannot be written to, or another process has it.
    pub fn open(folder: &Path, shard: Shard) -> Result<Self, Error> {
        let path = folder.join(name(shard));
        let refuse = |e: std::io::Error| Error::output(&path, format!("cannot be written ({e})"));
        let file = OpenOptions::new().read(true).append(true).create(true).open(&path).map_err(refuse)?;
        // Elsewhere a lock keeps readers out, too, and other shards read this.
        if cfg!(unix) && matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            let message = "another process is at work on this; wait for it, or stop it";
            return Err(Error::output(path, message));
        }
        let mut manifest = Manifest { path, file, pending: String::new() };
        manifest.mend().map_err(|e| Error::output(&manifest.path, format!("cannot be read ({e})")))?;
        Ok(manifest)
    }

    /// A torn last line must not spoil the next.
    fn mend(&mut self) -> std::io::Result<()> {
        use std::io::{Read as _, Seek as _, SeekFrom};
        if self.file.metadata()?.len() > 0 {
            let mut last = [0];
            self.file.seek(SeekFrom::End(-1))?;
            self.file.read_exact(&mut last)?;
            if last != *b"\n" {
                self.pending.push('\n');
            }
        }
        Ok(())
    }

    /// Appends a line and sees it to the disk. A line that cannot be written is kept, and goes with the next.
    ///
    /// # Errors
    /// [`Error::Output`], with a full disk for example.
    pub fn append(&mut self, line: &Event) -> Result<(), Error> {
        match serde_json::to_string(line) {
            Ok(text) => self.pending += &(text + "\n"),
            Err(e) => return Err(Error::output(&self.path, format!("cannot be written ({e})"))),
        }
        self.flush()
    }

    /// Tries to write what is kept.
    ///
    /// # Errors
    /// As [`Manifest::append`].
    pub fn flush(&mut self) -> Result<(), Error> {
        if self.pending.is_empty() {
            return Ok(());
        }
        let refuse = |e: std::io::Error| Error::output(&self.path, format!("cannot be written ({e})"));
        let before = self.file.metadata().map_err(refuse)?.len();
        let written = self.file.write_all(self.pending.as_bytes()).and_then(|()| self.file.sync_data());
        if let Err(error) = written {
            // Half a line would tear the next one.
            if self.file.set_len(before).is_err() && !self.pending.starts_with('\n') {
                self.pending.insert(0, '\n');
            }
            return Err(refuse(error));
        }
        self.pending.clear();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn started(item: &str) -> Event {
        Event::Started { item: item.into(), identity: "0".into() }
    }

    #[test]
    fn names_tell_the_shard() {
        for shard in [Shard::WHOLE, Shard::of(2, 8), Shard::of(0, 2)] {
            assert_eq!(shard_of(&name(shard)), Some(shard));
        }
        assert_eq!(name(Shard::of(2, 8)), "manifest-3-of-8.jsonl");
        for other in
            ["manifest-0-of-2.jsonl", "manifest-3-of-2.jsonl", "manifest-.jsonl", "manifest.json", "a"]
        {
            assert_eq!(shard_of(other), None, "{other}");
        }
    }

    #[test]
    fn a_torn_line_costs_nothing_but_itself() {
        let folder = tempfile::tempdir().unwrap();
        Manifest::open(folder.path(), Shard::WHOLE).unwrap().append(&started("a")).unwrap();
        let path = folder.path().join("manifest.jsonl");
        let whole = std::fs::read(&path).unwrap();
        for kept in 0..=whole.len() {
            std::fs::write(&path, [&whole[..], &whole[..kept]].concat()).unwrap();
            Manifest::open(folder.path(), Shard::WHOLE).unwrap().append(&started("b")).unwrap();
            let items: Vec<String> = read(&path).unwrap().iter().map(|line| line.item().to_owned()).collect();
            // Torn just before its line break, a line is whole.
            let wanted: &[&str] = if kept + 1 >= whole.len() { &["a", "a", "b"] } else { &["a", "b"] };
            assert_eq!(items, wanted, "{kept}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_manifest_has_one_writer() {
        let folder = tempfile::tempdir().unwrap();
        let first = Manifest::open(folder.path(), Shard::WHOLE).unwrap();
        let message = Manifest::open(folder.path(), Shard::WHOLE).unwrap_err().to_string();
        assert!(message.contains("manifest.jsonl: another process is at work"), "{message}");
        Manifest::open(folder.path(), Shard::of(0, 2)).unwrap();
        drop(first);
        Manifest::open(folder.path(), Shard::WHOLE).unwrap();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn lines_wait_for_room_on_a_full_disk() {
        let file = OpenOptions::new().append(true).open("/dev/full").unwrap();
        let mut manifest = Manifest { path: "/dev/full".into(), file, pending: String::new() };
        for item in ["a", "b"] {
            let message = manifest.append(&started(item)).unwrap_err().to_string();
            assert!(message.contains("No space left on device"), "{message}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("manifest.jsonl");
        manifest.file = OpenOptions::new().append(true).create(true).open(&path).unwrap();
        manifest.flush().unwrap();
        assert_eq!(read(&path).unwrap(), [started("a"), started("b")]);
    }
}
