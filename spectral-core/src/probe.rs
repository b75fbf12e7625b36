//! A test of a device: two pictures of 8 × 8 pixels with known colours.
//!
//! A driver may compile the kernel wrongly, or a device may return wrong results; nobody would notice in a new picture. The
//! scenes use all parts of a backend: facet planes, its own intersection, nested media, dispersion, polarisation, absorption
//! and the light.

use crate::{
    Error,
    camera::{Camera, Projection},
    environment::{Environment, LatLong},
    film::Film,
    material::MaterialSpec,
    prepare::PreparedScene,
    scene::{Background, Scene, Stone},
    settings::{Area, Coverage, Leftover, RenderSettings},
    shape::ShapeSpec,
    spectrum::columns,
    tracer::{Backend, DeviceInfo, OpenOptions},
    wavelength::WavelengthGrid,
};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Edge of a picture, pixels.
pub const SIZE: u32 = 8;
/// The relative difference above which a pixel is wrong.
const TOLERANCE: f32 = 1e-3;
/// Number of pixels that may be wrong: correct devices may take different sides at the edge of a facet.
const STRAY: usize = 3;

/// The materials of the probe: its own, so that the expected colours do not change with the catalogue.
const SAPPHIRE: &str = "
    sellmeier = { b = [1.4313493, 0.65054713, 5.3414021], c = [0.005279926102, 0.014238264706, 325.017834119001] }
    absorption = [
        { centre = 419.21, fwhm_cm1 = 6424.5, peak = 0.088632 },
        { centre = 591.05, fwhm_cm1 = 5755.1, peak = 0.553146 },
    ]
";
const EMERALD: &str = "
    cauchy = [1.570664, 0.004284]
    absorption = [
        { centre = 414.55, fwhm_cm1 = 3563.4, peak = 0.483615 },
        { centre = 446.37, fwhm_cm1 = 2721.5, peak = 0.517401 },
        { centre = 532.7, fwhm_cm1 = 1463.1, peak = 0.040938 },
        { centre = 605.71, fwhm_cm1 = 2467.1, peak = 0.709164 },
        { centre = 476.0, fwhm_cm1 = 300.0, peak = 0.1125 },
        { centre = 683.5, fwhm_cm1 = 20.0, peak = 0.6 },
    ]
";
const DIAMOND: &str = "like = 'diamond'";

/// A scene and its colours.
#[derive(Debug, Clone)]
pub struct Subject {
    /// A description.
    pub name: &'static str,
    /// The scene.
    pub scene: Arc<PreparedScene>,
    /// CIE XYZ of every pixel, row by row, by the double-precision reference.
    pub expected: Vec<[f32; 3]>,
}

/// The scenes of the probe.
///
/// # Errors
/// None in practice; those of built-in shapes and materials.
pub fn subjects() -> Result<[Subject; 2], Error> {
    let alone = vec![stone("step", SAPPHIRE, 6.5)?];
    let mut inclusion = stone("step", DIAMOND, 1.6)?;
    (inclusion.position, inclusion.rotation) = ([0.4, -0.3, -0.4].into(), [25.0, 10.0, 30.0].into());
    let nested = vec![stone("step", EMERALD, 6.5)?, inclusion];
    Ok([
        subject("a stone alone", alone, include_str!("../data/probe/alone.csv"))?,
        subject("a stone within another", nested, include_str!("../data/probe/nested.csv"))?,
    ])
}

fn subject(name: &'static str, stones: Vec<Stone>, expected: &str) -> Result<Subject, Error> {
    let rows = columns(expected, name)?;
    let expected = rows.into_iter().map(|(_, xyz)| xyz.map(|v: f64| v as f32)).collect();
    let scene = Arc::new(PreparedScene::new(&scene(stones), &settings()?)?);
    Ok(Subject { name, scene, expected })
}

/// Renders the scenes on a device and compares the colours.
///
/// # Errors
/// [`Error::Device`] if the device fails or its colours are wrong, with the expected and the actual colour.
pub fn probe(backend: &Backend, device: &DeviceInfo, options: &OpenOptions) -> Result<(), Error> {
    let mut open = (backend.open)(device, options)?;
    for subject in subjects()? {
        let mut film = Film::new(&subject.scene);
        let mut tracer = open.load(subject.scene.clone())?;
        let samples = 0..subject.scene.settings.samples;
        tracer.trace(samples, &mut film, &mut |_| ControlFlow::Continue(()))?;
        subject.check(&film).map_err(|message| Error::Device { device: device.name.clone(), message })?;
    }
    Ok(())
}

