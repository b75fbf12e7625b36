//! Rays that meet a surface, a wavelength a lane: the twin of `spectral_core::fresnel`, with selections in place of
//! branches.

use accel::lanes::{Lanes, Row, Triple, WIDTH};
use spectral_core::fresnel::conductor;

/// Rays that arrive at an interface between transparent media.
#[derive(Clone, Copy)]
pub(crate) struct Incidence<V: Lanes> {
    /// Cosine of the angle of incidence, in (0, 1].
    pub cos_i: V,
    /// Index of refraction on this side over that beyond.
    pub n: V,
    /// √|cos²θ₂|: the cosine of the angle of refraction, or κ of the evanescent wave.
    pub root: V,
    /// The lanes with total reflection.
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

    /// From air: as [`new`](Self::new), with the rounding errors of the products and of the constants added back. All
    /// that follows depends on this direction.
    #[inline(always)]
    pub fn entering(cosine: V, inverse: &[Row; 5]) -> Self {
        let [n, n2, one_less, n2_rest, one_less_rest] = inverse;
        let (n, n2, one_less) = (V::load(n), V::load(n2), V::load(one_less));
        let (n2_rest, one_less_rest) = (V::load(n2_rest), V::load(one_less_rest));
        let cos_i = cosine.min(V::splat(1.0)).max(V::splat(1e-12));
        let product = n2 * cos_i;
        let product_rest = n2_rest.fma(cos_i, n2.fma(cos_i, -product));
        let rest = product_rest.fma(cos_i, one_less_rest);
        let square = product * cos_i;
        let square_rest = product.fma(cos_i, -square);
        let sum = one_less + square;
        let sum_rest = square - (sum - one_less);
        let cos2_t = sum + (sum_rest + (square_rest + rest));
        let total = !V::splat(0.0).lt(cos2_t);
        Incidence { cos_i, n, root: cos2_t.abs().sqrt(), total }
    }

    /// Between media with the indices `n` here and `beyond`.
    #[inline(always)]
    pub fn between(cosine: V, n: V, beyond: V) -> Self {
        let ratio = n / beyond;
        Self::new(cosine, ratio, ratio * ratio, ratio.fnma(ratio, V::splat(1.0)))
    }

    /// The unit direction of rays that go through, `normal` pointing ahead; where reflection is total some other finite vector.
    #[inline(always)]
    pub fn refracted(&self, direction: Triple<V>, normal: Triple<V>) -> Triple<V> {
        let across = self.n * self.cos_i - self.root;
        direction.scaled(self.n).plus(normal.scaled(-across)).renormalized()
    }

    /// The unit direction of rays that stay.
    #[inline(always)]
    pub fn reflected(&self, direction: Triple<V>, normal: Triple<V>) -> Triple<V> {
        direction.plus(normal.scaled(-(self.cos_i + self.cos_i))).renormalized()
    }

    /// What is reflected, with the phases of total reflection.
    #[inline(always)]
    pub fn reflection(&self) -> Reflection<V> {
        let (one, zero, half) = (V::splat(1.0), V::splat(0.0), V::splat(0.5));
        // Total reflection turns the phase: tan(δ/2) = b/a (`fresnel::total`).
        let a = self.n * self.cos_i.fnma(self.cos_i, one);
        let b = self.root * self.cos_i;
        let inverse = one / V::select(self.total, a.fma(a, b * b), self.denominator());
        let [r_s, r_p] = self.amplitudes(inverse);
        let (s, p) = ((r_s * r_s).min(one), (r_p * r_p).min(one));
        Reflection {
            mean: V::select(self.total, one, (s + p) * half),
            difference: V::select(self.total, zero, (s - p) * half),
            re: V::select(self.total, b.fnma(b, a * a) * inverse, r_s * r_p),
            im: V::select(self.total, (a + a) * b * inverse, zero),
        }
    }

    /// The mean reflectance.
    #[inline(always)]
    pub fn reflectance(&self) -> V {
        let one = V::splat(1.0);
        let [r_s, r_p] = self.amplitudes(one / self.denominator());
        let mean = (r_s.fma(r_s, r_p * r_p) * V::splat(0.5)).min(one);
        V::select(self.total, one, mean)
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

/// What a reflection does to a Stokes row: half the sum and half the difference of the powers of s and p, and the
/// product of the amplitudes r_s and r_p*.
#[derive(Clone, Copy)]
pub(crate) struct Reflection<V> {
    pub mean: V,
    pub difference: V,
    pub re: V,
    pub im: V,
}

impl<V: Lanes> Reflection<V> {
    /// At a metal with the index n + ik, from a medium with the index `here`. Metals are rare, so the core computes
    /// lane by lane.
    #[inline(never)]
    pub fn metal(cosine: &Row, here: &Row, n: &Row, k: &Row) -> [Row; 4] {
        let mut rows = [Row::default(); 4];
        for lane in 0..WIDTH {
            let event = conductor(cosine.0[lane], here.0[lane], n.0[lane], k.0[lane]);
            rows[0].0[lane] = event.reflectance();
            rows[1].0[lane] = (event.reflectance_s - event.reflectance_p) * 0.5;
            [rows[2].0[lane], rows[3].0[lane]] = event.reflected_cross;
        }
        rows
    }

    /// From memory.
    #[inline(always)]
    pub fn load([mean, difference, re, im]: &[Row; 4]) -> Self {
        Reflection { mean: V::load(mean), difference: V::load(difference), re: V::load(re), im: V::load(im) }
    }
}
