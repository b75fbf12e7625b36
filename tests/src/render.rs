//! Renders a scene by any backend, and by each algorithm for one convex stone.

use crate::scene::with_speck;
use backend_cpu::{CPU, REFERENCE};
use spectral_core::{
    film::Film,
    prepare::PreparedScene,
    scene::Scene,
    settings::RenderSettings,
    tracer::{Backend, DeviceInfo, OpenOptions, TraceReport, Tracer},
};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;

/// A finished film with its report.
pub struct Picture {
    /// The film.
    pub film: Film,
    /// The sum of the reports of all calls.
    pub report: TraceReport,
}

impl Picture {
    /// Radiance at the first wavelength, pixel by pixel.
    pub fn first_line(&self) -> Vec<f64> {
        self.radiances().into_iter().map(|lines| lines[0]).collect()
    }

    /// Radiance of every pixel, row by row, by wavelength.
    pub fn radiances(&self) -> Vec<Vec<f64>> {
        let radiance = |(x, y)| self.film.radiance(x, y).iter().map(|&v| f64::from(v)).collect();
        pixels(&self.film).map(radiance).collect()
    }

    /// The share of each pixel's samples that meet a stone.
    pub fn coverage(&self) -> Vec<f64> {
        pixels(&self.film).map(|(x, y)| f64::from(self.film.coverage(x, y))).collect()
    }

    /// Colours and radiances as bits.
    pub fn bits(&self) -> Vec<u32> {
        let film = &self.film;
        let numbers = pixels(film).flat_map(|(x, y)| [film.xyz(x, y).to_vec(), film.radiance(x, y)].concat());
        numbers.map(f32::to_bits).collect()
    }
}

/// The places of a film's pixels, row by row.
pub fn pixels(film: &Film) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (width, height) = (film.width(), film.height());
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// An algorithm from a scene of one convex stone to its picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Single precision, the planes of the stone.
    Planes,
    /// Single precision, the hierarchy: with a speck of its own material the stone is not alone.
    Tree,
    /// The double-precision reference.
    Reference,
}

impl Way {
    /// All of them.
    pub const ALL: [Way; 3] = [Way::Planes, Way::Tree, Way::Reference];

    /// Renders a scene.
    pub fn render(self, scene: &Scene, settings: &RenderSettings) -> Picture {
        match self {
            Way::Planes => render(&CPU, scene, settings),
            Way::Tree => render(&CPU, &with_speck(scene), settings),
            Way::Reference => render(&REFERENCE, scene, settings),
        }
    }

    /// The tolerance of the arithmetic: `double` for the reference, `single` for the others.
    pub fn tolerance(self, single: f64, double: f64) -> f64 {
        if self == Way::Reference { double } else { single }
    }
}

/// The prepared scene.
pub fn prepared(scene: &Scene, settings: &RenderSettings) -> Arc<PreparedScene> {
    Arc::new(PreparedScene::new(scene, settings).expect("a valid scene"))
}

/// The first device of a backend, opened for a scene.
pub fn open(backend: &Backend, scene: &Arc<PreparedScene>, options: &OpenOptions) -> Box<dyn Tracer> {
    let device = &(backend.devices)()[0];
    backend.tracer(device, scene.clone(), options).expect("a device that opens")
}

/// Renders all samples of a scene in one call on a backend's first device.
pub fn render(backend: &Backend, scene: &Scene, settings: &RenderSettings) -> Picture {
    let whole = 0..settings.samples;
    render_with(backend, scene, settings, &OpenOptions::default(), &[whole])
}

/// Renders ranges of samples, one call each, on a backend's first device.
pub fn render_with(
    backend: &Backend,
    scene: &Scene,
    settings: &RenderSettings,
    options: &OpenOptions,
    ranges: &[Range<u32>],
) -> Picture {
    let prepared = prepared(scene, settings);
    let mut film = Film::new(&prepared);
    let mut tracer = open(backend, &prepared, options);
    let mut report = TraceReport::default();
    for range in ranges {
        let part = trace(tracer.as_mut(), range.clone(), &mut film);
        assert!(part.finished);
        report += part;
    }
    Picture { film, report }
}

/// Adds samples to a film.
pub fn trace(tracer: &mut dyn Tracer, samples: Range<u32>, film: &mut Film) -> TraceReport {
    tracer.trace(samples, film, &mut |_| ControlFlow::Continue(())).expect("a device that works")
}

/// Renders all samples of a scene on a device.
///
/// # Errors
/// What the scene or the device fails with.
pub fn render_on(
    backend: &Backend,
    device: &DeviceInfo,
    scene: &Scene,
    settings: &RenderSettings,
) -> Result<Picture, Box<dyn std::error::Error>> {
    let prepared = Arc::new(PreparedScene::new(scene, settings)?);
    let mut film = Film::new(&prepared);
    let mut tracer = backend.tracer(device, prepared, &OpenOptions::default())?;
    let report = tracer.trace(0..settings.samples, &mut film, &mut |_| ControlFlow::Continue(()))?;
    Ok(Picture { film, report })
}
