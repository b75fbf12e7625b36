//! The CIE 1931 2° standard observer and the illuminants.
//!
//! The eye is described by three colour-matching functions, x̄, ȳ and z̄: light of spectral radiance L(λ) has the
//! tristimulus values X = ∫ x̄ L dλ, Y = ∫ ȳ L dλ (luminance) and Z = ∫ z̄ L dλ. Illuminants are relative spectra. Here each
//! is scaled to the luminance of the flat spectrum 1,
//!
//! > Σ ȳ(λ) I(λ) = Σ ȳ(λ)  over λ = 380, 381, …, 780 nm,
//!
//! so E is 1 everywhere, and another illuminant does not change the exposure of a picture.
//!
//! Tables: CIE 1931 colour-matching functions, 2° observer (DOI 10.25039/CIE.DS.xvudnb9b), and CIE standard illuminant D65
//! (DOI 10.25039/CIE.DS.hjfjmt59), both at 1 nm, CC BY-SA 4.0, in `data/cie`. They are interpolated linearly, as the CIE
//! prescribes.

use std::sync::LazyLock;

use crate::Error;
use crate::spectrum::{Ends, Tabulated, columns};
use crate::wavelength::WavelengthGrid;

/// First and last wavelength (nm) of the sum that determines an illuminant's scale, in steps of 1 nm.
const SCALE_RANGE: [u16; 2] = [380, 780];

/// The embedded CIE tables.
struct Tables {
    matching: [Tabulated; 3],
    d65: Tabulated,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let matching = embedded::<4>(include_str!("../data/cie/cie1931_2deg_1nm.csv"));
    let [nm, x, y, z] = matching;
    let [d65_nm, d65] = embedded::<2>(include_str!("../data/cie/d65_1nm.csv"));
    let table = |nm: &Vec<f64>, values, ends| {
        Tabulated::new(nm.clone(), values, ends).expect("the embedded CIE tables are valid")
    };
    let matching = [x, y, z].map(|values| table(&nm, values, Ends::Zero));
    let d65 = table(&d65_nm, d65, Ends::Extend);
    let scale = equal_luminance_scale(&matching[1], |nm| d65.at(nm));
    Tables { matching, d65: d65.scaled(scale) }
});

/// The scale that gives illuminant A the luminance of the flat spectrum.
static A_SCALE: LazyLock<f64> = LazyLock::new(|| equal_luminance_scale(&TABLES.matching[1], planck_2848));

/// The columns of an embedded table.
fn embedded<const N: usize>(text: &str) -> [Vec<f64>; N] {
    let rows = columns::<N>(text, "CIE table").expect("the embedded CIE tables parse");
    std::array::from_fn(|column| rows.iter().map(|(_, row)| row[column]).collect())
}

/// Σȳ over the 1 nm table: the luminance of the flat spectrum 1 in nm.
pub(crate) fn luminous_integral() -> f64 {
    let [first, last] = SCALE_RANGE;
    (first..=last).map(|nm| TABLES.matching[1].at(f64::from(nm))).sum()
}

/// Σȳ / Σȳ·light over the 1 nm table.
fn equal_luminance_scale(y_bar: &Tabulated, light: impl Fn(f64) -> f64) -> f64 {
    let [first, last] = SCALE_RANGE;
    let sum = |f: &dyn Fn(f64) -> f64| (first..=last).map(|nm| f(f64::from(nm))).sum::<f64>();
    sum(&|nm| y_bar.at(nm)) / sum(&|nm| y_bar.at(nm) * light(nm))
}

/// Illuminant A's shape: Planck's law at 2848 K with c₂ = 1.435·10⁷ nm·K, relative to 560 nm (CIE 15:2018,
/// equation 1; the temperature is called 2856 K on today's scale).
fn planck_2848(nm: f64) -> f64 {
    let exponent = |nm: f64| (1.435e7 / (2848.0 * nm)).exp_m1();
    (560.0 / nm).powi(5) * exponent(560.0) / exponent(nm)
}

/// The CIE 1931 2° colour-matching functions [x̄, ȳ, z̄] at a wavelength in nm; zero outside 360–830 nm.
///
/// ```
/// let [_, y, _] = spectral_core::cie::color_matching(555.0);
/// assert_eq!(y, 1.0);
/// ```
pub fn color_matching(nm: f64) -> [f64; 3] {
    TABLES.matching.each_ref().map(|table| table.at(nm))
}

/// A light whose relative spectrum is known, scaled to the luminance of the flat spectrum 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Illuminant {
    /// Average daylight, about 6500 K: the white of sRGB.
    #[default]
    D65,
    /// Incandescent light, 2856 K.
    A,
    /// The equal-energy spectrum: 1 at every wavelength.
    E,
    /// A measured light; made with [`Illuminant::table`].
    Table(MeasuredLight),
}

/// A measured light that was checked and scaled by [`Illuminant::table`].
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredLight(Tabulated);

