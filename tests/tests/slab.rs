//! One plate against the closed forms of optics, by every algorithm.
//!
//! The published figures were computed independently in high precision from the same equations (Born & Wolf, *Principles
//! of Optics*, §1.5), to six or eight digits.

use gemtrace_tests::prelude::*;
use spectral_core::material::Material;

/// The radiance along one ray that meets the plate's upper face at `angle` degrees from its normal, without any symmetry.
fn seen(
    way: Way,
    angle: f64,
    thickness: f64,
    material: Material,
    light: Environment,
    settings: &RenderSettings,
) -> f64 {
    let (sin, cos) = angle.to_radians().sin_cos();
    let direction = DVec3::new(sin * 0.8, sin * 0.6, -cos);
    let camera = probe(DVec3::new(0.37, -0.21, 0.0) - 20.0 * direction, direction, 1e-3);
    let scene = scene(camera, 1, light, vec![stone(plate(60.0, thickness), material)]);
    way.render(&scene, settings).first_line()[0]
}

/// (T, R) of a plate with face reflectance `r` and internal transmittance `a`: the sum of all inner reflections,
/// T = (1 − r)²a/(1 − r²a²), R = r + (1 − r)²ra²/(1 − r²a²).
fn airy_energies(r: f64, a: f64) -> [f64; 2] {
    let through = (1.0 - r).powi(2) / (1.0 - (r * a).powi(2));
    [through * a, r + through * r * a * a]
}

/// [`airy_energies`] for unpolarised light, with polarisation or with the mean of s and p at each event.
fn slab(n: f64, angle: f64, a: f64, polarized: bool) -> [f64; 2] {
    let [s, p] = reflectances(n, angle);
    if !polarized {
        return airy_energies((s + p) / 2.0, a);
    }
    let (s, p) = (airy_energies(s, a), airy_energies(p, a));
    [(s[0] + p[0]) / 2.0, (s[1] + p[1]) / 2.0]
}

/// Index, R = ((n − 1)/(n + 1))², and of a lossless plate T = 2n/(n² + 1) and R = (n − 1)²/(n² + 1).
const NORMAL_INCIDENCE: [[f64; 4]; 6] = [
    [1.5168, 0.042_164_56, 0.919_082_72, 0.080_917_28],
    [1.54421, 0.045_753_8, 0.912_496_05, 0.087_503_95],
    [1.76808, 0.076_993_78, 0.857_020_94, 0.142_979_06],
    [2.15847, 0.134_529_05, 0.762_846, 0.237_154],
    [2.41726, 0.172_005_77, 0.706_476_24, 0.293_523_76],
    [2.64744, 0.204_005_98, 0.661_121_32, 0.338_878_68],
];

#[test]
fn normal_incidence() {
    let settings = settings(&[550.0]);
    for way in Way::ALL {
        let tolerance = way.tolerance(5e-7, 5e-8);
        for [n, face, through, back] in NORMAL_INCIDENCE {
            // The glass is so dark that its back face does not show.
            let black = seen(way, 0.0, 1.0, tinted(n, 50.0), furnace(), &settings);
            close(black, face, tolerance, format!("{way:?}, face of n = {n}"));
            let below = seen(way, 0.0, 1.0, glass(n), half(-DVec3::Z), &settings);
            close(below, through, tolerance, format!("{way:?}, transmittance at n = {n}"));
            let above = seen(way, 0.0, 1.0, glass(n), half(DVec3::Z), &settings);
            close(above, back, tolerance, format!("{way:?}, reflectance at n = {n}"));
        }
    }
}

#[test]
fn brewster_reflects_s_alone() {
    // At tan θ = n: R_p = 0 and R_s = ((n² − 1)/(n² + 1))².
    for (n, brewster) in [(1.5168_f64, 56.603_83), (1.76808, 60.508_14), (2.41726, 67.525_53)] {
        close(n.atan().to_degrees(), brewster, 5e-6, "Brewster's angle");
        let expected = ((n * n - 1.0) / (n * n + 1.0)).powi(2) / 2.0;
        for way in Way::ALL {
            let angle = n.atan().to_degrees();
            let found = seen(way, angle, 1.0, tinted(n, 80.0), furnace(), &settings(&[550.0]));
            close(found, expected, way.tolerance(5e-7, 5e-8), format!("{way:?}, n = {n}"));
        }
    }
}

/// Checks (T, R) of a plate by every algorithm, each in the light of one half sphere.
fn check_plate(
    angle: f64,
    thickness: f64,
    material: Material,
    expected: [f64; 2],
    settings: &RenderSettings,
) {
    for way in Way::ALL {
        for (axis, expected) in [-DVec3::Z, DVec3::Z].into_iter().zip(expected) {
            let found = seen(way, angle, thickness, material.clone(), half(axis), settings);
            let what = format!("{way:?}, {angle}°, light from {axis}, polarised {}", settings.polarized);
            close(found, expected, way.tolerance(1e-6, 5e-8), what);
        }
    }
}

