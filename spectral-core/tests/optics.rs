//! Fresnel's equations, refraction and absorption against closed forms.
//!
//! The figures were computed independently from the formulas named beside them, for the indices of six
//! substances at one Fraunhofer line each.

use spectral_core::absorption::{Absorption, Term};
use spectral_core::dispersion::fraunhofer;
use spectral_core::fresnel::{Fresnel, conductor, dielectric};
use spectral_core::material::Catalogue;
use spectral_core::stokes::{Scalar, StokesRow};

/// Name, n, R at normal incidence, critical angle, Brewster's angle from outside and from within (degrees),
/// transmittance of a slab at normal incidence with all inner reflections.
type Row = (&'static str, f64, f64, f64, f64, f64, f64);
const SUBSTANCES: [Row; 6] = [
    ("N-BK7, d", 1.5168, 0.04216456, 41.24519, 56.60383, 33.39617, 0.91908272),
    ("quartz o, D", 1.54421, 0.0457538, 40.35942, 57.0737, 32.9263, 0.91249605),
    ("corundum o, D", 1.76808, 0.07699378, 34.44294, 60.50814, 29.49186, 0.85702094),
    ("cubic zirconia, D", 2.15847, 0.13452905, 27.59968, 65.14213, 24.85787, 0.762846),
    ("diamond, D", 2.41726, 0.17200577, 24.43694, 67.52553, 22.47447, 0.70647624),
    ("moissanite o, D", 2.64744, 0.20400598, 22.19274, 69.30728, 20.69272, 0.66112132),
];

fn near(actual: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((actual - expected).abs() <= tolerance, "{what}: {actual} instead of {expected}");
}

fn cos_degrees(angle: f64) -> f64 {
    angle.to_radians().cos()
}

#[test]
fn normal_incidence() {
    for (name, n, reflectance, ..) in SUBSTANCES {
        for eta in [n, 1.0 / n] {
            let event = dielectric(1.0, eta);
            near(event.reflectance(), reflectance, 5e-9, name);
            near(event.reflectance(), ((n - 1.0) / (n + 1.0)).powi(2), 1e-15, name);
            assert_eq!(event.cos_t, 1.0);
            // r_p = −r_s, since e_p reverses with the light.
            near(event.reflected_cross[0], -event.reflectance(), 1e-15, name);
        }
    }
}

#[test]
fn brewster_from_both_sides() {
    for (name, n, _, _, outside, inside, _) in SUBSTANCES {
        for (tangent, eta, tabulated) in [(n, 1.0 / n, outside), (1.0 / n, n, inside)] {
            let angle = tangent.atan();
            near(angle.to_degrees(), tabulated, 5e-6, name);
            let event = dielectric(angle.cos(), eta);
            assert!(event.reflectance_p < 1e-12, "{name}: {}", event.reflectance_p);
            // There R_s = cos²(2θ_B), since the reflected and the refracted ray are perpendicular.
            near(event.reflectance_s, (2.0 * angle).cos().powi(2), 1e-14, name);
        }
    }
}

#[test]
fn critical_angle() {
    for (name, n, _, critical, ..) in SUBSTANCES {
        let sine = 1.0 / n;
        near(sine.asin().to_degrees(), critical, 5e-6, name);
        let below = dielectric(cos_degrees(critical - 1e-4), n);
        let above = dielectric(cos_degrees(critical + 1e-4), n);
        assert!(!below.tir && below.reflectance() < 1.0 && below.transmittance() > 0.0, "{name}");
        assert!(above.tir && above.reflectance() == 1.0 && above.transmittance() == 0.0, "{name}");
        assert!(!dielectric(cos_degrees(89.9), 1.0 / n).tir, "{name}: never from the thin side");
    }
}

#[test]
fn phase_of_total_reflection() {
    // tan(δ/2) = cos θ √(sin²θ − n⁻²)/sin²θ, δ = δ_s − δ_p (Born & Wolf, §1.5.4).
    for n in [1.5168_f64, 1.76808, 2.41726] {
        let critical = (1.0 / n).asin();
        for i in 1..100 {
            let angle = critical + (std::f64::consts::FRAC_PI_2 - critical) * f64::from(i) / 100.0;
            let (sin, cos) = angle.sin_cos();
            let delta = 2.0 * (cos * (sin * sin - 1.0 / (n * n)).sqrt() / (sin * sin)).atan();
            let [re, im] = dielectric(cos, n).reflected_cross;
            near(re, delta.cos(), 1e-13, "cos δ");
            near(im, delta.sin(), 1e-13, "sin δ");
        }
    }
    // Fresnel's rhomb: two reflections at 54.6° in crown glass of n = 1.51 make a quarter wave.
    let [re, im] = dielectric(cos_degrees(54.62), 1.51).reflected_cross;
    near(im.atan2(re).to_degrees(), 45.0, 0.02, "Fresnel's rhomb");
}

#[test]
fn phase_is_continuous_at_the_critical_angle() {
    let n = 2.41726_f64;
    let critical = (1.0 / n).asin();
    for side in [-1e-14, 1e-14] {
        let [re, im] = dielectric((critical + side).cos(), n).reflected_cross;
        near(re, 1.0, 1e-5, "re");
        near(im, 0.0, 1e-5, "im");
    }
}

#[test]
fn a_conductor_without_absorption_is_a_dielectric() {
    // One formula with complex indices against two with real ones, with amplitudes and phases.
    for (n1, n2) in [(1.0, 1.5168), (1.5168, 1.0), (2.41726, 1.33)] {
        for i in 0..=90 {
            let cos = cos_degrees(f64::from(i));
            let (metal, glass) = (conductor(cos, n1, n2, 0.0), dielectric(cos, n1 / n2));
            near(metal.reflectance_s, glass.reflectance_s, 1e-12, "s");
            near(metal.reflectance_p, glass.reflectance_p, 1e-12, "p");
            near(metal.reflected_cross[0], glass.reflected_cross[0], 1e-12, "re");
            near(metal.reflected_cross[1], glass.reflected_cross[1], 1e-12, "im");
        }
    }
}

#[test]
fn metals() {
    // Normal incidence, ((n − 1)² + k²)/((n + 1)² + k²), and the limits of grazing incidence.
    for name in ["gold", "silver", "platinum"] {
        let metal = Catalogue::builtin().get(name).unwrap();
        for nm in [400.0, 550.0, 700.0] {
            let (n, k) = (metal.index(nm), metal.extinction(nm));
            let expected = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
            near(conductor(1.0, 1.0, n, k).reflectance(), expected, 1e-14, name);
            let grazing = conductor(0.0, 1.0, n, k);
            near(grazing.reflectance(), 1.0, 1e-12, name);
            assert_eq!(grazing.transmittance(), 0.0);
        }
    }
    let gold = Catalogue::builtin().get("gold").unwrap();
    let shine = |nm| conductor(1.0, 1.0, gold.index(nm), gold.extinction(nm)).reflectance();
    assert!(shine(450.0) < 0.45 && shine(650.0) > 0.94, "gold is yellow: {} {}", shine(450.0), shine(650.0));
}

/// Checks the invariants of any event.
fn check_bounds(event: &Fresnel<f64>, what: &str) {
    for energy in [event.reflectance_s, event.reflectance_p, event.transmittance_s, event.transmittance_p] {
        assert!((0.0..=1.0).contains(&energy), "{what}: {event:?}");
    }
    let [re, im] = event.reflected_cross;
    near(re * re + im * im, event.reflectance_s * event.reflectance_p, 1e-14, what);
    assert!((0.0..=1.0).contains(&event.cos_t), "{what}: {event:?}");
}

#[test]
fn energy_is_conserved_exactly_from_normal_to_grazing() {
    for n in [1.0, 1.0 + 1e-15, 1.000001, 1.3, 1.5168, 2.41726, 2.9, 10.0] {
        for eta in [n, 1.0 / n] {
            for i in 0..=2000 {
                let cos = (f64::from(i) / 2000.0).powi(4);
                let event = dielectric(cos, eta);
                check_bounds(&event, &format!("η {eta}, cos {cos}"));
                assert_eq!(event.reflectance_s + event.transmittance_s, 1.0);
                let narrow = dielectric(cos as f32, eta as f32);
                let sum = narrow.reflectance_p + narrow.transmittance_p;
                assert!((0.0..=1.0).contains(&narrow.reflectance_p) && sum == 1.0, "{narrow:?}");
            }
        }
    }
    assert_eq!(dielectric(0.3, 1.0).reflectance(), 0.0);
    assert_eq!(dielectric(0.0_f32, 1.0).reflectance(), 0.0);
    near(dielectric(0.0, 1.0 / 1.5).reflectance(), 1.0, 1e-15, "grazing");
    assert_eq!(dielectric(0.0, 1.5).reflectance(), 1.0);
}

#[test]
fn single_precision_agrees_with_double() {
    // The same inputs in both precisions, also near the critical angle, where simple f32 formulas lose 3e-4.
    for n in [1.5168_f32, 1.76808, 2.41726] {
        for i in 0..=100_000 {
            let cos = i as f32 * 1e-5;
            let (a, b) = (dielectric(cos, n), dielectric(f64::from(cos), f64::from(n)));
            assert_eq!(a.tir, b.tir);
            near(f64::from(a.cos_t), b.cos_t, 1e-7, "cos θ₂");
            near(f64::from(a.reflectance_s), b.reflectance_s, 1e-6, "R_s");
            near(f64::from(a.reflectance_p), b.reflectance_p, 1e-6, "R_p");
            near(f64::from(a.reflected_cross[0]), b.reflected_cross[0], 1e-6, "cross");
        }
    }
}

/// ∫₀¹ f(x) dx by Simpson's rule.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    let steps = 200_000;
    let h = 1.0 / f64::from(steps);
    let sum: f64 = (0..=steps)
        .map(|i| f(f64::from(i) * h) * if i == 0 || i == steps { 1.0 } else { f64::from(2 + 2 * (i % 2)) })
        .sum();
    sum * h / 3.0
}

