//! A picture from within a program: a ruby brilliant in the built-in studio, printed as characters.

use spectral_core::camera::{Camera, Projection};
use spectral_core::environment::{Environment, LatLong};
use spectral_core::scene::{Background, Scene, Stone};
use spectral_core::shape::ShapeSpec;
use spectral_core::tracer::OpenOptions;
use spectral_core::{film::Film, material::Catalogue, prepare::PreparedScene, settings::RenderSettings};
use std::{ops::ControlFlow, sync::Arc};

fn main() -> Result<(), spectral_core::Error> {
    let cut = ShapeSpec::by_name("round-brilliant")?.cut()?;
    let (mesh, _) = cut.solid()?;
    let ruby = Catalogue::builtin().get("ruby")?.clone();
    let stone = Stone { width: Some(6.5), ..Stone::new("ruby", Arc::new(mesh), Arc::new(ruby)) };
    let camera = Camera {
        position: [0.0, -12.0, 30.0].into(),
        look_at: [0.0, 0.0, -0.5].into(),
        up: [0.0, 0.0, 1.0].into(),
        projection: Projection::Perspective { fov: 13.0 },
    };
    let environment = Environment::image(LatLong::studio());
    let background = Background::Transparent;
    let scene = Scene { camera, width: 72, height: 36, background, environment, stones: vec![stone] };
    let prepared = Arc::new(PreparedScene::new(&scene, &RenderSettings::default().with_samples(4))?);
    let cpu = backend_cpu::CPU;
    let mut tracer = cpu.tracer(&(cpu.devices)()[0], prepared.clone(), &OpenOptions::default())?;
    let mut film = Film::new(&prepared);
    let report = tracer.trace(0..prepared.settings.samples, &mut film, &mut |_| ControlFlow::Continue(()))?;
    for y in 0..film.height() {
        let shade = |x| b" .:-=+*#%@"[(film.xyz(x, y)[1].sqrt() * 9.0).min(9.0) as usize] as char;
        println!("{}", (0..film.width()).map(shade).collect::<String>());
    }
    println!("{} rays, {:.5} % of the energy dropped", report.rays, 100.0 * report.energy.dropped_share());
    Ok(())
}
