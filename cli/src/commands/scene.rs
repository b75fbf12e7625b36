//! `gemtrace scene`.

use crate::console::Report;
use gemtrace::scene_file::sketch;
use gemtrace::{Error, output};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `scene`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The mesh file: .glb, .gltf, .obj, .stl or .ply.
    pub mesh: PathBuf,
    /// Write the scene here (TOML); without it, it is printed.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Writes a scene to start from.
///
/// # Errors
/// [`Error::File`] for a file that cannot be read, [`Error::Output`] for the scene.
pub fn run(args: &Args) -> Result<Report, Error> {
    let name = named_from(&args.mesh, args.output.as_deref());
    let text = sketch(&args.mesh, &name)?;
    let json = json!({ "mesh": args.mesh, "scene": text, "output": args.output });
    let Some(path) = &args.output else { return Ok(Report { text, json, failure: None }) };
    output::prepare(&[path.as_path()], [args.mesh.as_path()])?;
    output::write_text(path, &text)?;
    Ok(Report { text: format!("wrote {}", path.display()), json, failure: None })
}

/// How a scene calls the mesh: its plain name in the scene's own folder, else the whole path.
fn named_from(mesh: &Path, scene: Option<&Path>) -> String {
    let folder = |path: &Path| {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        parent.unwrap_or(Path::new(".")).canonicalize().ok()
    };
    let beside = scene.is_none_or(|scene| folder(scene) == folder(mesh));
    let whole = || mesh.canonicalize().ok().map(PathBuf::into_os_string);
    let name = if beside { mesh.file_name().map(Into::into) } else { whole() };
    name.unwrap_or_else(|| mesh.as_os_str().to_owned()).to_string_lossy().into_owned()
}
