//! A scene that is built in code: a ruby brilliant in the studio.
//!
//!     cargo run --release -p gemtrace --example built_scene -- ruby.png

use gemtrace::spectral_core::{material::Catalogue, scene::Scene, scene::Stone, shape::ShapeSpec};
use gemtrace::{Error, Session};
use std::path::Path;
use std::sync::Arc;

/// Renders a ruby on the processor.
pub fn render(picture: &Path) -> Result<(), Error> {
    let (mesh, _warnings) = ShapeSpec::by_name("round-brilliant")?.cut()?.solid()?;
    let ruby = Catalogue::builtin().get("ruby")?.clone();
    let mut stone = Stone::new("my ruby", Arc::new(mesh), Arc::new(ruby));
    stone.width = Some(6.5);
    let scene = Scene { width: 96, height: 96, ..Scene::in_studio(vec![stone]) };
    Session::open("cpu")?.render(scene)?.save(picture)?;
    Ok(())
}

fn main() -> Result<(), Error> {
    let picture = std::env::args().nth(1).unwrap_or_else(|| "ruby.png".to_owned());
    render(picture.as_ref())
}
