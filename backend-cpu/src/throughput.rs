//! What a path carries from event to event, a wavelength a lane: a Stokes row with its frame, or one number. The twin of
//! `spectral_core::stokes`, with selections in place of branches.

use crate::incidence::{Incidence, Reflection};
use accel::lanes::{Lanes, Row, Triple};
use spectral_core::stokes::any_axis;

/// The throughput of the wavelengths along a path.
pub(crate) trait Throughput<V: Lanes>: Copy {
    /// After entering: the mean of the transmittances, half their difference (s less p), and the axis e_s.
    fn entering(mean: V, half: V, axis: &[Row; 3]) -> Self;
    /// What arrives of unpolarised light of intensity 1.
    fn intensity(&self) -> V;
    /// Times a number.
    fn scaled(self, factor: V) -> Self;
    /// At the eye; `axis` is a unit vector perpendicular to the ray.
    fn eye(axis: Triple<V>) -> Self;
    /// The reflected and the refracted share.
    fn split(self, direction: Triple<V>, normal: Triple<V>, incidence: &Incidence<V>) -> [Self; 2];
    /// What is reflected by something opaque.
    fn mirrored(self, direction: Triple<V>, normal: Triple<V>, reflection: &Reflection<V>) -> Self;
    /// The reflected share, and the intensity of the refracted one (0 where reflection is total).
    fn reflected(self, direction: Triple<V>, normal: Triple<V>, incidence: &Incidence<V>) -> (Self, V);
}

/// What a row and the first axis of its frame take in memory.
pub(crate) type Rows = [Row; 7];

/// A throughput that may lie in memory.
pub(crate) trait Stored<V: Lanes>: Throughput<V> {
    fn load(rows: &Rows) -> Self;
    fn stored(&self) -> Rows;
}

/// Unpolarised at every event: the mean of s and p.
#[derive(Clone, Copy)]
pub(crate) struct Mean<V>(V);

impl<V: Lanes> Throughput<V> for Mean<V> {
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
    fn reflected(self, _direction: Triple<V>, _normal: Triple<V>, at: &Incidence<V>) -> (Self, V) {
        let reflectance = at.reflectance();
        (Mean(self.0 * reflectance), self.0 * (V::splat(1.0) - reflectance))
    }

    #[inline(always)]
    fn eye(_axis: Triple<V>) -> Self {
        Mean(V::splat(1.0))
    }

    #[inline(always)]
    fn split(self, direction: Triple<V>, normal: Triple<V>, at: &Incidence<V>) -> [Self; 2] {
        let (reflected, through) = self.reflected(direction, normal, at);
        [reflected, Mean(through)]
    }

    #[inline(always)]
    fn mirrored(self, _direction: Triple<V>, _normal: Triple<V>, reflection: &Reflection<V>) -> Self {
        Mean(self.0 * reflection.mean)
    }
}

impl<V: Lanes> Stored<V> for Mean<V> {
    #[inline(always)]
    fn load(rows: &Rows) -> Self {
        Mean(V::load(&rows[0]))
    }

    #[inline(always)]
    fn stored(&self) -> Rows {
        let mut rows = Rows::default();
        rows[0] = self.0.stored();
        rows
    }
}

/// A Stokes row and the first axis of its frame.
#[derive(Clone, Copy)]
pub(crate) struct Polarized<V> {
    pub row: [V; 4],
    pub axis: Triple<V>,
}

impl<V: Lanes> Polarized<V> {
    /// In the frame of the plane of incidence, whose axis is e_s: `spectral_core::stokes::align`. One division
    /// serves the angle and, by its root, the axis.
    #[inline(always)]
    pub fn aligned(self, direction: Triple<V>, normal: Triple<V>) -> Self {
        let [i, q, u, v] = self.row;
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
        Polarized { row: [i, q.fma(cos2, u * sin2), q.fnma(sin2, u * cos2), v], axis }
    }

    /// Row · Mueller matrix, in the aligned frame.
    #[inline(always)]
    fn through(self, Reflection { mean, difference, re, im }: &Reflection<V>) -> Self {
        let [i, q, u, v] = self.row;
        let row = [
            i.fma(*mean, q * *difference),
            i.fma(*difference, q * *mean),
            u.fma(*re, v * *im),
            u.fnma(*im, v * *re),
        ];
        Polarized { row, ..self }
    }
}

impl<V: Lanes> Throughput<V> for Polarized<V> {
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
    fn reflected(self, direction: Triple<V>, normal: Triple<V>, at: &Incidence<V>) -> (Self, V) {
        let aligned = self.aligned(direction, normal);
        let reflection = at.reflection();
        let [i, q, _, _] = aligned.row;
        let leaving = q.fnma(reflection.difference, i * (V::splat(1.0) - reflection.mean));
        (aligned.through(&reflection), leaving)
    }

    #[inline(always)]
    fn eye(axis: Triple<V>) -> Self {
        let zero = V::splat(0.0);
        Polarized { row: [V::splat(1.0), zero, zero, zero], axis }
    }

    #[inline(always)]
    fn split(self, direction: Triple<V>, normal: Triple<V>, at: &Incidence<V>) -> [Self; 2] {
        let (one, zero) = (V::splat(1.0), V::splat(0.0));
        let aligned = self.aligned(direction, normal);
        let reflection = at.reflection();
        let mean = one - reflection.mean;
        let (s, p) = (mean - reflection.difference, mean + reflection.difference);
        let re = (s.max(zero) * p.max(zero)).sqrt();
        let refraction = Reflection { mean, difference: -reflection.difference, re, im: zero };
        [aligned.through(&reflection), aligned.through(&refraction)]
    }

    #[inline(always)]
    fn mirrored(self, direction: Triple<V>, normal: Triple<V>, reflection: &Reflection<V>) -> Self {
        self.aligned(direction, normal).through(reflection)
    }
}

impl<V: Lanes> Stored<V> for Polarized<V> {
    #[inline(always)]
    fn load([i, q, u, v, x, y, z]: &Rows) -> Self {
        let axis = Triple { x: V::load(x), y: V::load(y), z: V::load(z) };
        Polarized { row: [V::load(i), V::load(q), V::load(u), V::load(v)], axis }
    }

    #[inline(always)]
    fn stored(&self) -> Rows {
        let ([i, q, u, v], [x, y, z]) = (self.row, self.axis.stored());
        [i.stored(), q.stored(), u.stored(), v.stored(), x, y, z]
    }
}

/// The first axis of a camera ray's frame once it has met a surface: perpendicular to the plane of incidence.
pub(crate) fn first_axis(direction: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
    spectral_core::stokes::align(direction, any_axis(direction), normal).axis
}
