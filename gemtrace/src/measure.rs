//! What a cut does with light, in numbers: light return under light models, leakage, extinction, contrast.
//!
//! A stone is seen from +z, its table up, and tilted; each figure is a mean over the rays of a square raster that
//! meet the stone, or its table. What each means, and where it comes from, is in `docs/light-models.md`.
//!
//! * `raster`: the stone under one light, one ray a pixel.
//! * `figure`: means over it.

mod figure;
mod raster;

pub use figure::{Experimental, Figures};

use crate::{Error, Session, Watch};
use glam::DVec3;
use raster::{Eye, Mask, Raster};
use spectral_core::environment::{Environment, Head, LightModel, Pattern};
use spectral_core::scene::{Orientation, Stone};
use spectral_core::settings::{Leftover, RenderSettings};
use spectral_core::wavelength::WavelengthGrid;
use std::sync::Arc;

/// Which way a stone is tilted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hinge {
    /// About the x axis: what is at +y rises towards the eye for positive angles.
    #[default]
    X,
    /// About the y axis: what is at +x goes away from the eye for positive angles.
    Y,
}

impl Hinge {
    /// Both of them.
    pub const ALL: [Hinge; 2] = [Hinge::X, Hinge::Y];

    /// The axis' name.
    pub fn name(self) -> &'static str {
        match self {
            Hinge::X => "x",
            Hinge::Y => "y",
        }
    }
}

/// How a stone is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// The light models under which light return is measured.
    pub models: Vec<Pattern>,
    /// Half-angle of the viewer's head, degrees; 0 for none. It is at +z.
    pub head: f64,
    /// Distance of the eye from the origin, mm; `None` for parallel rays.
    pub eye: Option<f64>,
    /// Edge of the raster in the plane z = 0, mm; `None` for what the stone needs in every position.
    pub window: Option<f64>,
    /// Rays along an edge of the raster.
    pub size: u32,
    /// Depth, threshold, polarisation and wavelengths; one sample a pixel is taken whatever they say.
    pub settings: RenderSettings,
    /// About which axis the stone is tilted.
    pub hinge: Hinge,
    /// Whether the experimental figures are wanted, too: they take three more renders.
    pub experimental: bool,
}

impl Default for Conditions {
    /// ISO, COS and SC2 under a head of 10°, seen from afar, 300 × 300 rays.
    fn default() -> Self {
        let models = vec![Pattern::Iso, Pattern::Cos, Pattern::Sc2];
        let settings = RenderSettings {
            wavelengths: WavelengthGrid::default(),
            jitter: false,
            ..RenderSettings::default().with_samples(1)
        };
        Conditions {
            models,
            head: 10.0,
            eye: None,
            window: None,
            size: 300,
            settings,
            hinge: Hinge::X,
            experimental: false,
        }
    }
}

impl Conditions {
    /// What one unit of a GemCad file measures in GemRay, which takes every design at nine tenths of its size.
    pub const GEMRAY_SCALE: f64 = 0.9;

    /// The conditions of GemRay (Strickland), for stones scaled by [`GEMRAY_SCALE`](Self::GEMRAY_SCALE): the eye 30
    /// units away, a raster 2.5 units wide, nine hits inside the stone after which the rest is dropped, as are rays
    /// below a thousandth, the mean of both polarisations at every hit, one index.
    pub fn gemray() -> Self {
        let settings = RenderSettings {
            wavelengths: sodium(),
            max_depth: 10,
            leftover: Leftover::Drop,
            threshold: 1e-3,
            polarized: false,
            ..Conditions::default().settings
        };
        Conditions { eye: Some(30.0), window: Some(2.5), settings, ..Conditions::default() }
    }

    /// A light with the viewer's head before it.
    fn shadowed(&self, model: LightModel) -> LightModel {
        let head = (self.head > 0.0).then_some(Head { half_angle: self.head, towards: DVec3::Z });
        LightModel { head, ..model }
    }
}

