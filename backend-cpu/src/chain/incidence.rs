//! Rays meeting the surface from inside, a wavelength a lane: the twin of `spectral_core::fresnel` and of
//! `spectral_core::stokes`, with selections in place of branches.

use crate::lanes::{Lanes, Row, Triple};
use spectral_core::stokes::any_axis;

/// Rays that arrive at a surface from inside the stone.
#[derive(Clone, Copy)]
pub(crate) struct Incidence<V: Lanes> {
    /// Cosine of the angle of incidence, in (0, 1].
    pub cos_i: V,
    /// Index of refraction of the stone; air is outside.
    pub n: V,
    /// √|cos²θ₂|: the cosine of the angle of refraction, or κ of the evanescent wave.
    pub root: V,
    /// Where reflection is total.
    pub total: V::Mask,
}

impl<V: Lanes> Incidence<V> {
    /// From the cosine, n, n² and 1 − n².
    ///
    /// cos²θ₂ = n²·cos²θ₁ + (1 − n²) by one fused multiply-add, the difference having been taken in double
    /// precision when the table was made: near the critical angle the two cancel.
    #[inline(always)]
    pub fn new(cosine: V, n: V, n2: V, one_less_n2: V) -> Self {
        // Never 0: where n = 1, both cosines would be.
        let cos_i = cosine.min(V::splat(1.0)).max(V::splat(1e-12));
        let cos2_t = (n2 * cos_i).fma(cos_i, one_less_n2);
        let total = !V::splat(0.0).lt(cos2_t);
        Incidence { cos_i, n, root: cos2_t.abs().sqrt(), total }
    }

    /// The unit direction of rays that leave; where reflection is total some other finite vector.
    #[inline(always)]
    pub fn refracted(&self, direction: Triple<V>, normal: Triple<V>) -> Triple<V> {
        let across = self.n.fma(self.cos_i, -self.root);
        normal.fnma(across, direction.scaled(self.n)).renormalized()
    }

    /// The unit direction of rays that stay.
    #[inline(always)]
    pub fn reflected(&self, direction: Triple<V>, normal: Triple<V>) -> Triple<V> {
        normal.fnma(self.cos_i + self.cos_i, direction).renormalized()
    }

    /// Of unpolarised light where reflection is not total: the mean reflectance, the mean transmittance, and half
    /// the difference of the transmittances, s less p.
    #[inline(always)]
    pub fn shares(&self) -> [V; 3] {
        let (one, half) = (V::splat(1.0), V::splat(0.5));
        let [r_s, r_p] = self.amplitudes(one / self.denominator());
        let (s, p) = ((r_s * r_s).min(one), (r_p * r_p).min(one));
        let mean = (s + p) * half;
        [mean, one - mean, (p - s) * half]
    }

    /// The amplitudes r_s and r_p where reflection is not total, with `inverse` of [`Self::denominator`].
    #[inline(always)]
    fn amplitudes(&self, inverse: V) -> [V; 2] {
        let (c, t) = (self.cos_i, self.root);
        let (s_sum, s_difference) = (self.n.fma(c, t), self.n.fma(c, -t));
        let (p_sum, p_difference) = (self.n.fma(t, c), self.n.fnma(t, c));
        [s_difference * (inverse * p_sum), p_difference * (inverse * s_sum)]
    }

    /// The product of both amplitudes' denominators: one division serves both.
    #[inline(always)]
    fn denominator(&self) -> V {
        self.n.fma(self.cos_i, self.root) * self.n.fma(self.root, self.cos_i)
    }
}

/// What the wavelengths carry along a path inside the stone.
pub(crate) trait Flux<V: Lanes>: Copy {
    /// After entering: the mean of the transmittances, half their difference (s less p), and the axis e_s.
    fn entering(mean: V, half: V, axis: &[Row; 3]) -> Self;
    /// What arrives of unpolarised light of intensity 1.
    fn intensity(&self) -> V;
    /// Times a number.
    fn scaled(self, factor: V) -> Self;
    /// What is reflected, and the intensity of what leaves (0 where reflection is total).
    fn split(self, direction: Triple<V>, normal: Triple<V>, incidence: &Incidence<V>) -> (Self, V);
}

/// Unpolarised at every event: the mean of s and p.
#[derive(Clone, Copy)]
pub(crate) struct Mean<V>(V);

