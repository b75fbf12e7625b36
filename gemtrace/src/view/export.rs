//! What is taken away: pictures, scenes, turns, and the command that renders the same. Files are written to one folder and
//! nowhere else, under names that no request chooses.

use super::desk;
use super::hub::{Client, locked};
use super::inbox::Sessions;
use super::message::{Format, Letter, Refusal};
use super::sight::{Sight, Sights};
use super::store::Store;
use super::watch::Patience;
use crate::batch::plain;
use crate::batch::sweep::base::rename_files;
use crate::output::{self, Options, Picture, Target, animation};
use crate::scene_file::{Assets, Draft};
use crate::sequence::Motion;
use crate::{Error, Watch};
use serde_json::{Value, json};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Frames of a turn, and how many are shown a second.
const FRAMES: u32 = 36;
const RATE: u16 = 18;

pub struct Export {
    pub store: Arc<Store>,
    pub sights: Arc<Sights>,
    pub sessions: Sessions,
    /// The folder that files are written to, and what has been written there.
    pub folder: PathBuf,
    pub written: Mutex<Vec<PathBuf>>,
    /// The last scene that was written, and where.
    pub last: Mutex<Option<(String, PathBuf)>>,
}

impl Export {
    /// Saves into the folder; the message `saved`. Who asked is told how far a turn is; if they leave, it ends.
    pub fn save(&self, client: &Client, side: Letter, format: Format, id: u64) -> Value {
        let made = std::fs::create_dir_all(&self.folder);
        let made = made.map_err(|e| Error::output(&self.folder, format!("cannot be made ({e})")));
        let sight = self.sights.get(side);
        let message =
            |kind: &str| json!({ "type": kind, "id": id, "side": side.name(), "format": format.name() });
        let tell = |done: u32, of: u32| {
            let mut message = message("saving");
            (message["done"], message["of"]) = (done.into(), of.into());
            client.answer(&message);
        };
        let busy = || self.sights.is_busy();
        let mut watch = Patience { busy: &busy, over: &|| client.is_gone() };
        let written = made.and(sight).and_then(|sight| match format {
            Format::Turn => self.turn(&sight, &self.folder, &mut watch, &tell),
            _ => self.write(side, &sight, format, &self.folder),
        });
        let mut message = message("saved");
        match written {
            Ok(path) => {
                message["files"] = json!([path.display().to_string()]);
                locked(&self.written).push(path);
            }
            Err(error) => {
                let what = "nothing was saved".to_owned();
                message["error"] =
                    desk::refusal(what, &error, "the picture is as before".to_owned(), None).to_json();
            }
        }
        message
    }

    /// A file for a download: its name and what is in it.
    ///
    /// # Errors
    /// What cannot be rendered or written.
    pub fn download(&self, side: Letter, format: Format) -> Result<(String, Vec<u8>), Error> {
        let sight = self.sights.get(side)?;
        let folder = tempfile::tempdir().map_err(|e| Error::output(std::env::temp_dir(), e))?;
        let path = self.write(side, &sight, format, folder.path())?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok((name, crate::import::read_file(&path)?))
    }

    /// What was saved under a name.
    pub fn saved(&self, name: &str) -> Option<Result<Vec<u8>, Error>> {
        let written = locked(&self.written);
        let path = written.iter().find(|path| path.file_name().is_some_and(|own| own == name))?;
        Some(crate::import::read_file(path))
    }

    /// The command line that renders what is seen, from a scene file that is written for it.
    ///
    /// # Errors
    /// [`Error::Output`] for a file that cannot be written.
    pub fn command(&self, sight: &Sight) -> Result<String, Error> {
        std::fs::create_dir_all(&self.folder)
            .map_err(|e| Error::output(&self.folder, format!("cannot be made ({e})")))?;
        let path = self.scene(sight, &self.folder)?;
        let picture = free(&self.folder, &path.file_stem().unwrap_or_default().to_string_lossy(), "png");
        Ok(format!("gemtrace render {}{} -o {}", device(sight), quoted(&path), quoted(&picture)))
    }