#[test]
fn lossless_plate_at_any_angle() {
    // Angle, T with polarisation, T with the mean of s and p at each event; n = 1.5168.
    let figures = [
        (0.0, 0.919_083, 0.919_083),
        (30.0, 0.916_724, 0.916_22),
        (45.0, 0.903_299, 0.900_066),
        (60.0, 0.844_208, 0.831_572),
        (75.0, 0.615_321, 0.592_174),
    ];
    for (angle, separate, mean) in figures {
        for (polarized, published) in [(true, separate), (false, mean)] {
            let settings = RenderSettings { polarized, ..settings(&[550.0]) };
            let [through, back] = slab(1.5168, angle, 1.0, polarized);
            close(through, published, 1e-6, "closed form against published figure");
            check_plate(angle, 1.0, glass(1.5168), [through, back], &settings);
        }
    }
}

#[test]
fn absorbing_plate() {
    // α = 3/cm over 5 mm at normal incidence, n = 1.76808.
    let [through, back] = slab(1.76808, 0.0, (-1.5_f64).exp(), true);
    close(through, 0.190_149_74, 5e-9, "T against published figure");
    close(back, 0.080_260_48, 5e-9, "R against published figure");
    for polarized in [true, false] {
        let settings = RenderSettings { polarized, ..settings(&[550.0]) };
        for angle in [0.0, 40.0, 75.0_f64] {
            // The path through the plate is its thickness over the cosine inside.
            let length = 5.0 / (1.0 - (angle.to_radians().sin() / 1.76808).powi(2)).sqrt();
            let [through, back] = slab(1.76808, angle, (-0.3 * length).exp(), polarized);
            check_plate(angle, 5.0, tinted(1.76808, 0.3), [through, back], &settings);
        }
    }
}

#[test]
fn beer_lambert_over_any_length() {
    // The first transmitted ray alone: two events, (1 − R)² exp(−αL).
    let settings = RenderSettings { max_depth: 2, leftover: Leftover::Drop, ..settings(&[550.0]) };
    let [r, _] = reflectances(1.77, 0.0);
    for length in [0.01, 0.1, 1.0, 10.0_f64] {
        for absorption in [1e-3, 0.02, 0.5, 1.3_f64] {
            let expected = (1.0 - r).powi(2) * (-absorption * length).exp();
            for way in Way::ALL {
                let found = seen(way, 0.0, length, tinted(1.77, absorption), half(-DVec3::Z), &settings);
                // A length in single precision is as exact as the coordinates of the 60 mm plate.
                let rounding = way.tolerance(1e-6 + 4e-6 * absorption, 1e-7);
                close(found / expected, 1.0, rounding, format!("{way:?}, {length} mm at {absorption}/mm"));
            }
        }
    }
}

/// Born & Wolf §14.2 in real arithmetic: with 2a² = √((n² − k² − sin²)² + 4n²k²) + n² − k² − sin² and b² likewise.
fn conductor(n: f64, k: f64, angle: f64) -> f64 {
    let (sin, cos) = angle.to_radians().sin_cos();
    let tan = sin / cos;
    let real = n * n - k * k - sin * sin;
    let root = (real * real + 4.0 * n * n * k * k).sqrt();
    let (ab2, a) = (root, ((root + real) / 2.0).sqrt());
    let s = (ab2 - 2.0 * a * cos + cos * cos) / (ab2 + 2.0 * a * cos + cos * cos);
    let st = sin * tan;
    let p = s * (ab2 - 2.0 * a * st + st * st) / (ab2 + 2.0 * a * st + st * st);
    (s + p) / 2.0
}

#[test]
fn a_metal_mirror_has_the_reflectance_of_its_index() {
    let gold = material("gold");
    let tabulated = [450.0, 550.0, 650.0].map(|nm| (gold.index(nm), gold.extinction(nm), nm));
    for (n, k, nm) in [(0.29, 2.863, 550.0), (1.5, 7.6, 550.0)].into_iter().chain(tabulated) {
        for angle in [0.0, 30.0, 60.0, 85.0] {
            let expected = conductor(n, k, angle);
            for (way, polarized) in [(Way::Planes, true), (Way::Tree, false), (Way::Reference, true)] {
                let settings = RenderSettings { polarized, ..settings(&[nm]) };
                let found = seen(way, angle, 1.0, metal(n, k), furnace(), &settings);
                close(found, expected, way.tolerance(1e-6, 1e-7), format!("{way:?}, {n} + {k}i, {angle}°"));
            }
        }
    }
}
