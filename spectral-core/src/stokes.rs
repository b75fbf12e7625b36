//! Polarised light: Stokes vectors, and the row that a renderer propagates backwards from the eye.
//!
//! # Definition
//! In the frame (e_s, e_p, k), e_p = k × e_s, with fields as exp(i(k·r − ωt)),
//!
//! ```text
//! I = |E_s|² + |E_p|²    Q = |E_s|² − |E_p|²    U = 2 Re(E_s E_p*)    V = 2 Im(E_s E_p*)
//! ```
//!
//! Light from a source with the Stokes column S passes the events Mₘ, …, M₂, M₁ (M₁ nearest to the eye) and reaches a
//! detector D with the intensity **D · M₁ · M₂ ⋯ Mₘ · S**. A tracer that starts at the eye meets M₁ first, so it carries the
//! row r = D · M₁ ⋯ and multiplies it by matrices on the right: four numbers, not sixteen (Wilkie & Weidlich 2012,
//! "Polarised light in computer graphics", §4). An eye sees intensity, D = (1, 0, 0, 0), and most lights are unpolarised,
//! S = (L, 0, 0, 0). Then the first component of the row is the throughput.
//!
//! # Why the mean of s and p is not enough
//! A reflection near Brewster's angle polarises light, and the next surface treats the two polarisations differently. With
//! the mean of s and p at each event (the scalar mode, [`Scalar`]) an N-BK7 slab at 75° has a transmittance of 0.592; the
//! exact value is 0.615.

use crate::Real;
use crate::color::matrix::{cross, dot};
use crate::fresnel::Fresnel;

/// The row (I, Q, U, V) propagated backwards from the eye; it multiplies the Stokes column of the light.
///
/// ```
/// use spectral_core::{fresnel::dielectric, stokes::StokesRow};
/// // Straight through a window: 1 − R at each face, (1 − R)/(1 + R) with all inner reflections.
/// let face = dielectric(1.0, 1.0 / 1.5);
/// let row = StokesRow::<f64>::eye().refracted(&face).refracted(&face);
/// assert!((row.intensity() - 0.96 * 0.96).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StokesRow<T>(pub [T; 4]);

impl<T: Real> StokesRow<T> {
    /// A detector of intensity alone: (1, 0, 0, 0).
    #[inline]
    pub fn eye() -> Self {
        StokesRow([T::ONE, T::ZERO, T::ZERO, T::ZERO])
    }

    /// The response to unpolarised light of intensity 1: the first component.
    #[inline]
    pub fn intensity(&self) -> T {
        self.0[0]
    }

    /// Every component times `factor`: absorption acts on all polarisations alike.
    #[inline]
    pub fn scaled(self, factor: T) -> Self {
        StokesRow(self.0.map(|x| x * factor))
    }

    /// The same detector described in a frame turned by φ, given cos 2φ and sin 2φ.
    ///
    /// φ counts from e_s towards e_p. A column transforms as Q′ = Q cos 2φ + U sin 2φ, U′ = −Q sin 2φ + U cos 2φ, and row ·
    /// column must not change. Since a rotation is orthogonal, the row transforms in the same way. The angle comes from
    /// [`align`].
    #[inline]
    pub fn rotated(self, cos2: T, sin2: T) -> Self {
        let [i, q, u, v] = self.0;
        StokesRow([i, q * cos2 + u * sin2, u * cos2 - q * sin2, v])
    }

    /// Row · Mueller matrix of a reflection; the frame's e_s must be perpendicular to the plane of incidence.
    #[inline]
    pub fn reflected(self, event: &Fresnel<T>) -> Self {
        let [re, im] = event.reflected_cross;
        self.through(event.reflectance_s, event.reflectance_p, re, im)
    }

    /// Row · Mueller matrix of a refraction; the frame's e_s must be perpendicular to the plane of incidence.
    #[inline]
    pub fn refracted(self, event: &Fresnel<T>) -> Self {
        self.through(event.transmittance_s, event.transmittance_p, event.refracted_cross, T::ZERO)
    }

