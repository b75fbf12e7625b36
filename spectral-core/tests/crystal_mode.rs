//! Waves in crystals against closed forms: indices, rays, optic axes, absorption.

use num_complex::Complex64;
use spectral_core::color::matrix::{cross, dot};
use spectral_core::crystal::{Crystal, Incidence, Wave};

mod support;
use support::{Random, near, orientation};

type V = [f64; 3];

const UP: V = [0.0, 0.0, 1.0];
const AXES: [V; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], UP];

fn real(v: [Complex64; 3]) -> V {
    v.map(|x| x.re)
}

fn crystal(random: &mut Random) -> Crystal {
    let axes = orientation(random);
    let mut index = || 1.4 + 0.8 * random.unit();
    match [index(), index(), index()] {
        [o, e, third] if third > 1.8 => Crystal::uniaxial([o, e], axes[2]),
        all => Crystal::new(all, axes),
    }
}

#[test]
fn the_largest_walk_off_of_calcite() {
    let [o, e]: [f64; 2] = [1.65835, 1.48640];
    let walk_off = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Crystal::uniaxial([o, e], [sin, 0.0, cos]).waves([0.0; 3], UP, 1.0)[1].walk_off().to_degrees()
    };
    let at = (e / o).atan().to_degrees();
    near(at, 41.870, 5e-4, "where");
    near(walk_off(at), 6.259454, 5e-7, "how much");
    assert!(walk_off(at) > walk_off(at + 0.01) && walk_off(at) > walk_off(at - 0.01));
}

/// N × (N × E) + εE = 0 and S·n of the sign of the side, for every wave.
#[test]
fn waves_solve_maxwells_equations_on_their_side() {
    let random = &mut Random(11);
    let mut against = 0;
    for _ in 0..100_000 {
        let (crystal, normal) = (crystal(random), random.direction().to_array());
        let at = Incidence::new(random.direction().to_array().map(|x| x * 2.1 * random.unit()), normal);
        for side in [1.0, -1.0] {
            for wave in crystal.waves(at.q(), normal, side) {
                let Wave { normal: n, electric: e, magnetic: h, .. } = wave;
                let product = |a: [Complex64; 3], b: [Complex64; 3]| {
                    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
                };
                let along = |k: usize| {
                    let axis = crystal.axes()[k];
                    e[0] * axis[0] + e[1] * axis[1] + e[2] * axis[2]
                };
                let [induced, curl] = [product(n, e), product(n, h)];
                for i in 0..3 {
                    let displacement: Complex64 =
                        (0..3).map(|k| crystal.indices()[k].powi(2) * along(k) * crystal.axes()[k][i]).sum();
                    assert!(
                        (induced[i] - h[i]).norm() < 1e-6 && (curl[i] + displacement).norm() < 1e-6,
                        "{crystal:?}"
                    );
                }
                let zeta = n[0] * normal[0] + n[1] * normal[1] + n[2] * normal[2];
                if wave.propagates() {
                    assert!(wave.flux * side > 0.0, "{crystal:?} {at:?} {side}");
                    against += i32::from(zeta.re * side < 0.0);
                } else {
                    assert!(zeta.im * side > 0.0, "{crystal:?} {at:?} {side}");
                }
            }
        }
    }
    // Energy and wave vector are often on different sides: the test would miss a root sorted by its sign otherwise.
    assert!(against > 100, "{against}");
}

/// A biaxial crystal whose two indices approach each other becomes the uniaxial one.
#[test]
fn the_uniaxial_limit() {
    let random = &mut Random(12);
    for k in 0..20_000 {
        let (axes, normal) = (orientation(random), random.direction().to_array());
        let at = Incidence::new(random.direction().to_array(), normal);
        let [o, e] = [[1.6, 1.7], [1.9, 1.6]][k % 2];
        let uniaxial = Crystal::uniaxial([o, e], axes[2]).waves(at.q(), normal, 1.0);
        let biaxial = Crystal::new([o, o + 1e-10, e], axes).waves(at.q(), normal, 1.0);
        for wave in biaxial {
            let nearest = uniaxial.iter().map(|u| {
                let [a, b] = [u, &wave].map(|w| [w.wave_vector(), w.ray()]);
                (0..3).map(|i| (a[0][i] - b[0][i]).abs() + (a[1][i] - b[1][i]).abs()).sum::<f64>()
            });
            assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-6);
        }
    }
}

