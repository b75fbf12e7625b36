//! A scene made ready for any backend: validated, in flat arrays, with a table of optics for each wavelength grid.
//!
//! Whatever a caller can get wrong is refused here, so backends need not check. Geometry is kept in double precision
//! about a local origin, the middle of the stones. A backend's single precision then resolves the stones, wherever in
//! the world they stand.

mod contact;
mod eye;
mod geometry;
mod medium;
mod neighbour;
mod nest;
mod outline;
mod overlap;
mod reach;
mod rounding;
mod spectral;
mod substance;

pub use geometry::{FacetPlane, Geometry, PreparedStone};
pub use medium::Medium;
pub use nest::{Nest, Rank};
pub use outline::{Outline, Side};
pub use rounding::{Rounding, Span};
pub use spectral::{Optics, SpectralTable};
pub use substance::remarks as crystal_remarks;

use crate::{
    Error, Warning,
    beam::Silhouette,
    camera::{CameraRay, View},
    environment::Environment,
    film::{Film, Tile},
    scene::{Background, Scene},
    settings::{Coverage, RenderSettings},
};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// A validated scene with its settings: what every backend renders.
///
/// Its parts outlive it: [`update`](Self::update) prepares only those that a change touches and shares the others, so
/// that a backend knows by [`Arc::ptr_eq`] what it has already. Copies share all of them.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PreparedScene {
    /// The settings it was prepared for.
    pub settings: RenderSettings,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Camera rays, in local coordinates.
    pub view: View,
    /// What is seen past the stones.
    pub background: Background,
    /// All stones' surfaces, in local coordinates.
    pub geometry: Arc<Geometry>,
    /// The light, with the ground in local coordinates and its picture in the image.
    pub environment: Arc<Environment>,
    /// Optics by wavelength.
    pub optics: Arc<Optics>,
    /// The stones that a perspective camera stands in.
    pub eye_nest: Nest,
    /// Whether the eye is nearer to a surface than [`Geometry::CLOSE`]: single precision then looks at edges twice.
    pub close_up: bool,
    /// What the stone covers of each pixel, if samples are areas; else they are points.
    pub silhouette: Option<Arc<Silhouette>>,
    /// Remarks that do not stop the work.
    pub warnings: Vec<Warning>,
    /// The settings that were asked for.
    asked: RenderSettings,
    /// The light as the scene has it.
    light: Environment,
}

impl PreparedScene {
    /// Validates a scene and flattens it.
    ///
    /// # Errors
    /// [`Error::Value`] naming what cannot be rendered and what could.
    pub fn new(scene: &Scene, settings: &RenderSettings) -> Result<Self, Error> {
        Self::prepare(scene, settings, None)
    }

