//! The files that scenes name: found, hashed, and decoded once for all scenes that name them.

use super::fields::Entry;
use crate::{Error, import};
use sha2::{Digest, Sha256};
use spectral_core::Warning;
use spectral_core::environment::{LatLong, LightModel};
use spectral_core::mesh::Mesh;
use spectral_core::shape::ShapeSpec;
use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// A file that a scene names, as it was when it was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceFile {
    /// Where it is.
    pub path: PathBuf,
    /// Its size, bytes.
    pub bytes: u64,
    /// SHA-256 of its contents, in hexadecimal.
    pub sha256: String,
}

/// The most light models and shapes that are kept.
const MADE: usize = 16;

/// What the files of earlier scenes were decoded to, so that a scene that names them again need not read them.
///
/// A file counts as the same while its size and its time of change are. What the latest scene did not name is forgotten,
/// but for the latest so many that [`keeping`](Assets::keeping) asks for.
#[derive(Default)]
pub struct Assets {
    known: HashMap<(PathBuf, TypeId), Asset>,
    /// What scenes before the latest named, the latest last.
    resting: Vec<((PathBuf, TypeId), Asset)>,
    /// The most that rest.
    keep: usize,
    gate: Option<Gate>,
    /// The light models that were drawn last, the latest last.
    drawn: Vec<(LightModel, Arc<LatLong>)>,
    /// The shapes that were made last, likewise.
    shaped: Vec<(ShapeSpec, Solid)>,
    /// Whether shadows on the ground are coarse.
    coarse: bool,
    /// What scenes may name in place of a file.
    made: HashMap<String, Made>,
}

/// Something for scenes that is in no file: a light ([`LatLong`]) or a solid ([`Mesh`](spectral_core::mesh::Mesh)). A scene
/// names it by its [`name`](Made::name) where it could name a file of that kind, in `image`, `cut` or `mesh`.
///
/// ```
/// use gemtrace::scene_file::{Assets, Made};
/// use spectral_core::environment::LatLong;
/// let (sky, warnings) = LatLong::new(1, 2, vec![[1.0; 3], [0.2; 3]])?;
/// let sky = Made::new(sky, b"a grey sky", warnings);
/// let text = format!("format = 1\ncamera = {{ position = [0, -20, 20], look_at = [0, 0, 0] }}\nenvironment.image = '{}'", sky.name());
/// let mut assets = Assets::default();
/// assets.offer([sky]);
/// assert_eq!(assets.parse(&text, "".as_ref(), "".as_ref())?.files.len(), 1);
/// # Ok::<(), gemtrace::Error>(())
/// ```
#[derive(Clone)]
pub struct Made(Asset);

impl Made {
    /// What it is, its contents as bytes, which go into the hash of scenes that name it, and remarks that every such scene has.
    pub fn new<T: Any + Send + Sync>(made: T, contents: &[u8], warnings: Vec<Warning>) -> Self {
        let sha256 = sha256(contents);
        let file =
            SourceFile { path: format!("memory:{sha256}").into(), bytes: contents.len() as u64, sha256 };
        Made(Asset { file, changed: None, decoded: Arc::new(made), warnings })
    }

    /// What it is, if that is a `T`.
    pub fn contents<T: Any + Send + Sync>(&self) -> Option<Arc<T>> {
        Arc::clone(&self.0.decoded).downcast().ok()
    }

    /// Its name in scenes: the same for the same contents.
    pub fn name(&self) -> String {
        self.0.file.path.display().to_string()
    }
}

/// The solid of a shape, and what was accepted with a remark.
type Solid = (Arc<Mesh>, Vec<Warning>);

/// Says where a file is that a scene names, or why it may not be read.
pub type Gate = Arc<dyn Fn(&Path) -> Result<PathBuf, Error> + Send + Sync>;

impl Assets {
    /// Also keeps up to `files` files that only earlier scenes named, and reads none that `gate` refuses.
    pub fn keeping(files: usize, gate: Gate) -> Self {
        Assets { keep: files, gate: Some(gate), ..Assets::default() }
    }

    /// Whether shadows on a diffuse ground are coarse from now on: a frame of something that moves cannot wait for fine ones.
    #[cfg(feature = "view")]
    pub(crate) fn shade_coarsely(&mut self, coarse: bool) {
        self.coarse = coarse;
    }

    /// The image of a light model.
    pub(crate) fn drawn(&mut self, model: &LightModel) -> Result<Arc<LatLong>, spectral_core::Error> {
        remembered(&mut self.drawn, model, || Ok(Arc::new(model.image()?)))
    }

    /// What the scenes that follow may name in place of files; what was offered before is forgotten.
    pub fn offer(&mut self, made: impl IntoIterator<Item = Made>) {
        self.made = made.into_iter().map(|made| (made.name(), made)).collect();
    }

    /// Takes out what is known of a file, if it is still the same.
    fn take(&mut self, key: &(PathBuf, TypeId)) -> Option<Asset> {
        let resting = self.resting.iter().position(|(name, _)| name == key);
        let known = self.known.remove(key).or_else(|| resting.map(|at| self.resting.remove(at).1));
        known.filter(Asset::is_current)
    }

    /// Keeps what a scene used for the next one.
    fn keep(&mut self, used: HashMap<(PathBuf, TypeId), Asset>) {
        self.resting.extend(std::mem::replace(&mut self.known, used));
        let most = self.resting.len().saturating_sub(self.keep);
        self.resting.drain(..most);
    }
}

