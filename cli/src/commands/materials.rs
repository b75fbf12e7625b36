//! `gemtrace materials`.

mod appearance;
mod dichroscope;
mod swatch;

use super::table;
use crate::arguments::{Rendering, one_of, parse_stops};
use crate::console::{Console, Report};
use appearance::{Colour, REFLECTED, transmitted};
use dichroscope::Character;
use gemtrace::plot::{Curve, Panel, svg};
use gemtrace::{Error, output};
use serde_json::{Value, json};
use spectral_core::color::Tone;
use spectral_core::dispersion::{Dispersion, fraunhofer};
use spectral_core::material::{Catalogue, Kind, Material};
use spectral_core::wavelength::WavelengthGrid;
use std::path::PathBuf;

/// Arguments of `materials`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Show this material in full; without it all are listed.
    pub name: Option<String>,
    /// Write a plot of its indices and absorptions here.
    #[arg(long, value_name = "FILE", requires = "name")]
    pub svg: Option<PathBuf>,
    /// Write a picture of the same stone in every material here, as PNG.
    #[arg(long, value_name = "FILE", conflicts_with = "name")]
    pub sheet: Option<PathBuf>,
    /// Write a picture of the colours along the axes of every coloured crystal here, as PNG: above by D65, below by A.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["name", "sheet"])]
    pub axes: Option<PathBuf>,
    /// Thickness that colours are seen through, mm.
    #[arg(long, value_name = "MM", default_value_t = 5.0, value_parser = parse_thickness)]
    pub thickness: f64,
    /// Give the figures at these wavelengths (nm, ascending) in place of Fraunhofer's lines.
    #[arg(long, value_name = "NM,…", value_delimiter = ',')]
    pub nm: Option<Vec<f64>>,
    #[command(flatten, next_help_heading = "How the sheet is rendered")]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub rendering: Rendering,
    /// Brighten the sheet by this many stops.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_stops)]
    pub exposure: f64,
    /// How colours are shown that a screen cannot show: cut off, with their hue kept, or on the Khronos PBR Neutral curve.
    #[arg(long, value_name = "NAME", default_value = "hue", ignore_case = true, value_parser = one_of(&Tone::ALL, Tone::name))]
    pub tone: Tone,
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
    if let Some(path) = &args.axes {
        let count = swatch::axes(path, args.thickness)?;
        let text = format!(
            "wrote {} – {count} crystals, {} mm, above by D65, below by A",
            path.display(),
            args.thickness
        );
        return Ok(Report::new(text, json!({ "output": path.display().to_string(), "materials": count })));
    }
    let lines = lines(args)?;
    let Some(name) = &args.name else { return list(&lines, args.thickness) };
    let material = Catalogue::builtin().get(name)?;
    if let Some(path) = &args.svg {
        output::write_text(path, &plot(material))?;
    }
    Ok(Report::new(describe(material, &lines, args.thickness)?, facts(material, &lines, args.thickness)?))
}

fn parse_thickness(text: &str) -> Result<f64, String> {
    let mm = text.trim().parse::<f64>().ok().filter(|mm| *mm > 0.0 && *mm <= 1e6);
    mm.ok_or_else(|| "give a thickness in mm, above 0 and at most 1e6".to_owned())
}

/// The wavelengths to describe a material at, with the names of those that have one.
fn lines(args: &Args) -> Result<Vec<(String, f64)>, Error> {
    let Some(nm) = &args.nm else {
        return Ok(fraunhofer::LINES.iter().map(|&(line, nm)| (line.to_owned(), nm)).collect());
    };
    let grid = WavelengthGrid::list(nm.clone())?;
    Ok(grid.nm().iter().map(|&nm| (String::new(), nm)).collect())
}

fn list(lines: &[(String, f64)], mm: f64) -> Result<Report, Error> {
    let heads = ["name", "colour", "n at D", "birefringence", "n(G) − n(B)", "g/cm³"];
    let mut rows = vec![heads.map(str::to_owned).to_vec()];
    let mut all = Vec::new();
    for material in Catalogue::builtin().materials() {
        let dispersion =
            dispersion(material).map_or("metal".to_owned(), |d| format!("{:.4}", d.dispersion_bg()));
        rows.push(vec![
            material.name.clone() + if material.is_approximate() { " ~" } else { "" },
            Colour::of_material(material, mm)?.hex(),
            format!("{:.4}", material.index(fraunhofer::D)),
            Character::of(material).map_or("–".to_owned(), |c| format!("{:.4}", c.birefringence)),
            dispersion,
            material.density.map_or("–".to_owned(), |d| d.to_string()),
        ]);
        all.push(facts(material, lines, mm)?);
    }
    let legend = format!(
        "~ approximate\ncolour: {}, of crystals the mean of the axes; of metals {REFLECTED}\n\
         n: of crystals the ordinary ray's, or α",
        transmitted(mm)
    );
    let text = format!("{}\n\n{legend}", table::columns(2, &rows));
    Ok(Report::new(text, json!({ "materials": all })))
}