    /// The same for a scene that may have much in common with this one. Another camera, size or background prepares no
    /// part anew; another pose of the stones the geometry; another material, illuminant or scale the optics; another
    /// rotation of the light the environment, but not its image.
    ///
    /// The outcome is that of [`new`](Self::new). Meshes and materials are the same where they are equal, images and
    /// grounds where they are shared.
    ///
    /// ```
    /// use spectral_core::{prepare::PreparedScene, scene::Scene, settings::RenderSettings};
    /// use std::sync::Arc;
    /// let (mut scene, settings) = (Scene::in_studio(vec![]), RenderSettings::default());
    /// let first = PreparedScene::new(&scene, &settings)?;
    /// scene.camera.position.x += 1.0;
    /// let second = first.update(&scene, &settings)?;
    /// assert!(Arc::ptr_eq(&first.geometry, &second.geometry) && Arc::ptr_eq(&first.optics, &second.optics));
    /// assert!(first.view != second.view);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn update(&self, scene: &Scene, settings: &RenderSettings) -> Result<Self, Error> {
        Self::prepare(scene, settings, Some(self))
    }

    fn prepare(scene: &Scene, settings: &RenderSettings, before: Option<&Self>) -> Result<Self, Error> {
        settings.validate()?;
        scene.environment.validate()?;
        let kept = if settings.spectral { settings.wavelengths.len() } else { 0 };
        Film::check_size(scene.width, scene.height, kept)?;
        let view = scene.camera.view(scene.width, scene.height)?;
        let geometry = match before {
            Some(before) if before.geometry.is_of(&scene.stones) => before.geometry.clone(),
            _ => Arc::new(Geometry::new(&scene.stones)?),
        };
        let environment = Self::light(&scene.environment, geometry.origin, before);
        let view = view.seen_from(geometry.origin);
        // As the scene has it: what a camera that is moved no longer sees would not be judged.
        geometry.check_reach(&view)?;
        let (view, moved) = geometry.clear(view)?;
        let eye_nest = view.eye().map_or(Nest::default(), |eye| geometry.nest_at(eye));
        let close_up = geometry.is_close(&view);
        let wanted = settings.coverage != Coverage::Points;
        let lone = wanted.then(|| geometry.lone_convex(eye_nest)).flatten();
        let silhouette = lone.and_then(|stone| Silhouette::of(&geometry, stone, &view)).map(Arc::new);
        let asked = settings;
        let settings = &match silhouette {
            Some(_) => settings.of_area(),
            None => RenderSettings { coverage: Coverage::Points, ..settings.clone() },
        };
        let optics = Optics::new(scene, settings, before.map(|before| &before.optics))?;
        let mut warnings = optics.warnings.clone();
        if asked.coverage == Coverage::Area && silhouette.is_none() {
            warnings.push(Warning::new(
                "coverage = \"area\" needs one convex stone, all of it before the camera and nothing beside it: \
                 this scene is rendered from points",
            ));
        }
        warnings.extend(moved);
        warnings.extend(substance::remarks(&scene.stones)?);
        if !eye_nest.is_empty() {
            warnings.push(Warning::new("the camera stands inside a stone"));
        }
        Ok(PreparedScene {
            settings: settings.clone(),
            width: scene.width,
            height: scene.height,
            view,
            background: scene.background,
            geometry,
            environment,
            optics,
            eye_nest,
            close_up,
            silhouette,
            warnings,
            asked: asked.clone(),
            light: scene.environment.clone(),
        })
    }

    /// The light in local coordinates; `before`'s, or its picture, where they serve.
    fn light(light: &Environment, origin: DVec3, before: Option<&Self>) -> Arc<Environment> {
        let before = before.filter(|before| before.light.shares_picture(light));
        let figures = |light: &Environment| (light.rotation, light.scale, light.illuminant.clone());
        match before {
            Some(before)
                if figures(&before.light) == figures(light)
                    && (light.ground.is_none() || before.geometry.origin == origin) =>
            {
                before.environment.clone()
            }
            _ => Arc::new(light.seen_from(origin, before.map(|before| &before.environment.source))),
        }
    }

    /// The same scene for devices that cannot follow areas, its samples points; with a remark where areas were asked for by
    /// name. It shares what it can with one that was made `before`.
    ///
    /// # Errors
    /// As [`new`](Self::new), for the optics of other wavelengths.
    pub fn in_points(&self, before: Option<&Self>) -> Result<Self, Error> {
        let settings = RenderSettings { coverage: Coverage::Points, ..self.asked.clone() };
        let optics = self.optics.with(&self.light, &settings, before.map(|before| &before.optics))?;
        let mut scene = PreparedScene { settings, optics, silhouette: None, ..self.clone() };
        if self.silhouette.is_some() && self.asked.coverage == Coverage::Area {
            let remark = "coverage = \"area\" is for the processor: this device renders from points";
            scene.warnings.push(Warning::new(remark));
        }
        Ok(scene)
    }

    /// The most samples that a pixel gets, be they areas or [points](Self::in_points).
    pub fn most_samples(&self) -> u32 {
        self.settings.samples.max(self.asked.samples)
    }

    /// Wavelengths traced for each pixel sample.
    pub fn wavelength_count(&self) -> usize {
        self.settings.wavelengths.len()
    }

    /// The optics of pixel sample `sample`.
    pub fn table(&self, sample: u32) -> &SpectralTable {
        &self.optics.tables[sample as usize % self.optics.tables.len()]
    }

    /// The camera rays of some samples over a tile, with their samples: pixel by pixel, each pixel's samples in order, as
    /// [`TileSums`](crate::film::TileSums) has them.
    pub fn camera_rays(
        &self,
        tile: Tile,
        samples: Range<u32>,
    ) -> impl Iterator<Item = (u32, CameraRay)> + '_ {
        let row = move |y| (tile.x..tile.x + tile.width).map(move |x| [x, y].map(f64::from));
        let pixels = (tile.y..tile.y + tile.height).flat_map(row);
        pixels.flat_map(move |[x, y]| {
            samples.clone().map(move |sample| {
                let [dx, dy] = self.settings.offset(sample);
                (sample, self.view.ray(x + dx, y + dy))
            })
        })
    }

    /// Linear sRGB that a camera ray shows which meets no stone; black where the background is transparent.
    ///
    /// It is needed once a sample, so it is looked up in double precision: beside a lamp one texel may be a thousand
    /// times as bright as the next.
    pub fn background_of(&self, ray: &CameraRay) -> [f32; 3] {
        match self.background {
            Background::Environment => self.environment.seen(ray.origin, ray.direction).map(|c| c as f32),
            Background::Transparent => [0.0; 3],
        }
    }

    /// The stone that alone stands in the scene, if it is a convex dielectric of few facets seen from outside: then what
    /// leaves it never returns, and a path is a chain rather than a tree.
    pub fn lone_convex_stone(&self) -> Option<&PreparedStone> {
        self.geometry.lone_convex(self.eye_nest).filter(|stone| !stone.crystal)
    }

    /// The same where it is a crystal.
    pub fn lone_convex_crystal(&self) -> Option<&PreparedStone> {
        self.geometry.lone_convex(self.eye_nest).filter(|stone| stone.crystal)
    }
}

