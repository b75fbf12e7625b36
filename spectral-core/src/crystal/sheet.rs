//! The two sheets of the surface of wave vectors, and how rays turn on them.

use super::{Biaxial, Crystal, Form, Uniaxial, Wave, vector::Real3};
use crate::color::matrix::dot;

/// Nearer than this to an optic axis of a biaxial crystal, |a × N|, rays turn as they do there: on the axis itself they lie on a
/// cone, and there is no derivative.
const FROM_AXIS: f64 = 1e-3;

impl Crystal {
    /// The sheet of a wave: 0 for the ordinary wave or the smaller index, 1 for the other. `place` is its place in the list of
    /// [`waves`](Self::waves), which decides for a uniaxial crystal.
    pub fn sheet(&self, place: usize, wave: &Wave) -> usize {
        match self.form() {
            Form::Uniaxial(_) => place,
            Form::Biaxial(_) => {
                let index = wave.index();
                let [fast, slow] = self.indices_along(wave.wave_vector().map(|x| x / index));
                usize::from((fast - index).abs() > (slow - index).abs())
            }
        }
    }

    /// ½∇G of a sheet G(N) = 1 at the wave vector N = k/k₀. It is along the ray, and N·½∇G = G, since G is homogeneous of degree 2
    /// (Born & Wolf, *Principles of Optics*, §15.2–3):
    ///
    /// ```text
    /// ordinary   G = N²/ε_o                extraordinary   G = N·εN/(ε_o ε_e)
    /// biaxial    G = A N² + B[(a₁·N)(a₂·N) ± |a₁×N||a₂×N|]
    /// ```
    pub fn gradient(&self, sheet: usize, vector: [f64; 3]) -> [f64; 3] {
        self.turned(sheet, vector, vector).0
    }

    /// How the ray of a wave vector N of a sheet turns as N changes by `by`: the derivative of its unit vector, per unit of `by`.
    /// Within 10⁻³ of an optic axis of a biaxial crystal it is that at this distance: on the axis there is none.
    ///
    /// ```
    /// use spectral_core::crystal::Crystal;
    /// let calcite = Crystal::uniaxial([1.65835, 1.48640], [0.6, 0.0, 0.8]);
    /// let ray = |q: f64| calcite.waves([q, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0)[1];
    /// let [before, here, after] = [0.3 - 1e-5, 0.3, 0.3 + 1e-5].map(ray);
    /// let by = [0, 1, 2].map(|i| (after.wave_vector()[i] - before.wave_vector()[i]) / 2e-5);
    /// let turn = calcite.ray_by(1, here.wave_vector(), by);
    /// assert!((turn[0] - (after.ray()[0] - before.ray()[0]) / 2e-5).abs() < 1e-8);
    /// ```
    pub fn ray_by(&self, sheet: usize, vector: [f64; 3], by: [f64; 3]) -> [f64; 3] {
        let (gradient, turned) = self.turned(sheet, vector, by);
        let size = dot(gradient, gradient);
        let along = dot(gradient, turned) / size;
        std::array::from_fn(|i| (turned[i] - along * gradient[i]) / size.sqrt())
    }

    /// ½∇G and its change.
    fn turned(&self, sheet: usize, vector: Real3, by: Real3) -> (Real3, Real3) {
        match (self.form(), sheet) {
            (Form::Uniaxial(Uniaxial { ordinary, .. }), 0) => {
                (vector.map(|x| x / ordinary), by.map(|x| x / ordinary))
            }
            (Form::Uniaxial(Uniaxial { ordinary, difference, axis }), _) => {
                let product = ordinary * (ordinary + difference);
                let of = |v: Real3| {
                    let share = difference * dot(*axis, v);
                    std::array::from_fn(|i| (ordinary * v[i] + share * axis[i]) / product)
                };
                (of(vector), of(by))
            }
            (Form::Biaxial(biaxial), sheet) => {
                biaxial.turned(if sheet == 0 { 1.0 } else { -1.0 }, vector, by)
            }
        }
    }
}

