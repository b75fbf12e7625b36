//! The light around the stones: a lat-long RGB image or a uniform colour, infinitely far away.
//!
//! Texels are linear sRGB; they stay RGB until a ray asks for one wavelength (`upsample`). A direction d
//! (unit, away from the stone, +z up) falls on the image at
//!
//! ```text
//! u = (atan2(dx, dy) + rotation) / 2π mod 1        v = acos(dz) / π
//! ```
//!
//! so that row 0 is at +z and a positive rotation turns the lights counter-clockwise seen from +z. Texel
//! (i, j) is centred at ((i + ½)/W, (j + ½)/H); look-ups are bilinear, periodic in u, clamped in v.

mod ground;
mod model;
mod studio;

pub use ground::{Ground, GroundFrame};
pub use model::{Head, LightModel, Pattern};

use crate::color::{Oklab, RgbSpace};
use crate::{Error, Warning, cie::Illuminant};
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A lat-long image of linear sRGB texels, all finite and non-negative.
#[derive(Debug, Clone, PartialEq)]
pub struct LatLong {
    width: u32,
    height: u32,
    /// Columns and rows that are lights; below them may be a [`Ground`].
    sky: [u32; 2],
    texels: Vec<[f32; 3]>,
}

impl LatLong {
    /// The most texels accepted: 32,768 × 16,384.
    pub const MAX_TEXELS: u64 = 1 << 29;

    /// An image of `width` × `height` texels, row by row from +z, left to right in u.
    ///
    /// Texels that are not finite become black; those outside sRGB, which have negative components, come in along their hue
    /// and lightness ([`Oklab::without_negatives`]). Both are counted in the warnings.
    ///
    /// # Errors
    /// [`Error::Value`] where the size is zero, too large, or not that of `texels`.
    pub fn new(width: u32, height: u32, mut texels: Vec<[f32; 3]>) -> Result<(Self, Vec<Warning>), Error> {
        let count = u64::from(width) * u64::from(height);
        let size = format!("{width} × {height}");
        if count == 0 || count > Self::MAX_TEXELS {
            return Err(Error::value("environment size", size, "1 × 1 up to 2²⁹ texels"));
        }
        if texels.len() as u64 != count {
            let found = format!("as many texels, not {}", texels.len());
            return Err(Error::value("environment size", size, found));
        }
        let warnings = clean(&mut texels);
        Ok((LatLong { width, height, sky: [width, height], texels }, warnings))
    }

    /// The built-in studio: a dim room with a ring of soft boxes and a large one overhead.
    ///
    /// Procedural, the same on every machine.
    pub fn studio() -> Self {
        studio::image()
    }

    /// Texels across (u).
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Texels down (v).
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Columns and rows of the lat-long image itself, from the first; of a prepared scene with a ground the rest is
    /// the ground's picture.
    pub fn sky(&self) -> [u32; 2] {
        self.sky
    }

    /// All texels, row by row.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// The bilinear value at image coordinates `u` (periodic) and `v` (clamped), in double precision.
    pub fn bilinear(&self, u: f64, v: f64) -> [f64; 3] {
        let [w, h] = self.sky.map(|n| n as usize);
        let x = u * w as f64 - 0.5;
        let y = (v * h as f64 - 0.5).clamp(0.0, (h - 1) as f64);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let (i, j) = ((x0 as i64).rem_euclid(w as i64) as usize, y0 as usize);
        let (i1, j1) = ((i + 1) % w, (j + 1).min(h - 1));
        let texel = |i: usize, j: usize, c: usize| f64::from(self.texels[j * self.width as usize + i][c]);
        std::array::from_fn(|c| {
            let top = texel(i, j, c) * (1.0 - fx) + texel(i1, j, c) * fx;
            let bottom = texel(i, j1, c) * (1.0 - fx) + texel(i1, j1, c) * fx;
            top * (1.0 - fy) + bottom * fy
        })
    }
}

/// Negative components are said only from this share of the light on: below it nobody sees what was changed. Lossy
/// compression leaves about as much beside lamps.
const VISIBLE: f64 = 0.025;