impl Illuminant {
    /// The names of illuminants.
    pub const NAMES: [&'static str; 3] = ["D65", "A", "E"];

    /// The illuminant of a name, in either case.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing [`NAMES`](Self::NAMES).
    pub fn by_name(name: &str) -> Result<Self, Error> {
        match name.to_ascii_uppercase().as_str() {
            "D65" => Ok(Illuminant::D65),
            "A" => Ok(Illuminant::A),
            "E" => Ok(Illuminant::E),
            _ => Err(Error::unknown("illuminant", name, Self::NAMES)),
        }
    }

    /// A measured light: relative spectral power on any scale, which is then normalised like the others.
    ///
    /// # Errors
    /// [`Error::Value`] for a negative entry or a light without luminance.
    pub fn table(light: Tabulated) -> Result<Self, Error> {
        if let Some((nm, value)) = light.nm().iter().zip(light.values()).find(|(_, value)| **value < 0.0) {
            return Err(Error::value(format!("illuminant at {nm} nm"), value, "a light cannot be negative"));
        }
        let scale = equal_luminance_scale(&TABLES.matching[1], |nm| light.at(nm));
        if !(scale.is_finite() && scale > 0.0) {
            let expected = "it needs finite, visible light between 380 and 780 nm";
            return Err(Error::value("illuminant", "no luminance", expected));
        }
        Ok(Illuminant::Table(MeasuredLight(light.scaled(scale))))
    }

    /// The relative spectral radiance at a wavelength in nm, scaled so that Σȳ·I = Σȳ.
    ///
    /// Outside its table (300–830 nm) D65 has the value of the nearer end, so it is positive everywhere.
    pub fn at(&self, nm: f64) -> f64 {
        match self {
            Illuminant::D65 => TABLES.d65.at(nm),
            Illuminant::A => planck_2848(nm) * *A_SCALE,
            Illuminant::E => 1.0,
            Illuminant::Table(MeasuredLight(table)) => table.at(nm),
        }
    }

    /// [`at`](Self::at) every wavelength of a grid, in its order.
    pub fn sample(&self, grid: &WavelengthGrid) -> Vec<f64> {
        grid.nm().iter().map(|&nm| self.at(nm)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_hold_the_published_figures() {
        assert_eq!(color_matching(360.0), [0.000_129_9, 0.000_003_917, 0.000_606_1]);
        assert_eq!(color_matching(359.9), [0.0; 3]);
        assert_eq!(color_matching(830.1), [0.0; 3]);
        // D65 is 100 at 560 nm and 117.008 at 450 nm (CIE S 014-2).
        assert!((Illuminant::D65.at(450.0) / Illuminant::D65.at(560.0) - 1.170_08).abs() < 1e-12);
        assert!(Illuminant::D65.at(250.0) > 0.0 && Illuminant::D65.at(2000.0) > 0.0);
    }

    #[test]
    fn every_illuminant_is_as_luminous_as_the_flat_one() {
        let ramp = Tabulated::new(vec![400.0, 700.0], vec![1.0, 9.0], Ends::Extend).unwrap();
        let table = Illuminant::table(ramp).unwrap();
        for light in [Illuminant::D65, Illuminant::A, Illuminant::E, table] {
            let sums = (380..=780).map(f64::from).fold((0.0, 0.0), |(flat, lit), nm| {
                let y = color_matching(nm)[1];
                (flat + y, lit + y * light.at(nm))
            });
            assert!((sums.1 / sums.0 - 1.0).abs() < 1e-14, "{light:?}");
        }
        assert_eq!(Illuminant::E.at(432.1), 1.0);
    }

    #[test]
    fn published_chromaticities() {
        // CIE 15:2018, table T.3: 1931 observer, summed every 5 nm over 380–780 nm, rounded to five places.
        let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0).unwrap();
        for (light, x, y) in [
            (Illuminant::A, 0.447_58, 0.407_45),
            (Illuminant::D65, 0.312_72, 0.329_03),
            (Illuminant::E, 0.333_33, 0.333_33),
        ] {
            let mut xyz = [0.0; 3];
            for &nm in grid.nm() {
                xyz.iter_mut().zip(color_matching(nm)).for_each(|(s, bar)| *s += bar * light.at(nm));
            }
            let sum: f64 = xyz.iter().sum();
            let (found_x, found_y) = (xyz[0] / sum, xyz[1] / sum);
            assert!(
                (found_x - x).abs() <= 5e-6 && (found_y - y).abs() <= 5e-6,
                "{light:?} {found_x} {found_y}"
            );
        }
    }

    #[test]
    fn bad_lights_and_names_are_refused() {
        let message = Illuminant::by_name("D50").unwrap_err().to_string();
        assert_eq!(message, "unknown illuminant 'D50'; valid: D65, A, E");
        assert_eq!(Illuminant::by_name("d65").unwrap(), Illuminant::D65);
        let dark = Tabulated::new(vec![900.0, 950.0], vec![1.0, 1.0], Ends::Zero).unwrap();
        assert!(Illuminant::table(dark).unwrap_err().to_string().contains("no luminance"));
        let negative = Tabulated::new(vec![500.0, 550.0], vec![1.0, -1.0], Ends::Zero).unwrap();
        assert!(Illuminant::table(negative).unwrap_err().to_string().contains("illuminant at 550 nm: -1"));
    }
}