#[test]
fn hemispherical_reflectance() {
    // Under diffuse light 1 − R_internal = (1 − R_external)/n²: in uniform light, the light that enters a stone must leave
    // it, or the stone would not be invisible.
    for (n, external, internal) in
        [(1.5168, 0.09424, 0.606308), (1.768, 0.129694, 0.721576), (2.41726, 0.212218, 0.865178)]
    {
        let diffuse = |eta: f64| integral(|mu| dielectric(mu, eta).reflectance() * 2.0 * mu);
        let (outside, inside) = (diffuse(1.0 / n), diffuse(n));
        near(outside, external, 1e-6, "external");
        near(inside, internal, 1e-6, "internal");
        near(1.0 - inside, (1.0 - outside) / (n * n), 1e-6, "identity");
    }
}

/// Transmittance of a plane slab at `angle` degrees, polarised and scalar, as a sum over inner reflections; `inner` is the
/// internal transmittance of one pass.
fn slab(n: f64, angle: f64, inner: f64) -> (f64, f64) {
    let entry = dielectric(cos_degrees(angle), 1.0 / n);
    let exit = dielectric(entry.cos_t, n);
    let mut row = StokesRow::eye().refracted(&entry).scaled(inner);
    let mut mean = Scalar::eye().refracted(&entry).scaled(inner);
    let (mut polarised, mut scalar) = (0.0, 0.0);
    for _ in 0..200 {
        polarised += row.refracted(&exit).intensity();
        scalar += mean.refracted(&exit).intensity();
        row = row.reflected(&exit).scaled(inner).reflected(&exit).scaled(inner);
        mean = mean.reflected(&exit).scaled(inner).reflected(&exit).scaled(inner);
    }
    (polarised, scalar)
}

