//! `[camera]` and `[film]`.

use super::fields::{Entry, Fields, either};
use crate::Error;
use glam::DVec3;
use spectral_core::camera::{Camera, Projection};
use spectral_core::color::{Tone, srgb_decode};
use spectral_core::scene::Background;

pub(crate) const DEFAULT_FOV: f64 = 14.0;
const DEFAULT_SIZE: u32 = 512;

/// The camera and the picture it takes.
pub(super) struct View<'a> {
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    pub background: Background,
    /// The colour past the stones, linear sRGB, if it is one.
    pub backdrop: Option<[f64; 3]>,
    /// Stops that the picture is brightened by where it is shown.
    pub exposure: f64,
    pub tone: Tone,
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
    let (width, height, (exposure, tone), (background, backdrop)) = match &film_fields {
        Some(fields) => film(fields)?,
        None => (DEFAULT_SIZE, DEFAULT_SIZE, Look::default(), Behind::default()),
    };
    Ok(View { camera, width, height, background, backdrop, exposure, tone, camera_fields, film_fields })
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

/// Stops that the picture is brightened by where it is shown, and its tone.
type Look = (f64, Tone);

fn film(fields: &Fields) -> Result<(u32, u32, Look, Behind), Error> {
    let edge = |key| {
        let expected = "a whole number of pixels, from 1 to 65536";
        fields.get(key).map_or(Ok(DEFAULT_SIZE), |entry| entry.whole(expected))
    };
    let (width, height) = (edge("width")?, edge("height")?);
    let behind = fields.get("background").map_or(Ok(Behind::default()), |entry| background(&entry))?;
    let exposure = match fields.get("exposure") {
        Some(entry) => {
            let expected = "a number of stops from -64 to 64";
            let stops = entry.number(expected)?;
            if stops.abs() > 64.0 {
                return Err(entry.refuse(expected));
            }
            stops
        }
        None => 0.0,
    };
    let tone = match fields.get("tone") {
        Some(entry) => {
            let name = entry.text(&format!("one of {}", either(&Tone::ALL.map(Tone::name))))?;
            Tone::by_name(name).map_err(|e| entry.error(e))?
        }
        None => Tone::default(),
    };
    fields.finish()?;
    Ok((width, height, (exposure, tone), behind))
}

/// What is rendered past the stones, and the colour that is put there afterwards.
type Behind = (Background, Option<[f64; 3]>);

const BACKGROUNDS: [&str; 2] = ["environment", "transparent"];

fn background(entry: &Entry) -> Result<Behind, Error> {
    let colour = "a colour: \"#rrggbb\" or three linear sRGB values [r, g, b]";
    let expected = format!("one of {}, or {colour}", either(&BACKGROUNDS));
    let Some(name) = entry.value.get_ref().as_str() else {
        let rgb: [f64; 3] = entry.vector(&expected)?;
        let shown = rgb.iter().all(|c| (0.0..=1e6).contains(c));
        return if shown { Ok((Background::Transparent, Some(rgb))) } else { Err(entry.refuse(&expected)) };
    };
    match name {
        "environment" => Ok((Background::Environment, None)),
        "transparent" => Ok((Background::Transparent, None)),
        hex if hex.starts_with('#') => {
            let rgb =
                encoded(hex).ok_or_else(|| entry.refuse("a colour \"#rrggbb\", two digits 0 to f each"))?;
            Ok((Background::Transparent, Some(rgb)))
        }
        other => {
            let unknown = spectral_core::Error::unknown("background", other, BACKGROUNDS);
            Err(entry.error(format!("{unknown}, or {colour}")))
        }
    }
}

/// Linear sRGB of `#rrggbb`.
fn encoded(hex: &str) -> Option<[f64; 3]> {
    let digits =
        hex.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    Some([16, 8, 0].map(|shift| srgb_decode(f64::from(number >> shift & 0xff) / 255.0)))
}