    fn write(&self, side: Letter, sight: &Sight, format: Format, folder: &Path) -> Result<PathBuf, Error> {
        match format {
            Format::Scene => self.scene(sight, folder),
            Format::Png | Format::Exr => {
                let path = free(folder, &stem(sight), format.extension());
                self.picture(side, sight)?.write(&Target::new(&path)?)?;
                Ok(path)
            }
            Format::SpectralExr => {
                let draft = sight.draft().with("render", "spectral", true);
                let path = free(folder, &(stem(sight) + "-spectral"), "exr");
                self.render(&draft)?.write(&Target::new(&path)?)?;
                Ok(path)
            }
            Format::Turn => self.turn(sight, folder, &mut (), &|_, _| {}),
        }
    }

    /// The finished picture: the one that is seen once it is done, else one that is rendered beside it.
    fn picture(&self, side: Letter, sight: &Sight) -> Result<Arc<Picture>, Error> {
        match self.sights.wait(side, sight) {
            Some(picture) => Ok(picture),
            None => self.render(&sight.draft()).map(Arc::new),
        }
    }

    fn render(&self, draft: &Draft) -> Result<Picture, Error> {
        let loaded = draft.load(&mut Assets::keeping(0, self.store.gate()))?;
        let mut session = (self.sessions)()?;
        session.output = Options::default();
        session.render(loaded)
    }

    fn turn(
        &self,
        sight: &Sight,
        folder: &Path,
        watch: &mut dyn Watch,
        tell: &dyn Fn(u32, u32),
    ) -> Result<PathBuf, Error> {
        let frames = tempfile::tempdir().map_err(|e| Error::output(std::env::temp_dir(), e))?;
        let (draft, mut session) = (sight.draft(), (self.sessions)()?);
        let mut assets = Assets::keeping(0, self.store.gate());
        let mut paths = Vec::new();
        for frame in 0..FRAMES {
            let loaded = Motion::Turntable.frame(&draft, frame, FRAMES).load(&mut assets)?;
            let path = frames.path().join(format!("{frame:04}.png"));
            tell(frame, FRAMES);
            session.render_watched(loaded, watch)?.save(&path)?;
            paths.push(path);
        }
        let path = free(folder, &(stem(sight) + "-turn"), "png");
        animation::apng(&paths, RATE, &path)?;
        Ok(path)
    }

    /// Writes a scene file that renders the same picture from where it lies. What was dropped is copied beside it.
    fn scene(&self, sight: &Sight, folder: &Path) -> Result<PathBuf, Error> {
        let mut draft = sight.draft();
        let mut copies = Vec::new();
        rename_files(&mut draft.table, &mut |name| {
            let path = Path::new(name);
            if self.store.is_dropped(path) {
                let place = beside(path, folder, &copies);
                let name = place.file_name().unwrap_or_default().to_string_lossy().into_owned();
                copies.push((path.to_owned(), place));
                return name;
            }
            relative(path, folder).to_string_lossy().replace('\\', "/")
        });
        let table = toml::to_string(&draft.table).map_err(|e| Error::output(folder, e))?;
        let text =
            format!("# Saved by gemtrace view: `gemtrace render` makes the same picture of it.\n\n{table}");
        let mut last = locked(&self.last);
        if let Some((_, path)) =
            last.as_ref().filter(|(known, path)| *known == text && path.parent() == Some(folder))
            && path.exists()
        {
            return Ok(path.clone());
        }
        for (from, to) in copies {
            let bytes = crate::import::read_file(&from)?;
            output::write_file(&to, |file| {
                std::io::Write::write_all(file, &bytes).map_err(|e| e.to_string())
            })?;
        }
        let path = free(folder, &stem(sight), "toml");
        output::write_text(&path, &text)?;
        *last = Some((text, path.clone()));
        Ok(path)
    }
}