impl Geometry {
    /// The only stone, if it is a convex dielectric of few facets and the eye is not in it.
    fn lone_convex(&self, eye_nest: Nest) -> Option<&PreparedStone> {
        match self.stones.as_slice() {
            [stone] if stone.has_few_planes() && !stone.conductor && eye_nest.is_empty() => Some(stone),
            _ => None,
        }
    }
}

// Here, so that films do not know of scenes.
impl Film {
    /// An empty film for a prepared scene. Panics where there is not enough memory; [`Film::try_new`] says so.
    pub fn new(scene: &PreparedScene) -> Self {
        Film::try_new(scene).unwrap_or_else(|error| panic!("{error}"))
    }

    /// An empty film for a prepared scene.
    ///
    /// # Errors
    /// [`Error::Memory`].
    pub fn try_new(scene: &PreparedScene) -> Result<Self, Error> {
        let wavelengths = if scene.settings.spectral { scene.wavelength_count() } else { 0 };
        Film::empty(scene.width, scene.height, wavelengths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        environment::{Ground, Source},
        material::{Catalogue, Material},
        scene::Stone,
        settings::Quality,
        shape::ShapeSpec,
    };

    /// With one index: a crystal's optics turn with its stone.
    fn material(name: &str) -> Arc<Material> {
        Arc::new(Catalogue::builtin().get(name).unwrap().isotropic())
    }

    fn two_stones() -> Scene {
        let (mesh, _) = ShapeSpec::by_name("step").unwrap().cut().unwrap().solid().unwrap();
        let mesh = Arc::new(mesh);
        let [mut a, b] = ["ruby", "quartz"].map(|name| Stone::new(name, mesh.clone(), material(name)));
        a.position.x = 4.0;
        let mut scene = Scene::in_studio(vec![a, b]);
        let ground = Ground::new(-2.0, [-9.0; 2], 1.0, 2, vec![[0.5; 3]; 4]).unwrap();
        scene.environment.ground = Some(Arc::new(ground));
        scene
    }

    /// Which of geometry, environment, the environment's image and optics are another's.
    fn shared(a: &PreparedScene, b: &PreparedScene) -> [bool; 4] {
        let image = match (&a.environment.source, &b.environment.source) {
            (Source::Image(a), Source::Image(b)) => Arc::ptr_eq(a, b),
            _ => false,
        };
        [
            Arc::ptr_eq(&a.geometry, &b.geometry),
            Arc::ptr_eq(&a.environment, &b.environment),
            image,
            Arc::ptr_eq(&a.optics, &b.optics),
        ]
    }

    #[test]
    fn a_change_prepares_only_what_it_touches() {
        type Change = fn(&mut Scene, &mut RenderSettings);
        let cases: [(&str, Change, [bool; 4]); 11] = [
            ("nothing", |_, _| (), [true; 4]),
            ("camera", |scene, _| scene.camera.position.x += 1.0, [true; 4]),
            ("size", |scene, _| scene.width = 99, [true; 4]),
            ("background", |scene, _| scene.background = Background::Transparent, [true; 4]),
            ("depth", |_, settings| settings.max_depth = 3, [true; 4]),
            (
                "copies",
                |scene, _| scene.stones[0].mesh = Arc::new((*scene.stones[0].mesh).clone()),
                [true; 4],
            ),
            // With them the local origin moves, and with it the ground, but not the ground's picture.
            ("pose", |scene, _| scene.stones[0].rotation.z = 5.0, [false, false, true, true]),
            ("rotation", |scene, _| scene.environment.rotation = 5.0, [true, false, true, true]),
            ("scale", |scene, _| scene.environment.scale = 5.0, [true, false, true, false]),
            (
                "material",
                |scene, _| scene.stones[1].material = material("diamond"),
                [true, true, true, false],
            ),
            ("wavelengths", |_, settings| *settings = settings.at(Quality::Draft), [true, true, true, false]),
        ];
        let (scene, settings) = (two_stones(), RenderSettings::default().with_samples(16));
        let first = PreparedScene::new(&scene, &settings).unwrap();
        for (what, change, expected) in cases {
            let (mut scene, mut settings) = (scene.clone(), settings.clone());
            change(&mut scene, &mut settings);
            let second = first.update(&scene, &settings).unwrap();
            let anew = PreparedScene::new(&scene, &settings).unwrap();
            assert_eq!(shared(&first, &second), expected, "{what}");
            assert_eq!(second.optics.tables, anew.optics.tables, "{what}");
            assert_eq!(second.environment, anew.environment, "{what}");
            assert_eq!(second.geometry.facets, anew.geometry.facets, "{what}");
            assert_eq!((&second.view, &second.warnings), (&anew.view, &anew.warnings), "{what}");
        }
    }

    #[test]
    fn samples_are_areas_where_one_convex_stone_allows_it() {
        let area = RenderSettings { coverage: Coverage::Area, ..RenderSettings::default() };
        let mut scene = two_stones();
        let both = PreparedScene::new(&scene, &area).unwrap();
        assert!(both.silhouette.is_none() && both.settings.coverage == Coverage::Points);
        let remark =
            |scene: &PreparedScene| scene.warnings.iter().any(|w| w.to_string().contains("coverage"));
        assert!(remark(&both));
        scene.stones.pop();
        let one = PreparedScene::new(&scene, &area).unwrap();
        assert!(one.silhouette.is_some() && !remark(&one));
        assert_eq!((one.settings.samples, one.optics.tables.len()), (area.area.offsets, 27));
        let points = one.in_points(None).unwrap();
        assert!(points.silhouette.is_none() && remark(&points));
        let plain = RenderSettings { coverage: Coverage::Points, ..area };
        let alike = PreparedScene::new(&scene, &plain).unwrap();
        assert_eq!((&points.settings, &points.optics.tables), (&alike.settings, &alike.optics.tables));
        assert_eq!(one.most_samples(), plain.samples);
    }

    #[test]
    fn what_a_mesh_was_is_not_taken_for_another() {
        let (mut scene, settings) = (two_stones(), RenderSettings::default().with_samples(16));
        let first = PreparedScene::new(&scene, &settings).unwrap();
        scene.stones.pop();
        assert!(!shared(&first, &first.update(&scene, &settings).unwrap())[0]);
        // Given back and read again: nobody knows that it is the same.
        drop(std::mem::replace(&mut scene, two_stones()));
        assert!(!shared(&first, &first.update(&scene, &settings).unwrap())[0]);
    }
}