impl Biaxial {
    /// With P = N − (a·N)a and r = |a × N| = |P|, ∇r = P/r and ρ = r₂/r₁, half the gradient of r₁r₂ is ½(ρP₁ + P₂/ρ).
    fn turned(&self, sign: f64, vector: Real3, by: Real3) -> (Real3, Real3) {
        let [a, b] = self.sheet;
        let [one, two] = self.optic;
        let across = |axis: Real3, v: Real3| -> Real3 {
            let along = dot(axis, v);
            std::array::from_fn(|i| v[i] - along * axis[i])
        };
        let (p, p_by) =
            (self.optic.map(|axis| across(axis, vector)), self.optic.map(|axis| across(axis, by)));
        let square = p.map(|p| dot(p, p).max(FROM_AXIS * FROM_AXIS));
        let ratio = (square[1] / square[0]).sqrt();
        let ratio_by = ratio * (dot(p[1], by) / square[1] - dot(p[0], by) / square[0]);
        let inverse_by = -ratio_by / (ratio * ratio);
        let both = |v: Real3| -> Real3 {
            let along = [dot(one, v), dot(two, v)];
            std::array::from_fn(|i| a * v[i] + 0.5 * b * (one[i] * along[1] + two[i] * along[0]))
        };
        let (gradient, turned, half) = (both(vector), both(by), 0.5 * b * sign);
        let cone = |i: usize| ratio * p[0][i] + p[1][i] / ratio;
        let cone_by =
            |i: usize| ratio_by * p[0][i] + ratio * p_by[0][i] + inverse_by * p[1][i] + p_by[1][i] / ratio;
        (
            std::array::from_fn(|i| gradient[i] + half * cone(i)),
            std::array::from_fn(|i| turned[i] + half * cone_by(i)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_along_the_gradient_and_turn_as_finite_differences_say() {
        const STEP: f64 = 1e-5;
        let third = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
        let axes = [[1.0 / 3.0, -2.0 / 3.0, -2.0 / 3.0], [2.0 / 3.0, 2.0 / 3.0, -1.0 / 3.0], third];
        let crystals = [
            Crystal::uniaxial([1.65835, 1.48640], third),
            Crystal::uniaxial([1.92, 1.98], third),
            Crystal::new([1.654, 1.672, 1.690], axes),
            Crystal::new([1.5, 1.9, 1.6], axes),
        ];
        let (n, direction) = ([0.0, 0.0, 1.0], [0.6, 0.8, 0.0]);
        for crystal in crystals {
            for (q, side) in [(0.2, 1.0), (0.7, -1.0), (1.1, 1.0)] {
                let waves = |q: f64| crystal.waves(direction.map(|x| x * q), n, side);
                let (before, here, after) = (waves(q - STEP), waves(q), waves(q + STEP));
                for place in 0..2 {
                    let slope = |of: fn(&Wave) -> Real3| -> Real3 {
                        let (a, b) = (of(&before[place]), of(&after[place]));
                        std::array::from_fn(|i| (b[i] - a[i]) / (2.0 * STEP))
                    };
                    let wave = &here[place];
                    let sheet = crystal.sheet(place, wave);
                    assert_eq!(sheet, place);
                    let gradient = crystal.gradient(sheet, wave.wave_vector());
                    assert!((dot(gradient, wave.wave_vector()) - 1.0).abs() < 1e-12);
                    let turned = crystal.ray_by(sheet, wave.wave_vector(), slope(Wave::wave_vector));
                    let size = dot(gradient, gradient).sqrt();
                    for i in 0..3 {
                        assert!((gradient[i] / size - wave.ray()[i]).abs() < 1e-12);
                        assert!((turned[i] - slope(Wave::ray)[i]).abs() < 1e-6, "{turned:?}");
                    }
                }
            }
        }
    }
}
