//! What is measured: the one stone of a scene, or a cut or a mesh with a material.

use super::Args;
use gemtrace::measure::{Conditions, sodium};
use gemtrace::{Error, import, scene_file};
use spectral_core::Warning;
use spectral_core::absorption::Absorption;
use spectral_core::camera::Projection;
use spectral_core::dispersion::Dispersion;
use spectral_core::material::{Catalogue, Kind, Material};
use spectral_core::mesh::Mesh;
use spectral_core::prepare::crystal_remarks;
use spectral_core::scene::Stone;
use spectral_core::settings::RenderSettings;
use spectral_core::wavelength::WavelengthGrid;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The default number of wavelengths: enough for a mean over a smooth dispersion.
const WAVELENGTHS: usize = 8;

/// A stone, and what its file says about looking at it.
pub(super) struct Subject {
    pub stone: Stone,
    pub settings: RenderSettings,
    /// Distance of a scene's camera, mm, if it has perspective.
    pub eye: Option<f64>,
    /// File and material, for a plot's head.
    pub title: String,
    pub warnings: Vec<Warning>,
    /// What was read.
    pub files: Vec<PathBuf>,
}

impl Subject {
    pub fn new(args: &Args) -> Result<Self, Error> {
        let mut subject = if args.file.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
            Self::of_scene(args)?
        } else {
            Self::of_solid(args)?
        };
        if let Some(up) = args.up {
            subject.stone.up = up;
        }
        if let Some(width) = args.width {
            subject.stone.width = Some(width);
        }
        if args.gemray {
            // GemRay knows one index.
            subject.stone.material = Arc::new(subject.stone.material.isotropic());
            subject.stone.width = Some(Conditions::GEMRAY_SCALE * subject.stone.file_width());
        } else {
            subject.warnings.extend(crystal_remarks(std::slice::from_ref(&subject.stone))?);
        }
        let name = args.file.file_name().unwrap_or_default().to_string_lossy();
        subject.title = format!("{name}, {}", subject.stone.material.name);
        Ok(subject)
    }

    fn of_scene(args: &Args) -> Result<Self, Error> {
        let loaded = scene_file::load(&args.file)?;
        let camera = loaded.scene.camera;
        let mut stones = loaded.scene.stones;
        if stones.len() != 1 {
            let message = format!("a scene of one stone can be measured; this one has {}", stones.len());
            return Err(Error::file(&args.file, message));
        }
        let mut stone = stones.swap_remove(0);
        if let Some(material) = &args.material {
            stone.material = Arc::new(self::material(material)?);
        }
        let distance = camera.position.distance(camera.look_at);
        let eye = matches!(camera.projection, Projection::Perspective { .. }).then_some(distance);
        let title = String::new();
        let files = loaded.files.into_iter().map(|file| file.path).chain([args.file.clone()]).collect();
        Ok(Subject { stone, settings: loaded.settings, eye, title, warnings: loaded.warnings, files })
    }

    fn of_solid(args: &Args) -> Result<Self, Error> {
        let (mesh, designed, mut warnings) = solid(&args.file)?;
        let material = match (&args.material, designed) {
            (Some(name), _) => material(name)?,
            (None, Some(index)) => glass(index),
            (None, None) => {
                let message = "it names no index of refraction; give --material, a name or an index";
                return Err(Error::file(&args.file, message));
            }
        };
        let bare = matches!(
            &material.kind,
            Kind::Dielectric { dispersion: Dispersion::Constant(_), absorption } if *absorption == Absorption::default()
        );
        let wavelengths =
            if bare { sodium() } else { WavelengthGrid::midpoints([380.0, 740.0], WAVELENGTHS)? };
        warnings.extend(material.check(wavelengths.range())?);
        let settings = RenderSettings { wavelengths, ..Conditions::default().settings };
        let name = args.file.display().to_string();
        let stone = Stone::new(name, Arc::new(mesh), Arc::new(material));
        let files = vec![args.file.clone()];
        Ok(Subject { stone, settings, eye: None, title: String::new(), warnings, files })
    }
}

/// A cut or a mesh, and the index that a cut was designed for.
fn solid(path: &Path) -> Result<(Mesh, Option<f64>, Vec<Warning>), Error> {
    let bytes = import::read_file(path)?;
    if import::cut::Format::of(path).is_none() {
        let (mesh, warnings) = import::mesh::read(path, &bytes)?;
        return Ok((mesh, None, warnings));
    }
    let (cut, mut warnings) = import::cut::read(path, &bytes)?;
    let (mesh, more) = cut.solid().map_err(|error| Error::file(path, error))?;
    warnings.extend(more);
    Ok((mesh, cut.index_of_refraction, warnings))
}

/// A material of the catalogue, or of a bare index.
fn material(text: &str) -> Result<Material, Error> {
    match text.parse::<f64>() {
        Ok(index) if index > 1.0 && index <= 5.0 => Ok(glass(index)),
        Ok(index) => {
            let expected = "an index of refraction above 1 and at most 5, or the name of a material";
            Err(spectral_core::Error::value("material", index, expected).into())
        }
        Err(_) => Ok(Catalogue::builtin().get(text)?.clone()),
    }
}

/// Colourless, with the same index at every wavelength.
fn glass(index: f64) -> Material {
    let kind =
        Kind::Dielectric { dispersion: Dispersion::Constant(index), absorption: Absorption::default() };
    Material::new(format!("n = {index}"), kind)
}
