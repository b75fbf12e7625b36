//! What a surface between a crystal and a transparent isotropic medium does to light: the twin of the core's 2 × 2 boundary
//! conditions and of its weights, for paths that are followed backwards.

use super::{Optics, Wave, exact::Sent, unit};
use crate::throughput::Polarized;
use accel::lanes::{Lanes, Mask, Row, Triple};

/// A mode that a surface sends on; of weight 0 where there is none.
#[derive(Clone, Copy)]
pub(crate) struct Beam<V> {
    /// N.
    pub normal: Triple<V>,
    /// Unit, along the ray.
    pub ray: Triple<V>,
    /// Its throughput.
    pub weight: V,
}

/// What a surface sends on.
#[derive(Clone, Copy)]
pub(crate) struct Scattered<V> {
    /// Modes of the crystal that the light is in.
    pub back: [Beam<V>; 2],
    /// Modes of the crystal beyond.
    pub on: [Beam<V>; 2],
    /// What goes on outside crystals, and where to.
    pub row: Polarized<V>,
    pub direction: Triple<V>,
}

/// Below this share of the incident power's flux a wave is left to double precision.
const FAINT: f32 = 1e-3;

impl<V: Lanes> Beam<V> {
    #[inline(always)]
    fn none() -> Self {
        let zero = Triple::splat([0.0; 3]);
        Beam { normal: zero, ray: zero, weight: V::splat(0.0) }
    }

    /// With some lanes from memory.
    #[inline(always)]
    fn replaced(self, lanes: V::Mask, rows: &[Row; Sent::BEAM]) -> Self {
        let [x, y, z, u, v, w, weight] = rows;
        Beam {
            normal: Triple::select(lanes, triple([x, y, z]), self.normal),
            ray: Triple::select(lanes, triple([u, v, w]), self.ray),
            weight: V::select(lanes, V::load(weight), self.weight),
        }
    }
}

#[inline(always)]
fn triple<V: Lanes>([x, y, z]: [&Row; 3]) -> Triple<V> {
    Triple { x: V::load(x), y: V::load(y), z: V::load(z) }
}

impl<V: Lanes> Scattered<V> {
    /// Nothing.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = Triple::splat([0.0; 3]);
        let row = Polarized { row: [V::splat(0.0); 4], axis: zero };
        Scattered { back: [Beam::none(); 2], on: [Beam::none(); 2], row, direction: zero }
    }

    /// With some lanes from memory.
    #[inline(always)]
    pub(super) fn replaced(self, lanes: u16, sent: &Sent) -> Self {
        let lanes = V::Mask::from_bits(lanes);
        let Scattered { back, on, row, direction } = self;
        let [i, q, u, v] = &sent.row;
        let [ri, rq, ru, rv] = row.row;
        let components = [
            V::select(lanes, V::load(i), ri),
            V::select(lanes, V::load(q), rq),
            V::select(lanes, V::load(u), ru),
            V::select(lanes, V::load(v), rv),
        ];
        Scattered {
            back: [back[0].replaced(lanes, &sent.beams[0]), back[1].replaced(lanes, &sent.beams[1])],
            on: [on[0].replaced(lanes, &sent.beams[2]), on[1].replaced(lanes, &sent.beams[3])],
            row: Polarized {
                row: components,
                axis: Triple::select(lanes, Triple::load(&sent.axis), row.axis),
            },
            direction: Triple::select(lanes, Triple::load(&sent.direction), direction),
        }
    }
}

/// The tangential axes of a surface: e_s, and u = e_s × n with n along the light's way.
struct Plane<V> {
    s: Triple<V>,
    u: Triple<V>,
}

impl<V: Lanes> Plane<V> {
    /// E_u, E_s, H_u and H_s.
    #[inline(always)]
    fn fields(&self, wave: &Wave<V>) -> [V; 4] {
        let Wave { electric, magnetic, .. } = wave;
        [electric.dot(self.u), electric.dot(self.s), magnetic.dot(self.u), magnetic.dot(self.s)]
    }
}

/// z = √(n_i² − q²), real, or imaginary where reflection is total.
struct Root<V: Lanes> {
    re: V,
    im: V,
    total: V::Mask,
}

impl<V: Lanes> Root<V> {
    #[inline(always)]
    fn new(square: V) -> Self {
        let zero = V::splat(0.0);
        let (total, size) = (!zero.lt(square), square.abs().sqrt());
        Root { re: V::select(total, zero, size), im: V::select(total, size, zero), total }
    }
}

type Complex<V> = [V; 2];

#[inline(always)]
fn product<V: Lanes>(a: Complex<V>, b: Complex<V>) -> Complex<V> {
    [a[1].fnma(b[1], a[0] * b[0]), a[1].fma(b[0], a[0] * b[1])]
}

