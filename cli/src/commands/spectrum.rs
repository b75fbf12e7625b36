//! `gemtrace spectrum`.

mod list;

use super::table;
use crate::console::Report;
use gemtrace::plot::{Curve, Panel, svg};
use gemtrace::{Error, output};
use serde_json::json;
use spectral_core::cie::Illuminant;
use spectral_core::color::Response;
use spectral_core::upsample::{Refinement, Stop, refine_smits};
use spectral_core::wavelength::WavelengthGrid;
use std::path::PathBuf;

/// Arguments of `spectrum`.
#[derive(Debug, Clone, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Args {
    /// Red, green and blue, linear sRGB; 1 is the white's.
    #[arg(num_args = 3, value_names = ["RED", "GREEN", "BLUE"], required_unless_present = "list")]
    pub rgb: Vec<f64>,
    /// Read colours from here in place of one, three numbers a line; best with --json.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["rgb", "svg"])]
    pub list: Option<PathBuf>,
    /// Stop when the summed error, relative to the largest component, is at most this.
    #[arg(long, value_name = "ERROR", default_value_t = 1e-6)]
    pub tolerance: f64,
    /// Stop after this many sweeps in any case.
    #[arg(long, value_name = "N", default_value_t = Stop::default().max_sweeps)]
    pub sweeps: u32,
    /// Write a plot of the spectrum here.
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
}

/// Refines Smits's spectrum of the colour on the grid 380–780 nm, 5 nm.
///
/// # Errors
/// [`Error::Core`] for a colour that no light has; [`Error::File`] for a list that cannot be used;
/// [`Error::Output`] for the plot.
pub fn run(args: &Args) -> Result<Report, Error> {
    let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0)?;
    let response = Response::new(&grid)?;
    let stop = Stop { tolerance: args.tolerance, max_sweeps: args.sweeps };
    if let Some(path) = &args.list {
        return list::run(path, &grid, &response, stop);
    }
    let rgb = <[f64; 3]>::try_from(args.rgb.as_slice())
        .map_err(|_| Error::Usage("a colour is three numbers: red, green and blue".to_owned()))?;
    let refined = refine_smits(&grid, &response, rgb, stop)?;
    let shown = response.to_linear_srgb(&refined.spectrum);
    if let Some(path) = &args.svg {
        output::write_text(path, &plot(rgb, &grid, &refined))?;
    }
    let json = json!({
        "rgb": rgb,
        "shown": shown,
        "error": refined.residual,
        "sweeps": refined.sweeps,
        "converged": refined.converged,
        "nm": grid.nm(),
        "radiance": refined.spectrum,
    });
    Ok(Report::new(describe(&grid, &refined, shown), json))
}

fn describe(grid: &WavelengthGrid, refined: &Refinement, shown: [f64; 3]) -> String {
    let mut rows = vec![["nm", "radiance", "÷ D65"].map(str::to_owned).to_vec()];
    rows.extend(grid.nm().iter().zip(&refined.spectrum).map(|(&nm, &value)| {
        vec![nm.to_string(), format!("{value:.6}"), format!("{:.6}", value / Illuminant::D65.at(nm))]
    }));
    let verdict = if refined.converged { "" } else { "; not converged: the best that was found" };
    format!(
        "{}\n\nshows as {:.6} {:.6} {:.6}; summed error {:.1e} after {} sweeps{verdict}",
        table::columns(0, &rows),
        shown[0],
        shown[1],
        shown[2],
        refined.residual,
        refined.sweeps
    )
}

fn plot(rgb: [f64; 3], grid: &WavelengthGrid, refined: &Refinement) -> String {
    let line = |label: &str, colour, of: &dyn Fn(f64, f64) -> f64| Curve {
        label: label.to_owned(),
        colour,
        points: grid.nm().iter().zip(&refined.spectrum).map(|(&nm, &value)| [nm, of(nm, value)]).collect(),
    };
    let lines = vec![
        line("radiance", "#222", &|_, value| value),
        line("relative to D65", "#c60", &|nm, value| value / Illuminant::D65.at(nm)),
    ];
    let title = format!("Spectrum of linear sRGB {}, {}, {}", rgb[0], rgb[1], rgb[2]);
    svg(&title, &[Panel { label: "radiance".to_owned(), from_zero: true, lines }])
}
