//! The colour of a piece of a material.

use gemtrace::Error;
use spectral_core::cie::Illuminant;
use spectral_core::color::{Response, RgbSpace, Tone, ViewTransform, bradford, matrix::apply, srgb_encode};
use spectral_core::fresnel::conductor;
use spectral_core::material::Material;
use spectral_core::wavelength::WavelengthGrid;

/// What the colour of a metal is.
pub const REFLECTED: &str = "sRGB, D65 reflected at normal incidence";

/// What the colour of something to look through is the colour of, for people.
pub fn transmitted(mm: f64) -> String {
    format!("sRGB, D65 through {mm} mm, surfaces left out")
}

/// A colour in linear sRGB; components outside 0–1 are outside the space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour(pub [f64; 3]);

impl Colour {
    /// Light after a share of each wavelength is left of it, as an eye sees it that is adapted to the light (Bradford);
    /// 380–780 nm in steps of 5 nm, CIE 1931 2°.
    pub fn of(light: &Illuminant, share: impl Fn(f64) -> f64) -> Result<Self, Error> {
        let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0)?;
        let response = Response::new(&grid)?;
        let xyz = |share: &dyn Fn(f64) -> f64| {
            let left: Vec<f64> = grid.nm().iter().map(|&nm| light.at(nm) * share(nm)).collect();
            response.to_xyz(&left)
        };
        let white = xyz(&|_| 1.0);
        let adapted = apply(&bradford(white, RgbSpace::Srgb.white_xyz())?, xyz(&share));
        Ok(Colour(apply(&RgbSpace::Srgb.from_xyz(), adapted)))
    }

    /// A material's colour under D65: behind `mm` of it by Beer's law alone, of a crystal the mean of its axes, or reflected
    /// by a metal at normal incidence.
    pub fn of_material(material: &Material, mm: f64) -> Result<Self, Error> {
        Colour::of(&Illuminant::D65, |nm| {
            if material.is_conductor() {
                return conductor(1.0, 1.0, material.index(nm), material.extinction(nm)).reflectance_s;
            }
            material.absorptions(nm).map(|alpha| (-alpha * mm).exp()).iter().sum::<f64>() / 3.0
        })
    }

    /// Encoded sRGB; what is outside keeps its hue.
    pub fn srgb(&self) -> [u8; 3] {
        let shown = ViewTransform::new(Tone::Hue, RgbSpace::Srgb).shown(self.0);
        shown.map(|c| (srgb_encode(c.clamp(0.0, 1.0)) * 255.0).round() as u8)
    }

    /// The same as `#rrggbb`.
    pub fn hex(&self) -> String {
        let [r, g, b] = self.srgb();
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}
