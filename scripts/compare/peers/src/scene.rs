//! The scene of all renderers: a diamond brilliant, 6.5 mm wide, in the built-in studio.

use crate::Failure;
use backend_cpu::Instructions;
use spectral_core::{
    camera::{Camera, Projection},
    environment::{Environment, LatLong},
    material::Catalogue,
    prepare::PreparedScene,
    scene::{Background, Scene, Stone},
    settings::RenderSettings,
    shape::ShapeSpec,
    wavelength::WavelengthGrid,
};
use std::sync::Arc;

/// Edge of the square picture, pixels.
pub const SIZE: u32 = 256;

/// Angle across the picture, degrees.
pub const FOV: f64 = 14.0;

/// The studio, or a grey version of it: then one monochrome map is enough for every wavelength.
#[derive(Clone, Copy, PartialEq)]
pub enum Studio {
    Coloured,
    Grey,
}

/// The eye, above the table and to the front.
pub fn camera() -> Camera {
    Camera {
        position: [0.0, -11.115_654_657, 30.052_511_014].into(),
        look_at: [0.0, 0.0, -0.4875].into(),
        up: [0.0, 0.0, 1.0].into(),
        projection: Projection::Perspective { fov: FOV },
    }
}

/// The light's texels.
pub fn studio(kind: Studio) -> Result<LatLong, Failure> {
    let studio = LatLong::studio();
    if kind == Studio::Coloured {
        return Ok(studio);
    }
    let grey = studio.texels().iter().map(|[r, g, b]| [(r + g + b) / 3.0; 3]).collect();
    Ok(LatLong::new(studio.width(), studio.height(), grey)?.0)
}

/// The scene with the given settings.
pub fn prepared(kind: Studio, settings: &RenderSettings) -> Result<Arc<PreparedScene>, Failure> {
    let (mesh, _) = ShapeSpec::by_name("round-brilliant")?.cut()?.solid()?;
    let diamond = Catalogue::builtin().get("diamond")?.clone();
    let stone = Stone { width: Some(6.5), ..Stone::new("diamond", Arc::new(mesh), Arc::new(diamond)) };
    let scene = Scene {
        camera: camera(),
        width: SIZE,
        height: SIZE,
        background: Background::Transparent,
        environment: Environment::image(studio(kind)?),
        stones: vec![stone],
    };
    Ok(Arc::new(PreparedScene::new(&scene, settings)?))
}

/// 32 wavelengths at each pixel's centre, at most 16 events.
pub fn shallow(mode: &str) -> Result<RenderSettings, Failure> {
    let all = RenderSettings {
        wavelengths: WavelengthGrid::default(),
        ..RenderSettings::default().with_samples(1)
    };
    Ok(RenderSettings { max_depth: 16, polarized: polarized(mode)?, ..all })
}

/// Followed to the end.
pub fn deep(mode: &str, samples: u32, wavelengths: usize) -> Result<RenderSettings, Failure> {
    let wavelengths = WavelengthGrid::midpoints(WavelengthGrid::default().range(), wavelengths)?;
    let polarized = polarized(mode)?;
    Ok(RenderSettings { wavelengths, polarized, ..RenderSettings::default().with_samples(samples) })
}

fn polarized(mode: &str) -> Result<bool, Failure> {
    match mode {
        "polarized" => Ok(true),
        "scalar" => Ok(false),
        _ => Err(format!("mode {mode}: polarized or scalar").into()),
    }
}

/// The instruction set of a name.
pub fn instructions(name: &str) -> Result<Instructions, Failure> {
    let set = match name {
        "best" => Instructions::best(),
        "avx512" => Instructions::Avx512,
        "avx2" => Instructions::Avx2,
        "portable" => Instructions::Portable,
        _ => return Err(format!("instruction set {name}: best, avx512, avx2 or portable").into()),
    };
    if set.available() { Ok(set) } else { Err(format!("this machine has no {}", set.name()).into()) }
}