fn clean(texels: &mut [[f32; 3]]) -> Vec<Warning> {
    let (mut broken, mut negative) = (0usize, 0usize);
    let (mut light, mut cut) = (0.0, 0.0);
    let oklab = Oklab::of(RgbSpace::Srgb);
    for texel in texels.iter_mut() {
        if !texel.iter().all(|c| c.is_finite()) {
            *texel = [0.0; 3];
            broken += 1;
        }
        let below: f64 = texel.iter().map(|c| f64::from(-c.min(0.0))).sum();
        if below > 0.0 {
            *texel = oklab.without_negatives(texel.map(f64::from)).map(|c| c as f32);
            negative += 1;
            cut += below;
        }
        light += texel.iter().map(|c| f64::from(*c)).sum::<f64>();
    }
    let mut warnings = Vec::new();
    let total = texels.len();
    if broken > 0 {
        warnings.push(Warning::new(format!(
            "{broken} of the environment's {total} texels are not finite numbers; they were replaced by black"
        )));
    }
    if cut > VISIBLE * light {
        warnings.push(Warning::new(format!(
            "{negative} of the environment's {total} texels lie outside sRGB, by {:.2} % of its light; \
             they lost as much chroma as sRGB does not have",
            100.0 * cut / (light + cut)
        )));
    }
    warnings
}

/// Where the light's colour comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// The same linear sRGB colour from everywhere.
    Uniform([f64; 3]),
    /// A lat-long image.
    Image(Arc<LatLong>),
}