impl Subject {
    /// Checks the colours of a picture.
    ///
    /// # Errors
    /// A description of the difference.
    pub fn check(&self, film: &Film) -> Result<(), String> {
        let pixels = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y)));
        let wrong: Vec<_> = pixels
            .map(|(x, y)| (x, y, film.xyz(x, y), self.expected[(y * SIZE + x) as usize]))
            .filter(|(_, _, found, expected)| !alike(found, expected))
            .collect();
        match wrong.as_slice() {
            [(x, y, found, expected), ..] if wrong.len() > STRAY => Err(format!(
                "the probe, {}, comes out wrong in {} of {} pixels: pixel ({x}, {y}) should have XYZ {expected:?} \
                 and has {found:?}",
                self.name,
                wrong.len(),
                SIZE * SIZE
            )),
            _ => Ok(()),
        }
    }
}

/// False if anything is infinite or NaN.
fn alike(found: &[f32; 3], expected: &[f32; 3]) -> bool {
    let scale = expected.iter().fold(0.0, |a: f32, b| a.max(b.abs()));
    found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= TOLERANCE * scale)
}

fn stone(shape: &str, material: &str, width: f64) -> Result<Stone, Error> {
    let (mesh, _) = ShapeSpec::by_name(shape)?.cut()?.solid()?;
    let spec: MaterialSpec = toml::from_str(material).map_err(|e| {
        let (what, message) = ("the probe".to_owned(), e.to_string());
        Error::Data { what, line: 0, message }
    })?;
    let no_files = |file: &str| Err(Error::value("absorption", file, "the probe's materials stand alone"));
    let (material, _) = spec.build("probe", no_files)?;
    Ok(Stone { width: Some(width), ..Stone::new(shape, Arc::new(mesh), Arc::new(material)) })
}

fn scene(stones: Vec<Stone>) -> Scene {
    let camera = Camera {
        position: [3.0, -11.0, 28.0].into(),
        look_at: [0.0; 3].into(),
        up: [0.0, 0.0, 1.0].into(),
        projection: Projection::Perspective { fov: 14.0 },
    };
    let environment = Environment { rotation: 25.0, ..Environment::image(LatLong::studio()) };
    Scene { camera, width: SIZE, height: SIZE, background: Background::Environment, environment, stones }
}

fn settings() -> Result<RenderSettings, Error> {
    Ok(RenderSettings {
        coverage: Coverage::Points,
        area: Area { offsets: 1, tolerance: 0.0, split: 0.0 },
        samples: 1,
        tolerance: 0.0,
        wavelengths: WavelengthGrid::list(vec![460.0, 550.0, 640.0])?,
        jitter: false,
        max_depth: 16,
        leftover: Leftover::Exit,
        threshold: 1e-2,
        split: 0.0,
        polarized: true,
        spectral: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PixelSample, TileSums};

    fn film(subject: &Subject, change: impl Fn(usize, [f32; 3]) -> [f32; 3]) -> Film {
        let mut film = Film::new(&subject.scene);
        let sample = |(i, &xyz): (usize, &[f32; 3])| PixelSample { xyz: change(i, xyz), coverage: 1.0 };
        let samples = subject.expected.iter().enumerate().map(sample).collect();
        film.add(&TileSums { tile: film.tile(), samples, radiance: Vec::new() })
            .expect("the film's own tile");
        film
    }

    #[test]
    fn wrong_colours_are_distinguished_from_rounding_and_edges() {
        for subject in subjects().expect("valid scenes") {
            let check = |change: &dyn Fn(usize, [f32; 3]) -> [f32; 3]| subject.check(&film(&subject, change));
            assert_eq!(check(&|_, xyz| xyz.map(|v| v * 1.0005)), Ok(()));
            assert_eq!(check(&|i, xyz| if i % 30 == 0 { [9.0; 3] } else { xyz }), Ok(()));
            let message = check(&|_, xyz| xyz.map(|v| v * 1.01)).expect_err("wrong");
            assert!(
                message.contains("wrong in 64 of 64 pixels: pixel (0, 0) should have XYZ ["),
                "{message}"
            );
            for bad in [0.0, f32::NAN, f32::INFINITY] {
                assert!(check(&|_, _| [bad; 3]).is_err());
            }
        }
    }

    #[test]
    fn the_scenes_use_planes_and_a_hierarchy() {
        let [alone, nested] = subjects().expect("valid scenes");
        assert!(alone.scene.lone_convex_stone().is_some() && nested.scene.lone_convex_stone().is_none());
    }
}
