use glam::DVec3;
use spectral_core::*;
use std::{ops::ControlFlow, sync::Arc};
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    f[11].parse::<f64>().unwrap() / 100.0
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let size: u32 = args.get(1).map_or(256, |a| a.parse().unwrap());
    let waves: usize = args.get(2).map_or(32, |a| a.parse().unwrap());
    let samples: u32 = args.get(3).map_or(1, |a| a.parse().unwrap());
    let threads: usize = args.get(4).map_or(1, |a| a.parse().unwrap());
    let only = args.get(5).cloned().unwrap_or_default();
    let (mesh, _) = shape::ShapeSpec::by_name("round-brilliant").unwrap().cut().unwrap().solid().unwrap();
    let material = material::Catalogue::builtin().get("diamond").unwrap().clone();
    for polarized in [false, true] {
        let mut env = environment::Environment::image(environment::LatLong::studio());
        env.rotation = 10.0;
        let scene = scene::Scene {
            camera: camera::Camera { position: DVec3::new(1.0, -6.0, 20.0), look_at: DVec3::ZERO, up: DVec3::Y, projection: camera::Projection::Perspective { fov: 20.0 } },
            width: size, height: size, background: scene::Background::Transparent, environment: env,
            stones: vec![scene::Stone { width: Some(6.5), ..scene::Stone::new("s", Arc::new(mesh.clone()), material.clone().into()) }],
        };
        let settings = settings::RenderSettings { wavelengths: wavelength::WavelengthGrid::midpoints([400.0, 700.0], waves).unwrap(), samples, polarized, max_depth: 16, ..Default::default() };
        let prepared = Arc::new(prepare::PreparedScene::new(&scene, &settings).unwrap());
        let mut base = 0.0;
        for round in 0..4 { for set in backend_cpu::Instructions::ALL {
            if !only.is_empty() && set.name() != only { continue; }
            let backend = set.backend();
            let options = tracer::OpenOptions { threads: Some(threads), ..Default::default() };
            let mut t = (backend.open)(&(backend.devices)()[0], prepared.clone(), &options).unwrap();
            let mut film = film::Film::new(&prepared);
            let c0 = cpu();
            let r = t.trace(0..samples, &mut film, &mut |_| ControlFlow::Continue(())).unwrap();
            let rate = r.rays as f64 / (cpu() - c0) / 1e6;
            if base == 0.0 { base = rate; }
            println!("round {round} polarized {polarized} {:9} {rate:8.1} M rays/s  {} rays, {:?} dropped {:.2e}", set.name(), r.rays, r.trace, r.energy.dropped_share());
        } }
    }
}
