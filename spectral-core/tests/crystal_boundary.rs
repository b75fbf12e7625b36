//! Surfaces of crystals against closed forms, and what every surface conserves.

use num_complex::Complex64;
use spectral_core::color::matrix::{cross, dot};
use spectral_core::crystal::{Crystal, Incidence, Scattered, Wave, from_mode, into_mode, reflected};
use spectral_core::fresnel::{Fresnel, conductor, dielectric};
use spectral_core::stokes::{StokesRow, align};

mod support;
use support::{Random, near, orientation};

type V = [f64; 3];

const CALCITE: [f64; 2] = [1.65835, 1.48640];
const UP: V = [0.0, 0.0, 1.0];

/// From air onto calcite in the plane y = 0: |s→s|², |s→p|², |p→s|², |p→p|², and the extraordinary ray.
fn from_air(axis: V, degrees: f64) -> ([f64; 4], V) {
    let calcite = Crystal::uniaxial(CALCITE, axis);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let at = Incidence::new([sin, 0.0, cos], UP);
    let on = calcite.waves(at.q(), UP, 1.0);
    let [s, p] = at.enter(1.0, &on).map(|out| out.back.map(|r| r.norm_sqr()));
    ([s[0], s[1], p[0], p[1]], on[1].ray())
}

#[test]
fn calcite_in_air() {
    let (z, x, y) = (UP, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let tilted = [1.0, 1.0, 1.0];
    let (o, e) = (0.06133232, 0.03826883);
    for (what, axis, degrees, expected) in [
        ("axis along the normal", z, 0.0, [o, 0.0, 0.0, o]),
        ("axis along p", x, 0.0, [o, 0.0, 0.0, e]),
        ("axis along s", y, 0.0, [e, 0.0, 0.0, o]),
        ("axis (1, 1, 1)", tilted, 30.0, [0.07447510, 0.00061726, 0.00016659, 0.03437786]),
        ("axis (1, 1, 1)", tilted, 60.0, [0.20857237, 0.00107045, 0.00006188, 0.00069494]),
    ] {
        let (found, _) = from_air(axis, degrees);
        // Which of s and p is which at normal incidence is the frame's choice.
        let sorted =
            |r: [f64; 4]| if degrees == 0.0 { [r[0].max(r[3]), r[1], r[2], r[0].min(r[3])] } else { r };
        for (a, b) in sorted(found).into_iter().zip(sorted(expected)) {
            near(a, b, 5e-9, what);
        }
    }
    near(from_air(z, 30.0).0[3], 0.04323692, 5e-9, "axis along the normal, 30°");
    near(from_air(z, 60.78355).0[3], 0.0, 1e-14, "Brewster's angle");
    let ray = from_air(tilted, 30.0).1;
    near(ray[0].atan2(ray[2]).to_degrees(), 15.21264, 5e-6, "in the plane");
    near(ray[1].atan2(ray[2]).to_degrees(), -5.48018, 5e-6, "out of it");
}

/// Lekner 1991, §4: where s and p do not mix, each is Fresnel's with its own index and cosine.
#[test]
fn principal_orientations() {
    let [n_o, n_e] = CALCITE;
    for degrees in [5.0, 30.0, 45.0, 60.0, 75.0, 89.0_f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let s = |n: f64| ((cos - (n * n - sin * sin).sqrt()) / (cos + (n * n - sin * sin).sqrt())).powi(2);
        // r_p of a wave with E in the plane: axis along the normal, or in the surface and the plane.
        let p = |across: f64, along: f64| {
            let q = across / along * (along * along - sin * sin).sqrt();
            ((across * across * cos - q) / (across * across * cos + q)).powi(2)
        };
        for (axis, r_s, r_p) in [
            (UP, s(n_o), p(n_o, n_e)),
            ([1.0, 0.0, 0.0], s(n_o), p(n_e, n_o)),
            ([0.0, 1.0, 0.0], s(n_e), p(n_o, n_o)),
        ] {
            let (found, _) = from_air(axis, degrees);
            for (a, b) in found.into_iter().zip([r_s, 0.0, 0.0, r_p]) {
                near(a, b, 1e-13, &format!("{axis:?}, {degrees}°"));
            }
        }
    }
}

/// Calcite, zircon, quartz and rutile by their indices; olivine, topaz, and crystals that are stronger and weaker than any.
const UNIAXIAL: [[f64; 2]; 4] = [CALCITE, [1.925, 1.984], [1.5442, 1.5533], [2.6, 2.9]];
const BIAXIAL: [[f64; 3]; 4] =
    [[1.654, 1.671, 1.689], [1.61, 1.6103, 1.62], [1.5, 1.9, 2.4], [1.7, 1.70001, 1.700015]];

fn crystal(random: &mut Random) -> Crystal {
    let axes = orientation(random);
    match random.below(8) {
        k @ 0..4 => Crystal::uniaxial(UNIAXIAL[k], axes[2]),
        k => Crystal::new(BIAXIAL[k - 4], axes),
    }
}

/// The optic axes.
fn optic_axes(crystal: &Crystal) -> [V; 2] {
    let mut order = [0, 1, 2];
    let (index, axes) = (crystal.indices(), crystal.axes());
    order.sort_by(|&a, &b| index[a].total_cmp(&index[b]));
    let (sin, cos) = (crystal.optic_angle() / 2.0).sin_cos();
    let [x, _, z] = order.map(|k| axes[k]);
    [1.0, -1.0].map(|side| std::array::from_fn(|i| cos * z[i] + side * sin * x[i]))
}

/// A direction at an angle of 10^−`digits` from `axis`.
fn beside(axis: V, digits: i32, random: &mut Random) -> V {
    let aside = random.direction().to_array();
    let size = if digits > 17 { 0.0 } else { 10_f64.powi(-digits) };
    let v: V = std::array::from_fn(|i| axis[i] + size * aside[i]);
    v.map(|x| x / dot(v, v).sqrt())
}

/// A surface with its light: what each incident wave of power 1 sends on.
struct Case {
    scattered: Vec<Scattered>,
    /// How near to grazing the waves are: the least share of Poynting's vector along the normal.
    grazing: f64,
}

/// The share of the ray, or of an evanescent wave's N, that is along the normal.
fn steepness(wave: &Wave, normal: V) -> f64 {
    if wave.propagates() {
        return dot(wave.ray(), normal).abs();
    }
    let along: Complex64 = (0..3).map(|i| wave.normal[i] * normal[i]).sum();
    along.norm().min(1.0)
}

/// From a crystal along `direction` against something, or from something into it.
fn case(random: &mut Random, crystal: &Crystal, direction: V) -> Case {
    let mut normal = random.direction().to_array();
    let wave = crystal.waves([0.0; 3], direction, 1.0)[random.below(2)].at(normal);
    if wave.flux < 0.0 {
        normal = normal.map(|x| -x);
    }
    let wave = wave.at(normal);
    let at = Incidence::new(wave.wave_vector(), normal);
    let (back, on) = (crystal.reflections(&wave, &at), crystal.waves(at.q(), normal, 1.0));
    let index: f64 = [1.0, 1.33, 1.9, 2.7][random.below(4)];
    let room = (index * index - at.tangential * at.tangential).max(0.0).sqrt() / index;
    let least = |waves: &[&[Wave]]| {
        waves.iter().flat_map(|w| w.iter()).map(|w| steepness(w, normal)).fold(1.0, f64::min)
    };
    match random.below(3) {
        0 => {
            let scattered = vec![at.leave(&wave, &back, [index, 0.0])];
            let edge = if at.tangential < index { room } else { 1.0 };
            Case { scattered, grazing: least(&[&[wave], &back]).min(edge) }
        }
        1 if at.tangential < index => {
            let scattered = at.enter(index, &on).to_vec();
            Case { scattered, grazing: least(&[&on]).min(room) }
        }
        _ => {
            let other = self::crystal(random);
            let on = other.waves(at.q(), normal, 1.0);
            let scattered = vec![at.between(&wave, &back, &on)];
            Case { scattered, grazing: least(&[&[wave], &back, &on]) }
        }
    }
}

fn worst_energy(case: &Case) -> f64 {
    let error = |s: &Scattered| (s.power() - 1.0).abs();
    // NaN must not pass for a small number.
    case.scattered.iter().map(error).fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

#[test]
fn power_is_conserved() {
    let random = &mut Random(1);
    let (mut steep, mut any): (f64, f64) = (0.0, 0.0);
    for _ in 0..1_000_000 {
        let (crystal, direction) = (crystal(random), random.direction().to_array());
        let case = case(random, &crystal, direction);
        let error = worst_energy(&case);
        assert!(error.is_finite(), "{crystal:?} {direction:?}");
        any = any.max(error);
        if case.grazing > 0.03 {
            steep = steep.max(error);
        }
    }
    println!("worst |R + T − 1|: {steep:.1e}, with grazing {any:.1e}");
    assert!(steep <= 1e-10 && any <= 1e-2);
}

/// Biaxial crystals about their axes, also where a surface cuts the cone of rays, with a wave on either side of it.
#[test]
fn power_is_conserved_on_and_around_optic_axes() {
    let random = &mut Random(2);
    let mut worst: f64 = 0.0;
    for k in 0..100_000 {
        let crystal = crystal(random);
        let direction = beside(optic_axes(&crystal)[k % 2], (k % 19) as i32, random);
        let case = case(random, &crystal, direction);
        let error = worst_energy(&case);
        assert!(error.is_finite(), "{crystal:?} {direction:?}");
        if case.grazing > 0.03 {
            worst = worst.max(error);
        }
    }
    println!("worst |R + T − 1|: {worst:.1e}");
    assert!(worst <= 1e-6);
}

/// What a metal takes is what flows into it: Re(E × H*)·n of the whole field.
#[test]
fn a_metal_takes_the_rest() {
    let random = &mut Random(3);
    for _ in 0..20_000 {
        let (crystal, direction) = (crystal(random), random.direction().to_array());
        let wave = crystal.waves([0.0; 3], direction, 1.0)[random.below(2)];
        let normal = random.direction().to_array();
        let sign = wave.at(normal).flux.signum();
        let normal = normal.map(|x| sign * x);
        let wave = wave.at(normal);
        let at = Incidence::new(wave.wave_vector(), normal);
        let back = crystal.reflections(&wave, &at);
        let index = [0.2 + 3.0 * random.unit(), 0.5 + 4.0 * random.unit()];
        let out = at.leave(&wave, &back, index);
        let mut fields = [wave.electric, wave.magnetic];
        for (amplitude, reflected) in out.back.iter().zip(&back).filter(|(_, w)| w.propagates()) {
            let factor = amplitude * (wave.flux / reflected.flux.abs()).sqrt();
            for (sum, field) in fields.iter_mut().zip([reflected.electric, reflected.magnetic]) {
                *sum = std::array::from_fn(|i| sum[i] + factor * field[i]);
            }
        }
        let [e, h] = fields;
        let re = |e: [Complex64; 3], h: [Complex64; 3]| {
            let product = |i: usize, j: usize| (e[i] * h[j].conj()).re - (e[j] * h[i].conj()).re;
            [product(1, 2), product(2, 0), product(0, 1)]
        };
        let steep = back.iter().chain([&wave]).map(|w| steepness(w, normal)).fold(1.0, f64::min);
        if steep > 0.01 && back.iter().all(Wave::propagates) {
            near(out.power() + dot(re(e, h), normal) / wave.flux, 1.0, 1e-10, "power");
            assert!(out.power() < 1.0 && out.on == [Complex64::ZERO; 2]);
        }
    }
}

/// With equal indices s and p are Fresnel's, whatever the axis.
#[test]
fn equal_indices_are_isotropic() {
    let random = &mut Random(4);
    for _ in 0..10_000 {
        let axes = orientation(random);
        let n = 1.3 + random.unit();
        let crystal = match random.below(2) {
            0 => Crystal::uniaxial([n, n], axes[0]),
            _ => Crystal::new([n, n * (1.0 + 1e-14), n * (1.0 - 1e-14)], axes),
        };
        let (normal, cos) = (axes[1], 0.01 + 0.98 * random.unit());
        let sin = (1.0 - cos * cos).sqrt();
        let direction: V = std::array::from_fn(|i| cos * normal[i] + sin * axes[2][i]);
        let outside = 1.0 + random.unit();
        let at = Incidence::new(direction.map(|x| x * outside), normal);
        let [s, p] = at.enter(outside, &crystal.waves(at.q(), normal, 1.0));
        let expected = dielectric(cos, outside / n);
        check(&expected, [s.back[0], p.back[1], s.back[1], p.back[0]]);
        // From inside: the mode is s and p in the proportion of its field.
        let at = Incidence::new(direction.map(|x| x * n), normal);
        let [on, back] = [1.0, -1.0].map(|side| crystal.waves(at.q(), normal, side));
        let mode = &on[random.below(2)];
        for (index, expected) in [
            ([outside, 0.0], dielectric(cos, n / outside)),
            ([outside, 2.0], conductor(cos, n, outside, 2.0)),
        ] {
            let out = at.leave(mode, &back, index);
            let e = mode.electric.map(|x| x.re);
            let share = dot(e, at.s).powi(2) / dot(e, e);
            let r = share * expected.reflectance_s + (1.0 - share) * expected.reflectance_p;
            near(out.back[0].norm_sqr() + out.back[1].norm_sqr(), r, 1e-10, "reflected");
            let t = [share * expected.transmittance_s, (1.0 - share) * expected.transmittance_p];
            near(out.on[0].norm_sqr(), t[0], 1e-10, "transmitted, s");
            near(out.on[1].norm_sqr(), t[1], 1e-10, "transmitted, p");
        }
    }
}

fn check(expected: &Fresnel<f64>, [s, p, s_to_p, p_to_s]: [Complex64; 4]) {
    near(s.norm_sqr(), expected.reflectance_s, 1e-10, "s");
    near(p.norm_sqr(), expected.reflectance_p, 1e-10, "p");
    let cross = s * p.conj();
    near(cross.re, expected.reflected_cross[0], 1e-10, "cross");
    near(cross.im, expected.reflected_cross[1], 1e-10, "cross");
    near(s_to_p.norm() + p_to_s.norm(), 0.0, 1e-10, "mixed");
}

/// 1 where two fields point the same way, −1 where a wave was found with the opposite sign.
fn sign(a: &Wave, b: &Wave) -> f64 {
    dot(a.electric.map(|x| x.re), b.electric.map(|x| x.re)).signum()
}

/// A crystal's surface in an isotropic medium: the waves towards it and away from it, and S[j][i] from channel i to j; channels
/// are the crystal's waves, then s and p.
struct Surface {
    towards: [Wave; 2],
    away: [Wave; 2],
    amplitudes: [[Complex64; 4]; 4],
}

fn surface(crystal: &Crystal, at: &Incidence, index: f64) -> Surface {
    let [towards, away] = [1.0, -1.0].map(|side| crystal.waves(at.q(), at.normal, side));
    let inside = towards.map(|wave| at.leave(&wave, &away, [index, 0.0]));
    let beyond = Incidence { normal: at.normal.map(|x| -x), s: at.s.map(|x| -x), ..*at };
    let outside = beyond.enter(index, &away);
    let mut amplitudes = [[Complex64::ZERO; 4]; 4];
    for i in 0..2 {
        for j in 0..2 {
            amplitudes[j][i] = inside[i].back[j];
            amplitudes[j + 2][i] = inside[i].on[j];
            // e_s of `beyond` is −e_s.
            amplitudes[j][i + 2] = -outside[i].on[j];
            amplitudes[j + 2][i + 2] = outside[i].back[j];
        }
    }
    Surface { towards, away, amplitudes }
}

/// S_ji = S_īj̄: light that is sent back meets the same amplitudes.
#[test]
fn amplitudes_are_reciprocal() {
    let random = &mut Random(5);
    let mut compared = 0;
    for _ in 0..100_000 {
        let (crystal, normal, outside) =
            (crystal(random), random.direction().to_array(), 1.0 + random.unit());
        let at = Incidence::new(random.direction().to_array().map(|x| x * outside), normal);
        let back = Incidence { u: at.u.map(|x| -x), s: at.s.map(|x| -x), ..at };
        let [a, b] = [at, back].map(|at| surface(&crystal, &at, outside));
        let waves = a.towards.iter().chain(&a.away);
        if at.tangential > 0.999 * outside
            || waves.into_iter().any(|w| !w.propagates() || steepness(w, normal) < 0.05)
        {
            continue;
        }
        // s turns with the plane of incidence, p twice.
        let signs =
            |from: &[Wave; 2], to: &[Wave; 2]| [sign(&from[0], &to[0]), sign(&from[1], &to[1]), -1.0, 1.0];
        let (ins, outs) = (signs(&a.towards, &b.away), signs(&a.away, &b.towards));
        for (j, turned_out) in outs.iter().enumerate() {
            for (i, turned_in) in ins.iter().enumerate() {
                let (one, other) = (a.amplitudes[j][i], b.amplitudes[i][j] * turned_in * turned_out);
                assert!((one - other).norm() < 1e-10, "{i} → {j}: {one} {other}, {crystal:?} {at:?}");
            }
        }
        compared += 1;
    }
    assert!(compared > 50_000, "{compared}");
}

/// The weights of an event's children add up to their parent's, for every row.
#[test]
fn weights_add_up() {
    let random = &mut Random(6);
    for _ in 0..50_000 {
        let (crystal, normal) = (crystal(random), random.direction().to_array());
        let at = Incidence::new(random.direction().to_array(), normal);
        let row = StokesRow(std::array::from_fn(|k| if k == 0 { 2.0 } else { 2.0 * random.unit() - 1.0 }));
        let [s, p] = at.enter(1.0, &crystal.waves(at.q(), normal, 1.0));
        let modes = [0, 1].map(|j| into_mode(row, [s.on[j], p.on[j]]));
        let back = reflected(row, [s.back, p.back]).intensity();
        assert!(modes[0] >= -1e-12 && modes[1] >= -1e-12 && back >= -1e-12);
        if at.tangential < 0.999 {
            near(modes[0] + modes[1] + back, row.intensity(), 1e-10, "into a crystal");
            let waves = [1.0, -1.0].map(|side| crystal.waves(at.q(), normal, side));
            let out = at.leave(&waves[0][0], &waves[1], [1.0, 0.0]);
            let row = from_mode(0.7, out.on);
            let back = out.back.map(|a| 0.7 * a.norm_sqr());
            near(back[0] + back[1] + row.intensity(), 0.7, 1e-10, "out of it");
        }
    }
}

/// Out of one crystal and into another, over a reflection off a third: the weight is |amplitude|² of the same way forwards.
#[test]
fn rows_between_crystals_are_products_of_amplitudes() {
    let random = &mut Random(7);
    for _ in 0..20_000 {
        let crystals = [0, 1, 2].map(|_| crystal(random));
        let direction = random.direction().to_array();
        let facing = |random: &mut Random, along: V| {
            let n = random.direction().to_array();
            let sign = dot(n, along).signum();
            n.map(|x| sign * x)
        };
        let normals = [facing(random, direction), facing(random, direction)];
        // In a dense medium one mode may be evanescent, and light circularly polarised.
        let outside = [1.0, 1.6, 1.8, 2.7][random.below(4)];
        let incidence = |along: V, normal: V| Incidence::new(along.map(|x| x * outside), normal);
        let (first, second) = (incidence(direction, normals[0]), incidence(direction, normals[1]));
        let cos = dot(direction, normals[1]);
        let next: V = std::array::from_fn(|i| direction[i] - 2.0 * cos * normals[1][i]);
        let third = incidence(next, facing(random, next));
        // Backwards along the ray: rows and frames.
        let [towards, away] = [1.0, -1.0].map(|side| crystals[0].waves(first.q(), normals[0], side));
        let Some(mode) = towards.iter().find(|wave| wave.propagates()) else { continue };
        let leaving = first.leave(mode, &away, [outside, 0.0]);
        let turned = |row: StokesRow<f64>, along: V, from: &Incidence, to: &Incidence| {
            let frame = align(along, from.s, to.normal);
            row.rotated(frame.cos2, frame.sin2)
        };
        let row = turned(from_mode(1.0, leaving.on), direction, &first, &second);
        let [s, p] = second.enter(outside, &crystals[1].waves(second.q(), normals[1], 1.0));
        let row = turned(reflected(row, [s.back, p.back]), next, &second, &third);
        let [into_s, into_p] = third.enter(outside, &crystals[2].waves(third.q(), third.normal, 1.0));
        let weight = into_mode(row, [into_s.on[0], into_p.on[0]]);
        // Forwards along it: fields in space. E_p is along e_s × d.
        let components = |field: [Complex64; 3], at: &Incidence, along: V| {
            [at.s, cross(at.s, along)].map(|e| field[0] * e[0] + field[1] * e[1] + field[2] * e[2])
        };
        let field = |[s, p]: [Complex64; 2], at: &Incidence, along: V| -> [Complex64; 3] {
            let e_p = cross(at.s, along);
            std::array::from_fn(|i| s * at.s[i] + p * e_p[i])
        };
        let [a, b] = components(field(leaving.on, &first, direction), &second, direction);
        let back = [0, 1].map(|j| a * s.back[j] + b * p.back[j]);
        let [a, b] = components(field(back, &second, next), &third, next);
        let amplitude = a * into_s.on[0] + b * into_p.on[0];
        near(weight, amplitude.norm_sqr(), 1e-10, "weight");
    }
}