/// The wavelength at which gems' indices are given, alone.
pub fn sodium() -> WavelengthGrid {
    WavelengthGrid::list(vec![589.3]).expect("one visible wavelength is a grid")
}

/// A stone in one position, measured. Every figure but the angle is a share from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Position {
    /// Degrees.
    pub tilt: f64,
    /// Over all rays that meet the stone.
    pub stone: Figures,
    /// Over those that meet its table first; `None` for a stone without one, or that is not convex.
    pub table: Option<Figures>,
    /// Of the light that entered the account, what was dropped at the depth limit or the threshold.
    pub dropped: f64,
}

/// Measures a stone at one angle after another.
pub struct Measurement<'a> {
    stone: Stone,
    table: Option<u32>,
    conditions: &'a Conditions,
    eye: Eye<'a>,
}

impl<'a> Measurement<'a> {
    /// A stone as its mesh, width and rotation say, at the origin whatever its position, ready to be tilted.
    ///
    /// ```
    /// use gemtrace::{Session, measure::{Conditions, Measurement}};
    /// use spectral_core::{material::Catalogue, scene::Stone, shape::ShapeSpec};
    /// use std::sync::Arc;
    /// let (mesh, _) = ShapeSpec::by_name("round-brilliant")?.cut()?.solid()?;
    /// let quartz = Catalogue::builtin().get("quartz")?.clone();
    /// let stone = Stone::new("quartz", Arc::new(mesh), Arc::new(quartz));
    /// let conditions = Conditions { size: 24, ..Conditions::default() };
    /// let mut session = Session::open("cpu")?;
    /// let seen = Measurement::new(&stone, &conditions, &mut session)?.at(0.0, &mut ())?.stone;
    /// let whole = seen.light_return[0] + seen.extinction + seen.leakage + seen.missing;
    /// assert!((whole - 1.0).abs() < 1e-5);
    /// # Ok::<(), gemtrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Core`] for a stone that cannot be placed, or an eye that is not outside it.
    pub fn new(stone: &Stone, conditions: &'a Conditions, session: &'a mut Session) -> Result<Self, Error> {
        let upright = Stone { position: DVec3::ZERO, ..stone.clone() };
        let placed = upright.placed()?;
        let reach = placed.positions().iter().map(|p| p.length()).fold(0.0, f64::max);
        let table = if placed.is_convex() { table(stone) } else { None };
        let eye = Eye::new(conditions, reach, session)?;
        // A crystal is turned with the stone.
        let [x, y, _] = upright.crystal_axes()?;
        let orientation = stone.material.is_crystal().then_some(Orientation::Axes([x, y]));
        let stone = Stone::new(stone.name.clone(), Arc::new(placed), stone.material.clone());
        Ok(Measurement { stone: Stone { orientation, ..stone }, table, conditions, eye })
    }