/// ad − bc.
#[inline(always)]
fn determinant<V: Lanes>(a: Complex<V>, b: Complex<V>, c: Complex<V>, d: Complex<V>) -> Complex<V> {
    let (left, right) = (product(a, d), product(b, c));
    [left[0] - right[0], left[1] - right[1]]
}

#[inline(always)]
fn norm_sqr<V: Lanes>(a: Complex<V>) -> V {
    a[0].fma(a[0], a[1] * a[1])
}

/// From a mode of a crystal, in some lanes the second one, of the wave vector N and `weight` into a medium of index `beyond`, and the lanes for which single
/// precision does.
#[inline(always)]
pub(super) fn leave<V: Lanes>(
    crystal: Optics<'_>,
    second: V::Mask,
    (wave_vector, weight): (Triple<V>, V),
    n: Triple<V>,
    beyond: V,
) -> (Scattered<V>, V::Mask) {
    let (zero, one) = (V::splat(0.0), V::splat(1.0));
    let (incident, known) = crystal.wave(second, wave_vector);
    let q = n.fnma(n.dot(wave_vector), wave_vector);
    let q2 = q.dot(q);
    // At normal incidence each plane through the normal is one of incidence.
    let steep = V::splat(1e-6).lt(q2);
    let s = unit(n.cross(Triple::select(steep, q, incident.electric)));
    let plane = Plane { s, u: s.cross(n) };
    let (back, regular) = crystal.waves(q, n, -1.0);
    let z = Root::new(beyond * beyond - q2);
    let fields = [plane.fields(&incident), plane.fields(&back[0]), plane.fields(&back[1])];
    let [first, second, divisor] = reflections(&fields, &z, beyond * beyond);
    let flux = incident.poynting().dot(n);
    let rays = [back[0].poynting(), back[1].poynting()];
    let (flux_one, flux_two) = (-rays[0].dot(n), -rays[1].dot(n));
    let share = weight * (one / norm_sqr(divisor)) / flux;
    let powers = [norm_sqr(first) * share * flux_one, norm_sqr(second) * share * flux_two];
    // Where light gets out everything is real.
    let over = one / V::select(z.total, one, divisor[0]);
    let (first, second) = (first[0] * over, second[0] * over);
    let root = (z.re / flux).max(zero).sqrt();
    let b_s = second.fma(fields[2][1], first.fma(fields[1][1], fields[0][1])) * root;
    let b_p = second.fma(fields[2][3], first.fma(fields[1][3], fields[0][3])) * root / beyond;
    let [through, difference, cross] = sent(b_s, b_p, weight, z.total);
    // Rounding leaves 1e-6 of the energy over; no path of a hundred events may gather it.
    let exact = weight / (powers[0] + powers[1] + through);
    let row = Polarized { row: [through * exact, difference * exact, cross * exact, zero], axis: s };
    let direction = n.fma(z.re, q).scaled(one / beyond).renormalized();
    let back = beams(&back, &rays, [powers[0] * exact, powers[1] * exact]);
    let served = known & regular & V::splat(FAINT).lt(flux.min(flux_one).min(flux_two));
    (Scattered { back, row, direction, ..Scattered::none() }, served)
}

/// The numerators of both reflected amplitudes, and their divisor, of the fields of the incident and the reflected waves.
#[inline(always)]
fn reflections<V: Lanes>(fields: &[[V; 4]; 3], z: &Root<V>, permittivity: V) -> [Complex<V>; 3] {
    let (alpha, beta) = outward(&fields[0], z, permittivity);
    let (alpha_one, beta_one) = outward(&fields[1], z, permittivity);
    let (alpha_two, beta_two) = outward(&fields[2], z, permittivity);
    [
        determinant(alpha_two, alpha, beta_two, beta),
        determinant(alpha, alpha_one, beta, beta_one),
        determinant(alpha_one, alpha_two, beta_one, beta_two),
    ]
}

/// I, Q and U of a row of real amplitudes b_s and b_p; nothing where reflection is total.
#[inline(always)]
fn sent<V: Lanes>(b_s: V, b_p: V, weight: V, total: V::Mask) -> [V; 3] {
    let zero = V::splat(0.0);
    let (ss, pp) = (b_s * b_s * weight, b_p * b_p * weight);
    [
        V::select(total, zero, ss + pp),
        V::select(total, zero, ss - pp),
        V::select(total, zero, (b_s + b_s) * b_p * weight),
    ]
}

/// Waves with their rays, not yet of unit length, as modes of these weights.
#[inline(always)]
fn beams<V: Lanes>(waves: &[Wave<V>; 2], rays: &[Triple<V>; 2], weights: [V; 2]) -> [Beam<V>; 2] {
    [
        Beam { normal: waves[0].normal, ray: unit(rays[0]), weight: weights[0] },
        Beam { normal: waves[1].normal, ray: unit(rays[1]), weight: weights[1] },
    ]
}

