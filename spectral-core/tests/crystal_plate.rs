//! Plates of crystals by the surfaces of this crate against pyElli, an independent solver: 4 × 4 matrices after Berreman.
//!
//! `scripts/verify/crystals.py` writes the table and says what is in it; with `PLATES` this test reads another one.

use num_complex::Complex64;
use spectral_core::color::matrix::{cross, dot};
use spectral_core::crystal::{Crystal, Incidence, Wave};

type Matrix = [[Complex64; 2]; 2];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

fn sum(a: &Matrix, b: &Matrix, factor: f64) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + factor * b[i][j]))
}

fn inverse([[a, b], [c, d]]: Matrix) -> Matrix {
    let determinant = a * d - b * c;
    [[d, -b], [-c, a]].map(|row| row.map(|x| x / determinant))
}

/// Rows by outgoing, columns by incident waves.
fn columns(incident: [[Complex64; 2]; 2]) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| incident[j][i]))
}

/// r of a half-space, r and t of a plate `thickness` wavelengths thick, between media of index `before` and `behind`.
fn plate(crystal: &Crystal, [before, behind]: [f64; 2], q: f64, thickness: f64) -> [Matrix; 3] {
    let normal = [0.0, 0.0, 1.0];
    let at = Incidence::new([q, 0.0, (before * before - q * q).sqrt()], normal);
    let beyond = Incidence { normal: normal.map(|x| -x), s: at.s.map(|x| -x), ..at };
    let [down, up] = [1.0, -1.0].map(|side| crystal.waves(at.q(), normal, side));
    assert!(down.iter().chain(&up).all(Wave::propagates));
    let first = at.enter(before, &down);
    let below = down.map(|wave| at.leave(&wave, &up, [behind, 0.0]));
    let above = up.map(|wave| beyond.leave(&wave, &down, [before, 0.0]));
    // Across the plate, down and up.
    let across = |waves: &[Wave; 2], way: f64| {
        let turns = waves.map(|wave| way * thickness * dot(wave.wave_vector(), normal));
        let [one, two] = turns.map(|turns| Complex64::cis(std::f64::consts::TAU * turns));
        [[one, Complex64::ZERO], [Complex64::ZERO, two]]
    };
    let (into, surface) = (columns(first.map(|out| out.on)), columns(first.map(|out| out.back)));
    // From the first surface down, off the second, and up to the first.
    let returned =
        product(&across(&up, -1.0), &product(&columns(below.map(|out| out.back)), &across(&down, 1.0)));
    let one = [[Complex64::ONE, Complex64::ZERO], [Complex64::ZERO, Complex64::ONE]];
    let again = product(&columns(above.map(|out| out.back)), &returned);
    let within = product(&inverse(sum(&one, &again, -1.0)), &into);
    let through = product(&columns(below.map(|out| out.on)), &product(&across(&down, 1.0), &within));
    // e_s of `beyond` is −e_s.
    let out = product(&columns(above.map(|out| out.on)), &product(&returned, &within));
    [surface, sum(&surface, &out, -1.0), through]
}

#[test]
fn an_independent_solvers_plates() {
    let table = std::env::var_os("PLATES").map(|path| std::fs::read_to_string(path).expect("a table"));
    let table = table.as_deref().unwrap_or(include_str!("data/plates.txt"));
    let (mut plates, mut worst) = (0, [0.0_f64; 3]);
    for line in table.lines() {
        let row: Vec<f64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
        let axis = |k: usize| [row[k], row[k + 1], row[k + 2]];
        let (x, y) = (axis(5), axis(8));
        let crystal = Crystal::new(axis(2), [x, y, cross(x, y)]);
        for (k, found) in plate(&crystal, [row[0], row[1]], row[11], row[12]).iter().enumerate() {
            // The table has ss, sp, ps, pp, from the first to the second.
            let found = [found[0][0], found[1][0], found[0][1], found[1][1]];
            for (found, expected) in found.iter().zip(row[13 + 8 * k..].chunks(2)) {
                worst[k] = worst[k].max((found - Complex64::new(expected[0], expected[1])).norm());
            }
        }
        plates += 1;
    }
    println!("{plates} plates: r of the surface {:.1e}, r {:.1e}, t {:.1e}", worst[0], worst[1], worst[2]);
    assert!(plates >= 200 && worst.iter().all(|worst| *worst <= 1e-8), "{worst:?}");
}
