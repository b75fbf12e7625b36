//! Renders a scene by any of the ways through the code.

use crate::scene::with_speck;
use backend_cpu::{CPU, REFERENCE};
use spectral_core::{
    film::Film,
    prepare::PreparedScene,
    scene::Scene,
    settings::RenderSettings,
    tracer::{Backend, OpenOptions, TraceReport},
};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;

/// A finished film and what was reported of it.
pub struct Picture {
    /// The film.
    pub film: Film,
    /// The reports of all calls, joined.
    pub report: TraceReport,
}

impl Picture {
    /// Radiance at the first wavelength, pixel by pixel.
    pub fn first_line(&self) -> Vec<f64> {
        self.radiances().into_iter().map(|lines| lines[0]).collect()
    }

    /// Radiance of every pixel, row by row, by wavelength.
    pub fn radiances(&self) -> Vec<Vec<f64>> {
        self.pixels().map(|(x, y)| self.film.radiance(x, y).iter().map(|&v| f64::from(v)).collect()).collect()
    }

    /// The share of each pixel's samples that meet a stone.
    pub fn coverage(&self) -> Vec<f64> {
        self.pixels().map(|(x, y)| f64::from(self.film.coverage(x, y))).collect()
    }

    fn pixels(&self) -> impl Iterator<Item = (u32, u32)> {
        let (width, height) = (self.film.width(), self.film.height());
        (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
    }
}

/// A way from a scene of one convex stone to its picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Single precision, the stone's planes.
    Planes,
    /// Single precision, the hierarchy: a speck of the stone's own material rules the planes out.
    Tree,
    /// The double-precision oracle.
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

    /// `double` for the oracle, `single` for the others: the tolerance of their arithmetic.
    pub fn tolerance(self, single: f64, double: f64) -> f64 {
        if self == Way::Reference { double } else { single }
    }
}

/// Renders all samples of a scene at once.
pub fn render(backend: &Backend, scene: &Scene, settings: &RenderSettings) -> Picture {
    let whole = 0..settings.samples;
    render_with(backend, scene, settings, &OpenOptions::default(), &[whole])
}

/// Renders ranges of samples, one call each.
pub fn render_with(
    backend: &Backend,
    scene: &Scene,
    settings: &RenderSettings,
    options: &OpenOptions,
    ranges: &[Range<u32>],
) -> Picture {
    let prepared = Arc::new(PreparedScene::new(scene, settings).expect("a valid scene"));
    let mut film = Film::new(&prepared);
    let device = &(backend.devices)()[0];
    let mut tracer = backend.tracer(device, prepared, options).expect("a device that opens");
    let mut report = TraceReport::default();
    for range in ranges {
        let part = tracer
            .trace(range.clone(), &mut film, &mut |_| ControlFlow::Continue(()))
            .expect("a device that works");
        assert!(part.finished);
        report += part;
    }
    Picture { film, report }
}
