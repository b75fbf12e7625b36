//! What a plane surface of a crystal does to a wave: continuity of the tangential fields.

use super::vector::{along, plus, root, unit};
use super::wave::Wave;
use crate::color::matrix::{cross, dot};
use crate::stokes::any_axis;
use num_complex::Complex64;

/// The plane of incidence of a wave at a surface, and its tangential wave vector, which all waves there share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incidence {
    /// n: the unit normal of the surface, along the way of the incident light.
    pub normal: [f64; 3],
    /// e_s: unit, perpendicular to the plane of incidence; the first axis of the frames of rays outside the crystal.
    pub s: [f64; 3],
    /// u: unit, in the surface and the plane of incidence; e_s = n × u.
    pub u: [f64; 3],
    /// The component of N along u, at least 0.
    pub tangential: f64,
}

/// Amplitudes in units of power of what one incident wave of power 1 sends on; |amplitude|² is the share of the power.
///
/// The two reflected and the two transmitted waves are the crystal's as [`Crystal::waves`](super::Crystal::waves) lists
/// them; on an isotropic side they are s and p, with E_s along e_s and E_p along e_s × N. An evanescent wave has amplitude 0,
/// and so has what enters a metal.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Scattered {
    /// Reflected.
    pub back: [Complex64; 2],
    /// Transmitted.
    pub on: [Complex64; 2],
}

impl Scattered {
    /// The power that is sent on: 1 where nothing absorbs.
    pub fn power(&self) -> f64 {
        self.back.iter().chain(&self.on).map(|amplitude| amplitude.norm_sqr()).sum()
    }
}

impl Incidence {
    /// The incidence of a wave with the vector N = k/k₀ on a surface with unit normal n, which points along the way of the
    /// light.
    pub fn new(wave_vector: [f64; 3], normal: [f64; 3]) -> Self {
        let across = cross(normal, wave_vector);
        // At normal incidence each plane through the normal is one of incidence.
        let s = if dot(across, across) > 1e-28 { unit(across) } else { any_axis(normal) };
        let u = cross(s, normal);
        Incidence { normal, s, u, tangential: dot(wave_vector, u) }
    }

    /// The same with e_s given: `s` is the first axis of a ray's frame that has been turned into the plane of incidence by
    /// [`align`](crate::stokes::align).
    pub fn aligned(wave_vector: [f64; 3], normal: [f64; 3], s: [f64; 3]) -> Self {
        let s = unit(plus(s, -dot(s, normal), normal));
        let u = cross(s, normal);
        let tangential = dot(wave_vector, u);
        let sign = if tangential < 0.0 { -1.0 } else { 1.0 };
        Incidence { normal, s: s.map(|x| x * sign), u: u.map(|x| x * sign), tangential: tangential.abs() }
    }

    /// The tangential wave vector q.
    pub fn q(&self) -> [f64; 3] {
        self.u.map(|x| x * self.tangential)
    }

    /// E_u, E_s, H_u and H_s of a wave.
    fn tangential_fields(&self, wave: &Wave) -> [Complex64; 4] {
        let Wave { electric, magnetic, .. } = wave;
        [along(electric, self.u), along(electric, self.s), along(magnetic, self.u), along(magnetic, self.s)]
    }

    /// N·n in an isotropic medium: z = √(n_i² − q²), with Im z ≥ 0.
    fn isotropic(&self, permittivity: Complex64) -> Complex64 {
        let z2 = permittivity - self.tangential * self.tangential;
        // The principal root has Re z ≥ 0, and with it Im z ≥ 0 where the medium absorbs.
        if z2.im == 0.0 { root(z2.re) } else { z2.sqrt() }
    }

    /// From a crystal into an isotropic medium or onto a metal, of index n + ik; n_i² = (n + ik)².
    ///
    /// `back` are the crystal's waves for [`q`](Self::q) on the side that `incident` comes from. The isotropic side is
    /// eliminated: there H_u = −z E_s and z H_s = n_i² E_u, so with α = H_u + zE_s and β = zH_s − n_i²E_u of each wave
    ///
    /// ```text
    /// α₁r₁ + α₂r₂ = −α_i      β₁r₁ + β₂r₂ = −β_i      t_s = E_s, t_p = H_s/n_i² of the sum
    /// ```
    ///
    /// No division by z: grazing incidence is safe.
    pub fn leave(&self, incident: &Wave, back: &[Wave; 2], [n, k]: [f64; 2]) -> Scattered {
        let permittivity = Complex64::new(n * n - k * k, 2.0 * n * k);
        let z = self.isotropic(permittivity);
        let fields = [incident, &back[0], &back[1]].map(|wave| self.tangential_fields(wave));
        let [first, one, two] = fields.map(|[eu, es, hu, hs]| [hu + z * es, z * hs - permittivity * eu]);
        let r = solve([[one[0], two[0]], [one[1], two[1]]], first.map(|x| -x));
        let sum = |k: usize| fields[0][k] + r[0] * fields[1][k] + r[1] * fields[2][k];
        let power = |share: f64| (share / incident.flux).abs().sqrt();
        let transparent = permittivity.im == 0.0;
        let [t_s, t_p] = if transparent { [power(z.re), power(z.re * permittivity.re)] } else { [0.0; 2] };
        Scattered {
            back: [r[0] * power(back[0].flux), r[1] * power(back[1].flux)],
            on: [sum(1) * t_s, sum(3) / permittivity * t_p],
        }
    }

