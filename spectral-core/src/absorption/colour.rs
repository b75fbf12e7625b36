//! The absorption that shows a colour through a thickness.
//!
//! The transmittance is a sigmoid of a parabola over the wavelength (Jakob & Hanika, "A Low-Dimensional Function Space for
//! Efficient Spectral Upsampling", 2019): smooth, between 0 and 1, with three coefficients for the three figures of a colour. They
//! are found by the method of Levenberg and Marquardt in CIELAB, from grey on towards the colour.

use super::{Absorption, Term};
use crate::Error;
use crate::cie::Illuminant;
use crate::color::matrix::{Matrix, apply, inverse, product, transpose};
use crate::color::{Response, RgbSpace, delta_e_2000, lab};
use crate::spectrum::{Ends, Tabulated};
use crate::wavelength::WavelengthGrid;

/// What the eye sees, nm.
const RANGE: [f64; 2] = [360.0, 830.0];
/// From one row of the table to the next, nm.
const STEP: f64 = 5.0;
/// A colour that is missed by more (ΔE00) is one that absorption cannot show.
const CLOSE: f64 = 0.1;
/// Steps from grey to the colour, and rounds of the method at each; more at the last.
const STEPS: u32 = 16;
const ROUNDS: usize = 30;
const LAST_ROUNDS: usize = 300;

impl Absorption {
    /// The smooth absorption with which white light of `light` has the linear sRGB colour `rgb` after `mm` of the material.
    ///
    /// # Errors
    /// [`Error::Value`] for figures that are not finite, a thickness that is not positive, and a colour that no absorption
    /// shows, such as one brighter than the light; then with the nearest that is shown.
    ///
    /// ```
    /// use spectral_core::{absorption::Absorption, cie::Illuminant};
    /// let amber = Absorption::showing([0.8, 0.4, 0.1], 5.0, &Illuminant::D65)?;
    /// assert!(amber.coefficient(650.0) < amber.coefficient(450.0));
    /// assert!(Absorption::showing([1.2, 1.1, 1.1], 5.0, &Illuminant::D65).is_err()); // brighter than the light
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn showing(rgb: [f64; 3], mm: f64, light: &Illuminant) -> Result<Self, Error> {
        if !rgb.iter().all(|c| c.is_finite()) {
            return Err(Error::value(
                "color.rgb",
                format!("{rgb:?}"),
                "give three finite numbers, linear sRGB",
            ));
        }
        if !(mm.is_finite() && mm > 0.0) {
            return Err(Error::value("color.at", mm, "give a thickness above 0, in mm"));
        }
        let slab = Slab::new(light)?;
        let (curve, missed) = slab.fit(rgb);
        if missed > CLOSE {
            let nearest = slab.rgb(curve).map(|c| format!("{:.3}", c + 0.0)).join(", ");
            let expected = format!(
                "no absorption shows this colour; the nearest is rgb = [{nearest}], ΔE00 {missed:.1} from it"
            );
            return Err(Error::value("color.rgb", format!("{rgb:?}"), expected));
        }
        let count = ((RANGE[1] - RANGE[0]) / STEP) as usize;
        let nm: Vec<f64> = (0..=count).map(|k| RANGE[0] + STEP * k as f64).collect();
        let coefficients = nm.iter().map(|nm| -transmittance(curve, *nm).ln() / mm).collect();
        Absorption::new(vec![Term::Table(Tabulated::new(nm, coefficients, Ends::Extend)?)])
    }
}

/// The share of light that is transmitted: a sigmoid of c₀ + c₁t + c₂t², where t runs from −1 to 1 over the visible range.
fn transmittance([a, b, c]: [f64; 3], nm: f64) -> f64 {
    let t = (nm - 555.0) / 175.0;
    let x = a + t * (b + t * c);
    // ½ + x/(2√(1 + x²)), without loss of digits where it is small.
    if x >= 0.0 { 0.5 + 0.5 * x / x.hypot(1.0) } else { 0.5 / (x.hypot(1.0) * (x.hypot(1.0) - x)) }
}

/// A slab before white light.
struct Slab {
    nm: Vec<f64>,
    light: Vec<f64>,
    response: Response,
    white: [f64; 3],
}

impl Slab {
    fn new(light: &Illuminant) -> Result<Self, Error> {
        let grid = WavelengthGrid::stepped(RANGE[0], RANGE[1], 1.0)?;
        let response = Response::new(&grid)?;
        let nm = grid.nm().to_vec();
        Ok(Slab { light: light.sample(&grid), nm, response, white: RgbSpace::Srgb.white_xyz() })
    }

