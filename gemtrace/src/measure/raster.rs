//! A stone under one light: a raster with one ray a pixel, and which of its rays meet what.

use super::Conditions;
use crate::{Error, Session, Watch};
use glam::DVec3;
use spectral_core::camera::{Camera, Projection};
use spectral_core::environment::{Environment, LightModel};
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::{Background, Scene, Stone};
use spectral_core::settings::{Coverage, RenderSettings};
use std::sync::Arc;

/// The eye that looks at the stone, and what renders for it.
pub(super) struct Eye<'a> {
    camera: Camera,
    conditions: &'a Conditions,
    session: &'a mut Session,
}

impl<'a> Eye<'a> {
    /// For stones that reach this far from the origin, mm.
    pub fn new(conditions: &'a Conditions, reach: f64, session: &'a mut Session) -> Result<Self, Error> {
        let (distance, projection) = match conditions.eye {
            None => {
                // A ray more, so that those at the edge pass the stone by.
                let height =
                    conditions.window.unwrap_or(2.0 * reach * (1.0 + 1.0 / f64::from(conditions.size)));
                (10.0 * reach, Projection::Orthographic { height })
            }
            Some(eye) if eye.is_finite() && eye > reach => {
                // The cone that touches the sphere of what the stone can reach.
                let slope =
                    conditions.window.map_or(reach / (eye * eye - reach * reach).sqrt(), |w| w / 2.0 / eye);
                (eye, Projection::Perspective { fov: 2.0 * slope.atan().to_degrees() })
            }
            Some(eye) => {
                let expected = format!("a distance in mm beyond the stone's farthest corner, {reach:.3}");
                return Err(spectral_core::Error::value("eye", eye, expected).into());
            }
        };
        let camera = Camera { position: DVec3::Z * distance, look_at: DVec3::ZERO, up: DVec3::Y, projection };
        Ok(Eye { camera, conditions, session })
    }

    /// The stone under a light model, which the session draws once.
    pub fn see_under(
        &mut self,
        stone: &Stone,
        model: &LightModel,
        watch: &mut dyn Watch,
    ) -> Result<Raster, Error> {
        let light = Environment::image(self.session.assets.drawn(model)?);
        self.see(stone, light, watch)
    }

    /// The stone under a light.
    pub fn see(&mut self, stone: &Stone, light: Environment, watch: &mut dyn Watch) -> Result<Raster, Error> {
        let scene = Scene {
            camera: self.camera.clone(),
            width: self.conditions.size,
            height: self.conditions.size,
            background: Background::Transparent,
            environment: light,
            stones: vec![stone.clone()],
        };
        // Figures are means over rays, as published.
        let settings =
            RenderSettings { coverage: Coverage::Points, ..self.conditions.settings.with_samples(1) };
        let settings = RenderSettings { jitter: false, spectral: false, ..settings };
        let prepared = self.session.prepare(&scene, &settings)?;
        let (film, rendered) = self.session.film(&prepared, watch)?;
        let places = || (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
        let xyz = places().map(|(x, y)| film.xyz(x, y).map(f64::from)).collect();
        let covered: Vec<bool> = places().map(|(x, y)| film.coverage(x, y) > 0.5).collect();
        let energy = rendered.traced.energy;
        // Rays that miss the stone start with as much as those that meet it.
        let share = covered.iter().filter(|c| **c).count() as f64 / covered.len() as f64;
        let dropped = if share > 0.0 { energy.dropped_share() / share } else { 0.0 };
        Ok(Raster { xyz, covered, dropped, prepared })
    }
}

/// What the rays of the raster brought, row by row.
pub(super) struct Raster {
    /// CIE XYZ, Y = 1 for light of radiance 1.
    pub xyz: Vec<[f64; 3]>,
    /// Whether the ray meets the stone.
    covered: Vec<bool>,
    /// The share of the stone's rays that was dropped.
    pub dropped: f64,
    prepared: Arc<PreparedScene>,
}

/// Rays of a raster, by their places in it.
pub(super) struct Mask(Vec<usize>);

impl Mask {
    /// All that meet the stone.
    pub fn stone(picture: &Raster) -> Self {
        Mask((0..picture.covered.len()).filter(|&i| picture.covered[i]).collect())
    }

    /// Those of them that meet one facet first of a convex stone: a ray is inside it where it has crossed every plane
    /// that faces it, the last of which is its entry.
    pub fn of_facet(&self, picture: &Raster, facet: u32) -> Self {
        let scene = &picture.prepared;
        let entry = |i: usize| {
            let (x, y) = (i % scene.width as usize, i / scene.width as usize);
            let ray = scene.view.ray(x as f64 + 0.5, y as f64 + 0.5);
            let distance = |plane: &spectral_core::prepare::FacetPlane| {
                (plane.offset - plane.normal.dot(ray.origin)) / plane.normal.dot(ray.direction)
            };
            let planes = scene.geometry.facets.iter().enumerate();
            let facing = planes.filter(|(_, plane)| plane.normal.dot(ray.direction) < 0.0);
            facing.map(|(index, plane)| (index, distance(plane))).max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let meets = |&i: &usize| entry(i).is_some_and(|(index, _)| index as u32 == facet);
        Mask(self.0.iter().copied().filter(meets).collect())
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The rays' colours.
    pub fn of<'a>(&'a self, picture: &'a Raster) -> impl Iterator<Item = [f64; 3]> + 'a {
        self.0.iter().map(|&i| picture.xyz[i])
    }

    /// The rays' colours in two pictures, of those that meet the stone in the second, too.
    pub fn of_both<'a>(
        &'a self,
        [first, second]: [&'a Raster; 2],
    ) -> impl Iterator<Item = [[f64; 3]; 2]> + 'a {
        let both = self.0.iter().filter(|&&i| second.covered[i]);
        both.map(|&i| [first.xyz[i], second.xyz[i]])
    }

    /// The mean luminance.
    pub fn mean(&self, picture: &Raster) -> f64 {
        self.of(picture).map(|[_, y, _]| y).sum::<f64>() / self.0.len() as f64
    }

    /// The standard deviation of luminance.
    pub fn deviation(&self, picture: &Raster) -> f64 {
        let mean = self.mean(picture);
        let squares = self.of(picture).map(|[_, y, _]| (y - mean).powi(2)).sum::<f64>();
        (squares / self.0.len() as f64).sqrt()
    }
}