    /// From a transparent isotropic medium of index n_i into a crystal, for incident s and p.
    ///
    /// `on` are the crystal's waves on the far side. With α = H_u − zE_s and β = zH_s + n_i²E_u of each wave
    ///
    /// ```text
    /// α₁t₁ + α₂t₂ = −2z (s), 0 (p)      β₁t₁ + β₂t₂ = 0 (s), 2z n_i² (p)
    /// ```
    pub fn enter(&self, n: f64, on: &[Wave; 2]) -> [Scattered; 2] {
        let permittivity = n * n;
        let z = self.isotropic(Complex64::from(permittivity));
        let fields = [&on[0], &on[1]].map(|wave| self.tangential_fields(wave));
        let [one, two] = fields.map(|[eu, es, hu, hs]| [hu - z * es, z * hs + permittivity * eu]);
        let matrix = [[one[0], two[0]], [one[1], two[1]]];
        let zero = Complex64::ZERO;
        // A wave of amplitude 1 has the flux z (s) or z n_i² (p). At grazing incidence nothing is left to be divided.
        let flux = z.re.max(1e-280);
        let incident = [([-2.0 * z, zero], flux), ([zero, 2.0 * z * permittivity], flux * permittivity)];
        let reflect = [1.0, n];
        std::array::from_fn(|m| {
            let (right, flux) = incident[m];
            let t = solve(matrix, right);
            let sum = |k: usize| t[0] * fields[0][k] + t[1] * fields[1][k];
            let mut back = [sum(1), sum(3) / permittivity];
            back[m] -= 1.0;
            let power = |share: f64| (share / flux).abs().sqrt();
            Scattered {
                back: std::array::from_fn(|j| back[j] * (reflect[j] / reflect[m])),
                on: [t[0] * power(on[0].flux), t[1] * power(on[1].flux)],
            }
        })
    }

    /// From a crystal into another one in contact with it: four equations for E_u, E_s, H_u and H_s.
    pub fn between(&self, incident: &Wave, back: &[Wave; 2], on: &[Wave; 2]) -> Scattered {
        let waves = [&back[0], &back[1], &on[0], &on[1]];
        let fields = waves.map(|wave| self.tangential_fields(wave));
        let right = self.tangential_fields(incident);
        let rows: [[Complex64; 5]; 4] =
            std::array::from_fn(|k| [fields[0][k], fields[1][k], -fields[2][k], -fields[3][k], -right[k]]);
        let solution = eliminate(rows);
        let amplitude = |j: usize| solution[j] * (waves[j].flux / incident.flux).abs().sqrt();
        Scattered { back: [amplitude(0), amplitude(1)], on: [amplitude(2), amplitude(3)] }
    }
}

/// Two equations by Cramer's rule.
fn solve([[a, b], [c, d]]: [[Complex64; 2]; 2], [x, y]: [Complex64; 2]) -> [Complex64; 2] {
    let determinant = a * d - b * c;
    [(x * d - b * y) / determinant, (a * y - c * x) / determinant]
}

/// Four equations, the right-hand sides in the last column, by Gauss's elimination with pivots.
fn eliminate(mut rows: [[Complex64; 5]; 4]) -> [Complex64; 4] {
    for k in 0..4 {
        let pivot = (k..4).max_by(|&a, &b| rows[a][k].norm_sqr().total_cmp(&rows[b][k].norm_sqr()));
        rows.swap(k, pivot.unwrap_or(k));
        let pivot = rows[k].map(|x| x / rows[k][k]);
        rows[k] = pivot;
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k];
            for (entry, p) in row.iter_mut().zip(&pivot) {
                *entry -= factor * p;
            }
        }
    }
    rows.map(|row| row[4])
}
