//! `gemtrace turntable` and `gemtrace tilt`.

use super::figure::seconds;
use super::still::{self, Means, Studio};
use super::{Console, Report};
use crate::output::{Target, animation};
use crate::scene_file::{self, Draft};
use crate::sequence::Motion;
use crate::{Error, output};
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What turntables and tilts have in common.
#[derive(Debug, Clone, clap::Args)]
pub struct Frames {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// How many frames.
    #[arg(long, value_name = "N", default_value_t = 36, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
    /// Write the frames into this folder, which is made if need be [default: the scene's name with -turntable or
    /// -tilt].
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Write each frame as EXR, too.
    #[arg(long)]
    pub exr: bool,
    /// Write all frames as one animated PNG, alpha included.
    #[arg(long, value_name = "FILE")]
    pub apng: Option<PathBuf>,
    /// Write all frames as one MP4 (H.264; what is transparent over black); needs ffmpeg.
    #[arg(long, value_name = "FILE")]
    pub mp4: Option<PathBuf>,
    /// Frames a second of the animated files.
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u16).range(1..=240))]
    pub fps: u16,
    /// The ffmpeg to encode MP4 with.
    #[arg(long, value_name = "PROGRAM", default_value = "ffmpeg")]
    pub ffmpeg: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub means: Means,
}

/// Arguments of `turntable`.
#[derive(Debug, Clone, clap::Args)]
pub struct TurntableArgs {
    #[command(flatten)]
    #[allow(missing_docs, reason = "as above")]
    pub frames: Frames,
}

/// Arguments of `tilt`.
#[derive(Debug, Clone, clap::Args)]
pub struct TiltArgs {
    #[command(flatten)]
    #[allow(missing_docs, reason = "as above")]
    pub frames: Frames,
    /// The angles of the first and the last frame, degrees; positive: what is upright in the picture comes towards
    /// the eye.
    #[arg(long, value_name = "FROM..TO", default_value = "-30..30", allow_hyphen_values = true, value_parser = parse_range)]
    pub range: [f64; 2],
}

/// Renders a turn of all stones about +z.
///
/// # Errors
/// As [`tilt`].
pub fn turntable(args: &TurntableArgs, console: &mut Console) -> Result<Report, Error> {
    run(&args.frames, Motion::Turntable, console)
}

/// Renders a tilt of all stones about the camera's horizontal axis.
///
/// # Errors
/// [`Error`] of the scene, the outputs or the device; [`Error::Interrupted`] if it was broken off. The frames before
/// are there in each case. An animation that could not be written is told in the report's `failure`.
pub fn tilt(args: &TiltArgs, console: &mut Console) -> Result<Report, Error> {
    let [from, to] = args.range;
    run(&args.frames, Motion::Tilt { from, to }, console)
}

fn run(args: &Frames, motion: Motion, console: &mut Console) -> Result<Report, Error> {
    let start = Instant::now();
    let mut studio = Studio::new(&args.means)?;
    // As it stands: its faults have the file's lines, those of a frame have lines that nobody wrote.
    let mut first = scene_file::load(&args.scene)?;
    first.warnings.iter().for_each(|warning| console.warn(warning));
    let prepared = studio.prepare(&mut first)?;
    let draft = Draft::read(&args.scene)?;
    let stem = draft.stem();
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{stem}-{}", motion.name())));
    make(&folder)?;
    args.apng.iter().chain(&args.mp4).try_for_each(|path| output::check(path))?;
    let bar = still::bar(&prepared, args.frames, console.quiet);
    drop((first, prepared));
    let mut pngs = Vec::new();
    for i in 0..args.frames {
        let name = motion.frame_name(&stem, i, args.frames);
        let frame = motion.frame(&draft, i, args.frames).load()?;
        let png = folder.join(format!("{name}.png"));
        let exr = args.exr.then(|| folder.join(format!("{name}.exr")));
        let targets: Vec<Target> =
            [Some(png.clone()), exr].into_iter().flatten().map(Target::new).collect::<Result<_, _>>()?;
        studio.take(frame, console, &bar, i)?.write(&targets, &draft.name(), args.means.exposure)?;
        pngs.push(png);
    }
    drop(bar);
    Ok(report(args, motion, &folder, &pngs, start))
}

fn make(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder)
        .map_err(|e| Error::output(folder, format!("this folder cannot be made ({e})")))?;
    output::check(&folder.join("frame.png"))
}

fn report(args: &Frames, motion: Motion, folder: &Path, pngs: &[PathBuf], start: Instant) -> Report {
    let apng = args.apng.as_ref().map(|path| (path, animation::apng(pngs, args.fps, path)));
    let mp4 = args.mp4.as_ref().map(|path| (path, animation::mp4(pngs, args.fps, path, &args.ffmpeg)));
    let mut text = format!("wrote {} frames to {}", pngs.len(), folder.display());
    let mut failure = None;
    for (path, outcome) in apng.into_iter().chain(mp4) {
        match outcome {
            Ok(()) => text += &format!(", {}", path.display()),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    text += &format!(" in {}", seconds(start.elapsed()));
    let angles: Vec<f64> = (0..args.frames).map(|i| motion.angle(i, args.frames)).collect();
    let names: Vec<String> = pngs.iter().map(|path| path.display().to_string()).collect();
    let json = json!({ "motion": motion.name(), "frames": names, "angles": angles });
    Report { text, json, failure }
}

/// "-30..30".
fn parse_range(text: &str) -> Result<[f64; 2], String> {
    let ends = text
        .split_once("..")
        .filter(|(_, to)| !to.starts_with('.'))
        .map(|(from, to)| (from.trim().parse::<f64>(), to.trim().parse::<f64>()));
    match ends {
        Some((Ok(from), Ok(to))) if from.abs() <= 360.0 && to.abs() <= 360.0 => Ok([from, to]),
        _ => Err("give two angles in degrees, such as -30..30".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_two_ends() {
        assert_eq!(parse_range("-30..30"), Ok([-30.0, 30.0]));
        assert_eq!(parse_range("10.5 .. -4"), Ok([10.5, -4.0]));
        for bad in ["30", "a..b", "-30...30", "0..361", "nan..1"] {
            assert!(parse_range(bad).is_err(), "{bad}");
        }
    }
}
