//! Complex vectors: the fields of waves, which are complex beyond total reflection.

use num_complex::Complex64;

/// A vector in space.
pub(super) type Real3 = [f64; 3];
/// A field in space.
pub(super) type Complex3 = [Complex64; 3];

/// A real vector as a complex one.
pub(super) fn complex(a: Real3) -> Complex3 {
    a.map(Complex64::from)
}

/// The real parts.
pub(super) fn real(a: &Complex3) -> Real3 {
    a.map(|x| x.re)
}

/// a + s·b.
pub(super) fn plus(a: Real3, s: f64, b: Real3) -> Real3 {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// a + s·b for fields.
pub(super) fn plus_complex(a: &Complex3, s: Complex64, b: &Complex3) -> Complex3 {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// The scalar product of a field and a direction, without conjugation.
pub(super) fn along(a: &Complex3, b: Real3) -> Complex64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product, without conjugation.
pub(super) fn cross_complex(a: &Complex3, b: &Complex3) -> Complex3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// |a|² = a·a*.
pub(super) fn norm_sqr(a: &Complex3) -> f64 {
    a.iter().map(|x| x.norm_sqr()).sum()
}

/// The unit vector along a.
pub(super) fn unit(a: Real3) -> Real3 {
    let length = crate::color::matrix::dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// The root of a real number, on the positive imaginary axis for a negative one.
pub(super) fn root(x: f64) -> Complex64 {
    if x < 0.0 { Complex64::new(0.0, (-x).sqrt()) } else { Complex64::from(x.sqrt()) }
}

/// The principal root: as [`Complex64::sqrt`], without angles.
pub(super) fn complex_root(z: Complex64) -> Complex64 {
    if z.im == 0.0 {
        return root(z.re);
    }
    let larger = (0.5 * (z.norm_sqr().sqrt() + z.re.abs())).sqrt();
    let smaller = 0.5 * z.im / larger;
    if z.re < 0.0 {
        Complex64::new(smaller.abs(), larger.copysign(z.im))
    } else {
        Complex64::new(larger, smaller)
    }
}

/// a·a, without conjugation.
pub(super) fn square(a: &Complex3) -> Complex64 {
    a.iter().map(|x| x * x).sum()
}

/// The wave vector q + ζn.
pub(super) fn at(q: Real3, n: Real3, zeta: Complex64) -> Complex3 {
    plus_complex(&complex(q), zeta, &complex(n))
}
