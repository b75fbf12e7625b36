//! A scene file in, a picture out.
//!
//!     cargo run --release -p gemtrace --example scene_file -- scenes/brilliant.toml brilliant.png

use gemtrace::{Error, Session};
use std::path::Path;

/// Renders a scene file on the best device of this machine.
pub fn render(scene: &Path, picture: &Path) -> Result<(), Error> {
    let mut session = Session::open("auto")?;
    let scene = session.load(scene)?;
    session.render(scene)?.save(picture)?;
    Ok(())
}

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, scene, picture] = arguments.as_slice() else {
        return Err(Error::Usage("give a scene file and the name of a picture, .png or .exr".to_owned()));
    };
    render(scene.as_ref(), picture.as_ref())
}