    fn xyz(&self, curve: [f64; 3]) -> [f64; 3] {
        let left = self.nm.iter().zip(&self.light).map(|(nm, light)| light * transmittance(curve, *nm));
        self.response.to_xyz(&left.collect::<Vec<f64>>())
    }

    fn rgb(&self, curve: [f64; 3]) -> [f64; 3] {
        apply(&RgbSpace::Srgb.from_xyz(), self.xyz(curve))
    }

    fn lab(&self, curve: [f64; 3]) -> [f64; 3] {
        lab(self.xyz(curve), self.white)
    }

    /// The curve whose colour is nearest, and ΔE00 between them.
    fn fit(&self, rgb: [f64; 3]) -> ([f64; 3], f64) {
        let wanted = lab(apply(&RgbSpace::Srgb.to_xyz(), rgb), self.white);
        let mut curve = [0.0; 3];
        let start = self.lab(curve);
        for step in 1..=STEPS {
            let share = f64::from(step) / f64::from(STEPS);
            let goal = std::array::from_fn(|k| start[k] + share * (wanted[k] - start[k]));
            curve = self.approach(curve, goal, if step == STEPS { LAST_ROUNDS } else { ROUNDS });
        }
        (curve, delta_e_2000(self.lab(curve), wanted))
    }

    fn approach(&self, mut curve: [f64; 3], goal: [f64; 3], rounds: usize) -> [f64; 3] {
        let off = |curve: [f64; 3]| {
            let found = self.lab(curve);
            std::array::from_fn::<f64, 3, _>(|k| found[k] - goal[k])
        };
        let square = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
        let (mut now, mut damping) = (off(curve), 1e-3);
        for _ in 0..rounds {
            if square(now) < 1e-10 {
                break;
            }
            let columns: Matrix = std::array::from_fn(|k| {
                let step = 1e-6 * (1.0 + curve[k].abs());
                let mut beside = curve;
                beside[k] += step;
                let there = off(beside);
                std::array::from_fn(|i| (there[i] - now[i]) / step)
            });
            let mut normal = product(&columns, &transpose(&columns));
            (0..3).for_each(|k| normal[k][k] += damping * (normal[k][k] + 1e-9));
            let Some(solved) = inverse(&normal) else { break };
            let change = apply(&solved, apply(&columns, now));
            let next: [f64; 3] = std::array::from_fn(|k| curve[k] - change[k]);
            let there = off(next);
            if square(there) < square(now) {
                (curve, now, damping) = (next, there, (damping * 0.3).max(1e-12));
            } else {
                damping *= 4.0;
            }
        }
        curve
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_come_back_through_their_thickness() {
        let grid = WavelengthGrid::stepped(380.0, 780.0, 1.0).unwrap();
        let response = Response::new(&grid).unwrap();
        let white = RgbSpace::Srgb.white_xyz();
        let colours = [
            [0.9; 3],
            [0.02; 3],
            [0.5, 0.02, 0.05],
            [0.02, 0.05, 0.4],
            [0.03, 0.4, 0.1],
            [0.8, 0.7, 0.1],
            [0.3, 0.05, 0.5],
            [0.6, 0.8, 0.9],
        ];
        for (rgb, mm) in colours.iter().flat_map(|rgb| [1.0, 12.0].map(|mm| (*rgb, mm))) {
            let absorption = Absorption::showing(rgb, mm, &Illuminant::D65).unwrap();
            let left: Vec<f64> = Illuminant::D65
                .sample(&grid)
                .iter()
                .zip(grid.nm())
                .map(|(light, nm)| light * absorption.transmittance(*nm, mm))
                .collect();
            let wanted = lab(apply(&RgbSpace::Srgb.to_xyz(), rgb), white);
            let missed = delta_e_2000(lab(response.to_xyz(&left), white), wanted);
            assert!(missed < CLOSE, "{rgb:?} {mm}: {missed}");
        }
    }

    #[test]
    fn the_lamp_counts_and_what_cannot_be_shown_is_refused() {
        // Lamplight is orange in the picture: this is a grey filter.
        let lamp = Slab::new(&Illuminant::A).unwrap();
        let half = lamp.rgb([0.0; 3]);
        assert!(half[0] > half[2] && Absorption::showing(half, 3.0, &Illuminant::A).is_ok());
        for bad in [[1.5, 0.2, 0.2], [1.0, 1.0, 1.3], [-0.5, 0.6, 0.1]] {
            let message = Absorption::showing(bad, 3.0, &Illuminant::D65).unwrap_err().to_string();
            assert!(message.contains("the nearest is rgb = ["), "{message}");
        }
        assert!(Absorption::showing([0.5; 3], 0.0, &Illuminant::D65).is_err());
    }
}
