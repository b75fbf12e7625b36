//! Small pictures of the materials: a round brilliant in each, made when it is first asked for.

use super::hub::locked;
use crate::output;
use crate::scene_file::LoadedScene;
use crate::{Error, Session, registry};
use spectral_core::material::Catalogue;
use spectral_core::mesh::Mesh;
use spectral_core::scene::{Background, Scene, Stone};
use spectral_core::settings::RenderSettings;
use spectral_core::shape::ShapeSpec;
use spectral_core::tracer::OpenOptions;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// Edge, pixels.
const EDGE: u32 = 48;
const SAMPLES: u32 = 9;
/// The stone's width, mm.
const WIDTH: f64 = 6.5;
/// Steps of each channel: so few that a file has one to two kilobytes.
const STEPS: f64 = 15.0;

/// What has been made, and what makes it.
#[derive(Default)]
pub struct Swatches(Mutex<Made>);

#[derive(Default)]
struct Made {
    eye: Option<(Session, Arc<Mesh>)>,
    known: HashMap<String, Arc<[u8]>>,
}

impl Swatches {
    /// The PNG of a material of the catalogue.
    ///
    /// # Errors
    /// [`Error::Core`] for a name that no material has.
    pub fn get(&self, name: &str) -> Result<Arc<[u8]>, Error> {
        let material = Catalogue::builtin().get(name)?;
        let mut made = locked(&self.0);
        if let Some(known) = made.known.get(&material.name) {
            return Ok(Arc::clone(known));
        }
        let (session, mesh) = match &mut made.eye {
            Some(eye) => eye,
            none => none.insert(eye()?),
        };
        // Double refraction is not seen in so small a picture.
        let mut stone = Stone::new(&*material.name, Arc::clone(mesh), Arc::new(material.isotropic()));
        stone.width = Some(WIDTH);
        let background = Background::Transparent;
        let scene = Scene { width: EDGE, height: EDGE, background, ..Scene::in_studio(vec![stone]) };
        let settings = RenderSettings::default().with_samples(SAMPLES);
        let picture = session.render(LoadedScene { settings, ..scene.into() })?;
        let coarse = |c: u8| ((f64::from(c) / 255.0 * STEPS).round() / STEPS * 255.0) as u8;
        let pixels: Vec<[u8; 4]> = picture.rgba().into_iter().map(|pixel| pixel.map(coarse)).collect();
        let png: Arc<[u8]> = output::small_png(EDGE, &pixels).map_err(|e| Error::output(name, e))?.into();
        made.known.insert(material.name.clone(), Arc::clone(&png));
        Ok(png)
    }
}

/// One thread: pictures that someone turns go first.
fn eye() -> Result<(Session, Arc<Mesh>), Error> {
    let open = OpenOptions { threads: Some(1), ..OpenOptions::default() };
    let (mesh, _) = ShapeSpec::by_name("round-brilliant")?.cut()?.solid()?;
    Ok((Session::new(registry::choose("cpu", None)?, open), Arc::new(mesh)))
}
