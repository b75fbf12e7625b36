//! `gemtrace materials`.

mod appearance;
mod swatch;

use super::table;
use crate::arguments::{Rendering, parse_stops};
use crate::console::{Console, Report};
use appearance::Appearance;
use gemtrace::plot::{Curve, Panel, svg};
use gemtrace::{Error, output};
use serde_json::{Value, json};
use spectral_core::dispersion::{Dispersion, fraunhofer};
use spectral_core::material::{Catalogue, Kind, Material};
use spectral_core::wavelength::WavelengthGrid;
use std::path::PathBuf;

/// Arguments of `materials`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Show this material in full; without it all are listed.
    pub name: Option<String>,
    /// Write a plot of its index and absorption here.
    #[arg(long, value_name = "FILE", requires = "name")]
    pub svg: Option<PathBuf>,
    /// Write a picture of the same stone in every material here, as PNG.
    #[arg(long, value_name = "FILE", conflicts_with = "name")]
    pub sheet: Option<PathBuf>,
    /// Give the figures at these wavelengths (nm, ascending) in place of Fraunhofer's lines.
    #[arg(long, value_name = "NM,…", value_delimiter = ',')]
    pub nm: Option<Vec<f64>>,
    #[command(flatten, next_help_heading = "How the sheet is rendered")]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub rendering: Rendering,
    /// Brighten the sheet by this many stops.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_stops)]
    pub exposure: f64,
}

/// Lists the catalogue, or describes one material.
///
/// # Errors
/// [`Error::Core`] for a name that is not in the catalogue and for wavelengths that are none; [`Error::Output`] for
/// the plot or the sheet; [`Error`] of the device that renders the sheet.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    if let Some(path) = &args.sheet {
        let count = swatch::sheet(path, args, console)?;
        let text = format!("wrote {} – {count} materials", path.display());
        return Ok(Report::new(text, json!({ "output": path.display().to_string(), "materials": count })));
    }
    let lines = lines(args)?;
    let Some(name) = &args.name else { return list(&lines) };
    let material = Catalogue::builtin().get(name)?;
    if let Some(path) = &args.svg {
        output::write_text(path, &plot(material))?;
    }
    Ok(Report::new(describe(material, &lines)?, facts(material, &lines)?))
}

/// The wavelengths to describe a material at, with the names of those that have one.
fn lines(args: &Args) -> Result<Vec<(String, f64)>, Error> {
    let Some(nm) = &args.nm else {
        return Ok(fraunhofer::LINES.iter().map(|&(line, nm)| (line.to_owned(), nm)).collect());
    };
    let grid = WavelengthGrid::list(nm.clone())?;
    Ok(grid.nm().iter().map(|&nm| (String::new(), nm)).collect())
}

fn list(lines: &[(String, f64)]) -> Result<Report, Error> {
    let mut rows = vec![["name", "colour", "n at D", "n(G) − n(B)", "g/cm³"].map(str::to_owned).to_vec()];
    let mut all = Vec::new();
    for material in Catalogue::builtin().materials() {
        let dispersion =
            dispersion(material).map_or("metal".to_owned(), |d| format!("{:.4}", d.dispersion_bg()));
        rows.push(vec![
            material.name.clone() + if material.is_approximate() { " ~" } else { "" },
            Appearance::of(material)?.hex(),
            format!("{:.4}", material.index(fraunhofer::D)),
            dispersion,
            material.density.map_or("–".to_owned(), |d| d.to_string()),
        ]);
        all.push(facts(material, lines)?);
    }
    let (through, metal) = (appearance::TRANSMITTED, appearance::REFLECTED);
    let legend = format!("~ approximate\ncolour: {through}; of metals {metal}");
    let text = format!("{}\n\n{legend}", table::columns(2, &rows));
    Ok(Report::new(text, json!({ "materials": all })))
}

fn dispersion(material: &Material) -> Option<&Dispersion> {
    match &material.kind {
        Kind::Dielectric { dispersion, .. } => Some(dispersion),
        Kind::Conductor { .. } => None,
    }
}

