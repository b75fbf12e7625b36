//! Many colours at once, for comparisons with other ways from a colour to a spectrum.

use crate::commands::table;
use crate::console::Report;
use gemtrace::{Error, import};
use serde_json::json;
use spectral_core::color::Response;
use spectral_core::upsample::{Refinement, Stop, refine_smits};
use spectral_core::wavelength::WavelengthGrid;
use std::path::Path;
use std::time::Instant;

/// Refines every colour of a file. The report's `seconds` are those of the refinement alone.
///
/// # Errors
/// [`Error::File`] for a file that cannot be read, and naming the line for one that is no colour.
pub fn run(path: &Path, grid: &WavelengthGrid, response: &Response, stop: Stop) -> Result<Report, Error> {
    let colours = read(path)?;
    let start = Instant::now();
    let refined = colours
        .iter()
        .map(|&(line, rgb)| {
            refine_smits(grid, response, rgb, stop)
                .map_err(|e| Error::file(path, format!("line {line}: {e}")))
        })
        .collect::<Result<Vec<Refinement>, Error>>()?;
    let seconds = start.elapsed().as_secs_f64();
    let mut rows = vec![["colour", "error", "sweeps"].map(str::to_owned).to_vec()];
    rows.extend(colours.iter().zip(&refined).map(|((_, [r, g, b]), refined)| {
        vec![format!("{r} {g} {b}"), format!("{:.1e}", refined.residual), refined.sweeps.to_string()]
    }));
    let json = json!({
        "nm": grid.nm(),
        "seconds": seconds,
        "colours": colours.iter().zip(&refined).map(|((_, rgb), refined)| json!({
            "rgb": rgb,
            "error": refined.residual,
            "sweeps": refined.sweeps,
            "converged": refined.converged,
            "radiance": refined.spectrum,
        })).collect::<Vec<_>>(),
    });
    Ok(Report::new(table::columns(1, &rows), json))
}

/// The colours with the lines they stand in, counted from 1. Blank lines and those that begin with `#` are skipped.
fn read(path: &Path) -> Result<Vec<(usize, [f64; 3])>, Error> {
    let bytes = import::read_file(path)?;
    let text = import::text(path, &bytes)?;
    let lines = text.lines().zip(1..);
    let colours = lines.filter(|(line, _)| !line.trim().is_empty() && !line.starts_with('#'));
    colours
        .map(|(line, number)| {
            let parts = line.split([',', ' ', '\t']).filter(|part| !part.is_empty());
            let numbers: Option<Vec<f64>> = parts.map(|part| part.trim().parse().ok()).collect();
            numbers.and_then(|n| <[f64; 3]>::try_from(n).ok()).map(|rgb| (number, rgb)).ok_or_else(|| {
                Error::file(path, format!("line {number}: '{line}' is no colour; three numbers are"))
            })
        })
        .collect()
}
