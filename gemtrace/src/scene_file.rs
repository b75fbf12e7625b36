//! Scene files: TOML to a [`Scene`] with its [`RenderSettings`].
//!
//! The format is described, key by key, in the examples under `scenes/`. Lengths are in mm, angles in
//! degrees, wavelengths in nm; paths are relative to the scene file. Every key has a default but `format`,
//! the camera's `position` and `look_at`, and a stone's shape and `material`. An error names the
//! line, what was written, and what would be valid.
//!
//! ```
//! let text = r#"
//!     format = 1
//!     camera = { position = [0, -20, 20], look_at = [0, 0, 0] }
//!     [[stone]]
//!     shape = { name = "round-brilliant", table = 0.55 }
//!     width = 6.5
//!     material = "diamond"
//! "#;
//! let loaded = gemtrace::scene_file::parse(text, "stone.toml".as_ref(), ".".as_ref())?;
//! assert_eq!(loaded.scene.stones.len(), 1);
//!
//! let error = gemtrace::scene_file::parse(&text.replace("width", "widht"), "stone.toml".as_ref(), ".".as_ref());
//! let message = error.unwrap_err().to_string();
//! assert_eq!(message, "stone.toml, line 6: unknown key 'widht' in [[stone]]; did you mean 'width'?");
//! # Ok::<(), gemtrace::Error>(())
//! ```

mod draft;
pub(crate) mod fields;
mod ground;
mod light;
mod material;
mod overrides;
mod pose;
mod setting;
#[cfg(feature = "formats")]
mod sketch;
pub(crate) mod source;
mod stone;
mod value;
mod view;

use crate::{Error, import};
pub use draft::Draft;
use fields::{Document, Fields};
use glam::DVec3;
pub use overrides::Override;
#[cfg(feature = "formats")]
pub use sketch::sketch;
use source::Sources;
pub use source::{Assets, Gate, Made, SourceFile};
use spectral_core::Warning;
use spectral_core::color::Tone;
use spectral_core::film::Film;
use spectral_core::scene::Scene;
use spectral_core::settings::RenderSettings;
use std::path::Path;
use toml::de::DeTable;
#[cfg(feature = "view")]
pub(crate) use view::DEFAULT_FOV;

/// The only version of the format so far.
pub const FORMAT: i64 = 1;

/// A scene as its file describes it, with all that it names read in.
#[derive(Debug, Clone)]
pub struct LoadedScene {
    /// The scene file's name, for headers and messages; empty for a scene that was built in code.
    pub name: String,
    /// What is to be rendered.
    pub scene: Scene,
    /// How.
    pub settings: RenderSettings,
    /// The colour that is put behind the stones as the picture is written, linear sRGB; the scene's own background is
    /// then transparent.
    pub backdrop: Option<[f64; 3]>,
    /// Stops that the picture is brightened by where it is shown (PNG), beside what is asked for elsewhere.
    pub exposure: f64,
    /// How it is shown there where a screen cannot show a colour, unless something else is asked for elsewhere.
    pub tone: Tone,
    /// The point about which `[pose]` turns the stones, mm; `None` without stones.
    pub pivot: Option<DVec3>,
    /// What was accepted with a remark.
    pub warnings: Vec<Warning>,
    /// SHA-256, in hexadecimal, over the scene's text and the SHA-256 of every file it names, each with its length, in the
    /// order they are named: the same hash, the same input.
    pub hash: String,
    /// The files that the scene names, in that order.
    pub files: Vec<SourceFile>,
}

impl From<Scene> for LoadedScene {
    /// A scene that was built in code, with the default settings.
    fn from(scene: Scene) -> Self {
        let (name, hash) = (String::new(), String::new());
        let settings = RenderSettings::default();
        let (backdrop, exposure, tone, pivot) = (None, 0.0, Tone::default(), None);
        let (warnings, files) = (Vec::new(), Vec::new());
        LoadedScene { name, scene, settings, backdrop, exposure, tone, pivot, warnings, hash, files }
    }
}

/// Reads a scene file and the files it names.
///
/// # Errors
/// [`Error::File`] if the scene file itself cannot be read, else [`Error::Scene`] with the line.
pub fn load(path: &Path) -> Result<LoadedScene, Error> {
    Assets::default().load(path)
}

/// Reads a scene from its text. `path` names it in messages; the files it names are found from `folder`.
///
/// # Errors
/// [`Error::Scene`] with the line.
pub fn parse(text: &str, path: &Path, folder: &Path) -> Result<LoadedScene, Error> {
    Assets::default().parse(text, path, folder)
}

impl Assets {
    /// As [`load`], without reading again what the scene before it named.
    ///
    /// # Errors
    /// As [`load`].
    pub fn load(&mut self, path: &Path) -> Result<LoadedScene, Error> {
        let bytes = import::read_file(path)?;
        let text = import::text(path, &bytes)?;
        self.parse(&text, path, path.parent().unwrap_or(Path::new("")))
    }

    /// As [`parse`], without reading again what the scene before it named.
    ///
    /// # Errors
    /// As [`parse`].
    pub fn parse(&mut self, text: &str, path: &Path, folder: &Path) -> Result<LoadedScene, Error> {
        read(Document { path, text }, Sources::new(text, folder, self))
    }
}

fn read(document: Document, mut sources: Sources) -> Result<LoadedScene, Error> {
    let Document { path, text } = document;
    let table = DeTable::parse(text).map_err(|e| document.toml_error(&e))?;
    let root = Fields::new(document, "the scene", 0, table.get_ref());
    check_format(&root)?;
    let settings = setting::read(&root)?;
    let mut view = view::read(&root)?;
    let mut environment = light::read(&root, &mut sources, &view.camera)?;
    let materials = material::read(&root, &mut sources, &settings, &environment.illuminant)?;
    let mut stones = stone::read(&root, &materials, &mut sources)?;
    // Scaling moves it as it moves the stones.
    let middle = pose::middle(&stones).map_err(|e| root.blame(e))?;
    let scale = pose::read(&root)?.map_or(Ok(1.0), |pose| pose.apply(&mut view.camera, &mut stones))?;
    let ground =
        ground::read(&root, &materials, scale, &stones, &mut environment, sources.shades_coarsely())?;
    root.finish()?;
    stones.extend(ground);
    view.check(&settings)?;
    let scene = Scene {
        camera: view.camera,
        width: view.width,
        height: view.height,
        background: view.background,
        environment,
        stones,
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let hash = sources.finish();
    Ok(LoadedScene {
        name,
        scene,
        settings,
        backdrop: view.backdrop,
        exposure: view.exposure,
        tone: view.tone,
        pivot: middle.map(|middle| middle * scale),
        warnings: sources.warnings,
        hash,
        files: sources.files,
    })
}

fn check_format(root: &Fields) -> Result<(), Error> {
    let expected = format!("the version of the scene format, {FORMAT}");
    match root.get("format") {
        None => Err(root.error(format!("a scene begins with 'format = {FORMAT}', which is missing here"))),
        Some(entry) if entry.whole::<i64>(&expected)? == FORMAT => Ok(()),
        Some(entry) => Err(entry.refuse(&expected)),
    }
}

impl view::View<'_> {
    /// The picture's size against memory, which depends on the settings, too.
    fn check(&self, settings: &RenderSettings) -> Result<(), Error> {
        let kept = if settings.spectral { settings.wavelengths.len() } else { 0 };
        Film::check_size(self.width, self.height, kept).map_err(|e| self.at_film(e))?;
        self.camera.view(self.width, self.height).map_err(|e| self.at_camera(e))?;
        Ok(())
    }
}
