//! One's own progress: percent on the standard error, and an end after a minute.
//!
//!     cargo run --release -p gemtrace --example progress -- scenes/brilliant.toml brilliant.png

use gemtrace::spectral_core::tracer::Progress;
use gemtrace::{Error, Session};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

/// Renders a scene file within a minute, or not at all.
pub fn render(scene: &Path, picture: &Path) -> Result<(), Error> {
    let mut session = Session::open("auto")?;
    let scene = session.load(scene)?;
    let start = Instant::now();
    let mut watch = |progress: Progress| {
        eprint!("\r{} %", 100 * progress.done / progress.total.max(1));
        let late = start.elapsed() > Duration::from_secs(60);
        if late { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    session.render_watched(scene, &mut watch)?.save(picture)?;
    Ok(())
}

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, scene, picture] = arguments.as_slice() else {
        return Err(Error::Usage("give a scene file and the name of a picture, .png or .exr".to_owned()));
    };
    render(scene.as_ref(), picture.as_ref())
}
