//! A plane wave in a crystal or beside one.

use super::vector::{Complex3, Real3, complex, cross_complex, norm_sqr, plus_complex, real, unit};
use crate::color::matrix::{cross, dot};
use num_complex::Complex64;

/// A plane wave: its wave vector and its fields, up to a common factor.
///
/// Fields are exp(i k₀ N·r) with μ₀ = ε₀ = c = 1, so N × E = H and N × H = −εE (Born & Wolf, *Principles of Optics*,
/// §15.2). N, E and H of a wave that propagates are real; of an evanescent one they are complex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// N = k/k₀: its length is the index that the wave sees.
    pub normal: [Complex64; 3],
    /// E.
    pub electric: [Complex64; 3],
    /// H.
    pub magnetic: [Complex64; 3],
    /// Re(E × H*)·n: power through the surface whose normal n the wave was made for, above 0 along n; exactly 0 for an
    /// evanescent wave.
    pub flux: f64,
}

impl Wave {
    /// A wave with real fields.
    pub(super) fn propagating(normal: Real3, electric: Real3, magnetic: Real3, surface: Real3) -> Self {
        let flux = dot(cross(electric, magnetic), surface);
        Wave { normal: complex(normal), electric: complex(electric), magnetic: complex(magnetic), flux }
    }

    /// A wave that carries nothing through the surface. Its fields are scaled to |E| = 1.
    pub(super) fn evanescent(normal: Complex3, electric: Complex3, magnetic: Complex3) -> Self {
        let scale = norm_sqr(&electric).sqrt().recip();
        let [electric, magnetic] = [electric, magnetic].map(|field| field.map(|x| x * scale));
        Wave { normal, electric, magnetic, flux: 0.0 }
    }

    /// A wave by its N and E alone.
    pub(super) fn by_field(normal: Complex3, electric: Complex3, surface: Real3, propagates: bool) -> Self {
        if propagates {
            let (normal, electric) = (real(&normal), real(&electric));
            return Wave::propagating(normal, electric, cross(normal, electric), surface);
        }
        Wave::evanescent(normal, electric, cross_complex(&normal, &electric))
    }

    /// Whether it carries power through its surface.
    pub fn propagates(&self) -> bool {
        self.flux != 0.0
    }

    /// The unit vector along which a propagating wave carries its power: that of Poynting's vector E × H.
    pub fn ray(&self) -> [f64; 3] {
        unit(self.poynting())
    }

    /// N of a propagating wave.
    pub fn wave_vector(&self) -> [f64; 3] {
        real(&self.normal)
    }

    /// |N| of a propagating wave.
    pub fn index(&self) -> f64 {
        let normal = self.wave_vector();
        dot(normal, normal).sqrt()
    }

    /// The angle between wave vector and ray, radians: the walk-off.
    ///
    /// ```
    /// use spectral_core::crystal::Crystal;
    /// // Calcite at 589.3 nm; light straight through a surface 41.870° from the axis, the most there is.
    /// let (sin, cos) = 41.870_f64.to_radians().sin_cos();
    /// let calcite = Crystal::uniaxial([1.65835, 1.48640], [sin, 0.0, cos]);
    /// let [o, e] = calcite.waves([0.0; 3], [0.0, 0.0, 1.0], 1.0);
    /// let degrees = [o, e].map(|wave| wave.walk_off().to_degrees());
    /// println!("o walks off by {:.4}°, e by {:.4}°", degrees[0], degrees[1]);
    /// assert!(degrees[0] < 1e-6 && (degrees[1] - 6.259454).abs() < 1e-6);
    /// ```
    pub fn walk_off(&self) -> f64 {
        let (normal, ray) = (self.wave_vector(), self.ray());
        let across = cross(normal, ray);
        dot(across, across).sqrt().atan2(dot(normal, ray))
    }

    fn poynting(&self) -> Real3 {
        cross(real(&self.electric), real(&self.magnetic))
    }

    /// Poynting's vector against another surface: the same wave with its flux through it.
    #[must_use]
    pub fn at(mut self, surface: [f64; 3]) -> Self {
        self.flux = dot(self.poynting(), surface);
        self
    }

    /// This wave with `factor` times another's fields added.
    pub(super) fn plus(mut self, factor: f64, other: &Wave, surface: Real3) -> Self {
        let factor = Complex64::from(factor);
        self.electric = plus_complex(&self.electric, factor, &other.electric);
        self.magnetic = plus_complex(&self.magnetic, factor, &other.magnetic);
        self.at(surface)
    }
}