#[test]
fn lossless_slab() {
    for (name, n, reflectance, .., transmittance) in SUBSTANCES {
        let (polarised, scalar) = slab(n, 0.0, 1.0);
        near(polarised, transmittance, 5e-9, name);
        near(scalar, transmittance, 5e-9, name);
        near(polarised, (1.0 - reflectance) / (1.0 + reflectance), 1e-8, name);
    }
    for (angle, polarised, scalar) in [
        (0.0, 0.919083, 0.919083),
        (30.0, 0.916724, 0.91622),
        (45.0, 0.903299, 0.900066),
        (60.0, 0.844208, 0.831572),
        (75.0, 0.615321, 0.592174),
    ] {
        let found = slab(1.5168, angle, 1.0);
        near(found.0, polarised, 5.1e-7, "polarised");
        near(found.1, scalar, 5.1e-7, "scalar");
    }
}

#[test]
fn absorbing_slab() {
    // Corundum, 3 cm⁻¹ over half a centimetre.
    let absorption = Absorption::new(vec![Term::Constant(0.3)]).unwrap();
    let inner = absorption.transmittance(589.0, 5.0);
    near(inner, (-1.5_f64).exp(), 1e-15, "Beer-Lambert");
    let (transmitted, _) = slab(1.76808, 0.0, inner);
    near(transmitted, 0.19014974, 5e-9, "transmittance");
    let r = ((1.76808_f64 - 1.0) / 2.76808).powi(2);
    let closed = (1.0 - r).powi(2) * inner / (1.0 - r * r * inner * inner);
    near(transmitted, closed, 1e-15, "closed form");
    near(r + r * inner * closed, 0.08026048, 5e-9, "reflectance");
}