    /// Row · matrix of an event with the powers `s` and `p` and the product of amplitudes `re` + i `im`.
    #[inline]
    fn through(self, s: T, p: T, re: T, im: T) -> Self {
        let [i, q, u, v] = self.0;
        let mean = (s + p) * T::HALF;
        let half = (s - p) * T::HALF;
        StokesRow([i * mean + q * half, i * half + q * mean, u * re + v * im, v * re - u * im])
    }
}

/// The throughput of the scalar mode: the mean of s and p at every event. Cheaper, but inexact: see the module's
/// documentation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scalar<T>(pub T);

impl<T: Real> Scalar<T> {
    /// A detector of intensity: 1.
    #[inline]
    pub fn eye() -> Self {
        Scalar(T::ONE)
    }

    /// The response to light of intensity 1.
    #[inline]
    pub fn intensity(&self) -> T {
        self.0
    }

    /// Times `factor`.
    #[inline]
    pub fn scaled(self, factor: T) -> Self {
        Scalar(self.0 * factor)
    }

    /// Times the mean reflectance.
    #[inline]
    pub fn reflected(self, event: &Fresnel<T>) -> Self {
        self.scaled(event.reflectance())
    }

    /// Times the mean transmittance.
    #[inline]
    pub fn refracted(self, event: &Fresnel<T>) -> Self {
        self.scaled(event.transmittance())
    }
}

/// A 4 × 4 Mueller matrix, row by row, acting on Stokes columns from the left.
///
/// The tracer uses the specialised products of [`StokesRow`]; this type is for tests and for other programs.
///
/// ```
/// use spectral_core::{fresnel::dielectric, stokes::{Mueller, StokesRow}};
/// let event = dielectric(0.4, 1.0 / 1.77);
/// let row = StokesRow([1.0, 0.2, -0.3, 0.1]);
/// assert_eq!(Mueller::reflection(&event).left_of(row), row.reflected(&event));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mueller<T>(pub [[T; 4]; 4]);

impl<T: Real> Mueller<T> {
    /// The identity.
    pub fn identity() -> Self {
        let mut m = [[T::ZERO; 4]; 4];
        for (i, row) in m.iter_mut().enumerate() {
            row[i] = T::ONE;
        }
        Mueller(m)
    }

    /// The change of frame by φ (from e_s towards e_p), given cos 2φ and sin 2φ: columns in the old frame to
    /// columns in the new one.
    pub fn rotation(cos2: T, sin2: T) -> Self {
        let mut m = Self::identity();
        m.0[1][1] = cos2;
        m.0[1][2] = sin2;
        m.0[2][1] = -sin2;
        m.0[2][2] = cos2;
        m
    }

    /// A reflection.
    pub fn reflection(event: &Fresnel<T>) -> Self {
        let [re, im] = event.reflected_cross;
        Self::event(event.reflectance_s, event.reflectance_p, re, im)
    }

    /// A refraction.
    pub fn refraction(event: &Fresnel<T>) -> Self {
        Self::event(event.transmittance_s, event.transmittance_p, event.refracted_cross, T::ZERO)
    }

    /// E_s → a_s E_s, E_p → a_p E_p, with s = |a_s|², p = |a_p|², a_s a_p* = re + i im.
    fn event(s: T, p: T, re: T, im: T) -> Self {
        let zero = T::ZERO;
        let mean = (s + p) * T::HALF;
        let half = (s - p) * T::HALF;
        Mueller([
            [mean, half, zero, zero],
            [half, mean, zero, zero],
            [zero, zero, re, -im],
            [zero, zero, im, re],
        ])
    }

    /// `self` · `nearer_the_source`: light meets the right factor first.
    pub fn then(&self, nearer_the_source: &Self) -> Self {
        let mut m = [[T::ZERO; 4]; 4];
        for (out, row) in m.iter_mut().zip(&self.0) {
            *out = Mueller(nearer_the_source.0).left_of(StokesRow(*row)).0;
        }
        Mueller(m)
    }

