//! Reflection and refraction at one interface: Fresnel's equations with phases, for dielectrics and conductors.
//!
//! # Frame and signs
//! Light with wave vector k is described in the right-handed frame (e_s, e_p, k), e_p = k × e_s, with e_s
//! perpendicular to the plane of incidence and **the same before and after the event**. In this frame (Born &
//! Wolf, *Principles of Optics*, 7th ed., §1.5.2), with n₁ on the incident side,
//! n₂ beyond, c = cos θ₁ and c′ = cos θ₂,
//!
//! ```text
//! r_s = (n₁c − n₂c′)/(n₁c + n₂c′)      r_p = (n₂c − n₁c′)/(n₂c + n₁c′)
//! ```
//!
//! so r_p = −r_s at normal incidence, where e_p reverses with k.
//!
//! # Time
//! Fields vary as exp(i(k·r − ωt)). So an absorbing medium has the index n + ik with k > 0, and under total internal
//! reflection c′ = +i√(sin²θ₁ n₁²/n₂² − 1), with which the evanescent wave decays.
//!
//! # Energy, not radiance
//! Transmittances are ratios of power, T = 1 − R. A renderer that follows rays backwards carries radiance/n², which a
//! lossless interface conserves. So there is no factor (n₂/n₁)²: it cancels between entering and leaving the stone.

use num_complex::Complex64;

use crate::Real;

/// The effect of one event on the two polarisations. Made by [`dielectric`] and [`conductor`].
///
/// Every energy lies in [0, 1]. [`Mueller`](crate::stokes::Mueller) matrices consist of products of amplitudes, since no
/// single amplitude can be observed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Fresnel<T> {
    /// |r_s|²: the reflectance for light polarised perpendicular to the plane of incidence.
    pub reflectance_s: T,
    /// |r_p|²: the reflectance for light polarised in the plane of incidence.
    pub reflectance_p: T,
    /// Transmitted power, s: exactly 1 − `reflectance_s` for a dielectric; 0 for a conductor, which absorbs it within a
    /// wavelength.
    pub transmittance_s: T,
    /// Transmitted power, p.
    pub transmittance_p: T,
    /// r_s · conj(r_p), real and imaginary part: its phase is the retardation δ_s − δ_p of reflected light.
    pub reflected_cross: [T; 2],
    /// The same product for refracted light, in power: √(T_s T_p). It is real, since refraction does not change the phase.
    pub refracted_cross: T,
    /// Cosine of the angle of refraction; 0 under total internal reflection and for a conductor.
    pub cos_t: T,
    /// Whether reflection is total. Then there is no refracted ray.
    pub tir: bool,
}

impl<T: Real> Fresnel<T> {
    /// Reflectance of unpolarised light: the mean of s and p.
    #[inline]
    pub fn reflectance(&self) -> T {
        (self.reflectance_s + self.reflectance_p) * T::HALF
    }

    /// Transmittance of unpolarised light: the mean of s and p.
    #[inline]
    pub fn transmittance(&self) -> T {
        (self.transmittance_s + self.transmittance_p) * T::HALF
    }
}

/// cos²θ₂ by Snell's law, in double precision for any `T`; negative under total internal reflection.
///
/// In single precision an error of 1e-7 in sin²θ₂ becomes 3e-4 in cos θ₂ near the critical angle.
#[inline]
fn cos2_refracted<T: Real>(cos_i: T, eta: T) -> f64 {
    let (c, eta) = (cos_i.to_f64(), eta.to_f64());
    1.0 - eta * eta * (1.0 - c * c)
}

/// (r_s, r_p) for real cosines, with one division.
///
/// With η ≠ 1 the two cosines are never both zero, so neither denominator is.
#[inline]
fn amplitudes<T: Real>(cos_i: T, eta: T, cos_t: T) -> [T; 2] {
    let (s_sum, p_sum) = (eta * cos_i + cos_t, cos_i + eta * cos_t);
    let inverse = T::ONE / (s_sum * p_sum);
    [(eta * cos_i - cos_t) * (inverse * p_sum), (cos_i - eta * cos_t) * (inverse * s_sum)]
}

