//! A scene made ready for any backend: validated, flat arrays, one table of optics a wavelength grid.
//!
//! All that a caller can get wrong is refused here, so that backends need not check. Geometry is kept in
//! double precision about a local origin (the middle of the stones), so that a backend's single precision
//! is spent on the stones and not on where they stand.

mod geometry;
mod nest;
mod outline;
mod rounding;
mod spectral;

pub use geometry::{FacetPlane, Geometry, PreparedStone};
pub use nest::{Nest, Rank};
pub use outline::{Outline, Side};
pub use rounding::{Rounding, Span};
pub use spectral::{Medium, SpectralTable};

use crate::{
    Error, Warning,
    camera::View,
    environment::Environment,
    film::Film,
    scene::{Background, Scene},
    settings::RenderSettings,
};
use glam::DVec3;

/// A validated scene with its settings: what every backend renders.
#[derive(Debug, Clone)]
pub struct PreparedScene {
    /// The settings it was prepared for.
    pub settings: RenderSettings,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Camera rays, in local coordinates.
    pub view: View,
    /// The local origin in the world, mm.
    pub origin: DVec3,
    /// What is seen past the stones.
    pub background: Background,
    /// All stones' surfaces, in local coordinates.
    pub geometry: Geometry,
    /// The light, with the ground in local coordinates and its picture in the image.
    pub environment: Environment,
    /// Optics by wavelength: one table for all samples, or one a sample where wavelengths are jittered.
    pub tables: Vec<SpectralTable>,
    /// The stones that a perspective camera stands in.
    pub eye_nest: Nest,
    /// Remarks that do not stop the work.
    pub warnings: Vec<Warning>,
}

impl PreparedScene {
    /// Validates a scene and flattens it.
    ///
    /// # Errors
    /// [`Error::Value`] naming what cannot be rendered and what could.
    pub fn new(scene: &Scene, settings: &RenderSettings) -> Result<Self, Error> {
        settings.validate()?;
        scene.environment.validate()?;
        let kept = if settings.spectral { settings.wavelengths.len() } else { 0 };
        Film::check_size(scene.width, scene.height, kept)?;
        let view = scene.camera.view(scene.width, scene.height)?;
        let mut warnings = Vec::new();
        let (geometry, origin) = Geometry::new(&scene.stones)?;
        let tables = spectral::tables(scene, settings, &mut warnings)?;
        let view = view.seen_from(origin);
        let eye_nest = view.eye().map_or(Nest::default(), |eye| geometry.nest_at(eye));
        if !eye_nest.is_empty() {
            warnings.push(Warning::new("the camera stands inside a stone"));
        }
        Ok(PreparedScene {
            settings: settings.clone(),
            width: scene.width,
            height: scene.height,
            view,
            origin,
            background: scene.background,
            geometry,
            environment: scene.environment.seen_from(origin),
            tables,
            eye_nest,
            warnings,
        })
    }

    /// Wavelengths traced for each pixel sample.
    pub fn wavelength_count(&self) -> usize {
        self.settings.wavelengths.len()
    }

    /// The optics of pixel sample `sample`.
    pub fn table(&self, sample: u32) -> &SpectralTable {
        &self.tables[sample as usize % self.tables.len()]
    }

    /// The stone that alone stands in the scene, if it is a convex dielectric of few facets seen from outside: then what
    /// leaves it never returns, and a path is a chain rather than a tree.
    pub fn lone_convex_stone(&self) -> Option<&PreparedStone> {
        match self.geometry.stones.as_slice() {
            [stone] if stone.has_few_planes() && !stone.conductor && self.eye_nest.is_empty() => Some(stone),
            _ => None,
        }
    }
}