fn dispersion(material: &Material) -> Option<&Dispersion> {
    match &material.kind {
        Kind::Dielectric { dispersion, .. } => Some(dispersion),
        Kind::Conductor { .. } => None,
    }
}

fn facts(material: &Material, lines: &[(String, f64)], mm: f64) -> Result<Value, Error> {
    let crystal = dichroscope::facts(material, lines, mm)?;
    let lines: Vec<Value> = lines
        .iter()
        .map(|(line, nm)| {
            let nm = *nm;
            json!({ "line": line, "nm": nm, "n": material.index(nm), "k": material.extinction(nm),
                    "absorption_per_mm": material.absorption(nm) })
        })
        .collect();
    let colour = Colour::of_material(material, mm)?;
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
        "colour": { "srgb": colour.hex(), "linear_srgb": colour.0, "meaning": meaning(material, mm) },
        "crystal": crystal,
        "approximate": material.is_approximate(),
        "notes": material.notes,
        "sources": sources,
    }))
}

/// What the colour of a material is the colour of.
fn meaning(material: &Material, mm: f64) -> String {
    match material.is_conductor() {
        true => REFLECTED.to_owned(),
        false if material.is_crystal() => transmitted(mm) + ", the mean of the axes",
        false => transmitted(mm),
    }
}

fn describe(material: &Material, lines: &[(String, f64)], mm: f64) -> Result<String, Error> {
    let ray = if material.is_crystal() || material.ray.is_empty() {
        String::new()
    } else {
        format!(" ({})", material.ray)
    };
    let mut text = format!("{}{ray}\n\n{}\n", material.name, table::columns(1, &figures(material, lines)));
    if let Some(d) = dispersion(material) {
        text += &format!("\nAbbe number  {:.2}", d.abbe_number());
        text += &format!("\nn(G) − n(B)  {:.5}", d.dispersion_bg());
        text += &format!("\nn(F) − n(C)  {:.5}", d.dispersion_cf());
    }
    if let Some(density) = material.density {
        text += &format!("\ndensity      {density} g/cm³");
    }
    let colour = Colour::of_material(material, mm)?;
    text += &format!("\ncolour       {} ({})", colour.hex(), meaning(material, mm));
    text += &dichroscope::describe(material, mm)?;
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

/// A row for each line: n and α along each axis, of a metal n and k.
fn figures(material: &Material, lines: &[(String, f64)]) -> Vec<Vec<String>> {
    let axes = axes(material);
    let heads = |figure: &str, unit: &str| -> Vec<String> {
        axes.iter().map(|(name, _)| format!("{figure} {name}").trim().to_owned() + unit).collect()
    };
    let second = if material.is_conductor() { vec!["k".to_owned()] } else { heads("α", ", 1/mm") };
    let mut rows = vec![[vec!["line".to_owned(), "nm".to_owned()], heads("n", ""), second].concat()];
    for (line, nm) in lines {
        let n = axes.iter().map(|&(_, k)| format!("{:.5}", material.indices(*nm)[k]));
        let alpha = axes.iter().map(|&(_, k)| match material.is_conductor() {
            true => format!("{:.4}", material.extinction(*nm)),
            false => format!("{:.4}", material.absorptions(*nm)[k]),
        });
        rows.push([line.clone(), format!("{nm:.2}")].into_iter().chain(n).chain(alpha).collect());
    }
    rows
}

/// The axes of a material; of what is isotropic one without a name.
fn axes(material: &Material) -> &'static [(&'static str, usize)] {
    if material.is_crystal() { material.axis_names() } else { &[("", 0)] }
}

fn plot(material: &Material) -> String {
    let panel = |label: &str, from_zero, of: &dyn Fn(f64) -> [f64; 3]| {
        let colours = ["#06c", "#c60", "#283"];
        let curve = |(&(name, k), colour): (&(&str, usize), &'static str)| Curve {
            label: name.to_owned(),
            colour,
            points: (380..=780).map(f64::from).map(|nm| [nm, of(nm)[k]]).collect(),
        };
        let lines = axes(material).iter().zip(colours).map(curve).collect();
        Panel { label: label.to_owned(), from_zero, lines }
    };
    let second = if material.is_conductor() {
        panel("k", true, &|nm| [material.extinction(nm); 3])
    } else {
        panel("absorption, 1/mm", true, &|nm| material.absorptions(nm))
    };
    svg(&material.name, &[panel("refractive index n", false, &|nm| material.indices(nm)), second])
}
