//! `gemtrace sheet`: one scene several times, as one picture.

mod axes;
mod sizes;

use crate::arguments::{Rendering, one_of, parse_stops};
use crate::console::{Console, Report};
use clap::Subcommand;
use gemtrace::scene_file::{Draft, LoadedScene};
use gemtrace::{Error, Session, output};
use spectral_core::color::Tone;
use std::path::PathBuf;

/// Arguments of `sheet`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// What differs from picture to picture.
    #[command(subcommand)]
    pub kind: Kind,
}

/// The kinds of sheets.
#[derive(Debug, Clone, Subcommand)]
pub enum Kind {
    /// One scene with stones of several sizes: the camera keeps step, so that only the colour changes.
    Sizes(sizes::Args),
    /// A crystal cut with its axis at several angles to the table: how shall this rough be oriented?
    Axes(axes::Args),
}

/// What every sheet takes.
#[derive(Debug, Clone, clap::Args)]
pub struct Common {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Write the sheet here, as PNG [default: the scene's name with the sheet's kind, in the current folder].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub rendering: Rendering,
    /// Brighten what is shown by this many stops, the same for all pictures.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_stops)]
    pub exposure: f64,
    /// How colours are shown that a screen cannot show, in place of what the scene says: cut off, with their hue kept, or on the
    /// Khronos PBR Neutral curve.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = one_of(&Tone::ALL, Tone::name))]
    pub tone: Option<Tone>,
}

/// Pictures side by side before a new row begins.
const COLUMNS: usize = 4;

/// Renders a sheet.
///
/// # Errors
/// [`Error`] of the scene, the output or the device; [`Error::Interrupted`] if it was broken off.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    match &args.kind {
        Kind::Sizes(args) => sizes::run(args, console),
        Kind::Axes(args) => axes::run(args, console),
    }
}

impl Common {
    /// An open device, the document, the scene as it stands, and where the sheet goes. The scene must have a stone.
    fn begin(
        &self,
        kind: &str,
        console: &mut Console,
    ) -> Result<(Session, Draft, LoadedScene, PathBuf), Error> {
        let mut session = self.rendering.session()?;
        session.output.exposure = self.exposure;
        session.output.tone = self.tone;
        let first = session.load(&self.scene)?;
        first.warnings.iter().for_each(|warning| console.warn(warning));
        if first.scene.stones.is_empty() {
            let message = format!("a sheet of {kind} needs a stone; this scene has none");
            return Err(Error::file(&self.scene, message));
        }
        let draft = Draft::read(&self.scene)?;
        let path =
            self.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}-{kind}.png", draft.stem())));
        let inputs = first.files.iter().map(|file| file.path.as_path()).chain([self.scene.as_path()]);
        output::prepare(&[&path], inputs)?;
        Ok((session, draft, first, path))
    }
}