/// α = H_u + zE_s, β = zH_s − n_i²E_u.
#[inline(always)]
fn outward<V: Lanes>([eu, es, hu, hs]: &[V; 4], z: &Root<V>, permittivity: V) -> (Complex<V>, Complex<V>) {
    ([z.re.fma(*es, *hu), z.im * *es], [permittivity.fnma(*eu, z.re * *hs), z.im * *hs])
}

/// From a medium of index `here` into a crystal; the row's frame lies in the plane of incidence, `direction` is the ray's.
#[inline(always)]
pub(super) fn enter<V: Lanes>(
    crystal: Optics<'_>,
    row: Polarized<V>,
    direction: Triple<V>,
    n: Triple<V>,
    here: V,
) -> (Scattered<V>, V::Mask) {
    let (zero, one) = (V::splat(0.0), V::splat(1.0));
    let cosine = n.dot_unfused(direction);
    let q = n.fnma(cosine, direction).scaled(here);
    let z = cosine * here;
    let row = row.aligned(direction, n);
    let s = unit(n.fnma(n.dot(row.axis), row.axis));
    let plane = Plane { s, u: s.cross(n) };
    let (on, regular) = crystal.waves(q, n, 1.0);
    let (t_s, t_p, jones) = transmissions(&[plane.fields(&on[0]), plane.fields(&on[1])], here, z);
    let rays = [on[0].poynting(), on[1].poynting()];
    let flux = [rays[0].dot(n), rays[1].dot(n)];
    let (over, power) = (one / here, one / z);
    let first = into_mode(&row.row, t_s[0], t_p[0] * over) * flux[0] * power;
    let second = into_mode(&row.row, t_s[1], t_p[1] * over) * flux[1] * power;
    let back = mirrored(&row.row, &jones);
    let sum = back[0] + first + second;
    let exact = V::select(zero.lt(sum), row.row[0] / sum, zero);
    let components = [back[0] * exact, back[1] * exact, back[2] * exact, back[3] * exact];
    let row = Polarized { row: components, axis: row.axis };
    let direction = n.fnma(cosine + cosine, direction).renormalized();
    let on = beams(&on, &rays, [first * exact, second * exact]);
    let served = regular & V::splat(FAINT).lt(z.min(flux[0]).min(flux[1]));
    (Scattered { on, row, direction, ..Scattered::none() }, served)
}

/// The amplitudes of both waves for incident s and for incident p, in the units of their fields, and the Jones matrix of the
/// reflection, from the incident polarisation to the outgoing one.
#[inline(always)]
fn transmissions<V: Lanes>(fields: &[[V; 4]; 2], here: V, z: V) -> ([V; 2], [V; 2], [[V; 2]; 2]) {
    let (permittivity, one) = (here * here, V::splat(1.0));
    let [first, second] = fields;
    // α = H_u − zE_s, β = zH_s + n_i²E_u.
    let (a1, a2) = (z.fnma(first[1], first[2]), z.fnma(second[1], second[2]));
    let b1 = permittivity.fma(first[0], z * first[3]);
    let b2 = permittivity.fma(second[0], z * second[3]);
    let inverse = (z + z) / (a1 * b2 - a2 * b1);
    let t_s = [-(b2 * inverse), b1 * inverse];
    let inverse = inverse * permittivity;
    let t_p = [-(a2 * inverse), a1 * inverse];
    let over = one / here;
    let ss = t_s[0].fma(first[1], t_s[1] * second[1]) - one;
    let sp = t_s[0].fma(first[3], t_s[1] * second[3]) * over;
    let ps = t_p[0].fma(first[1], t_p[1] * second[1]) * over;
    let pp = t_p[0].fma(first[3], t_p[1] * second[3]) * over * over - one;
    (t_s, t_p, [[ss, sp], [ps, pp]])
}

/// ½ row · the Stokes column of real amplitudes a_s and a_p.
#[inline(always)]
fn into_mode<V: Lanes>([i, q, u, _]: &[V; 4], s: V, p: V) -> V {
    let (ss, pp, sp) = (s * s, p * p, s * p);
    V::splat(0.5) * i.fma(ss + pp, q.fma(ss - pp, *u * (sp + sp)))
}

/// Row · the Mueller matrix of a real Jones matrix: `spectral_core::crystal::reflected`.
#[inline(always)]
fn mirrored<V: Lanes>([i, q, u, v]: &[V; 4], [[ss, sp], [ps, pp]]: &[[V; 2]; 2]) -> [V; 4] {
    let (up, down) = (*i + *q, *i - *q);
    let s = (*ss * *ss).fma(up, (*ps * *ps).fma(down, (*ss + *ss) * *ps * *u));
    let p = (*sp * *sp).fma(up, (*pp * *pp).fma(down, (*sp + *sp) * *pp * *u));
    let half = V::splat(0.5);
    let same = (*ss * *sp).fma(up, *ps * *pp * down);
    let (with, against) = (*ss * *pp, *ps * *sp);
    [half * (s + p), half * (s - p), (with + against).fma(*u, same), (with - against) * *v]
}
