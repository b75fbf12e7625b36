//! The roots of a polynomial.

use num_complex::Complex64;

/// The N roots of c₀ + c₁z + … + c_N z^N by Aberth's method (Aberth 1973, Math. Comp. 27, 339), which finds all at once.
/// Simple roots come out within rounding, a double one within its square root.
pub(super) fn roots<const N: usize>(coefficients: &[f64]) -> [Complex64; N] {
    let leading = coefficients[N];
    let centre = -coefficients[N - 1] / (N as f64 * leading);
    let bound = coefficients[..N].iter().fold(0.0_f64, |most, c| most.max((c / leading).abs()));
    let radius = bound.sqrt().min(1.0 + bound);
    // Not symmetric about the real axis, so that complex pairs can part.
    let start = |k| centre + Complex64::from_polar(radius, 0.4 + std::f64::consts::TAU * k as f64 / N as f64);
    let mut roots: [Complex64; N] = std::array::from_fn(start);
    for _ in 0..100 {
        let mut largest: f64 = 0.0;
        for i in 0..N {
            let z = roots[i];
            let (mut value, mut slope) = (Complex64::ZERO, Complex64::ZERO);
            for c in coefficients[..=N].iter().rev() {
                slope = slope * z + value;
                value = value * z + c;
            }
            let others: Complex64 =
                roots.iter().filter(|root| **root != z).map(|root| (z - root).inv()).sum();
            // value/slope over 1 − others·value/slope, without dividing by a slope of 0.
            let step = value / (slope - value * others);
            if step.is_finite() {
                roots[i] -= step;
                largest = largest.max(step.norm());
            }
        }
        if largest <= 1e-15 {
            break;
        }
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(expected: [Complex64; 4], tolerance: f64) {
        let mut c = [1.0, 0.0, 0.0, 0.0, 0.0].map(Complex64::from);
        for (degree, root) in expected.iter().enumerate() {
            for k in (0..=degree + 1).rev() {
                c[k] = if k > 0 { c[k - 1] } else { Complex64::ZERO } - root * c[k];
            }
        }
        let found = roots::<4>(&c.map(|c| 2.5 * c.re));
        for root in expected {
            let error = found.iter().map(|z| (z - root).norm()).fold(f64::INFINITY, f64::min);
            assert!(error <= tolerance, "{root}: {found:?}");
        }
    }

    #[test]
    fn four_roots_of_every_kind() {
        let pair = |re, im| [Complex64::new(re, im), Complex64::new(re, -im)];
        let [a, b] = pair(0.3, 1.2);
        let [c, d] = pair(-0.7, 0.01);
        let real = [1.5, -1.6, 1.7, -1.4].map(Complex64::from);
        check(real, 1e-13);
        check([a, b, c, d], 1e-13);
        check([a, b, real[0], real[1]], 1e-13);
        check([real[0], real[0], real[1], real[3]], 1e-7);
        check([real[0], -real[0], real[2], -real[2]], 1e-13);
        check([a, b, a, b], 1e-7);
    }
}