/// Along an optic axis both waves have n_β, and rays lie on a cone through the axis of aperture χ:
/// tan χ = √((n_β² − n_α²)(n_γ² − n_β²))/(n_α n_γ) (Born & Wolf, §15.3.4).
#[test]
fn conical_refraction() {
    for index in [[1.525, 1.722, 1.945], [1.5, 1.9, 2.4], [1.654, 1.671, 1.689]] {
        let [a, b, c] = index.map(|n: f64| n * n);
        let aperture = (((b - a) * (c - b)).sqrt() / (a * c).sqrt()).atan().to_degrees();
        if index[2] == 1.945 {
            near(aperture, 13.0 + 44.0 / 60.0, 0.05, "naphthalene's in Born & Wolf");
        }
        let crystal = Crystal::new(index, AXES);
        let v = crystal.optic_angle() / 2.0;
        near(v.tan(), index[2] / index[0] * ((b - a) / (c - b)).sqrt(), 1e-12, "V");
        let axis = [v.sin(), 0.0, v.cos()];
        let across = [v.cos(), 0.0, -v.sin()];
        let rays: Vec<V> = (0..360)
            .flat_map(|k| {
                let (sin, cos) = f64::from(k).to_radians().sin_cos();
                let beside: V =
                    std::array::from_fn(|i| axis[i] + 1e-7 * (cos * across[i] + sin * AXES[1][i]));
                let length = dot(beside, beside).sqrt();
                crystal.waves([0.0; 3], beside.map(|x| x / length), 1.0).map(|wave| wave.ray())
            })
            .collect();
        let angle = |a: &V, b: &V| {
            let across = cross(*a, *b);
            dot(across, across).sqrt().atan2(dot(*a, *b)).to_degrees()
        };
        let widest = rays.iter().map(|ray| angle(&axis, ray)).fold(0.0, f64::max);
        near(widest, aperture, 1e-4, "aperture");
        for wave in crystal.waves([0.0; 3], axis, 1.0) {
            near(wave.index(), index[1], 1e-12, "index along the axis");
        }
    }
}

/// det(ε + NNᵀ − N²) with a complex ε.
fn determinant(epsilon: &[[Complex64; 3]; 3], q: V, n: V, zeta: Complex64) -> Complex64 {
    let wave: [Complex64; 3] = std::array::from_fn(|i| q[i] + zeta * n[i]);
    let square: Complex64 = wave.iter().map(|x| x * x).sum();
    let m: [[Complex64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            epsilon[i][j] + wave[i] * wave[j] - if i == j { square } else { Complex64::ZERO }
        })
    });
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

/// How a wave fades by its ray against 2k₀ Im ζ of the complex permittivity n_k² + 2i n_k κ_k, κ = α/2k₀.
#[test]
fn absorption_is_that_of_the_complex_permittivity() {
    let random = &mut Random(13);
    let (k0, mut worst) = (2.0 * std::f64::consts::PI / 550e-6, [0.0_f64; 2]);
    for _ in 0..20_000 {
        let (crystal, normal) = (crystal(random), random.direction().to_array());
        let alpha: V = std::array::from_fn(|_| random.unit());
        let alpha =
            if crystal.indices()[0] == crystal.indices()[1] { [alpha[0], alpha[0], alpha[2]] } else { alpha };
        let epsilon: [[Complex64; 3]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                (0..3)
                    .map(|k| {
                        let index = Complex64::new(crystal.indices()[k], alpha[k] / (2.0 * k0));
                        index * index * crystal.axes()[k][i] * crystal.axes()[k][j]
                    })
                    .sum()
            })
        });
        let at = Incidence::new(random.direction().to_array(), normal);
        let q = at.q();
        let waves = crystal.waves(q, normal, 1.0);
        let [a, b] = waves.map(|wave| dot(wave.wave_vector(), normal));
        // Next to an axis the two roots are closer than a complex index can tell apart.
        if waves.iter().any(|w| !w.propagates() || dot(w.ray(), normal) < 0.1) || (a - b).abs() < 0.01 {
            continue;
        }
        for (wave, start) in waves.iter().zip([a, b]) {
            let mut zeta = Complex64::from(start);
            for _ in 0..6 {
                let h = 1e-5;
                let slope = (determinant(&epsilon, q, normal, zeta + h)
                    - determinant(&epsilon, q, normal, zeta - h))
                    / (2.0 * h);
                zeta -= determinant(&epsilon, q, normal, zeta) / slope;
            }
            let along_ray = 2.0 * k0 * zeta.im * dot(wave.ray(), normal);
            let kind = usize::from(crystal.optic_angle() % std::f64::consts::PI != 0.0);
            worst[kind] = worst[kind].max((crystal.absorption(wave, alpha) - along_ray).abs());
        }
    }
    println!("uniaxial {:.1e}, biaxial {:.1e} of the largest α", worst[0], worst[1]);
    assert!(worst[0] < 1e-8 && worst[1] < 2e-5);
}

/// A slab with E along an axis: exp(−α d) of this axis alone.
#[test]
fn each_axis_has_its_own_absorption() {
    let alpha = [0.3, 0.7, 2.0];
    let crystal = Crystal::new([1.6, 1.65, 1.7], AXES);
    for (along, direction) in AXES.into_iter().enumerate() {
        for wave in crystal.waves([0.0; 3], direction, 1.0) {
            let e = real(wave.electric);
            let axis = (0..3).max_by(|&a, &b| e[a].abs().total_cmp(&e[b].abs())).unwrap_or(0);
            assert_ne!(axis, along);
            near(crystal.absorption(&wave, alpha), alpha[axis], 1e-15, "α");
            near(wave.index(), crystal.indices()[axis], 1e-15, "n");
        }
    }
    // An ordinary wave meets its own α in every direction.
    let (random, crystal) = (&mut Random(14), Crystal::uniaxial([1.6, 1.7], UP));
    for _ in 0..1000 {
        let [o, _] = crystal.waves([0.0; 3], random.direction().to_array(), 1.0);
        near(crystal.absorption(&o, [0.3, 0.3, 2.0]), 0.3, 1e-15, "α of o");
    }
}
