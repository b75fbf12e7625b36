//! The colour of a piece of a material.

use gemtrace::Error;
use spectral_core::cie::Illuminant;
use spectral_core::color::{Response, srgb_encode};
use spectral_core::fresnel::conductor;
use spectral_core::material::Material;
use spectral_core::wavelength::WavelengthGrid;

/// Thickness of the slab that is looked through, mm.
const THICKNESS: f64 = 5.0;

/// What the colour of something to look through is the colour of, for people.
pub const TRANSMITTED: &str = "sRGB, D65 through 5 mm, surfaces left out";
/// What the colour of a metal is.
pub const REFLECTED: &str = "sRGB, D65 reflected at normal incidence";

/// A material's colour under D65.
pub struct Appearance {
    /// Linear sRGB; components outside 0–1 are outside the space.
    pub linear: [f64; 3],
    /// Which light this is: [`TRANSMITTED`] or [`REFLECTED`].
    pub meaning: &'static str,
}

impl Appearance {
    /// The colour of D65 behind 5 mm of the material by Beer's law alone, or reflected by a metal at normal
    /// incidence; 380–780 nm in steps of 5 nm, CIE 1931 2°.
    pub fn of(material: &Material) -> Result<Self, Error> {
        let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0)?;
        let share = |nm: f64| {
            if material.is_conductor() {
                let fresnel = conductor(1.0, 1.0, material.index(nm), material.extinction(nm));
                return fresnel.reflectance_s;
            }
            (-material.absorption(nm) * THICKNESS).exp()
        };
        let light: Vec<f64> = grid.nm().iter().map(|&nm| Illuminant::D65.at(nm) * share(nm)).collect();
        let meaning = if material.is_conductor() { REFLECTED } else { TRANSMITTED };
        Ok(Appearance { linear: Response::new(&grid)?.to_linear_srgb(&light), meaning })
    }

    /// As `#rrggbb`, clipped to sRGB.
    pub fn hex(&self) -> String {
        let [r, g, b] = self.linear.map(|c| (srgb_encode(c.clamp(0.0, 1.0)) * 255.0).round() as u8);
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}
