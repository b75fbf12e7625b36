//! The backward Stokes row against a forward calculation with complex fields in three dimensions.

use num_complex::Complex64;
use spectral_core::color::matrix::{cross, dot};
use spectral_core::fresnel::{Fresnel, conductor, dielectric};
use spectral_core::stokes::{Mueller, StokesRow, align, any_axis};

mod support;
use support::Random;

type V = [f64; 3];
/// A complex field in space.
type Field = [Complex64; 3];

fn scaled(a: V, s: f64) -> V {
    a.map(|x| x * s)
}

fn plus(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn unit(a: V) -> V {
    scaled(a, 1.0 / dot(a, a).sqrt())
}

fn along(field: Field, axis: V) -> Complex64 {
    field[0] * axis[0] + field[1] * axis[1] + field[2] * axis[2]
}

/// The event at a surface.
#[derive(Clone, Copy)]
enum Event {
    /// Inner reflection in a medium of index n against air.
    Inner(f64),
    /// A mirror n + ik in air.
    Metal(f64, f64),
    /// Refraction from the first index (on the side of the eye) to the second.
    Refraction(f64, f64),
}

/// Amplitudes r_s and r_p (or power-normalised t_s, t_p) by the textbook formulas with complex cosines.
fn amplitudes(event: Event, cos: f64) -> (Complex64, Complex64) {
    let (n1, n2) = match event {
        Event::Inner(n) => (Complex64::from(n), Complex64::from(1.0)),
        Event::Metal(n, k) => (Complex64::from(1.0), Complex64::new(n, k)),
        Event::Refraction(a, b) => (Complex64::from(a), Complex64::from(b)),
    };
    let sin_t = n1 / n2 * (1.0 - cos * cos).sqrt();
    let mut cos_t = (1.0 - sin_t * sin_t).sqrt();
    if (n2 * cos_t).im < 0.0 {
        cos_t = -cos_t; // exp(−iωt): the wave beyond decays
    }
    if let Event::Refraction(..) = event {
        let power = (n2 * cos_t / (n1 * cos)).re.sqrt();
        let t_s = 2.0 * n1 * cos / (n1 * cos + n2 * cos_t);
        let t_p = 2.0 * n1 * cos / (n2 * cos + n1 * cos_t);
        return (t_s * power, t_p * power);
    }
    let r_s = (n1 * cos - n2 * cos_t) / (n1 * cos + n2 * cos_t);
    let r_p = (n2 * cos - n1 * cos_t) / (n2 * cos + n1 * cos_t);
    (r_s, r_p)
}

fn fresnel(event: Event, cos: f64) -> Fresnel<f64> {
    match event {
        Event::Inner(n) => dielectric(cos, n),
        Event::Metal(n, k) => conductor(cos, 1.0, n, k),
        Event::Refraction(a, b) => dielectric(cos, a / b),
    }
}

/// The direction after the event of a ray traced backwards along `w`; `n` points against it.
fn next(event: Event, w: V, n: V, cos: f64, cos_t: f64) -> V {
    match event {
        Event::Inner(_) | Event::Metal(..) => plus(w, scaled(n, 2.0 * cos)),
        Event::Refraction(a, b) => {
            let eta = a / b;
            unit(plus(scaled(w, eta), scaled(n, eta * cos - cos_t)))
        }
    }
}

/// A path from the eye: for each surface the event, the ray's direction before and after, and the normal.
struct Path {
    legs: Vec<(Event, V, V, V)>,
}

fn path(start: V, surfaces: &[(Event, V)]) -> Path {
    let mut w = unit(start);
    let mut legs = Vec::new();
    for &(event, normal) in surfaces {
        let mut n = unit(normal);
        if dot(n, w) > 0.0 {
            n = scaled(n, -1.0);
        }
        let cos = -dot(w, n);
        let after = next(event, w, n, cos, fresnel(event, cos).cos_t);
        legs.push((event, w, after, n));
        w = after;
    }
    Path { legs }
}

/// The row at the far end and its frame axis, starting from the frame axis `x`.
fn backward(path: &Path, x: V) -> (StokesRow<f64>, V) {
    let mut row = StokesRow::eye();
    let mut axis = x;
    for &(event, w, _, n) in &path.legs {
        let turned = align(w, axis, n);
        axis = turned.axis;
        row = row.rotated(turned.cos2, turned.sin2);
        let fresnel = fresnel(event, -dot(w, n));
        row = match event {
            Event::Refraction(..) => row.refracted(&fresnel),
            _ => row.reflected(&fresnel),
        };
    }
    (row, axis)
}

/// The intensity at the eye of light with the field `field` at the far end of the path.
fn forward(path: &Path, mut field: Field) -> f64 {
    for &(event, w, after, n) in path.legs.iter().rev() {
        let (incoming, outgoing) = (scaled(after, -1.0), scaled(w, -1.0));
        let s = unit(cross(incoming, n));
        let (p_in, p_out) = (cross(incoming, s), cross(outgoing, s));
        // The light travels in the other direction, from the far index to the near one.
        let (event, cos) = match event {
            Event::Refraction(a, b) => (Event::Refraction(b, a), dot(incoming, n).abs()),
            other => (other, dot(incoming, n).abs()),
        };
        let (a_s, a_p) = amplitudes(event, cos);
        let (s_part, p_part) = (along(field, s) * a_s, along(field, p_in) * a_p);
        field = std::array::from_fn(|i| s_part * s[i] + p_part * p_out[i]);
    }
    field.iter().map(|c| c.norm_sqr()).sum()
}

/// The Stokes column of light (a along the axis, b along y = k × axis).
fn column(a: Complex64, b: Complex64) -> [f64; 4] {
    let product = a * b.conj();
    [a.norm_sqr() + b.norm_sqr(), a.norm_sqr() - b.norm_sqr(), 2.0 * product.re, 2.0 * product.im]
}

/// Compares both directions of the path for seven polarisations.
fn compare(path: &Path) {
    let start = path.legs[0].1;
    let far = path.legs.last().unwrap().2;
    let (row, axis) = backward(path, any_axis(start));
    let y = cross(scaled(far, -1.0), axis);
    let i = Complex64::I;
    let one = Complex64::from(1.0);
    let zero = Complex64::ZERO;
    let mut mean = 0.0;
    for (a, b) in
        [(one, zero), (zero, one), (one, one), (one, -one), (one, i), (one, -i), (one, 0.3 + 0.4 * i)]
    {
        let field: Field = std::array::from_fn(|j| a * axis[j] + b * y[j]);
        let expected = forward(path, field);
        let found: f64 = row.0.iter().zip(column(a, b)).map(|(r, s)| r * s).sum();
        assert!((found - expected).abs() < 1e-13, "{found} instead of {expected}");
        if b == zero || a == zero {
            mean += 0.5 * expected;
        }
    }
    // Unpolarised light is the mean of two perpendicular polarisations.
    assert!((row.intensity() - mean).abs() < 1e-13);
}

const DIRECTION: V = [0.1, -0.2, -1.0];

/// Three total reflections with planes of incidence turned against one another.
fn three_total_reflections() -> Path {
    let n = Event::Inner(1.5168);
    path(DIRECTION, &[(n, [0.9, 0.1, 0.7]), (n, [-0.3, 0.8, 0.6]), (n, [0.2, 0.9, -0.65])])
}

#[test]
fn three_total_reflections_out_of_plane() {
    let path = three_total_reflections();
    for &(event, w, _, n) in &path.legs {
        assert!(fresnel(event, -dot(w, n)).tir, "the chain was meant to reflect totally");
    }
    compare(&path);
    // All light returns, whatever its polarisation, although linear polarisation becomes elliptical.
    let (row, _) = backward(&path, any_axis(unit(DIRECTION)));
    assert!((row.intensity() - 1.0).abs() < 1e-14);
}

#[test]
fn partial_reflections_metal_and_refractions_out_of_plane() {
    let surfaces = [
        (Event::Refraction(1.0, 2.417), [0.4, 0.5, 1.0]),
        (Event::Inner(2.417), [0.9, -0.2, 0.35]),
        (Event::Inner(2.417), [-0.1, 0.9, 0.3]),
        (Event::Inner(2.417), [0.3, 0.5, -0.8]),
        (Event::Refraction(2.417, 1.0), [0.15, 0.1, 1.0]),
        (Event::Metal(0.29, 2.863), [0.7, 0.3, 0.6]),
        (Event::Metal(2.1, 3.7), [-0.5, 0.9, 0.1]),
    ];
    for count in 1..=surfaces.len() {
        let path = path(DIRECTION, &surfaces[..count]);
        if path.legs.iter().any(|(event, w, _, n)| {
            matches!(event, Event::Refraction(..)) && fresnel(*event, -dot(*w, *n)).tir
        }) {
            panic!("surface {count} was meant to refract");
        }
        compare(&path);
    }
}

#[test]
fn any_start_frame_gives_the_same_intensity() {
    let surfaces = [
        (Event::Refraction(1.0, 1.77), [0.4, 0.5, 1.0]),
        (Event::Inner(1.77), [0.9, -0.2, 0.35]),
        (Event::Metal(0.29, 2.863), [0.1, 0.9, 0.6]),
    ];
    let path = path(DIRECTION, &surfaces);
    let x = any_axis(unit(DIRECTION));
    let y = cross(scaled(unit(DIRECTION), -1.0), x);
    let (reference, _) = backward(&path, x);
    for i in 0..36 {
        let (sin, cos) = (f64::from(i) * 10.0).to_radians().sin_cos();
        let (row, _) = backward(&path, plus(scaled(x, cos), scaled(y, sin)));
        for (a, b) in row.0.iter().zip(reference.0) {
            assert!((a - b).abs() < 1e-14, "{row:?} instead of {reference:?}");
        }
    }
}

#[test]
fn row_operations_are_the_matrices() {
    let row = StokesRow([0.9, 0.3, -0.5, 0.2]);
    let same = |a: StokesRow<f64>, b: StokesRow<f64>| a.0.iter().zip(b.0).all(|(x, y)| (x - y).abs() < 1e-15);
    let (sin2, cos2) = 0.7_f64.sin_cos();
    assert!(same(row.rotated(cos2, sin2), Mueller::rotation(cos2, -sin2).left_of(row)));
    for event in [dielectric(0.4, 1.0 / 1.77), dielectric(0.4, 1.77), conductor(0.4, 1.0, 0.29, 2.863)] {
        let (reflection, refraction) = (Mueller::reflection(&event), Mueller::refraction(&event));
        assert!(same(row.reflected(&event), reflection.left_of(row)));
        assert!(same(row.refracted(&event), refraction.left_of(row)));
        let both = reflection.then(&Mueller::rotation(cos2, -sin2)).then(&refraction);
        assert!(same(both.left_of(row), row.reflected(&event).rotated(cos2, sin2).refracted(&event)));
        let column = [1.0, 0.1, 0.2, -0.3];
        let by_column: f64 = row.0.iter().zip(both.apply(column)).map(|(r, s)| r * s).sum();
        let by_row: f64 = both.left_of(row).0.iter().zip(column).map(|(r, s)| r * s).sum();
        assert!((by_column - by_row).abs() < 1e-15);
    }
    assert_eq!(Mueller::identity().left_of(row), row);
}

#[test]
fn throughput_never_exceeds_one() {
    // Ten thousand random paths of eight events. A row must stay in the cone of physical detectors.
    let mut generator = Random(1);
    let mut random = move || generator.unit();
    for _ in 0..10_000 {
        let mut row = StokesRow::<f32>::eye();
        let mut axis = any_axis([0.0_f32, 0.0, -1.0]);
        let mut w: V = [0.0, 0.0, -1.0];
        for _ in 0..8 {
            let n = unit([random() - 0.5, random() - 0.5, random() - 0.5]);
            let n = scaled(n, -dot(n, w).signum());
            let cos = -dot(w, n);
            let event = dielectric(cos as f32, 0.4 + 2.2 * random() as f32);
            let turned = align(w.map(|c| c as f32), axis, n.map(|c| c as f32));
            axis = turned.axis;
            row = row.rotated(turned.cos2, turned.sin2).reflected(&event);
            w = unit(plus(w, scaled(n, 2.0 * cos)));
            let [i, q, u, v] = row.0.map(f64::from);
            assert!((0.0..=1.0 + 1e-6).contains(&i), "{row:?}");
            assert!((q * q + u * u + v * v).sqrt() <= i * (1.0 + 1e-5) + 1e-7, "{row:?}");
        }
    }
}

#[test]
fn frames_at_normal_incidence_stay_put() {
    let axis = [0.6, 0.8, 0.0];
    let turned = align([0.0, 0.0, -1.0], axis, [0.0, 0.0, 1.0]);
    assert_eq!((turned.axis, turned.cos2, turned.sin2), (axis, 1.0, 0.0));
    // Near it the result is the same except for the choice of frame: light straight back, energy R.
    for tilt in [1e-9, 1e-7, 1e-5, 1e-3] {
        let n = unit([tilt, 0.5 * tilt, 1.0]);
        let turned = align([0.0, 0.0, -1.0], axis, n);
        assert!((turned.cos2.hypot(turned.sin2) - 1.0).abs() < 1e-14);
        let event = dielectric(n[2], 1.0 / 1.5);
        let row = StokesRow::eye().rotated(turned.cos2, turned.sin2).reflected(&event);
        assert!((row.intensity() - 0.04).abs() < 1e-8);
        assert!(row.0[1].abs() < 1e-6);
    }
}

#[test]
fn first_axes_are_perpendicular() {
    for w in
        [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], unit([1.0, -2.0, 1e-9]), unit([1e-9, 0.0, -1.0])]
    {
        let x = any_axis(w);
        assert!(dot(x, w).abs() < 1e-15 && (dot(x, x) - 1.0).abs() < 1e-15, "{w:?}: {x:?}");
    }
}