/// The arguments that choose the device of a sight: others may round otherwise.
fn device(sight: &Sight) -> String {
    let Some(device) = &sight.device else { return String::new() };
    let number = if device.index > 0 { format!("--device {} ", device.index) } else { String::new() };
    format!("--backend {} {number}", device.backend)
}

/// The name of a scene, for names of files.
fn stem(sight: &Sight) -> String {
    let stem = plain(&sight.setup.draft.stem());
    if stem.is_empty() { "view".to_owned() } else { stem }
}

/// A name in a folder that no file has.
fn free(folder: &Path, stem: &str, extension: &str) -> PathBuf {
    let plain = folder.join(format!("{stem}.{extension}"));
    let numbered = (2..).map(|n| folder.join(format!("{stem}-{n}.{extension}")));
    std::iter::once(plain).chain(numbered).find(|path| !path.exists()).unwrap_or_default()
}

/// Where a copy of a file goes: under its own name, unless another file has it.
fn beside(path: &Path, folder: &Path, copies: &[(PathBuf, PathBuf)]) -> PathBuf {
    if let Some((_, place)) = copies.iter().find(|(from, _)| from == path) {
        return place.clone();
    }
    let place = folder.join(path.file_name().unwrap_or_default());
    let same = std::fs::read(&place).ok().zip(std::fs::read(path).ok()).is_some_and(|(a, b)| a == b);
    let taken = copies.iter().any(|(_, other)| *other == place) || (place.exists() && !same);
    if !taken {
        return place;
    }
    let [stem, extension] = [path.file_stem(), path.extension()]
        .map(|part| part.unwrap_or_default().to_string_lossy().into_owned());
    free(folder, &stem, &extension)
}

/// A file as it is called from a folder: with `..` where the two have more in common than the root.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let [mut to, mut from] = [path.components().peekable(), folder.components().peekable()];
    let mut shared = 0;
    while let (Some(a), Some(b)) = (to.peek(), from.peek())
        && a == b
    {
        shared += usize::from(matches!(a, Component::Normal(_)));
        to.next();
        from.next();
    }
    if shared == 0 {
        return path.to_owned();
    }
    from.map(|_| Component::ParentDir).chain(to).collect()
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = text.chars().all(|c| c.is_ascii_alphanumeric() || "/._-+=:,".contains(c));
    if plain { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

/// Something that cannot be downloaded, as the page shows it.
pub fn refused(error: &Error) -> Refusal {
    desk::refusal("nothing was saved".to_owned(), error, "the picture is as before".to_owned(), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_from_the_folder() {
        let named = |path: &str, folder: &str| relative(path.as_ref(), folder.as_ref()).display().to_string();
        assert_eq!(named("/no/such/cuts/a.asc", "/no/such/views"), "../cuts/a.asc");
        assert_eq!(named("/no/such/a.asc", "/no/such"), "a.asc");
        assert_eq!(named("/other/a.asc", "/no/such"), "/other/a.asc");
    }

    #[test]
    fn paths_are_quoted_for_a_shell() {
        assert_eq!(quoted("a b/c.png".as_ref()), "'a b/c.png'");
        assert_eq!(quoted("it's".as_ref()), r"'it'\''s'");
        assert_eq!(quoted("views/c-2.png".as_ref()), "views/c-2.png");
    }

    #[test]
    fn no_file_is_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        std::fs::write(place("a.png"), "1").unwrap();
        assert_eq!(free(folder.path(), "a", "png"), place("a-2.png"));
        let (from, other) = (place("from"), place("other"));
        [&from, &other].iter().for_each(|path| std::fs::create_dir(path).unwrap());
        std::fs::write(from.join("a.png"), "1").unwrap();
        std::fs::write(other.join("a.png"), "2").unwrap();
        assert_eq!(beside(&from.join("a.png"), folder.path(), &[]), place("a.png"));
        assert_eq!(beside(&other.join("a.png"), folder.path(), &[]), place("a-2.png"));
    }
}
