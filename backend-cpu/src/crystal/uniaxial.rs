//! Waves in a uniaxial crystal: the twin of the core's closed form.

use super::{Wave, single, unit};
use accel::lanes::{Lanes, Row, Triple};
use spectral_core::{crystal as core, stokes::any_axis};

/// A uniaxial crystal.
#[derive(Debug, Clone)]
pub(super) struct Uniaxial {
    /// c, and a vector across it.
    pub(super) axis: [f32; 3],
    across: [f32; 3],
}

/// Below this |c × N| is rounding error.
const ON_AXIS: f32 = 1e-6;
/// Below this ζ_o² or the discriminant is left to double precision.
const GRAZING: f32 = 1e-5;

impl Uniaxial {
    /// ε_o, Δ = ε_e − ε_o and ε_e, and 1/ε_o and Δ/(ε_o ε_e): ε⁻¹ = 1/ε_o − Δ/(ε_o ε_e) ccᵀ.
    pub const FIGURES: usize = 5;

    pub fn new(axis: [f64; 3]) -> Self {
        Uniaxial { axis: single(axis), across: single(any_axis(axis)) }
    }

    pub fn figures(crystal: &core::Uniaxial) -> [f32; Self::FIGURES] {
        let core::Uniaxial { ordinary, difference, .. } = *crystal;
        let extraordinary = ordinary + difference;
        let share = difference / (ordinary * extraordinary);
        single([ordinary, difference, extraordinary, ordinary.recip(), share])
    }

    /// See `spectral_core::crystal`; the discriminant is factored: ε_o((ε_e − q²)a − Δ(c·q)²).
    #[inline(always)]
    pub fn waves<V: Lanes>(
        &self,
        figures: &[Row; Self::FIGURES],
        q: Triple<V>,
        n: Triple<V>,
        side: f32,
    ) -> ([Wave<V>; 2], V::Mask) {
        let [ordinary, difference, extraordinary, inverse_o, _] = figures;
        let (ordinary, difference) = (V::load(ordinary), V::load(difference));
        let extraordinary = V::load(extraordinary);
        let (zero, side) = (V::splat(0.0), V::splat(side));
        let axis = Triple::splat(self.axis);
        let (cn, cq, q2) = (axis.dot(n), axis.dot(q), q.dot(q));
        let a = (difference * cn).fma(cn, ordinary);
        let b = difference * cn * cq;
        let disc = ordinary * (difference * cq).fnma(cq, (extraordinary - q2) * a);
        let cos2_o = ordinary - q2;
        let regular = V::splat(GRAZING).lt(cos2_o) & V::splat(GRAZING).lt(disc);
        let zeta = cos2_o.max(zero).sqrt() * side;
        let root = disc.max(zero).sqrt() * side;
        let normal_o = n.fma(zeta, q);
        let at_ordinary = a.fma(zeta, b);
        let w = axis.cross(normal_o);
        let w2 = w.dot(w);
        // ζ_e − ζ_o = Δ|c × N_o|²/(aζ_o + b + σ√disc), unless the two of the sum cancel.
        let together = zero.lt(at_ordinary * side);
        let (over, under) = (difference * w2, at_ordinary + root);
        let step = V::select(together, over, root - at_ordinary) / V::select(together, under, a);
        let size = w2.sqrt();
        let off_axis = V::splat(ON_AXIS).lt(size);
        let inverse = V::splat(1.0) / size.max(V::splat(ON_AXIS));
        let w = Triple::select(off_axis, w.scaled(inverse), Triple::splat(self.across));
        let tilt = V::select(off_axis, step * inverse, zero);
        let w = unit(normal_o.fnma(w.dot(normal_o) * V::load(inverse_o), w));
        // Both waves of one w: near the axis w is rounding error, and their powers must add up.
        let first = Wave { normal: normal_o, electric: w, magnetic: normal_o.cross(w) };
        let second = self.extraordinary(figures, n.fma(step, normal_o), axis.cross(n).fma(tilt, w));
        ([first, second], regular)
    }

    /// E = ε⁻¹(N × w), H = −w.
    #[inline(always)]
    fn extraordinary<V: Lanes>(
        &self,
        [.., inverse, share]: &[Row; Self::FIGURES],
        normal: Triple<V>,
        w: Triple<V>,
    ) -> Wave<V> {
        let axis = Triple::splat(self.axis);
        let displacement = normal.cross(w);
        let share = axis.dot(displacement) * V::load(share);
        let electric = axis.fnma(share, displacement.scaled(V::load(inverse)));
        Wave { normal, electric, magnetic: w.scaled(V::splat(-1.0)) }
    }

    #[inline(always)]
    pub fn wave<V: Lanes>(
        &self,
        figures: &[Row; Self::FIGURES],
        second: V::Mask,
        normal: Triple<V>,
    ) -> Wave<V> {
        let w = Triple::splat(self.axis).cross(normal);
        let size = w.dot(w).sqrt();
        let inverse = V::splat(1.0) / size.max(V::splat(ON_AXIS));
        let off_axis = V::splat(ON_AXIS).lt(size);
        let w = Triple::select(off_axis, w.scaled(inverse), Triple::splat(self.across));
        let extraordinary = self.extraordinary(figures, normal, w);
        Wave {
            normal,
            electric: Triple::select(second, extraordinary.electric, w),
            magnetic: Triple::select(second, extraordinary.magnetic, normal.cross(w)),
        }
    }
}