impl<V: Lanes> Flux<V> for Mean<V> {
    #[inline(always)]
    fn entering(mean: V, _half: V, _axis: &[Row; 3]) -> Self {
        Mean(mean)
    }

    #[inline(always)]
    fn intensity(&self) -> V {
        self.0
    }

    #[inline(always)]
    fn scaled(self, factor: V) -> Self {
        Mean(self.0 * factor)
    }

    #[inline(always)]
    fn split(self, _direction: Triple<V>, _normal: Triple<V>, at: &Incidence<V>) -> (Self, V) {
        let one = V::splat(1.0);
        let [r_s, r_p] = at.amplitudes(one / at.denominator());
        let reflectance = (r_s.fma(r_s, r_p * r_p) * V::splat(0.5)).min(one);
        let reflectance = V::select(at.total, one, reflectance);
        (Mean(self.0 * reflectance), self.0 * (one - reflectance))
    }
}

/// A Stokes row and the first axis of its frame.
#[derive(Clone, Copy)]
pub(crate) struct Polarized<V> {
    row: [V; 4],
    axis: Triple<V>,
}

impl<V: Lanes> Polarized<V> {
    /// Q and U in the frame of the plane of incidence, and its axis e_s: `spectral_core::stokes::align`. One
    /// division serves the angle and, by its root, the axis.
    #[inline(always)]
    fn aligned(&self, direction: Triple<V>, normal: Triple<V>) -> (V, V, Triple<V>) {
        let [_, q, u, _] = self.row;
        let s = direction.cross(normal);
        let cos = s.dot(self.axis);
        let sin = s.dot(self.axis.cross(direction));
        let norm = cos.fma(cos, sin * sin);
        // Within √ε of normal incidence s and p are the same, and s is rounding error.
        let turned = V::splat(f32::EPSILON).lt(norm);
        let inverse = V::splat(1.0) / norm.max(V::splat(f32::EPSILON));
        let cos2 = V::select(turned, sin.fnma(sin, cos * cos) * inverse, V::splat(1.0));
        let sin2 = V::select(turned, (cos + cos) * sin * inverse, V::splat(0.0));
        let axis = Triple::select(turned, s.scaled(inverse.sqrt()), self.axis);
        (q.fma(cos2, u * sin2), q.fnma(sin2, u * cos2), axis)
    }
}

impl<V: Lanes> Flux<V> for Polarized<V> {
    #[inline(always)]
    fn entering(mean: V, half: V, axis: &[Row; 3]) -> Self {
        let zero = V::splat(0.0);
        Polarized { row: [mean, half, zero, zero], axis: Triple::load(axis) }
    }

    #[inline(always)]
    fn intensity(&self) -> V {
        self.row[0]
    }

    #[inline(always)]
    fn scaled(self, factor: V) -> Self {
        let [i, q, u, v] = self.row;
        Polarized { row: [i * factor, q * factor, u * factor, v * factor], axis: self.axis }
    }

    #[inline(always)]
    fn split(self, direction: Triple<V>, normal: Triple<V>, at: &Incidence<V>) -> (Self, V) {
        let (one, zero, half) = (V::splat(1.0), V::splat(0.0), V::splat(0.5));
        let (q, u, axis) = self.aligned(direction, normal);
        let [i, _, _, v] = self.row;
        // Total reflection turns the phase: tan(δ/2) = b/a (`fresnel::total`).
        let a = at.n * at.cos_i.fnma(at.cos_i, one);
        let b = at.root * at.cos_i;
        let inverse = one / V::select(at.total, a.fma(a, b * b), at.denominator());
        let [r_s, r_p] = at.amplitudes(inverse);
        let (s, p) = ((r_s * r_s).min(one), (r_p * r_p).min(one));
        let mean = V::select(at.total, one, (s + p) * half);
        let difference = V::select(at.total, zero, (s - p) * half);
        let re = V::select(at.total, b.fnma(b, a * a) * inverse, r_s * r_p);
        let im = V::select(at.total, (a + a) * b * inverse, zero);
        let row =
            [i.fma(mean, q * difference), i.fma(difference, q * mean), u.fma(re, v * im), u.fnma(im, v * re)];
        let leaving = q.fnma(difference, i * (one - mean));
        (Polarized { row, axis }, leaving)
    }
}

/// The first axis of a camera ray's frame once it has met a surface: perpendicular to the plane of incidence.
pub(crate) fn first_axis(direction: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
    spectral_core::stokes::align(direction, any_axis(direction), normal).axis
}