impl Source {
    /// Whether a device that holds the texels of one has those of the other. Uniform light has none.
    pub fn shares_texels(&self, other: &Self) -> bool {
        match (self, other) {
            (Source::Uniform(_), Source::Uniform(_)) => true,
            (Source::Image(a), Source::Image(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

/// The light around the stones.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    /// Colour by direction.
    pub source: Source,
    /// Degrees; the lights turn counter-clockwise seen from +z.
    pub rotation: f64,
    /// Factor on every radiance.
    pub scale: f64,
    /// The light that the image's white stands for: a grey texel is exactly grey × illuminant.
    pub illuminant: Illuminant,
    /// What is seen below the horizon in place of the image's lower half, if anything is.
    pub ground: Option<Arc<Ground>>,
}

impl Environment {
    /// The same grey from everywhere, under D65: the furnace of energy tests.
    pub fn uniform(rgb: [f64; 3]) -> Self {
        Self::new(Source::Uniform(rgb))
    }

    /// An image as it stands, under D65.
    pub fn image(image: impl Into<Arc<LatLong>>) -> Self {
        Self::new(Source::Image(image.into()))
    }

    fn new(source: Source) -> Self {
        Environment { source, rotation: 0.0, scale: 1.0, illuminant: Illuminant::D65, ground: None }
    }

    /// Linear sRGB seen in a unit direction (away from the stone), before `scale`.
    pub fn rgb(&self, direction: DVec3) -> [f64; 3] {
        match &self.source {
            Source::Uniform(rgb) => *rgb,
            Source::Image(image) => {
                let turn = direction.x.atan2(direction.y) / TAU + self.rotation / 360.0;
                image.bilinear(turn.rem_euclid(1.0), direction.z.clamp(-1.0, 1.0).acos() / PI)
            }
        }
    }

    /// Linear sRGB that a ray sees which leaves the stones at `origin` (mm) in a unit direction, before `scale`: the
    /// ground where there is one and the ray goes down, else the light from there.
    pub fn seen(&self, origin: DVec3, direction: DVec3) -> [f64; 3] {
        match &self.ground {
            Some(ground) if direction.z < 0.0 => ground.rgb(origin, direction),
            _ => self.rgb(direction),
        }
    }

    /// Rotation of the image in turns, in [0, 1), in single precision as backends take it.
    pub fn turn(&self) -> f32 {
        (self.rotation / 360.0).rem_euclid(1.0) as f32
    }

    /// Whether another shows the same picture: the same image and ground, not copies of them, or the same colour.
    pub(crate) fn shares_picture(&self, other: &Environment) -> bool {
        let same_source = match (&self.source, &other.source) {
            (Source::Uniform(a), Source::Uniform(b)) => a == b,
            (a, b) => a.shares_texels(b),
        };
        same_source && self.ground.as_ref().map(Arc::as_ptr) == other.ground.as_ref().map(Arc::as_ptr)
    }

    /// The same with the world's origin moved to `origin`, and the ground's picture in the image: in `picture`, if it
    /// has been made before.
    pub(crate) fn seen_from(&self, origin: DVec3, picture: Option<&Source>) -> Environment {
        let Some(ground) = &self.ground else { return self.clone() };
        let make = || match &self.source {
            Source::Image(image) => image.with_ground(ground),
            Source::Uniform(rgb) => uniform(*rgb).with_ground(ground),
        };
        let source = picture.cloned().unwrap_or_else(|| Source::Image(Arc::new(make())));
        let ground = Some(Arc::new(ground.seen_from(origin)));
        Environment { source, ground, ..self.clone() }
    }

    /// Refuses what cannot be light.
    ///
    /// # Errors
    /// [`Error::Value`] for a scale, rotation or uniform colour that is not finite, or negative light.
    pub fn validate(&self) -> Result<(), Error> {
        if !(self.scale.is_finite() && self.scale >= 0.0 && self.scale <= 1e12) {
            return Err(Error::value("environment.scale", self.scale, "a factor from 0 to 1e12"));
        }
        if !(self.rotation.is_finite() && self.rotation.abs() <= 1e6) {
            return Err(Error::value("environment.rotation", self.rotation, "an angle in degrees"));
        }
        match self.source {
            Source::Uniform(rgb) if !rgb.iter().all(|c| (0.0..=1e12).contains(c)) => {
                let expected = "three linear sRGB values from 0 to 1e12";
                Err(Error::value("environment.uniform", format!("{rgb:?}"), expected))
            }
            _ => Ok(()),
        }
    }
}

/// A sky of one colour, wide enough for its edges to be rare.
fn uniform(rgb: [f64; 3]) -> LatLong {
    const EDGE: u32 = 64;
    let texels = vec![rgb.map(|c| c as f32); (EDGE * EDGE) as usize];
    LatLong { width: EDGE, height: EDGE, sky: [EDGE; 2], texels }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> LatLong {
        let texels = (0..8 * 4).map(|i| [(i % 8) as f32, (i / 8) as f32, 1.0]).collect();
        LatLong::new(8, 4, texels).unwrap().0
    }

    #[test]
    fn row_zero_is_up_and_column_zero_starts_at_plus_y() {
        let mut e = Environment::image(gradient());
        assert_eq!(e.rgb(DVec3::Z)[1], 0.0);
        assert_eq!(e.rgb(-DVec3::Z)[1], 3.0);
        // +y is u = 0, half-way between the last texel and the first; +x is a quarter turn on.
        assert!((e.rgb(DVec3::Y)[0] - 3.5).abs() < 1e-12);
        assert!((e.rgb(DVec3::X)[0] - 1.5).abs() < 1e-12);
        e.rotation = 45.0;
        assert!((e.rgb(DVec3::Y)[0] - 0.5).abs() < 1e-12);
    }

    #[test]
    fn broken_texels_are_counted_and_replaced() {
        let texels = vec![[f32::NAN, 1.0, 1.0], [1.0, f32::INFINITY, 0.0], [-0.5, 1.0, 1.0], [1.0; 3]];
        let (image, warnings) = LatLong::new(2, 2, texels).unwrap();
        let [broken @ .., [r, g, b], white] = image.texels() else { panic!("four texels") };
        assert!(broken == [[0.0; 3]; 2] && *white == [1.0; 3]);
        // As light as it was, and as cyan as sRGB has it.
        assert!((0.0..1e-5).contains(r) && (0.7..0.9).contains(g) && (0.7..0.9).contains(b), "{r} {g} {b}");
        assert!(warnings[0].message.starts_with("2 of the environment's 4 texels"));
        assert!(warnings[1].message.starts_with("1 of the environment's 4 texels"));
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(LatLong::new(0, 4, vec![]).is_err());
        assert!(LatLong::new(u32::MAX, u32::MAX, vec![]).is_err());
        assert!(LatLong::new(2, 2, vec![[0.0; 3]]).unwrap_err().to_string().contains("not 1"));
    }

    #[test]
    fn the_studio_has_light_above_and_contrast() {
        let studio = LatLong::studio();
        let mean =
            studio.texels().iter().map(|t| f64::from(t[1])).sum::<f64>() / studio.texels().len() as f64;
        let peak = studio.texels().iter().map(|t| t[1]).fold(0.0, f32::max);
        assert!(mean > 0.1 && f64::from(peak) > 4.0 * mean, "mean {mean}, peak {peak}");
    }
}
