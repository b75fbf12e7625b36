//! Waves in a uniaxial crystal, in closed form.

use super::vector::{Complex3, Real3, along, at, complex, cross_complex, norm_sqr, plus, real, root, unit};
use super::wave::Wave;
use crate::color::matrix::{cross, dot};
use crate::stokes::any_axis;
use num_complex::Complex64;

/// A uniaxial crystal at one wavelength: ε = ε_o + Δ ccᵀ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uniaxial {
    /// ε_o = n_o².
    pub ordinary: f64,
    /// Δ = ε_e − ε_o, as a product: the difference of rounded squares would have lost digits.
    pub difference: f64,
    /// c, unit.
    pub axis: Real3,
}

impl Uniaxial {
    pub(super) fn new([o, e]: [f64; 2], axis: Real3) -> Self {
        Uniaxial { ordinary: o * o, difference: (e - o) * (e + o), axis }
    }

    /// ε⁻¹v.
    fn impermittivity(&self, v: &Complex3) -> Complex3 {
        let (o, e) = (self.ordinary, self.ordinary + self.difference);
        let share = along(v, self.axis) * (self.difference / (o * e));
        std::array::from_fn(|i| v[i] / o - share * self.axis[i])
    }

    /// The ordinary and the extraordinary wave with the tangential wave vector q and energy on the side σ of a surface
    /// with normal n (Lekner 1991, J. Phys.: Condens. Matter 3, 6121). With N = q + ζn:
    ///
    /// ```text
    /// ζ_o = σ√(ε_o − q²)      a ζ_e² + 2b ζ_e + … = 0,  a = ε_o + Δ(c·n)²,  b = Δ(c·n)(c·q)
    /// ζ_e = (−b + σ√disc)/a   disc = ε_o (ε_e a − ε_o q² − Δ[(c·q)² + (c·n)² q²])
    /// o: E = w, H = N × w     e: E = ε⁻¹(N × w), H = −w,   w = c × N
    /// ```
    ///
    /// (E × H)·n of the extraordinary wave has the sign of aζ + b = σ√disc, so σ sorts by energy, which the sign of ζ
    /// does not.
    pub fn waves(&self, q: Real3, n: Real3, side: f64) -> [Wave; 2] {
        let Uniaxial { ordinary, difference, axis } = *self;
        let (cn, cq, q2) = (dot(axis, n), dot(axis, q), dot(q, q));
        let (a, b) = (ordinary + difference * cn * cn, difference * cn * cq);
        let disc =
            ordinary * ((ordinary + difference) * a - ordinary * q2 - difference * (cq * cq + cn * cn * q2));
        let (cos2_o, root_e) = (ordinary - q2, root(disc) * side);
        let zeta_o = root(cos2_o) * side;
        let normal_o = at(q, n, zeta_o);
        if cos2_o > 0.0 && disc > 0.0 {
            let step = self.apart(real(&normal_o), a * zeta_o.re + b, root_e.re, a, side);
            return self.propagating(q, n, zeta_o.re, step);
        }
        let extraordinary = self.extraordinary(q, n, (root_e - b) / a, disc > 0.0);
        [Wave::by_field(normal_o, self.across(&normal_o), n, cos2_o > 0.0), extraordinary]
    }

    /// 1/n_e(θ)² = cos²θ/ε_o + sin²θ/ε_e, θ from the axis.
    pub(super) fn indices_along(&self, direction: Real3) -> [f64; 2] {
        let (o, e) = (self.ordinary, self.ordinary + self.difference);
        let (cos, across) = (dot(self.axis, direction), cross(self.axis, direction));
        [o.sqrt(), (cos * cos / o + dot(across, across) / e).sqrt().recip()]
    }

    /// ζ_e − ζ_o = Δ|c × N_o|²/(B + σ√disc), B = aζ_o + b: exact where both waves nearly coincide.
    fn apart(&self, normal_o: Real3, at_ordinary: f64, root: f64, a: f64, side: f64) -> f64 {
        let w = cross(self.axis, normal_o);
        if at_ordinary * side > 0.0 {
            self.difference * dot(w, w) / (at_ordinary + root)
        } else {
            (root - at_ordinary) / a
        }
    }

    /// Both waves of one w. Near the axis w = c × N is rounding error alone; taken separately for each wave the two would
    /// no longer share power exactly. So w_e = w_o + (ζ_e − ζ_o) c × n, and on the axis w_o is any vector across it.
    fn propagating(&self, q: Real3, n: Real3, zeta_o: f64, step: f64) -> [Wave; 2] {
        let axis = self.axis;
        let (normal_o, normal_e) = (plus(q, zeta_o, n), plus(q, zeta_o + step, n));
        let w = cross(axis, normal_o);
        let size = dot(w, w).sqrt();
        // Below 1e-14 nothing is left of w, and ζ_e = ζ_o.
        let (w, step) = if size > 1e-14 { (w.map(|x| x / size), step / size) } else { (any_axis(axis), 0.0) };
        let w = unit(plus(w, -dot(w, normal_o) / self.ordinary, normal_o));
        let ordinary = Wave::propagating(normal_o, w, cross(normal_o, w), n);
        let w = plus(w, step, cross(axis, n));
        let electric = real(&self.impermittivity(&complex(cross(normal_e, w))));
        [ordinary, Wave::propagating(normal_e, electric, w.map(|x| -x), n)]
    }

    /// w/|w|, or any vector across the axis where there is no w: at grazing incidence along the axis.
    fn across(&self, normal: &Complex3) -> Complex3 {
        let w = cross_complex(&complex(self.axis), normal);
        let size = norm_sqr(&w).sqrt();
        if size > 1e-14 { w.map(|x| x / size) } else { complex(any_axis(self.axis)) }
    }

    /// The extraordinary wave by itself.
    fn extraordinary(&self, q: Real3, n: Real3, zeta: Complex64, propagates: bool) -> Wave {
        let normal = at(q, n, zeta);
        let w = self.across(&normal);
        let electric = self.impermittivity(&cross_complex(&normal, &w));
        let magnetic = w.map(|x| -x);
        if propagates {
            Wave::propagating(real(&normal), real(&electric), real(&magnetic), n)
        } else {
            Wave::evanescent(normal, electric, magnetic)
        }
    }
}
