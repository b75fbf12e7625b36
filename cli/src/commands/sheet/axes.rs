//! `gemtrace sheet axes`: one crystal, cut with its axis at several angles to the table.

use super::{COLUMNS, Common};
use crate::commands::table;
use crate::console::{Console, Report};
use crate::progress::Onlooker;
use gemtrace::output::Picture;
use gemtrace::quantity::seconds;
use gemtrace::sheet::{Cell, Sheet};
use gemtrace::{Error, output, registry};
use serde_json::{Value, json};
use spectral_core::color::{RgbSpace, delta_e_2000, lab};
use spectral_core::material::Material;
use spectral_core::scene::{Orientation, Stone};
use std::time::Instant;

/// Arguments of `sheet axes`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub common: Common,
    /// The axis that is turned: of a uniaxial crystal e, its optic axis; of a biaxial one x, y or z [default: e, z].
    #[arg(long, value_name = "AXIS", value_parser = ["e", "x", "y", "z"])]
    pub axis: Option<String>,
    /// Angles between that axis and the normal of the table, degrees.
    #[arg(long, value_name = "DEGREES,…", value_delimiter = ',', default_value = "0,30,60,90", value_parser = parse_angle)]
    pub angles: Vec<f64>,
    /// Directions in which it is tilted, degrees counter-clockwise from the stone's +x.
    #[arg(long, value_name = "DEGREES,…", value_delimiter = ',', default_value = "0,90", value_parser = parse_angle,
        allow_negative_numbers = true)]
    pub azimuths: Vec<f64>,
}

/// How the crystal lies, and what is then seen of it: the mean colour of the stones, L*a*b*.
struct View {
    angle: f64,
    azimuth: f64,
    lab: [f64; 3],
}

/// Renders the sheet.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    let start = Instant::now();
    let common = &args.common;
    let (mut session, draft, first, path) = common.begin("axes", console)?;
    let material = first.scene.stones[0].material.clone();
    drop(first);
    let turned = turned(args, &material)?;
    let positions = positions(args, &material);
    let mut onlooker = Onlooker::new(console, positions.len(), common.rendering.backend == registry::AUTO);
    let (mut cells, mut views): (Vec<Cell>, Vec<View>) = (Vec::new(), Vec::new());
    for (angle, azimuth) in positions {
        let mut loaded = draft.load(&mut session.assets)?;
        let stones = loaded.scene.stones.iter_mut().filter(|stone| stone.material == material);
        stones.for_each(|stone| stone.orientation = Some(orientation(stone, turned, angle, azimuth)));
        common.rendering.overrides().apply(&mut loaded);
        let picture = session.render_watched(loaded, &mut onlooker)?;
        let lab = mean_lab(&picture);
        let apart = views.first().map_or(0.0, |first| delta_e_2000(first.lab, lab));
        // The lettering of sheets has no signs for degrees and Δ.
        let name = if angle == 0.0 { "0 deg".to_owned() } else { format!("{angle} deg to {azimuth} deg") };
        let mut cell = Cell::new(&picture, name);
        cell.label.push(format!("L* {:.0}, dE00 {apart:.1}", lab[0]));
        cells.push(cell);
        views.push(View { angle, azimuth, lab });
        onlooker.next();
    }
    drop(onlooker);
    let sheet = Sheet::new(&cells, COLUMNS);
    let bytes = output::write_rgb(&path, sheet.width, &sheet.pixels)?;
    let took = seconds(start.elapsed());
    let text =
        format!("{}\n\nwrote {} – {} positions in {took}", describe(&views), path.display(), cells.len());
    let axis = material.axis_names()[if material.axes.len() == 1 { 1 } else { turned }].0;
    Ok(Report::new(
        text,
        json!({ "output": path.display().to_string(), "bytes": bytes, "axis": axis, "positions": facts(&views) }),
    ))
}

