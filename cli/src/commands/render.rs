//! `gemtrace render`.

mod outcome;

use super::{Console, Report};
use crate::arguments::{Rendering, parse_stops};
use crate::progress::Bar;
use gemtrace::Error;
use gemtrace::batch::{Portion, Shard};
use gemtrace::output::part::Work;
use gemtrace::output::{self, Depth, Format, Picture, Provenance, Target, Written};
use gemtrace::registry::{self, Candidates, Choice};
use gemtrace::rendering::{self, Rendered, Watch};
use gemtrace::scene_file::{self, LoadedScene};
use gemtrace::share::{self, Share};
use outcome::Outcome;
use spectral_core::color::RgbSpace;
use spectral_core::film::Film;
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Background;
use spectral_core::tracer::{Backend, Progress};
use std::ops::ControlFlow;
use std::path::PathBuf;
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
    /// Colour space of the EXR, and of the PNG up to Rec. 2020: srgb, p3, rec2020, acescg or xyz.
    #[arg(long, value_name = "SPACE", default_value = "srgb", value_parser = parse_space)]
    pub space: RgbSpace,
    /// Brighten the PNG by this many stops; the EXR keeps the scene's own values.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_stops)]
    pub exposure: f64,
    /// Render the i-th of n shares of the picture's rows into NAME.part-I-of-N.exr, for 'gemtrace merge' to join; auto:
    /// the share that Slurm or Kubernetes says.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Portion>,
    /// Bits a channel of the PNG: 8 or 16.
    #[arg(long, value_name = "N", default_value = "8", value_parser = parse_depth)]
    pub bits: Depth,
}

/// Renders a scene and writes its picture.
///
/// Whatever can be refused is refused before the first ray: the backend's name, the outputs, the scene.
///
/// # Errors
/// [`Error`] of the scene, the outputs or the device; [`Error::Interrupted`] if nothing was finished. A
/// picture that could not be written, or is partial, is told in the report's `failure`.
pub fn run(args: &Args, console: &mut Console) -> Result<Report, Error> {
    run_among(registry::backends(), args, console)
}

/// The same with other backends than this program's.
///
/// # Errors
/// As [`run`].
pub fn run_among(backends: &[Backend], args: &Args, console: &mut Console) -> Result<Report, Error> {
    let start = Instant::now();
    let shard = args.shard.map_or(Ok(Shard::WHOLE), Portion::resolve)?;
    let targets = targets(args)?;
    registry::known(backends, &args.rendering.backend)?;
    let mut loaded = load(args)?;
    targets.iter().try_for_each(Target::check)?;
    let scene = Arc::new(prepare(args, &loaded)?);
    let candidates = registry::choose_for(&scene, backends, &args.rendering.backend, args.rendering.device)?;
    // Prepared, it is not needed any more, and meshes are large.
    loaded.scene.stones = Vec::new();
    let mut warnings: Vec<String> =
        loaded.warnings.iter().chain(&scene.warnings).map(ToString::to_string).collect();
    warnings.extend(space_remarks(args.space, &targets));
    warnings.iter().for_each(|warning| console.warn(warning));

    let mut film = Film::new(&scene);
    if !shard.is_whole() {
        Share::new(shard, scene.height)?.reserve(&mut film, scene.settings.samples)?;
    }
    let rendered = trace(args, candidates, &scene, &mut film, console, &mut warnings);
    // A share is whole or nothing; of a picture that is broken off something can be shown.
    if !rendered.traced.finished && (!shard.is_whole() || !has_samples(&film)) {
        return Err(rendered.failure.unwrap_or(Error::Interrupted));
    }
    let written = write(args, shard, &targets, &film, &scene, &loaded, &rendered);
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
    for (i, path) in paths.iter().enumerate() {
        if let Some(first) = paths[..i].iter().position(|earlier| earlier == path) {
            let message = format!("output {} is output {} again: {}", i + 1, first + 1, path.display());
            return Err(Error::Usage(message));
        }
    }
    paths.into_iter().map(Target::new).collect()
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

/// Someone at a console, who sees warnings and a bar and may press Ctrl-C.
struct Onlooker<'a, 'b> {
    console: &'a mut Console<'b>,
    bar: Bar,
    warnings: &'a mut Vec<String>,
    /// Whether the program was to choose the device.
    auto: bool,
}

impl Watch for Onlooker<'_, '_> {
    fn chosen(&mut self, choice: &Choice) {
        if self.auto {
            self.console.say(&choice.reason);
        }
    }

    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        self.console.interrupt.heed();
        self.bar.set_total(progress.total);
        self.bar.set(progress.done);
        if self.console.interrupt.is_requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn warning(&mut self, message: &str) {
        self.console.warn(message);
        self.warnings.push(message.to_owned());
    }
}

fn trace(
    args: &Args,
    candidates: Candidates,
    scene: &Arc<PreparedScene>,
    film: &mut Film,
    console: &mut Console,
    warnings: &mut Vec<String>,
) -> Rendered {
    let total = u64::from(scene.width) * u64::from(scene.height) * u64::from(scene.settings.samples);
    let bar = Bar::new(total, console.quiet);
    let auto = args.rendering.backend == registry::AUTO;
    rendering::render(
        candidates,
        scene,
        film,
        &args.rendering.options(),
        &mut Onlooker { console, bar, warnings, auto },
    )
}

fn has_samples(film: &Film) -> bool {
    (0..film.height()).any(|y| (0..film.width()).any(|x| film.samples(x, y) > 0))
}

fn write(
    args: &Args,
    shard: Shard,
    targets: &[Target],
    film: &Film,
    scene: &PreparedScene,
    loaded: &LoadedScene,
    rendered: &Rendered,
) -> Vec<Written> {
    let partial = !rendered.traced.finished;
    let name = args.scene.file_name().unwrap_or_default().to_string_lossy();
    let provenance =
        Provenance::new(&name, &loaded.hash, scene, &rendered.devices, &rendered.traced, partial)
            .with("space", args.space.name().into())
            .with("exposure", args.exposure.into());
    let picture = Picture {
        film,
        space: args.space,
        depth: args.bits,
        exposure: args.exposure,
        transparent: scene.background == Background::Transparent,
        backdrop: loaded.backdrop,
        wavelengths: scene.settings.wavelengths.nm(),
        provenance: &provenance,
    };
    if !shard.is_whole() {
        let work = Work::new(&rendered.devices, &rendered.traced);
        return vec![share::write(shard, targets, &picture, work).into()];
    }
    let partials: Vec<Target> = targets.iter().map(Target::partial).collect();
    output::write_all(if partial { &partials } else { targets }, &picture)
}

/// What a person should know who asks for a space that PNG cannot carry.
fn space_remarks(space: RgbSpace, targets: &[Target]) -> impl Iterator<Item = String> {
    let pngs = targets.iter().filter(move |t| t.format() == Format::Png && output::png_space(space) != space);
    pngs.map(move |t| format!("{} is in sRGB: {} is for EXR only", t.path().display(), space.name()))
}

fn parse_space(name: &str) -> Result<RgbSpace, String> {
    RgbSpace::by_name(name).map_err(|e| e.to_string())
}

fn parse_depth(text: &str) -> Result<Depth, String> {
    match text {
        "8" => Ok(Depth::Eight),
        "16" => Ok(Depth::Sixteen),
        _ => Err("a PNG has 8 or 16 bits a channel".to_owned()),
    }
}