/// Deviation in radians of a ray through a prism of apex `apex` radians: a 2-D trace with Snell's law from the Fresnel
/// formulas.
fn deviation(n: f64, apex: f64, incidence: f64) -> Option<f64> {
    let inside = dielectric(incidence.cos(), 1.0 / n).cos_t.acos();
    let second = apex - inside;
    let exit = dielectric(second.abs().cos(), n);
    (!exit.tir).then(|| incidence + exit.cos_t.acos().copysign(second) - apex)
}

#[test]
fn prism_minimum_deviation() {
    let glass = Catalogue::builtin().get("n-bk7").unwrap();
    let apex = 60.0_f64.to_radians();
    for (nm, n, degrees) in [
        (fraunhofer::C, 1.5143224, 38.429144),
        (fraunhofer::LOWER_D, 1.5168001, 38.646705),
        (fraunhofer::F, 1.5223765, 39.138126),
    ] {
        near(glass.index(nm), n, 5.1e-8, "index");
        let n = glass.index(nm);
        let least = (0..=400_000)
            .filter_map(|i| deviation(n, apex, (40.0 + f64::from(i) * 5e-5).to_radians()))
            .fold(f64::INFINITY, f64::min);
        near(least.to_degrees(), degrees, 2e-6, "traced");
        near(least, 2.0 * (n * (0.5 * apex).sin()).asin() - apex, 1e-11, "closed form");
    }
}

#[test]
fn snell_across_the_fraunhofer_lines() {
    for name in ["diamond", "moissanite", "n-bk7"] {
        let material = Catalogue::builtin().get(name).unwrap();
        for (line, nm) in fraunhofer::LINES {
            let n = material.index(nm);
            for degrees in [5.0, 30.0, 60.0, 85.0] {
                let angle = f64::to_radians(degrees);
                let refracted = dielectric(angle.cos(), 1.0 / n).cos_t.acos();
                near(n * refracted.sin(), angle.sin(), 1e-14, line);
                let back = dielectric(refracted.cos(), n);
                near(back.cos_t, angle.cos(), 1e-12, line);
                // Reversing the light changes no energy (Stokes's relations).
                near(back.reflectance_s, dielectric(angle.cos(), 1.0 / n).reflectance_s, 1e-12, line);
            }
        }
    }
}
