//! The command line: one module a command, each a function from its arguments to a [`Report`].

pub mod batch;
pub mod bench;
pub mod check;
pub mod cut;
pub mod devices;
mod manual;
pub mod materials;
pub mod measure;
pub mod merge;
pub mod motion;
pub mod render;
pub mod scene;
pub mod sheet;
pub mod spectrum;
mod table;
#[cfg(feature = "view")]
pub mod view;

use crate::console::{Console, Interrupt, Report};
use clap::error::ErrorKind;
use clap::{Parser, Subcommand};
use gemtrace::Error;
use serde_json::json;
use spectral_core::{printable, shown_lines};
use std::io::Write;

const EXIT_CODES: &str = "\
Exit codes:
  0    done
  1    the render or its device failed; what was finished is written as for 130
  2    the command line does not make sense
  3    a scene, cut, mesh, image or figure that cannot be used
  4    a file that cannot be written
  5    some items of a batch failed or are missing; the manifest says which
  130  interrupted (Ctrl-C); what was finished is in NAME.partial.png, NAME.partial.exr";

/// The command line of `gemtrace`.
#[derive(Debug, Parser)]
#[command(name = "gemtrace", version, about, after_help = EXIT_CODES, propagate_version = true)]
pub struct Cli {
    /// Print one JSON object instead of text, see docs/json.md; what went wrong is in its "failure".
    #[arg(long, global = true)]
    pub json: bool,
    /// Print errors and nothing else; no progress, no warnings, no closing line.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to PNG and EXR.
    Render(render::Args),
    /// Render every picture of a sweep file: what is missing or has changed.
    Batch(batch::Args),
    /// Check that all shards of a batch are there and whole, and join them.
    Merge(merge::Args),
    /// Render a turn of all stones about +z, frame by frame; camera and lights stay.
    Turntable(motion::TurntableArgs),
    /// Render a tilt of all stones towards the eye and away from it, frame by frame.
    Tilt(motion::TiltArgs),
    /// Render a scene many times for one picture: its sizes.
    Sheet(sheet::Args),
    /// List the materials, or show one: index, dispersion, colour.
    Materials(materials::Args),
    /// Turn a linear sRGB colour into a spectrum.
    Spectrum(spectrum::Args),
    /// Describe a cut or a mesh: facets, proportions, whether it closes.
    Cut(cut::Args),
    /// Write a scene to start from, with the objects, materials and camera of a mesh file.
    Scene(scene::Args),
    /// Read a scene and everything it names, and say what would be rendered.
    Check(check::Args),
    /// List the backends and their devices.
    Devices(devices::Args),
    /// Measure what a cut does with light: light return, leakage, extinction, contrast, over the tilt.
    Measure(measure::Args),
    /// Look at stones live in a browser: turn them, change them, click a pixel.
    #[cfg(feature = "view")]
    View(view::Args),
    /// Measure every device on the same scenes: speed, time to first pixel, agreement with the processor.
    Bench(bench::Args),
    /// Print a script that completes commands and options in a shell.
    Completions(manual::CompletionArgs),
    /// Print the manual page of the program, or of a command.
    Man(manual::Args),
}

/// Runs a command.
///
/// # Errors
/// The error of a command that has nothing to report.
pub fn run(command: &Command, console: &mut Console) -> Result<Report, Error> {
    match command {
        Command::Render(args) => render::run(args, console),
        Command::Batch(args) => batch::run(args, console),
        Command::Merge(args) => merge::run(args, console),
        Command::Turntable(args) => motion::turntable(args, console),
        Command::Tilt(args) => motion::tilt(args, console),
        Command::Sheet(args) => sheet::run(args, console),
        Command::Materials(args) => materials::run(args, console),
        Command::Spectrum(args) => spectrum::run(args),
        Command::Cut(args) => cut::run(args, console),
        Command::Scene(args) => scene::run(args),
        Command::Check(args) => check::run(args, console),
        Command::Devices(args) => Ok(devices::run(args)),
        Command::Measure(args) => measure::run(args, console),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(args, console),
        Command::Bench(args) => bench::run(args, console),
        Command::Completions(args) => Ok(manual::completions(args)),
        Command::Man(args) => manual::run(args),
    }
}

/// Runs the whole program but for parsing: prints the report to `out`, warnings and errors to `log`, and
/// returns the exit code.
pub fn main(cli: &Cli, out: &mut dyn Write, log: &mut dyn Write, interrupt: &Interrupt) -> u8 {
    let mut console = Console { quiet: cli.quiet, json: cli.json, ..Console::new(log, interrupt) };
    let (report, failure) = match run(&cli.command, &mut console) {
        Ok(report) => (Some(report.clone()), report.failure),
        Err(error) => (None, Some(error)),
    };
    let warnings = std::mem::take(&mut console.warnings);
    let text = if cli.json {
        object(
            report,
            warnings,
            failure.as_ref().map(|error| (shown_lines(&error.to_string()), error.exit_code())),
        )
    } else {
        report.filter(|_| !cli.quiet).map_or(String::new(), |r| r.text)
    };
    let failure = failure.or(print(&text, out).err());
    if let Some(error) = &failure {
        let told = shown_lines(&error.to_string());
        let line = if cli.json {
            printable(&json!({ "error": told }).to_string())
        } else {
            format!("error: {told}")
        };
        writeln!(log, "{line}").ok();
    }
    failure.map_or(0, |error| error.exit_code())
}

/// Says what is wrong with a command line, or shows the help that was asked for. Returns the exit code.
pub fn refuse(error: &clap::Error, json: bool, out: &mut dyn Write) -> u8 {
    let help = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
    if json && !help {
        let text = error.render().to_string();
        // Without the hints of how to call the program, which follow after an empty line.
        let message = text.split("\n\nUsage").next().unwrap_or_default().split("\n\nFor more").next();
        let message = message.unwrap_or_default().trim_start_matches("error: ").trim();
        print(&object(None, Vec::new(), Some((message.to_owned(), 2))), out).ok();
    } else {
        // If the stream is closed, there is nowhere to report it.
        error.print().ok();
    }
    if help { 0 } else { 2 }
}

/// The number of the layout of what `--json` prints, which docs/json.md describes.
const FORMAT: u32 = 1;

/// What `--json` prints.
fn object(report: Option<Report>, warnings: Vec<String>, failure: Option<(String, u8)>) -> String {
    let mut object = report.map_or(json!({}), |report| report.json);
    object["format"] = json!(FORMAT);
    if object.get("warnings").is_none() {
        object["warnings"] = json!(warnings);
    }
    if let Some((message, exit_code)) = failure {
        object["failure"] = json!({ "message": message, "exit_code": exit_code });
    }
    object.to_string()
}

fn print(text: &str, out: &mut dyn Write) -> Result<(), Error> {
    if text.is_empty() {
        return Ok(());
    }
    match writeln!(out, "{}", printable(text)).and_then(|()| out.flush()) {
        // Whoever reads us has seen enough (`gemtrace materials | head`).
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(Error::output("standard output", format!("cannot be written ({e})"))),
        Ok(()) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