/// Which axis is turned: its place among x, y and z, where a uniaxial crystal has its optic axis along z.
fn turned(args: &Args, material: &Material) -> Result<usize, Error> {
    if !material.is_crystal() {
        let message =
            format!("a sheet of axes needs a crystal; '{}', of the first stone, has none", material.name);
        return Err(Error::file(&args.common.scene, message));
    }
    let uniaxial = material.axes.len() == 1;
    match args.axis.as_deref() {
        None => Ok(2),
        Some("e") if uniaxial => Ok(2),
        Some("x") if !uniaxial => Ok(0),
        Some("y") if !uniaxial => Ok(1),
        Some("z") if !uniaxial => Ok(2),
        Some(other) => {
            let expected =
                if uniaxial { "a uniaxial crystal has e" } else { "a biaxial crystal has x, y and z" };
            Err(spectral_core::Error::value("axis", other, expected).into())
        }
    }
}

/// The angles and azimuths to show. An optic axis along the normal has no azimuth.
fn positions(args: &Args, material: &Material) -> Vec<(f64, f64)> {
    let uniaxial = material.axes.len() == 1;
    let azimuths = |angle: f64| {
        let count = if angle % 180.0 == 0.0 && uniaxial { 1 } else { args.azimuths.len() };
        args.azimuths[..count].iter().map(move |&azimuth| (angle, azimuth))
    };
    args.angles.iter().flat_map(|&angle| azimuths(angle)).collect()
}

/// The crystal with the axis `turned` at `angle` to the table's normal, towards `azimuth`; the next axis (x after z) lies in
/// the plane of both.
fn orientation(stone: &Stone, turned: usize, angle: f64, azimuth: f64) -> Orientation {
    let ((sin, cos), (across, along)) = (angle.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    let axis = [sin * along, sin * across, cos];
    let next = [cos * along, cos * across, -sin];
    let after = [-across, along, 0.0];
    let mut axes = [[0.0; 3]; 3];
    axes[turned] = axis;
    axes[(turned + 1) % 3] = next;
    axes[(turned + 2) % 3] = after;
    // Axes are given in the frame of the file.
    let to_file = stone.up.matrix().transpose();
    Orientation::Axes([axes[0], axes[1]].map(|axis| to_file * glam::DVec3::from(axis)))
}

/// L*a*b* of the mean light of the pixels that stones cover wholly.
fn mean_lab(picture: &Picture) -> [f64; 3] {
    let film = &picture.film;
    let pixels = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    let covered: Vec<[f32; 3]> =
        pixels.filter(|&(x, y)| film.coverage(x, y) > 0.999).map(|(x, y)| film.xyz(x, y)).collect();
    let scale = picture.options.exposure.exp2() / covered.len().max(1) as f64;
    let mean = std::array::from_fn(|c| covered.iter().map(|xyz| f64::from(xyz[c])).sum::<f64>() * scale);
    lab(mean, RgbSpace::Srgb.white_xyz())
}

fn describe(views: &[View]) -> String {
    let mut rows = vec![["angle", "azimuth", "L*", "a*", "b*", "ΔE00"].map(str::to_owned).to_vec()];
    for View { angle, azimuth, lab } in views {
        let [l, a, b] = lab.map(|v| format!("{v:.1}"));
        let apart = format!("{:.1}", delta_e_2000(views[0].lab, *lab));
        rows.push(vec![format!("{angle}°"), format!("{azimuth}°"), l, a, b, apart]);
    }
    table::columns(0, &rows)
}

fn facts(views: &[View]) -> Vec<Value> {
    let facts = |View { angle, azimuth, lab }: &View| json!({ "angle": angle, "azimuth": azimuth, "lab": lab, "delta_e": delta_e_2000(views[0].lab, *lab) });
    views.iter().map(facts).collect()
}

fn parse_angle(text: &str) -> Result<f64, String> {
    let angle = text.trim().parse::<f64>().ok().filter(|angle| angle.abs() <= 360.0);
    angle.ok_or_else(|| "give angles in degrees, from -360 to 360, such as 0,30,60,90".to_owned())
}
