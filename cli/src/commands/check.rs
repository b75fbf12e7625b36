//! `gemtrace check`.

use crate::console::{Console, Report};
use gemtrace::{Error, scene_file};
use serde_json::{Value, json};
use spectral_core::dispersion::fraunhofer;
use spectral_core::film::Film;
use spectral_core::material::Material;
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Stone;
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The scene file (TOML).
    pub scene: PathBuf,
}

/// Reads and prepares a scene as `render` does, and describes it.
///
/// # Errors
/// [`Error`] of the scene file or of what it names, exactly as `render` gives it.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    let loaded = scene_file::load(&args.scene)?;
    let scene =
        PreparedScene::new(&loaded.scene, &loaded.settings).map_err(|e| Error::file(&args.scene, e))?;
    let warnings: Vec<String> =
        loaded.warnings.iter().chain(&scene.warnings).map(ToString::to_string).collect();
    warnings.iter().for_each(|warning| console.warn(warning));
    let grid = loaded.settings.wavelengths.nm();
    let told = if console.json { usize::MAX } else { FEW };
    let stones: Vec<_> =
        loaded.scene.stones.iter().take(told).map(|stone| stone_facts(stone, grid)).collect();
    let json = json!({
        "scene": args.scene.display().to_string(),
        "hash": loaded.hash,
        "files": loaded.files.iter().map(|f| f.path.display().to_string()).collect::<Vec<_>>(),
        "settings": gemtrace::output::settings(&scene),
        "stones": stones,
        "film_bytes": film_bytes(&scene),
        "warnings": warnings,
    });
    Ok(Report::new(describe(&loaded, &scene), json))
}

/// So many stones are described where nobody asks for JSON: the figures of a hundred thousand take a gigabyte.
const FEW: usize = 1000;

/// A stone with its optics at the wavelengths that the settings name, before any jitter.
fn stone_facts(stone: &Stone, nm: &[f64]) -> Value {
    let material = &stone.material;
    let at = |of: &dyn Fn(f64) -> f64| nm.iter().map(|&nm| of(nm)).collect::<Vec<f64>>();
    json!({
        "name": stone.name,
        "material": material.name,
        "facets": stone.mesh.facets().len(),
        "triangles": stone.mesh.triangles().len(),
        "convex": stone.mesh.is_convex(),
        "conductor": material.is_conductor(),
        "n": at(&|nm| material.index(nm)),
        "k": at(&|nm| material.extinction(nm)),
        "absorption_per_mm": at(&|nm| material.absorption(nm)),
        "axes": if material.is_crystal() { axes(material, nm) } else { Value::Null },
    })
}

/// A crystal's index and absorption along each of its axes: o and e, or x, y and z.
fn axes(material: &Material, nm: &[f64]) -> Value {
    let figures = |axis: usize, of: fn(&Material, f64) -> [f64; 3]| -> Vec<f64> {
        nm.iter().map(|&nm| of(material, nm)[axis]).collect()
    };
    let axis = |&(name, k): &(&str, usize)| {
        json!({
            "axis": name,
            "n": figures(k, Material::indices),
            "absorption_per_mm": figures(k, Material::absorptions),
        })
    };
    material.axis_names().iter().map(axis).collect()
}

fn film_bytes(scene: &PreparedScene) -> u64 {
    let kept = if scene.settings.spectral { scene.wavelength_count() } else { 0 };
    // Films beyond `Film::MAX_BYTES` are refused.
    Film::bytes(scene.width, scene.height, kept) as u64
}

fn describe(loaded: &scene_file::LoadedScene, scene: &PreparedScene) -> String {
    let s = &scene.settings;
    let [from, to] = s.wavelengths.range();
    let mut lines = vec![format!(
        "{} × {} pixels, {}{}{} each, {} from {from} to {to} nm{}; film {}",
        scene.width,
        scene.height,
        if s.tolerance > 0.0 { "up to " } else { "" },
        counted(u64::from(s.samples), "sample"),
        if scene.silhouette.is_some() { " of its whole area" } else { "" },
        counted(s.wavelengths.len() as u64, "wavelength"),
        if s.jitter && s.wavelengths.can_jitter() { ", jittered" } else { "" },
        memory(film_bytes(scene)),
    )];
    for stone in &loaded.scene.stones {
        let shape = if stone.mesh.is_convex() { "convex" } else { "not convex" };
        let facets = stone.mesh.facets().len();
        let optics = optics(&stone.material);
        lines.push(format!("{}: {}{optics}, {facets} facets, {shape}", stone.name, stone.material.name));
    }
    if loaded.scene.stones.is_empty() {
        lines.push("no stones: the environment alone".to_owned());
    }
    lines.push("the scene is sound".to_owned());
    lines.join("\n")
}

/// A crystal's index and absorption along each axis at sodium's D line.
fn optics(material: &Material) -> String {
    let nm = fraunhofer::D;
    let axis = |&(name, k): &(&str, usize)| {
        let (n, alpha) = (material.indices(nm)[k], material.absorptions(nm)[k]);
        format!("{name} {n:.4}, {alpha:.3}/mm")
    };
    let axes: Vec<String> = material.axis_names().iter().map(axis).collect();
    if axes.is_empty() { String::new() } else { format!(" (at 589.3 nm {})", axes.join("; ")) }
}

fn counted(n: u64, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

fn memory(bytes: u64) -> String {
    let bytes = bytes as f64;
    if bytes < 1e9 { format!("{:.1} MB", bytes / 1e6) } else { format!("{:.2} GB", bytes / 1e9) }
}
