//! `gemtrace turntable` and `gemtrace tilt`.

use super::batch;
use crate::arguments::{Rendering, one_of, parse_stops};
use crate::console::{Console, Report};
use gemtrace::batch::{Pictures, Place};
use gemtrace::output::{Format, animation};
use gemtrace::scene_file::Draft;
use gemtrace::sequence::Motion;
use gemtrace::shard::Shard;
use gemtrace::{Error, output};
use serde_json::json;
use spectral_core::color::Tone;
use std::path::{Path, PathBuf};

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
    /// Render the i-th of n shares of the frames only; auto: the one that Slurm or Kubernetes says, else all.
    #[arg(long, value_name = "I/N", default_value = "auto")]
    pub shard: String,
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
    pub rendering: Rendering,
    /// Brighten what is shown by this many stops, the same for all frames; EXRs keep the scene's own values.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_stops)]
    pub exposure: f64,
    /// How colours are shown that a screen cannot show, in place of what the scene says: cut off, with their hue kept, or on the
    /// Khronos PBR Neutral curve.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = one_of(&Tone::ALL, Tone::name))]
    pub tone: Option<Tone>,
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
/// [`Error`] of the scene or the outputs, before the first ray. Frames that failed, an interruption and an animation that
/// could not be written are in the report's `failure`; what was rendered is there, and the same command goes on from
/// it (see [`gemtrace::batch`]).
pub fn tilt(args: &TiltArgs, console: &mut Console) -> Result<Report, Error> {
    let [from, to] = args.range;
    run(&args.frames, Motion::Tilt { from, to }, console)
}

fn run(args: &Frames, motion: Motion, console: &mut Console) -> Result<Report, Error> {
    let shard = Shard::by_name(&args.shard)?;
    let mut session = args.rendering.session()?;
    // As it stands: its faults have the file's lines, those of a frame have none.
    let mut first = session.load(&args.scene)?;
    first.warnings.iter().for_each(|warning| console.warn(warning));
    args.rendering.overrides().apply(&mut first);
    session.prepare(&first.scene, &first.settings)?;
    let inputs = first.files.iter().map(|file| file.path.as_path()).chain([args.scene.as_path()]);
    let films: Vec<&Path> = args.apng.iter().chain(&args.mp4).map(PathBuf::as_path).collect();
    output::prepare(&films, inputs)?;
    drop(first);
    let draft = Draft::read(&args.scene)?;
    let folder = args.output.clone().unwrap_or_else(|| format!("{}-{}", draft.stem(), motion.name()).into());
    let mut pictures = Pictures::default();
    pictures.options.exposure = args.exposure;
    pictures.options.tone = args.tone;
    pictures.formats.extend(args.exr.then_some(Format::Exr));
    let plan = motion.plan(&draft, args.frames, pictures)?.with(args.rendering.overrides());
    let place = Place { output: folder.clone(), shard };
    let mut report = batch::render(&plan, &place, &mut session, console)?;
    let pngs: Vec<PathBuf> =
        plan.items().iter().map(|item| folder.join(format!("{}.png", item.name))).collect();
    if report.failure.is_none() {
        if shard.is_whole() {
            animate(args, &pngs, &mut report);
        } else if args.apng.is_some() || args.mp4.is_some() {
            console.say(
                "animations are of all frames: once they are there, give the same command without --shard",
            );
        }
    }
    let angles: Vec<f64> = (0..args.frames).map(|i| motion.angle(i, args.frames)).collect();
    let names: Vec<String> = pngs.iter().map(|path| path.display().to_string()).collect();
    report.json["motion"] = json!(motion.name());
    report.json["frames"] = json!(names);
    report.json["angles"] = json!(angles);
    Ok(report)
}

/// Makes the animations that were asked for.
fn animate(args: &Frames, pngs: &[PathBuf], report: &mut Report) {
    let apng = args.apng.as_ref().map(|path| (path, animation::apng(pngs, args.fps, path)));
    let mp4 = args.mp4.as_ref().map(|path| (path, animation::mp4(pngs, args.fps, path, &args.ffmpeg)));
    for (path, outcome) in apng.into_iter().chain(mp4) {
        match outcome {
            Ok(()) => report.text += &format!(", {}", path.display()),
            Err(error) => report.failure = report.failure.take().or(Some(error)),
        }
    }
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
