//! `gemtrace measure`: the numbers of a cut, and how they change as it is tilted.
//!
//! * `subject`: the stone, from a scene, a cut or a mesh.
//! * `tilt`: the angles.
//! * `table`: the numbers as text, CSV, JSON and a plot.

mod subject;
mod table;
mod tilt;

use crate::arguments::{one_of, open_options, parse_square};
use crate::console::{Console, Report};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use gemtrace::measure::{Conditions, Hinge, Measurement, Position, sodium};
use gemtrace::{Error, Session, output, registry};
use spectral_core::environment::Pattern;
use spectral_core::scene::Up;
use spectral_core::settings::Leftover;
use spectral_core::tracer::Progress;
use spectral_core::wavelength::WavelengthGrid;
use std::path::{Path, PathBuf};
use subject::Subject;

/// Arguments of `measure`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// A scene of one stone (.toml), a cut (.asc, .gem, .gcs) or a mesh (.obj, .stl, .ply).
    pub file: PathBuf,
    /// Its material, or a bare index of refraction [default: the scene's; for a cut, the index it was designed for].
    #[arg(short, long, value_name = "NAME|INDEX")]
    pub material: Option<String>,
    /// Width in mm: the smaller extent [default: the scene's; for a cut or a mesh, the file's units as mm].
    #[arg(long, value_name = "MM")]
    pub width: Option<f64>,
    /// The axis of a mesh's file that is the normal of the table [default: the scene's; for a mesh, z].
    #[arg(long, value_name = "AXIS", value_parser = PossibleValuesParser::new(Up::NAMES).try_map(|name| Up::by_name(&name)))]
    pub up: Option<Up>,
    /// Light models, separated by commas.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = "iso,cos,sc2",
        value_parser = PossibleValuesParser::new(Pattern::NAMES).try_map(|name| Pattern::by_name(&name)))]
    pub models: Vec<Pattern>,
    /// Half-angle of the viewer's head, degrees; 0 for none.
    #[arg(long, value_name = "DEGREES", default_value_t = 10.0)]
    pub head: f64,
    /// Angles of tilt, degrees: one, some (0,10,20), or from..to:step [default: 0].
    #[arg(long, value_name = "ANGLES", allow_hyphen_values = true, default_value = "0", value_parser = tilt::parse)]
    pub tilt: tilt::Angles,
    /// The axis that it is tilted about.
    #[arg(long, value_name = "AXIS", default_value = "x", value_parser = one_of(&Hinge::ALL, Hinge::name))]
    pub about: Hinge,
    /// Distance of the eye in mm [default: a scene's camera; else infinite: parallel rays].
    #[arg(long, value_name = "MM")]
    pub eye: Option<f64>,
    /// Rays across the square raster [default: 300x300].
    #[arg(long, value_name = "WxH", value_parser = parse_square)]
    pub size: Option<u32>,
    /// Surface events on a path, in place of the scene's.
    #[arg(long, value_name = "N")]
    pub max_depth: Option<u32>,
    /// What becomes of a ray at that limit, in place of the scene's.
    #[arg(long, value_name = "WHAT", value_parser = one_of(&Leftover::ALL, Leftover::name))]
    pub leftover: Option<Leftover>,
    /// Throughput below which a ray in the stone is spent, in place of the scene's.
    #[arg(long, value_name = "SHARE")]
    pub threshold: Option<f64>,
    /// Average both polarisations at every surface, as most programs for cutters do.
    #[arg(long)]
    pub unpolarized: bool,
    /// Wavelengths over 380 to 740 nm, in place of the scene's [default: 8; 1 where the index is bare].
    #[arg(long, value_name = "N")]
    pub wavelengths: Option<usize>,
    /// The conditions of GemRay: see `docs/light-models.md`. What else is given changes them.
    #[arg(long, conflicts_with = "width")]
    pub gemray: bool,
    /// Fire and scintillation, too: figures without a standard, by the formulas in `docs/light-models.md`.
    #[arg(long)]
    pub experimental: bool,
    /// Write the numbers here, in percent.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write a plot over the tilt here.
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// What renders, as `gemtrace devices` lists it.
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    pub backend: String,
    /// Worker threads [default: one a core]; the numbers are the same for any.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
}

/// Measures a stone at every angle.
///
/// # Errors
/// [`Error`] of the files, the figures of the command line or the device; [`Error::Interrupted`] after Ctrl-C, when
/// nothing is written.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    let device = registry::choose(&args.backend, None)?;
    let subject = Subject::new(args)?;
    let outputs: Vec<&Path> = [&args.csv, &args.svg].into_iter().flatten().map(PathBuf::as_path).collect();
    output::prepare(&outputs, subject.files.iter().map(PathBuf::as_path))?;
    subject.warnings.iter().for_each(|warning| console.warn(warning));
    let conditions = conditions(args, &subject)?;
    let mut session = Session::new(device, open_options(args.threads));
    let mut measurement = Measurement::new(&subject.stone, &conditions, &mut session)?;
    console.interrupt.heed();
    let mut watch = |_: Progress| console.interrupt.flow();
    let positions = args
        .tilt
        .0
        .iter()
        .map(|&tilt| measurement.at(tilt, &mut watch))
        .collect::<Result<Vec<Position>, Error>>()?;
    if let Some(path) = &args.csv {
        output::write_text(path, &table::csv(&conditions, &positions))?;
    }
    if let Some(path) = &args.svg {
        output::write_text(path, &table::plot(&subject.title, &conditions, &positions))?;
    }
    let text = table::text(&conditions, &positions);
    Ok(Report::new(text, table::json(&subject, &conditions, &positions)))
}

/// GemRay's conditions or the subject's own, changed by what the command line says.
fn conditions(args: &Args, subject: &Subject) -> Result<Conditions, Error> {
    let default = if args.gemray { Conditions::gemray() } else { Conditions::default() };
    let mut settings = if args.gemray { default.settings.clone() } else { subject.settings.clone() };
    if let Some(count) = args.wavelengths {
        let even = || WavelengthGrid::midpoints([380.0, 740.0], count);
        settings.wavelengths = if count == 1 { sodium() } else { even()? };
    }
    settings.max_depth = args.max_depth.unwrap_or(settings.max_depth);
    settings.leftover = args.leftover.unwrap_or(settings.leftover);
    settings.threshold = args.threshold.unwrap_or(settings.threshold);
    settings.polarized &= !args.unpolarized;
    if !(0.0..=90.0).contains(&args.head) {
        let expected = "a half-angle in degrees, from 0 (no head) to 90";
        return Err(spectral_core::Error::value("head", args.head, expected).into());
    }
    let eye = if args.gemray { default.eye } else { subject.eye };
    Ok(Conditions {
        models: args.models.clone(),
        head: args.head,
        eye: args.eye.or(eye),
        size: args.size.unwrap_or(default.size),
        settings,
        hinge: args.about,
        experimental: args.experimental,
        ..default
    })
}