/// An interface between two transparent media.
///
/// `cos_i`: cosine of the angle of incidence (clamped to [0, 1]). `eta`: n₁/n₂, the index on the incident side over the other
/// index. Equal indices give R = 0 exactly; grazing incidence gives R = 1.
///
/// ```
/// use spectral_core::fresnel::dielectric;
/// let entering = dielectric(1.0, 1.0 / 1.5);
/// assert!((entering.reflectance() - 0.04_f64).abs() < 1e-15); // ((n − 1)/(n + 1))²
/// assert!(dielectric(0.5, 1.5).tir); // 60° from inside: above the critical angle of 41.8°
/// ```
#[inline]
pub fn dielectric<T: Real>(cos_i: T, eta: T) -> Fresnel<T> {
    let c = cos_i.max(T::ZERO).min(T::ONE);
    if eta == T::ONE {
        let (one, cos_t) = (T::ONE, c);
        return Fresnel {
            transmittance_s: one,
            transmittance_p: one,
            refracted_cross: one,
            cos_t,
            ..Fresnel::default()
        };
    }
    let cos2_t = cos2_refracted(c, eta);
    if cos2_t <= 0.0 {
        return total(c, eta, -cos2_t);
    }
    let cos_t = T::from_f64(cos2_t.sqrt());
    let [r_s, r_p] = amplitudes(c, eta, cos_t);
    let reflectance_s = (r_s * r_s).min(T::ONE);
    let reflectance_p = (r_p * r_p).min(T::ONE);
    let transmittance_s = T::ONE - reflectance_s;
    let transmittance_p = T::ONE - reflectance_p;
    Fresnel {
        reflectance_s,
        reflectance_p,
        transmittance_s,
        transmittance_p,
        reflected_cross: [r_s * r_p, T::ZERO],
        refracted_cross: (transmittance_s * transmittance_p).sqrt(),
        cos_t,
        tir: false,
    }
}

/// Total internal reflection, `kappa2` = −cos²θ₂ ≥ 0.
///
/// With c′ = iκ both amplitudes are phases; their difference δ = δ_s − δ_p follows from
/// tan(δ/2) = cos θ √(sin²θ − (n₂/n₁)²)/sin²θ = κ cos θ/(η sin²θ) (Born & Wolf, §1.5.4),
/// and cos δ and sin δ from the half-angle formulas, without a trigonometric function.
#[inline]
fn total<T: Real>(cos_i: T, eta: T, kappa2: f64) -> Fresnel<T> {
    let (c, eta) = (cos_i.to_f64(), eta.to_f64());
    let a = eta * (1.0 - c * c);
    let b = kappa2.sqrt() * c;
    let inverse = 1.0 / (a * a + b * b);
    Fresnel {
        reflectance_s: T::ONE,
        reflectance_p: T::ONE,
        reflected_cross: [T::from_f64((a * a - b * b) * inverse), T::from_f64(2.0 * a * b * inverse)],
        tir: true,
        ..Fresnel::default()
    }
}

/// The surface of a metal or another opaque substance with the complex index n + ik.
///
/// `cos_i`: cosine of the angle of incidence (clamped to [0, 1]). `n_incident`: index of the incident medium. Light that is
/// not reflected is absorbed, so both transmittances are 0.
///
/// The formulas of [`dielectric`] with a complex n₂ (Born & Wolf, §14.2): with w = n₂c′ =
/// √(n₂² − n₁² sin²θ), Im w ≥ 0, r_s = (n₁c − w)/(n₁c + w) and r_p = (n₂²c − n₁w)/(n₂²c + n₁w).
///
/// ```
/// use spectral_core::fresnel::conductor;
/// let gold = conductor(1.0, 1.0, 0.29, 2.863); // at 582 nm
/// let expected = ((0.29_f64 - 1.0).powi(2) + 2.863_f64.powi(2)) / ((0.29_f64 + 1.0).powi(2) + 2.863_f64.powi(2));
/// assert!((gold.reflectance() - expected).abs() < 1e-15);
/// ```
pub fn conductor<T: Real>(cos_i: T, n_incident: T, n: T, k: T) -> Fresnel<T> {
    let c = cos_i.max(T::ZERO).min(T::ONE).to_f64();
    let n1 = n_incident.to_f64();
    let index = Complex64::new(n.to_f64(), k.to_f64());
    let index2 = index * index;
    // The principal root has Re ≥ 0. With k ≥ 0 its argument has Im ≥ 0, and so has the root.
    let w = (index2 - n1 * n1 * (1.0 - c * c)).sqrt();
    let r_s = quotient(n1 * c - w, n1 * c + w);
    let r_p = quotient(index2 * c - n1 * w, index2 * c + n1 * w);
    let cross = r_s * r_p.conj();
    Fresnel {
        reflectance_s: T::from_f64(r_s.norm_sqr().min(1.0)),
        reflectance_p: T::from_f64(r_p.norm_sqr().min(1.0)),
        reflected_cross: [T::from_f64(cross.re), T::from_f64(cross.im)],
        ..Fresnel::default()
    }
}

/// A quotient that is 0 if both parts vanish: without an interface there is no reflection.
fn quotient(numerator: Complex64, denominator: Complex64) -> Complex64 {
    if denominator.norm_sqr() == 0.0 { Complex64::ZERO } else { numerator / denominator }
}
