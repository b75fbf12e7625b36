//! gemtrace's own pictures.

use crate::{
    Failure,
    scene::{self, Studio},
    store,
};
use backend_cpu::Instructions;
use cpu_time::ProcessTime;
use serde_json::{Value, json};
use spectral_core::{film::Film, prepare::PreparedScene, settings::RenderSettings, tracer::OpenOptions};
use std::{ops::ControlFlow, path::Path, sync::Arc, time::Instant};

/// Pictures of one measurement, since a single one is too short to be timed accurately.
const REPEATS: u32 = 8;

struct Rendered {
    film: Film,
    cpu: f64,
    wall: f64,
}

/// Renders on the processor; the time does not include tables and planes.
fn rendered(
    scene: &Arc<PreparedScene>,
    instructions: Instructions,
    threads: usize,
) -> Result<Rendered, Failure> {
    let backend = backend_cpu::cpu_in(instructions);
    let options = OpenOptions { threads: Some(threads), ..OpenOptions::default() };
    let mut tracer = backend.tracer(&(backend.devices)()[0], scene.clone(), &options)?;
    let mut film = Film::new(scene);
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    tracer.trace(0..scene.settings.samples, &mut film, &mut |_| ControlFlow::Continue(()))?;
    Ok(Rendered { film, cpu: cpu.elapsed().as_secs_f64(), wall: wall.elapsed().as_secs_f64() })
}

/// The picture of the first line of the table, several times: seconds a picture.
pub fn render(instructions: Instructions, mode: &str, threads: usize) -> Result<Value, Failure> {
    let scene = scene::prepared(Studio::Coloured, &scene::shallow(mode)?)?;
    let (mut cpu, mut wall, mut mean) = (0.0, 0.0, 0.0);
    for _ in 0..REPEATS {
        let picture = rendered(&scene, instructions, threads)?;
        cpu += picture.cpu / f64::from(REPEATS);
        wall += picture.wall / f64::from(REPEATS);
        mean = self::mean(&picture.film);
    }
    Ok(json!({ "cpu": cpu, "wall": wall, "mean": mean }))
}

/// The mean luminance of the pixels that see the stone.
fn mean(film: &Film) -> f64 {
    let (mut sum, mut covered) = (0.0, 0.0);
    for y in 0..film.height() {
        for x in 0..film.width() {
            sum += f64::from(film.xyz(x, y)[1]);
            covered += f64::from(film.coverage(x, y));
        }
    }
    sum / covered
}

/// A picture in the grey studio as floats, X, Y, Z and coverage of each pixel.
pub fn picture(settings: &RenderSettings, file: &Path) -> Result<Value, Failure> {
    let scene = scene::prepared(Studio::Grey, settings)?;
    let Rendered { film, cpu, .. } = rendered(&scene, Instructions::best(), 1)?;
    let mut pixels = Vec::new();
    for y in 0..film.height() {
        for x in 0..film.width() {
            pixels.extend(film.xyz(x, y));
            pixels.push(film.coverage(x, y));
        }
    }
    store::write_numbers(file, &pixels)?;
    Ok(json!({ "cpu": cpu, "mean": mean(&film) }))
}

/// The scene for renderers that are not in Rust: `stone.ply`, `studio.f32` and, as the result, the rest.
pub fn describe(folder: &Path) -> Result<Value, Failure> {
    let scene = scene::prepared(Studio::Grey, &scene::deep("scalar", 1, 32)?)?;
    store::write_ply(&folder.join("stone.ply"), &scene)?;
    let studio = scene::studio(Studio::Grey)?;
    store::write_numbers(&folder.join("studio.f32"), studio.texels().as_flattened())?;
    let (camera, table) = (scene::camera(), scene.table(0));
    let white: Vec<f64> = table.basis.iter().map(|bases| bases[0]).collect();
    Ok(json!({
        "size": scene::SIZE,
        "fov": scene::FOV,
        "position": (camera.position - scene.geometry.origin).to_array(),
        "look_at": (camera.look_at - scene.geometry.origin).to_array(),
        "studio": [studio.width(), studio.height()],
        "wavelengths": table.wavelengths,
        "index": table.media[0].iter().map(|medium| medium.n).collect::<Vec<_>>(),
        "response": table.response,
        "white": white,
    }))
}
