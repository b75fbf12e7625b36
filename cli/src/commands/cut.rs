//! `gemtrace cut`.

use super::table;
use crate::console::{Console, Report};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use gemtrace::tier::{self, Tier};
use gemtrace::{Error, import, output};
use glam::DVec3;
use serde_json::{Value, json};
use spectral_core::Warning;
use spectral_core::cut::{Cut, Proportions};
use spectral_core::mesh::{Mesh, Plane};
use spectral_core::scene::Up;
use spectral_core::shown_lines;
use std::path::{Path, PathBuf};

/// Arguments of `cut`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// A cut (.asc, .gem, .gcs) or a mesh (.glb, .gltf, .obj, .stl, .ply).
    pub file: PathBuf,
    /// The axis of a mesh's file that is the normal of the table [default: z].
    #[arg(long, value_name = "AXIS", value_parser = PossibleValuesParser::new(Up::NAMES).try_map(|name| Up::by_name(&name)))]
    pub up: Option<Up>,
    /// Write the closed solid here, as triangles in the file's unit of length (.obj).
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
}

/// Describes a cut or a mesh. A cut that does not close is described all the same, with its fault as the
/// report's failure.
///
/// # Errors
/// [`Error::File`] for a file that cannot be read or, for a mesh, that bounds no solid; [`Error::Output`] for the
/// mesh to write; [`Error::Usage`] for `--up` with a cut.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    if let Some(path) = &args.mesh {
        output::prepare(&[path], [args.file.as_path()])?;
    }
    let bytes = import::read_file(&args.file)?;
    if import::cut::Format::of(&args.file).is_some() {
        if args.up.is_some() {
            return Err(Error::Usage(
                "--up is for meshes; the table of a cut is always towards +z".to_owned(),
            ));
        }
        let (cut, warnings) = import::cut::read(&args.file, &bytes)?;
        return design(args, &cut, warnings, console);
    }
    let (mut mesh, warnings) = import::mesh::read(&args.file, &bytes)?;
    warnings.iter().for_each(|warning| console.warn(warning));
    if let Some(up) = args.up {
        mesh = mesh.transformed(up.matrix(), 1.0, DVec3::ZERO)?;
    }
    write_mesh(args.mesh.as_deref(), &mesh)?;
    let measures = Measures::of(&mesh);
    let mut json =
        json!({ "file": args.file.display().to_string(), "closed": true, "warnings": texts(&warnings) });
    json["solid"] = tier::proportions(&mesh);
    Ok(Report::new(measures.text(), json))
}

fn write_mesh(path: Option<&Path>, mesh: &Mesh) -> Result<(), Error> {
    path.map_or(Ok(()), |path| output::write_mesh(path, mesh).map(|_| ()))
}

fn design(
    args: &Args,
    cut: &Cut,
    mut warnings: Vec<Warning>,
    console: &mut Console,
) -> Result<Report, Error> {
    let path = &args.file;
    let planes: Vec<(&Plane, Option<&str>)> =
        cut.facets.iter().map(|f| (&f.plane, f.name.as_deref())).collect();
    let tiers = tier::group(&planes);
    let mut lines: Vec<String> = cut.title.iter().map(|line| shown_lines(line)).collect();
    let gear = cut.gear.map(|gear| format!("gear {gear}"));
    let index = cut.index_of_refraction.map(|n| format!("designed for n = {n}"));
    lines.extend([gear, index].into_iter().flatten());
    lines.extend((!lines.is_empty()).then(String::new));
    lines.push(tier_table(&tiers));
    let mut json = json!({
        "file": path.display().to_string(),
        "title": cut.title,
        "gear": cut.gear,
        "index_of_refraction": cut.index_of_refraction,
        "facets": cut.facets.len(),
        "tiers": tiers.iter().map(Tier::json).collect::<Vec<_>>(),
    });
    let failure = match cut.solid() {
        Ok((mesh, more)) => {
            warnings.extend(more);
            write_mesh(args.mesh.as_deref(), &mesh)?;
            let measures = Measures::of(&mesh);
            lines.extend([String::new(), measures.text()]);
            json["solid"] = tier::proportions(&mesh);
            None
        }
        Err(error) => Some(Error::file(path, error)),
    };
    json["closed"] = json!(failure.is_none());
    json["warnings"] = texts(&warnings);
    warnings.iter().for_each(|warning| console.warn(warning));
    Ok(Report { text: lines.join("\n"), json, failure })
}

fn texts(warnings: &[Warning]) -> Value {
    warnings.iter().map(ToString::to_string).collect()
}

fn tier_table(tiers: &[Tier]) -> String {
    let mut rows = vec![["tier", "part", "facets", "angle", "distance"].map(str::to_owned).to_vec()];
    rows.extend(tiers.iter().map(|tier| {
        vec![
            tier.name.clone(),
            tier.part().to_owned(),
            tier.facets.to_string(),
            format!("{:.2}°", tier.angle()),
            format!("{:.5}", tier.distance),
        ]
    }));
    table::columns(2, &rows)
}

/// The figures of a closed solid, in the file's unit of length.
struct Measures<'a> {
    mesh: &'a Mesh,
    proportions: Proportions,
}

impl<'a> Measures<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        Measures { mesh, proportions: Proportions::of(mesh) }
    }

    fn text(&self) -> String {
        let p = &self.proportions;
        let of_width = |v: f64| format!("{:.1} % of the width", 100.0 * v / p.width);
        let angle = |a: Option<f64>| a.map_or(String::new(), |a| format!(", {a:.2}°"));
        let mut rows = vec![
            ("closed", format!("yes{}", if self.mesh.is_convex() { ", convex" } else { ", not convex" })),
            (
                "facets",
                format!(
                    "{}: crown {}, girdle {}, pavilion {}",
                    self.mesh.facets().len(),
                    p.crown_facets,
                    p.girdle_facets,
                    p.pavilion_facets
                ),
            ),
            ("triangles", self.mesh.triangles().len().to_string()),
            ("width × length", format!("{:.5} × {:.5}", p.width, p.length)),
            ("depth", of_width(p.total_depth)),
            ("crown", of_width(p.crown_height) + &angle(p.crown_angle)),
            ("girdle", of_width(p.girdle)),
            ("pavilion", of_width(p.pavilion_depth) + &angle(p.pavilion_angle)),
            ("volume", format!("{:.5}", p.volume)),
        ];
        if let Some(table) = p.table_percent {
            rows.insert(4, ("table", format!("{table:.1} % of the width")));
        }
        if self.mesh.shells() > 1 {
            rows.insert(1, ("shells", self.mesh.shells().to_string()));
        }
        let rows: Vec<Vec<String>> =
            rows.into_iter().map(|(key, value)| vec![key.to_owned(), value]).collect();
        table::columns(2, &rows)
    }
}
