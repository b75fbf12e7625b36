//! `gemtrace materials --sheet`: the same stone in every material.

use crate::commands::Console;
use crate::commands::still::{self, Means, Studio};
use gemtrace::scene_file::LoadedScene;
use gemtrace::sheet::{Cell, Sheet};
use gemtrace::{Error, output};
use spectral_core::material::{Catalogue, Material};
use spectral_core::mesh::Mesh;
use spectral_core::scene::{Background, Scene, Stone};
use spectral_core::settings::RenderSettings;
use spectral_core::shape::ShapeSpec;
use spectral_core::wavelength::WavelengthGrid;
use std::path::Path;
use std::sync::Arc;

/// Each picture's edge in pixels where no size is asked for.
const EDGE: u32 = 160;
/// The stone's width, mm.
const WIDTH: f64 = 6.5;

/// Writes the whole catalogue as one picture: a round brilliant of 6.5 mm in each material, in the built-in studio,
/// in the order of the list; `~` marks those whose figures are approximate. Returns how many there are.
pub fn sheet(path: &Path, means: &Means, console: &mut Console) -> Result<usize, Error> {
    output::check(path)?;
    let mut studio = Studio::new(means)?;
    let (mesh, _) = ShapeSpec::by_name("round-brilliant")?.cut()?.solid()?;
    let mesh = Arc::new(mesh);
    let materials: Vec<&Material> = Catalogue::builtin().materials().collect();
    let mut bar = None;
    let mut cells = Vec::new();
    for (i, material) in materials.iter().enumerate() {
        let mut scene = scene(material, &mesh);
        if bar.is_none() {
            bar = Some(still::bar(&studio.prepare(&mut scene)?, materials.len() as u32, console.quiet));
        }
        let Some(bar) = &bar else { break };
        let still = studio.take(scene, console, bar, i as u32)?;
        let name = material.name.clone() + if material.is_approximate() { " ~" } else { "" };
        cells.push(Cell { width: still.scene.width, pixels: still.rgba(means.exposure), label: vec![name] });
    }
    let columns = (1..).find(|n| n * n >= cells.len()).unwrap_or(1);
    let sheet = Sheet::new(&cells, columns);
    output::write_rgb(path, sheet.width, &sheet.pixels)?;
    Ok(cells.len())
}

fn scene(material: &Material, mesh: &Arc<Mesh>) -> LoadedScene {
    let mut stone = Stone::new(material.name.clone(), mesh.clone(), Arc::new(material.clone()));
    stone.width = Some(WIDTH);
    let background = Background::Transparent;
    let scene = Scene { width: EDGE, height: EDGE, background, ..Scene::in_studio(vec![stone]) };
    LoadedScene {
        scene,
        settings: RenderSettings {
            wavelengths: WavelengthGrid::default(),
            ..RenderSettings::default().with_samples(16)
        },
        backdrop: None,
        warnings: Vec::new(),
        hash: String::new(),
        files: Vec::new(),
    }
}
