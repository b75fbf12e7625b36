//! `gemtrace materials --sheet`: the same stone in every material.

use super::Args;
use crate::console::Console;
use crate::progress::Onlooker;
use gemtrace::scene_file::LoadedScene;
use gemtrace::sheet::{Cell, Sheet};
use gemtrace::{Error, output, registry};
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
pub fn sheet(path: &Path, args: &Args, console: &mut Console) -> Result<usize, Error> {
    output::prepare(&[path], [])?;
    let mut session = args.rendering.session()?;
    session.output.exposure = args.exposure;
    let (mesh, _) = ShapeSpec::by_name("round-brilliant")?.cut()?.solid()?;
    let mesh = Arc::new(mesh);
    let materials: Vec<&Material> = Catalogue::builtin().materials().collect();
    let mut onlooker = Onlooker::new(console, materials.len(), args.rendering.backend == registry::AUTO);
    let mut cells = Vec::new();
    for material in materials {
        let mut loaded = LoadedScene::from(scene(material, &mesh));
        let settings = RenderSettings::default().with_samples(16);
        loaded.settings = RenderSettings { wavelengths: WavelengthGrid::default(), ..settings };
        args.rendering.overrides().apply(&mut loaded);
        let picture = session.render_watched(loaded, &mut onlooker)?;
        cells.push(Cell::new(
            &picture,
            material.name.clone() + if material.is_approximate() { " ~" } else { "" },
        ));
        onlooker.next();
    }
    let columns = (1..).find(|n| n * n >= cells.len()).unwrap_or(1);
    let sheet = Sheet::new(&cells, columns);
    output::write_rgb(path, sheet.width, &sheet.pixels)?;
    Ok(cells.len())
}

fn scene(material: &Material, mesh: &Arc<Mesh>) -> Scene {
    let mut stone = Stone::new(material.name.clone(), mesh.clone(), Arc::new(material.clone()));
    stone.width = Some(WIDTH);
    let background = Background::Transparent;
    Scene { width: EDGE, height: EDGE, background, ..Scene::in_studio(vec![stone]) }
}
