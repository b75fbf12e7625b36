//! Weights of paths that are followed backwards: between the Stokes rows outside a crystal and the modes within.
//!
//! The amplitudes of a lossless surface, in units of power, do not change when time is reversed: S_ji = S_īj̄, where ī is
//! the wave i sent back with the same E. So a ray is traced backwards with the amplitudes of light that travels with it, and
//! none is transposed. In a crystal a ray is one mode with one weight W, the throughput; there is no factor n² and no
//! solid angle, since d²x d²q is conserved along each mode.
//!
//! Frames of rows are (e_s, e_s × d, −d) for a ray traced along d, as everywhere in [`stokes`](crate::stokes). The modes
//! are added as intensities: their interference averages out over a colour.

use crate::stokes::StokesRow;
use num_complex::Complex64;

/// From a row to a mode, with the amplitudes a_s and a_p into this mode for incident s and p:
///
/// ```text
/// W = ½ row·(|a_s|²+|a_p|², |a_s|²−|a_p|², 2Re a_s a_p*, 2Im a_s a_p*)
/// ```
///
/// The ½ is one of the two polarisations of unpolarised light, which every mode is.
pub fn into_mode(row: StokesRow<f64>, amplitudes: [Complex64; 2]) -> f64 {
    let column = stokes(amplitudes);
    0.5 * row.0.iter().zip(column).map(|(r, c)| r * c).sum::<f64>()
}

/// From a mode of weight W to a row, with the amplitudes b_s and b_p that the mode sends into s and p:
///
/// ```text
/// row = W (|b_s|²+|b_p|², |b_s|²−|b_p|², 2Re b_s b_p*, −2Im b_s b_p*)
/// ```
pub fn from_mode(weight: f64, amplitudes: [Complex64; 2]) -> StokesRow<f64> {
    let [i, q, u, v] = stokes(amplitudes);
    StokesRow([i, q, u, -v].map(|x| weight * x))
}

/// From a row to a row, with `jones[m][j]` the amplitude from incident polarisation m to outgoing polarisation j: what
/// is reflected outside a crystal, where s and p mix.
///
/// Light comes in by j and goes out by m, so J_mj is its Jones matrix. Applied to the Stokes vector of a field E, the row
/// (I, Q, U, V) is the form E†ΩE with Ω = ((I + Q, U + iV), (U − iV, I − Q)). Behind the surface it is J†ΩJ.
pub fn reflected(row: StokesRow<f64>, jones: [[Complex64; 2]; 2]) -> StokesRow<f64> {
    let [i, q, u, v] = row.0;
    let [up, down] = [Complex64::new(u, v), Complex64::new(u, -v)];
    let form = [[Complex64::from(i + q), up], [down, Complex64::from(i - q)]];
    let entry = |a: usize, b: usize| -> Complex64 {
        let term = |m: usize, n: usize| jones[m][a].conj() * form[m][n] * jones[n][b];
        term(0, 0) + term(0, 1) + term(1, 0) + term(1, 1)
    };
    let (s, p, cross) = (entry(0, 0).re, entry(1, 1).re, entry(0, 1));
    StokesRow([0.5 * (s + p), 0.5 * (s - p), cross.re, cross.im])
}

/// The Stokes column of the field (a_s, a_p).
fn stokes([s, p]: [Complex64; 2]) -> [f64; 4] {
    let cross = s * p.conj();
    [s.norm_sqr() + p.norm_sqr(), s.norm_sqr() - p.norm_sqr(), 2.0 * cross.re, 2.0 * cross.im]
}