/// What was made of a key before, or is made now.
fn remembered<K: Clone + PartialEq, T: Clone>(
    known: &mut Vec<(K, T)>,
    key: &K,
    make: impl FnOnce() -> Result<T, spectral_core::Error>,
) -> Result<T, spectral_core::Error> {
    if let Some((_, made)) = known.iter().find(|(other, _)| other == key) {
        return Ok(made.clone());
    }
    let made = make()?;
    if known.len() == MADE {
        known.remove(0);
    }
    known.push((key.clone(), made.clone()));
    Ok(made)
}

/// A file, and what one of its readers made of it.
#[derive(Clone)]
struct Asset {
    file: SourceFile,
    changed: Option<SystemTime>,
    decoded: Arc<dyn Any + Send + Sync>,
    warnings: Vec<Warning>,
}

impl Asset {
    fn is_current(&self) -> bool {
        std::fs::metadata(&self.file.path)
            .is_ok_and(|data| data.len() == self.file.bytes && data.modified().ok() == self.changed)
    }
}

/// What one scene has read so far.
pub(super) struct Sources<'a> {
    folder: PathBuf,
    earlier: &'a mut Assets,
    used: HashMap<(PathBuf, TypeId), Asset>,
    hash: Hash,
    pub files: Vec<SourceFile>,
    pub warnings: Vec<Warning>,
}

impl<'a> Sources<'a> {
    pub fn new(text: &str, folder: &Path, earlier: &'a mut Assets) -> Self {
        let mut hash = Hash::new();
        hash.add(text.as_bytes());
        let (used, files, warnings) = (HashMap::new(), Vec::new(), Vec::new());
        Sources { folder: folder.to_owned(), earlier, used, hash, files, warnings }
    }

    /// A file that the scene names, decoded by `reader`, which owns the bytes and may drop them before it is done.
    pub fn read<T: Any + Send + Sync>(
        &mut self,
        name: &str,
        reader: impl FnOnce(&Path, Vec<u8>) -> Result<(T, Vec<Warning>), Error>,
    ) -> Result<Arc<T>, Error> {
        self.read_variant(name, "", reader)
    }

    /// The same where a reader makes several things of one file: `variant` tells them apart.
    pub fn read_variant<T: Any + Send + Sync>(
        &mut self,
        name: &str,
        variant: &str,
        reader: impl FnOnce(&Path, Vec<u8>) -> Result<(T, Vec<Warning>), Error>,
    ) -> Result<Arc<T>, Error> {
        if let Some(Made(asset)) = self.earlier.made.get(name).cloned() {
            return self.take_note(&asset);
        }
        let path = self.folder.join(name);
        let path = self.earlier.gate.as_ref().map_or(Ok(path.clone()), |gate| gate(&path))?;
        let mut kind = path.clone().into_os_string();
        kind.push(variant);
        let key = (PathBuf::from(kind), TypeId::of::<T>());
        let known = self.used.get(&key).cloned();
        let known = known.or_else(|| self.earlier.take(&key));
        let asset = match known {
            Some(asset) => asset,
            None => {
                // Before the contents, so that a change in between is noticed the next time.
                let changed = std::fs::metadata(&path).and_then(|data| data.modified()).ok();
                let contents = import::read_file(&path)?;
                let (bytes, sha256) = (contents.len() as u64, sha256(&contents));
                let (decoded, warnings) = reader(&path, contents)?;
                let file = SourceFile { path, bytes, sha256 };
                Asset { file, changed, decoded: Arc::new(decoded), warnings }
            }
        };
        let decoded = self.take_note(&asset)?;
        self.used.insert(key, asset);
        Ok(decoded)
    }

    /// What an asset was decoded to; the scene names it.
    fn take_note<T: Any + Send + Sync>(&mut self, asset: &Asset) -> Result<Arc<T>, Error> {
        if !self.files.contains(&asset.file) {
            self.hash.add(asset.file.sha256.as_bytes());
            self.files.push(asset.file.clone());
        }
        self.warn(asset.warnings.clone());
        let decoded = Arc::clone(&asset.decoded).downcast();
        decoded.map_err(|_| Error::file(&asset.file.path, "this is another kind of file"))
    }

    /// The same for the file that an entry names; complaints come with the entry's line.
    pub fn import<T: Any + Send + Sync>(
        &mut self,
        entry: &Entry,
        reader: impl FnOnce(&Path, Vec<u8>) -> Result<(T, Vec<Warning>), Error>,
    ) -> Result<Arc<T>, Error> {
        self.read(entry.text("the name of a file")?, reader).map_err(|e| entry.error(e))
    }

    /// The image of a light model.
    pub fn drawn(&mut self, model: &LightModel) -> Result<Arc<LatLong>, spectral_core::Error> {
        self.earlier.drawn(model)
    }

    /// The solid of a shape.
    pub fn shaped(&mut self, shape: &ShapeSpec) -> Result<Arc<Mesh>, spectral_core::Error> {
        let (mesh, warnings) = remembered(&mut self.earlier.shaped, shape, || {
            let (mesh, warnings) = shape.cut()?.solid()?;
            Ok((Arc::new(mesh), warnings))
        })?;
        self.warn(warnings);
        Ok(mesh)
    }

    /// Whether shadows on the ground are coarse.
    pub fn shades_coarsely(&self) -> bool {
        self.earlier.coarse
    }

    /// Adds what was not yet said.
    pub fn warn(&mut self, warnings: Vec<Warning>) {
        for warning in warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
    }

    /// The scene is read: keeps what it used for the next one. Returns its hash.
    pub fn finish(&mut self) -> String {
        self.earlier.keep(std::mem::take(&mut self.used));
        std::mem::replace(&mut self.hash, Hash::new()).finish()
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