    /// The figures at one angle, degrees. `watch` follows each of the renders that it takes, and may stop it.
    ///
    /// # Errors
    /// [`Error::Core`] for what cannot be rendered, [`Error::Render`] for a device that fails,
    /// [`Error::Interrupted`] where the watcher stopped it.
    pub fn at(&mut self, tilt: f64, watch: &mut dyn Watch) -> Result<Position, Error> {
        let stone = self.tilted(tilt);
        let all = self.eye.see(&stone, Environment::uniform([1.0; 3]), watch)?;
        let masks = self.masks(&all)?;
        let mut model = |model: &LightModel| self.eye.see_under(&stone, model, watch);
        let mut figures: Vec<Figures> = masks.iter().map(|mask| Figures::missing(mask, &all)).collect();
        let note = |picture: &Raster, figures: &mut Vec<Figures>, field: fn(&mut Figures, f64)| {
            for (figures, mask) in figures.iter_mut().zip(&masks) {
                field(figures, mask.mean(picture));
            }
        };
        let mut iso = None;
        for pattern in &self.conditions.models {
            let picture = model(&self.conditions.shadowed(LightModel::new(pattern.clone())))?;
            note(&picture, &mut figures, |f, mean| f.light_return.push(mean));
            if *pattern == Pattern::Iso {
                iso = Some(picture);
            }
        }
        let from_behind = LightModel { below: [1.0; 3], ..LightModel::new(Pattern::Iso).with_head(90.0) };
        note(&model(&from_behind)?, &mut figures, |f, mean| f.leakage = mean);
        if self.conditions.head > 0.0 {
            let head = LightModel::new(Pattern::Dome { half_angle: self.conditions.head });
            note(&model(&head)?, &mut figures, |f, mean| f.extinction = mean);
        }
        let dome = |half_angle: f64| LightModel::new(Pattern::Dome { half_angle });
        note(&model(&dome(15.0))?, &mut figures, |f, mean| f.aset[0] = mean);
        note(&model(&dome(45.0).with_head(15.0))?, &mut figures, |f, mean| f.aset[1] = mean);
        let iso = iso.map_or_else(|| model(&self.conditions.shadowed(LightModel::new(Pattern::Iso))), Ok)?;
        for (figures, mask) in figures.iter_mut().zip(&masks) {
            figures.contrast = mask.deviation(&iso);
            figures.aset[2] = 1.0 - figures.missing - figures.leakage - figures.aset[0] - figures.aset[1];
        }
        if self.conditions.experimental {
            self.experiment(tilt, &masks, &mut figures, watch)?;
        }
        let mut figures = figures.into_iter();
        let stone = figures.next().unwrap_or_default();
        Ok(Position { tilt, stone, table: figures.next(), dropped: all.dropped })
    }

    /// Fire and scintillation, under spots.
    fn experiment(
        &mut self,
        tilt: f64,
        masks: &[Mask],
        figures: &mut [Figures],
        watch: &mut dyn Watch,
    ) -> Result<(), Error> {
        let spots = self.conditions.shadowed(LightModel::new(Pattern::by_name("spots")?));
        let [now, next] = [tilt, tilt + Experimental::STEP].map(|tilt| self.tilted(tilt));
        let now = self.eye.see_under(&now, &spots, watch)?;
        let next = self.eye.see_under(&next, &spots, watch)?;
        for (figures, mask) in figures.iter_mut().zip(masks) {
            figures.experimental = Some(Experimental::of(mask, &now, &next));
        }
        Ok(())
    }

    fn tilted(&self, degrees: f64) -> Stone {
        let mut stone = self.stone.clone();
        stone.rotation = match self.conditions.hinge {
            Hinge::X => DVec3::new(degrees, 0.0, 0.0),
            Hinge::Y => DVec3::new(0.0, degrees, 0.0),
        };
        stone
    }

    /// The stone's rays, and the table's.
    fn masks(&self, all: &Raster) -> Result<Vec<Mask>, Error> {
        let stone = Mask::stone(all);
        if stone.is_empty() {
            let message = "no ray meets the stone; give a larger size, or an eye that is nearer".to_owned();
            return Err(Error::Usage(message));
        }
        let table = self.table.map(|facet| stone.of_facet(all, facet)).filter(|mask| !mask.is_empty());
        Ok([stone].into_iter().chain(table).collect())
    }
}

/// The table of a stone before its rotation: the facet that faces +z, to 0.8°, and lies highest.
fn table(stone: &Stone) -> Option<u32> {
    let facing = |normal: DVec3| (stone.up.matrix() * normal).z > 0.9999;
    let level = stone.mesh.facets().iter().enumerate().filter(|(_, facet)| facing(facet.plane.normal));
    let highest = level.max_by(|(_, a), (_, b)| a.plane.offset.total_cmp(&b.plane.offset));
    highest.map(|(index, _)| index as u32)
}
