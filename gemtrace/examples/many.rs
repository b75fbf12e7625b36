//! Many small pictures from one session, or one each, for a measure of what surrounds a render:
//!
//!     cargo run --release -p gemtrace --example many -- scenes/brilliant.toml same 100
//!
//! `same` renders one scene again and again, `turned` turns it about +z, `fresh` does so with a session for each. Pictures are
//! drafts of 64 × 64 pixels on one thread.

use gemtrace::scene_file::{Draft, Override};
use gemtrace::sequence::Motion;
use gemtrace::{Error, Session, registry};
use spectral_core::settings::Quality;
use spectral_core::tracer::OpenOptions;
use std::path::Path;

fn session() -> Result<Session, Error> {
    let options = OpenOptions { threads: Some(1), ..OpenOptions::default() };
    Ok(Session::new(registry::choose("cpu", None)?, options))
}

/// Renders `count` pictures; the sum of their first pixels, which other programs must agree with.
pub fn render(scene: &Path, mode: &str, count: u32) -> Result<f64, Error> {
    let draft = Draft::read(scene)?;
    let change = Override { size: Some([64, 64]), quality: Some(Quality::Draft), ..Override::default() };
    let mut open = session()?;
    let mut same = draft.load(&mut open.assets)?;
    change.apply(&mut same);
    let mut sum = 0.0;
    for frame in 0..count {
        let loaded = match mode {
            "same" => same.clone(),
            _ => {
                if mode == "fresh" {
                    open = session()?;
                }
                let mut loaded = Motion::Turntable.frame(&draft, frame, count).load(&mut open.assets)?;
                change.apply(&mut loaded);
                loaded
            }
        };
        sum += f64::from(open.render(loaded)?.film.xyz(0, 0)[1]);
    }
    Ok(sum)
}

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().collect();
    let usage = || Error::Usage("give a scene file, 'same', 'turned' or 'fresh', and a number".to_owned());
    let [_, scene, mode, count] = arguments.as_slice() else { return Err(usage()) };
    let count = count.parse().map_err(|_| usage())?;
    println!("{}", render(scene.as_ref(), mode, count)?);
    Ok(())
}