fn facts(material: &Material, lines: &[(String, f64)]) -> Result<Value, Error> {
    let lines: Vec<Value> = lines
        .iter()
        .map(|(line, nm)| {
            let nm = *nm;
            json!({ "line": line, "nm": nm, "n": material.index(nm), "k": material.extinction(nm),
                    "absorption_per_mm": material.absorption(nm) })
        })
        .collect();
    let appearance = Appearance::of(material)?;
    let sources: Vec<Value> = material
        .sources
        .iter()
        .map(|s| {
            json!({ "figure": s.figure, "source": s.source, "licence": s.licence, "range_nm": s.range,
                    "approximate": s.approximate })
        })
        .collect();
    Ok(json!({
        "name": material.name,
        "aliases": Catalogue::builtin().aliases(&material.name),
        "kind": if material.is_conductor() { "conductor" } else { "dielectric" },
        "ray": material.ray,
        "lines": lines,
        "abbe_number": dispersion(material).map(Dispersion::abbe_number),
        "dispersion_bg": dispersion(material).map(Dispersion::dispersion_bg),
        "dispersion_cf": dispersion(material).map(Dispersion::dispersion_cf),
        "density": material.density,
        "colour": { "srgb": appearance.hex(), "linear_srgb": appearance.linear, "meaning": appearance.meaning },
        "approximate": material.is_approximate(),
        "notes": material.notes,
        "sources": sources,
    }))
}

fn describe(material: &Material, lines: &[(String, f64)]) -> Result<String, Error> {
    let mut rows = vec![
        ["line", "nm", "n", if material.is_conductor() { "k" } else { "absorption, 1/mm" }]
            .map(str::to_owned)
            .to_vec(),
    ];
    for (line, nm) in lines {
        let nm = *nm;
        let last = if material.is_conductor() { material.extinction(nm) } else { material.absorption(nm) };
        rows.push(vec![
            line.clone(),
            format!("{nm:.2}"),
            format!("{:.5}", material.index(nm)),
            format!("{last:.4}"),
        ]);
    }
    let ray = if material.ray.is_empty() { String::new() } else { format!(" ({})", material.ray) };
    let mut text = format!("{}{ray}\n\n{}\n", material.name, table::columns(1, &rows));
    if let Some(d) = dispersion(material) {
        text += &format!("\nAbbe number  {:.2}", d.abbe_number());
        text += &format!("\nn(G) − n(B)  {:.5}", d.dispersion_bg());
        text += &format!("\nn(F) − n(C)  {:.5}", d.dispersion_cf());
    }
    if let Some(density) = material.density {
        text += &format!("\ndensity      {density} g/cm³");
    }
    let appearance = Appearance::of(material)?;
    text += &format!("\ncolour       {} ({})", appearance.hex(), appearance.meaning);
    text += "\n";
    for note in &material.notes {
        text += &format!("\nnote: {note}");
    }
    for source in &material.sources {
        let rough = if source.approximate { ", approximate" } else { "" };
        text += &format!("\n{}{rough}: {} [{}]", source.figure, source.source, source.licence);
    }
    Ok(text.trim_end().to_owned())
}

fn plot(material: &Material) -> String {
    let line = |colour, of: &dyn Fn(f64) -> f64| Curve {
        label: String::new(),
        colour,
        points: (380..=780).map(|nm| [f64::from(nm), of(f64::from(nm))]).collect(),
    };
    let panel =
        |label: &str, from_zero, line| Panel { label: label.to_owned(), from_zero, lines: vec![line] };
    let second = if material.is_conductor() {
        panel("k", true, line("#c60", &|nm| material.extinction(nm)))
    } else {
        panel("absorption, 1/mm", true, line("#c60", &|nm| material.absorption(nm)))
    };
    svg(&material.name, &[panel("refractive index n", false, line("#06c", &|nm| material.index(nm))), second])
}
