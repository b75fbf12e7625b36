//! `[camera]` and `[film]`.

use super::fields::{Fields, either};
use crate::Error;
use glam::DVec3;
use spectral_core::camera::{Camera, Projection};
use spectral_core::scene::Background;

const DEFAULT_FOV: f64 = 14.0;
const DEFAULT_SIZE: u32 = 512;

/// The camera and the picture it takes.
pub(super) struct View<'a> {
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    pub background: Background,
    camera_fields: Fields<'a>,
    film_fields: Option<Fields<'a>>,
}

impl View<'_> {
    pub fn at_camera(&self, error: spectral_core::Error) -> Error {
        self.camera_fields.blame(error)
    }

    pub fn at_film(&self, error: spectral_core::Error) -> Error {
        match &self.film_fields {
            Some(fields) => fields.error(error),
            None => self.camera_fields.error(error),
        }
    }
}

pub(super) fn read<'a>(root: &Fields<'a>) -> Result<View<'a>, Error> {
    let camera_fields =
        root.need("camera", "a table with at least 'position' and 'look_at'")?.fields("[camera]")?;
    let camera = camera(&camera_fields)?;
    let film_fields = root.get("film").map(|entry| entry.fields("[film]")).transpose()?;
    let (width, height, background) = match &film_fields {
        Some(fields) => film(fields)?,
        None => (DEFAULT_SIZE, DEFAULT_SIZE, Background::default()),
    };
    Ok(View { camera, width, height, background, camera_fields, film_fields })
}

fn camera(fields: &Fields) -> Result<Camera, Error> {
    let point = "three numbers [x, y, z], mm";
    let position = fields.need("position", point)?.vector(point)?.into();
    let look_at = fields.need("look_at", point)?.vector(point)?.into();
    let up = match fields.get("up") {
        Some(entry) => entry.vector("three numbers [x, y, z]")?.into(),
        None => DVec3::Z,
    };
    let projection = match fields.one_of(&["fov", "orthographic"])? {
        Some(("orthographic", entry)) => {
            Projection::Orthographic { height: entry.number("the height of the image, mm")? }
        }
        Some((_, entry)) => Projection::Perspective { fov: entry.number("the full angle, degrees")? },
        None => Projection::Perspective { fov: DEFAULT_FOV },
    };
    fields.finish()?;
    Ok(Camera { position, look_at, up, projection })
}

fn film(fields: &Fields) -> Result<(u32, u32, Background), Error> {
    let edge = |key| {
        let expected = "a whole number of pixels, from 1 to 65536";
        fields.get(key).map_or(Ok(DEFAULT_SIZE), |entry| entry.whole(expected))
    };
    let (width, height) = (edge("width")?, edge("height")?);
    const BACKGROUNDS: [&str; 2] = ["environment", "transparent"];
    let background = match fields.get("background") {
        None => Background::default(),
        Some(entry) => {
            let names = format!("one of {}", either(&BACKGROUNDS));
            match entry.text(&names)? {
                "environment" => Background::Environment,
                "transparent" => Background::Transparent,
                other => {
                    return Err(entry.error(spectral_core::Error::unknown("background", other, BACKGROUNDS)));
                }
            }
        }
    };
    fields.finish()?;
    Ok((width, height, background))
}