    /// Row · matrix.
    pub fn left_of(&self, row: StokesRow<T>) -> StokesRow<T> {
        let mut out = [T::ZERO; 4];
        for (weight, line) in row.0.iter().zip(&self.0) {
            for (sum, &entry) in out.iter_mut().zip(line) {
                *sum = *sum + *weight * entry;
            }
        }
        StokesRow(out)
    }

    /// Matrix · column.
    pub fn apply(&self, column: [T; 4]) -> [T; 4] {
        self.0.map(|row| row.iter().zip(column).fold(T::ZERO, |sum, (&m, s)| sum + m * s))
    }
}

/// The frame of a ray, turned into the plane of incidence of a surface; made by [`align`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alignment<T> {
    /// e_s: unit vector perpendicular to the ray and to the surface normal; the frame axis of both child rays.
    pub axis: [T; 3],
    /// cos 2φ for [`StokesRow::rotated`].
    pub cos2: T,
    /// sin 2φ for [`StokesRow::rotated`].
    pub sin2: T,
}

/// Turns the frame of a ray that is traced backwards into the plane of incidence.
///
/// `direction` w: the unit vector along which the ray is traced, away from the eye. `axis` x: the first axis of the frame, a
/// unit vector perpendicular to w. `normal` n: the unit normal of the surface, with either sign.
///
/// Light travels along k = −w, so the frame is (x, y, k) with y = k × x = x × w. The plane of incidence is spanned by w and n,
/// hence e_s ∝ w × n. φ counts from x towards y: cos φ = e_s·x, sin φ = e_s·y. Only 2φ matters, so the signs of e_s and n are
/// free. After the event both child rays, traced along w′, keep e_s, which is perpendicular to both of them.
/// (e_s, −w′ × e_s, −w′) is the frame of [`fresnel`](crate::fresnel).
///
/// Within √ε of normal incidence the direction of w × n is mere rounding error, but s and p differ by O(ε) only, so x itself
/// is taken. cos 2φ and sin 2φ are normalised by cos²φ + sin²φ, so that rounding in x never creates energy.
///
/// ```
/// use spectral_core::stokes::align;
/// // A ray along −z with frame axis x meets a surface with a plane of incidence turned by 90°.
/// let turned = align([0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.6_f64, 0.0, 0.8]);
/// assert_eq!(turned.axis.map(f64::abs), [0.0, 1.0, 0.0]);
/// assert_eq!((turned.cos2, turned.sin2), (-1.0, 0.0)); // Q changes sign
/// ```
#[inline]
pub fn align<T: Real>(direction: [T; 3], axis: [T; 3], normal: [T; 3]) -> Alignment<T> {
    let s = cross(direction, normal);
    let sin2_incidence = dot(s, s);
    let unturned = Alignment { axis, cos2: T::ONE, sin2: T::ZERO };
    if sin2_incidence <= T::EPSILON {
        return unturned;
    }
    let inverse = T::ONE / sin2_incidence.sqrt();
    let e_s = s.map(|component| component * inverse);
    let cos = dot(e_s, axis);
    let sin = dot(e_s, cross(axis, direction));
    let norm = cos * cos + sin * sin;
    if norm <= T::EPSILON {
        return Alignment { axis: e_s, ..unturned };
    }
    let inverse = T::ONE / norm;
    Alignment { axis: e_s, cos2: (cos * cos - sin * sin) * inverse, sin2: (cos + cos) * sin * inverse }
}

/// A unit vector perpendicular to a unit `direction`: the frame axis of a ray that leaves the eye, where any axis is valid.
///
/// Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017, without division by zero.
#[inline]
pub fn any_axis<T: Real>(direction: [T; 3]) -> [T; 3] {
    let [x, y, z] = direction;
    let sign = if z < T::ZERO { -T::ONE } else { T::ONE };
    let a = -T::ONE / (sign + z);
    [T::ONE + sign * x * x * a, sign * x * y * a, -sign * x]
}
