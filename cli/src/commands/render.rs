//! `gemtrace render`.

mod outcome;

use crate::arguments::{Rendering, one_of, parse_stops};
use crate::console::{Console, Report};
use crate::progress::Onlooker;
use gemtrace::output::{self, Depth, Format, Options, Picture, Target, Written};
use gemtrace::part::{self, Bands, Contribution};
use gemtrace::scene_file::{self, LoadedScene};
use gemtrace::session::Rendered;
use gemtrace::shard::Shard;
use gemtrace::{Error, Session, registry};
use outcome::Outcome;
use spectral_core::color::{RgbSpace, Tone};
use spectral_core::film::Film;
use spectral_core::prepare::PreparedScene;
use spectral_core::tracer::Backend;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Arguments of `render`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// Write the picture here, as PNG or EXR by the name's extension; may be given more than once
    /// [default: the scene's name with .png and .exr, in the current folder].
    #[arg(short, long, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would print it as the command's own description")]
    pub rendering: Rendering,
    /// Colour space of the EXR, and of the PNG up to Rec. 2020.
    #[arg(long, value_name = "SPACE", default_value = "srgb", ignore_case = true,
        value_parser = one_of(&RgbSpace::ALL, RgbSpace::name))]
    pub space: RgbSpace,
    /// Brighten the PNG by this many stops; the EXR keeps the scene's own values.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_stops)]
    pub exposure: f64,
    /// How colours are shown that a screen cannot show, in place of what the scene says: cut off, with their hue kept, or on the
    /// Khronos PBR Neutral curve.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = one_of(&Tone::ALL, Tone::name))]
    pub tone: Option<Tone>,
    /// Render the i-th of n shares of the picture's rows into NAME.part-I-of-N.exr, for 'gemtrace merge' to join; auto:
    /// the share that Slurm or Kubernetes gives.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Bits a channel of the PNG.
    #[arg(long, value_name = "N", default_value = "8", value_parser = one_of(&Depth::ALL, Depth::name))]
    pub bits: Depth,
}

/// Renders a scene and writes its picture.
///
/// Whatever can be refused is refused before the first ray: the backend's name, the outputs, the scene.
///
/// # Errors
/// [`Error`] of the scene, the outputs or the device; [`Error::Interrupted`] if nothing was finished. A
/// picture that could not be written, or is partial, is in the report's `failure`.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    run_among(registry::backends(), args, console)
}

/// The same with other backends than this program's.
///
/// # Errors
/// As [`run`].
pub fn run_among(backends: &[Backend], args: &Args, console: &mut Console) -> Result<Report, Error> {
    let start = Instant::now();
    let shard = args.shard.as_deref().map_or(Ok(Shard::WHOLE), Shard::by_name)?;
    let targets = targets(args)?;
    registry::known(backends, &args.rendering.backend)?;
    if !shard.is_whole() {
        part::check(&targets)?;
    }
    let mut loaded = load(args)?;
    guard(args, shard, &targets, &loaded)?;
    let scene = Arc::new(prepare(args, &loaded)?);
    let candidates = registry::choose_for(&scene, backends, &args.rendering.backend, args.rendering.device)?;
    // Prepared, it is not needed any more, and meshes are large.
    loaded.scene.stones = Vec::new();
    let mut warnings: Vec<String> =
        loaded.warnings.iter().chain(&scene.warnings).map(ToString::to_string).collect();
    warnings.extend(space_remarks(args.space, &targets));
    warnings.iter().for_each(|warning| console.warn(warning));

    output::check_memory(&scene)?;
    let mut film = Film::try_new(&scene)?;
    if !shard.is_whole() {
        Bands::new(shard, scene.height)?.reserve(&mut film, scene.most_samples())?;
    }
    let mut session = Session::new(candidates, args.rendering.open_options());
    let mut onlooker = Onlooker::new(console, 1, args.rendering.backend == registry::AUTO);
    let rendered = session.fill(&scene, &mut film, &mut onlooker);
    warnings.append(&mut onlooker.warnings);
    // A part is whole or nothing; of a picture that is broken off something can be shown.
    if !rendered.traced.finished && (!shard.is_whole() || !has_samples(&film)) {
        return Err(rendered.failure.unwrap_or(Error::Interrupted));
    }
    let options = Options { space: args.space, depth: args.bits, exposure: args.exposure, tone: args.tone };
    let picture = rendered.picture(film, &scene, &loaded, options);
    let written = write(shard, &targets, &picture, &rendered);
    let outcome = Outcome { scene, rendered, written, warnings, elapsed: start.elapsed() };
    Ok(outcome.report())
}

/// The files that were asked for; by default the scene's name with both extensions.
fn targets(args: &Args) -> Result<Vec<Target>, Error> {
    let stem = args.scene.file_stem().unwrap_or_default().to_string_lossy();
    let paths = match args.output.as_slice() {
        [] => vec![PathBuf::from(format!("{stem}.png")), PathBuf::from(format!("{stem}.exr"))],
        paths => paths.to_vec(),
    };
    paths.into_iter().map(Target::new).collect()
}

/// Makes sure that every file can be written and that none of them is an input, and clears away what earlier runs that
/// were killed left of them.
fn guard(args: &Args, shard: Shard, targets: &[Target], loaded: &LoadedScene) -> Result<(), Error> {
    let inputs = || loaded.files.iter().map(|file| file.path.as_path()).chain([args.scene.as_path()]);
    let asked: Vec<&Path> = targets.iter().map(Target::path).collect();
    output::prepare(&asked, inputs())?;
    let mut others: Vec<PathBuf> = targets.iter().map(|target| target.partial().path().to_owned()).collect();
    if !shard.is_whole() {
        others.extend(asked.first().map(|first| part::part_path(first, shard)));
    }
    output::refuse_overlap(others.iter().map(PathBuf::as_path), inputs())?;
    output::remove_leftovers(&others);
    Ok(())
}

fn load(args: &Args) -> Result<LoadedScene, Error> {
    let mut loaded = scene_file::load(&args.scene)?;
    args.rendering.overrides().apply(&mut loaded);
    Ok(loaded)
}

/// Prepares a scene; what is wrong with it is the scene file's fault unless the command line changed it.
fn prepare(args: &Args, loaded: &LoadedScene) -> Result<PreparedScene, Error> {
    PreparedScene::new(&loaded.scene, &loaded.settings).map_err(|error| {
        if args.rendering.overrides().is_given() {
            Error::Core(error)
        } else {
            Error::file(&args.scene, error)
        }
    })
}

fn has_samples(film: &Film) -> bool {
    (0..film.height()).any(|y| (0..film.width()).any(|x| film.samples(x, y) > 0))
}

fn write(shard: Shard, targets: &[Target], picture: &Picture, rendered: &Rendered) -> Vec<Written> {
    if !shard.is_whole() {
        let work = Contribution::new(&rendered.devices, &rendered.traced);
        return vec![part::write(shard, targets, picture, work).into()];
    }
    let partials: Vec<Target> = targets.iter().map(Target::partial).collect();
    output::write_all(if rendered.traced.finished { targets } else { &partials }, picture)
}

/// What a person should know who asks for a space that PNG cannot carry.
fn space_remarks(space: RgbSpace, targets: &[Target]) -> impl Iterator<Item = String> {
    let pngs = targets.iter().filter(move |t| t.format() == Format::Png && output::png_space(space) != space);
    pngs.map(move |t| format!("{} is in sRGB: {} is for EXR only", t.path().display(), space.name()))
}
