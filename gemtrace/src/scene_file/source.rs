//! The files that a scene names: found, read once, hashed and remembered.

use super::fields::Entry;
use crate::{Error, import};
use sha2::{Digest, Sha256};
use spectral_core::Warning;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// What the scene has read so far.
pub(super) struct Sources {
    folder: PathBuf,
    pub files: Vec<PathBuf>,
    /// Of each file, if it is small.
    contents: Vec<Option<Contents>>,
    pub hash: Hash,
    pub warnings: Vec<Warning>,
}

/// Files up to this size are remembered, bytes; a larger one that is named again is read again.
const REMEMBERED: usize = 1 << 20;

/// The bytes of a file. Large ones are its reader's alone, and may be dropped before it is done.
#[derive(Clone)]
pub(super) struct Contents(Rc<Vec<u8>>);

impl AsRef<[u8]> for Contents {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl Sources {
    pub fn new(text: &str, folder: &Path) -> Self {
        let mut hash = Hash::new();
        hash.add(text.as_bytes());
        Sources {
            folder: folder.to_owned(),
            files: Vec::new(),
            contents: Vec::new(),
            hash,
            warnings: Vec::new(),
        }
    }

    /// A file named by the scene, with its path from here.
    pub fn read(&mut self, name: &str) -> Result<(PathBuf, Contents), Error> {
        let path = self.folder.join(name);
        let known = self.files.iter().position(|f| *f == path);
        if let Some(contents) = known.and_then(|known| self.contents[known].clone()) {
            return Ok((path, contents));
        }
        let contents = Contents(Rc::new(import::read_file(&path)?));
        self.hash.add(contents.as_ref());
        if known.is_none() {
            self.files.push(path.clone());
            self.contents.push((contents.as_ref().len() <= REMEMBERED).then(|| contents.clone()));
        }
        Ok((path, contents))
    }

    /// What `reader` makes of the file that an entry names; its complaints come with the entry's line.
    pub fn import<T>(
        &mut self,
        entry: &Entry,
        reader: impl FnOnce(&Path, Contents) -> Result<(T, Vec<Warning>), Error>,
    ) -> Result<T, Error> {
        let name = entry.text("the name of a file")?;
        let read = self.read(name).and_then(|(path, contents)| reader(&path, contents));
        let (value, warnings) = read.map_err(|e| entry.error(e))?;
        self.warn(warnings);
        Ok(value)
    }

    /// Adds what was not yet said.
    pub fn warn(&mut self, warnings: Vec<Warning>) {
        for warning in warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
    }
}

/// SHA-256 over parts, each preceded by its length, so that no two inputs run into each other.
pub(crate) struct Hash(Sha256);

impl Hash {
    /// Of nothing yet.
    pub fn new() -> Self {
        Hash(Sha256::new())
    }

    /// One more part.
    pub fn add(&mut self, part: &[u8]) {
        self.0.update((part.len() as u64).to_le_bytes());
        self.0.update(part);
    }

    /// In hexadecimal.
    pub fn finish(self) -> String {
        hexadecimal(&self.0.finalize())
    }
}

/// SHA-256 of a file's bytes and nothing else, as `sha256sum` prints it.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
