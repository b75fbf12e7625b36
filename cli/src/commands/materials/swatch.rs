//! Pictures of the whole catalogue: the same stone in every material, and the colours along the axes of crystals.

use super::Args;
use super::dichroscope::{Window, is_coloured, views};
use crate::console::Console;
use crate::progress::Onlooker;
use gemtrace::scene_file::LoadedScene;
use gemtrace::sheet::{Cell, Sheet};
use gemtrace::{Error, output, registry};
use glam::DVec3;
use spectral_core::material::{Catalogue, Material};
use spectral_core::mesh::Mesh;
use spectral_core::scene::{Background, Orientation, Scene, Stone};
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
    session.output.tone = Some(args.tone);
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

/// Writes the colours along the axes of every coloured crystal, seen through `mm`: a column for each axis, above by D65, below
/// by illuminant A, each adapted to its light. Returns how many there are.
pub fn axes(path: &Path, mm: f64) -> Result<usize, Error> {
    output::prepare(&[path], [])?;
    let coloured = |material: &&Material| material.is_crystal() && is_coloured(material);
    let materials = Catalogue::builtin().materials().filter(coloured);
    let cells = materials.map(|material| swatches(material, mm)).collect::<Result<Vec<Cell>, Error>>()?;
    let columns = (1..).find(|n| n * n >= cells.len()).unwrap_or(1);
    let sheet = Sheet::new(&cells, columns);
    output::write_rgb(path, sheet.width, &sheet.pixels)?;
    Ok(cells.len())
}

/// The colours along one crystal's axes.
fn swatches(material: &Material, mm: f64) -> Result<Cell, Error> {
    let views = views(material, mm)?;
    let windows = || views.iter().flat_map(|view| &view.windows);
    let axes = material.axis_names().iter();
    let windows: Vec<&Window> =
        axes.filter_map(|(name, _)| windows().find(|window| window.axis == *name)).collect();
    let column = |x: u32| windows[x as usize * windows.len() / EDGE as usize];
    let colour = |x: u32, y: u32| column(x).colours[usize::from(y >= EDGE / 4)].srgb();
    let pixels = (0..EDGE / 2).flat_map(|y| (0..EDGE).map(move |x| (x, y)));
    let pixels = pixels
        .map(|(x, y)| {
            let [r, g, b] = colour(x, y);
            [r, g, b, 255]
        })
        .collect();
    let names: Vec<&str> = windows.iter().map(|window| window.axis).collect();
    let label = material.name.clone() + if material.is_approximate() { " ~" } else { "" };
    Ok(Cell { width: EDGE, pixels, label: vec![label, names.join(" | ")] })
}

fn scene(material: &Material, mesh: &Arc<Mesh>) -> Scene {
    let mut stone = Stone::new(material.name.clone(), mesh.clone(), Arc::new(material.clone()));
    stone.width = Some(WIDTH);
    stone.orientation = material.is_crystal().then_some(Orientation::Axes([DVec3::X, DVec3::Y]));
    let background = Background::Transparent;
    Scene { width: EDGE, height: EDGE, background, ..Scene::in_studio(vec![stone]) }
}
