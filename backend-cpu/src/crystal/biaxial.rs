//! Waves in a biaxial crystal, sheet by sheet of its index surface: the twin of the core's.

use super::{Wave, single};
use accel::lanes::{Lanes, Mask, Row, Triple};
use spectral_core::crystal as core;

/// A biaxial crystal.
#[derive(Debug, Clone)]
pub(super) struct Biaxial {
    axes: [[f32; 3]; 3],
}

/// See [`Biaxial::FIGURES`].
type Figures = [Row; Biaxial::FIGURES];

/// Newton's method settles within so many steps in single precision, for the strongest crystals.
const STEPS: usize = 6;
/// The last step is at most this long; its square is below rounding.
const SETTLED: f32 = 5e-4;
/// Below this |a × N| is rounding error.
const ON_AXIS: f32 = 1e-7;
/// Below this N·n is left to double precision.
const GRAZING: f32 = 3e-3;

/// N²(D·E) is D² but for so much of it.
const ON_SHEET: f32 = 1e-4;

/// What both sheets need of a surface.
struct Surface<V> {
    q2: V,
    axes: [Beside<V>; 2],
    /// A and B.
    sheet: [V; 2],
}

/// An optic axis a beside a surface: a·q, a·n, a × q and a × n.
struct Beside<V> {
    along_q: V,
    along_n: V,
    across_q: Triple<V>,
    across_n: Triple<V>,
}

/// At some ζ: a·N and its slope a·n, |a × N|² and half its slope.
struct Angle<V> {
    along: V,
    slope: V,
    across2: V,
    widens: V,
}

impl<V: Lanes> Beside<V> {
    #[inline(always)]
    fn new(axis: Triple<V>, q: Triple<V>, n: Triple<V>) -> Self {
        Beside {
            along_q: axis.dot(q),
            along_n: axis.dot(n),
            across_q: axis.cross(q),
            across_n: axis.cross(n),
        }
    }

    #[inline(always)]
    fn at(&self, zeta: V) -> Angle<V> {
        let vector = self.across_n.fma(zeta, self.across_q);
        Angle {
            along: self.along_n.fma(zeta, self.along_q),
            slope: self.along_n,
            across2: vector.dot(vector),
            widens: vector.dot(self.across_n),
        }
    }
}

impl<V: Lanes> Surface<V> {
    /// ζ on a sheet: the root of G∓(q + ζn) = 1 by Newton's method.
    ///
    /// With R = √P, P = |a₁ × N|²|a₂ × N|², a step is (G − 1)R/((2Aζ + B(…)′)R ± ½BP′): one root and one division.
    #[inline(always)]
    fn newton(&self, start: V, sign: f32, side: f32) -> (V, V::Mask) {
        let (one, sign) = (V::splat(1.0), V::splat(sign));
        let Surface { q2, axes: [first, second], sheet: [a, b] } = self;
        let (a, b) = (*a, *b);
        let (mut zeta, mut step, mut slope) = (start, one, one);
        // A lane stops by itself, so that its root does not depend on its neighbours.
        let mut open = V::Mask::from_bits(u16::MAX);
        for _ in 0..STEPS {
            let (first, second) = (first.at(zeta), second.at(zeta));
            let root = (first.across2 * second.across2).max(V::splat(ON_AXIS * ON_AXIS)).sqrt();
            let widening = first.widens.fma(second.across2, second.widens * first.across2);
            let value = b.fma(sign.fma(root, first.along * second.along), a.fma(zeta * zeta, a * *q2));
            let both = first.slope.fma(second.along, first.along * second.slope);
            let rises = b.fma(both, (a + a) * zeta).fma(root, b * sign * widening);
            slope = V::select(open, rises, slope);
            step = V::select(open, (value - one) * root / rises, step);
            zeta = V::select(open, zeta - step, zeta);
            open = open & !step.abs().lt(V::splat(SETTLED));
            if open.bits() == 0 {
                break;
            }
        }
        (zeta, !open & V::splat(0.0).lt(slope * V::splat(side)))
    }
}

impl Biaxial {
    /// 1/ε along each axis, the two optic axes, A and B = ½(1/n_α² ± 1/n_γ²), and n_β².
    pub const FIGURES: usize = 12;

    pub fn new(axes: [[f64; 3]; 3]) -> Self {
        Biaxial { axes: axes.map(single) }
    }

    pub fn figures(crystal: &core::Crystal) -> [f32; Self::FIGURES] {
        let core::Biaxial { permittivity: [x, y, z], optic: [a, b], sheet, middle, .. } =
            core::Biaxial::new(crystal.indices(), crystal.axes());
        let [sum, difference] = sheet;
        let inverse = [x.recip(), y.recip(), z.recip()];
        single([
            inverse[0], inverse[1], inverse[2], a[0], a[1], a[2], b[0], b[1], b[2], sum, difference, middle,
        ])
    }

    #[inline(always)]
    pub fn waves<V: Lanes>(
        &self,
        figures: &Figures,
        q: Triple<V>,
        n: Triple<V>,
        side: f32,
    ) -> ([Wave<V>; 2], V::Mask) {
        let axes = [Beside::new(optic(figures, 0), q, n), Beside::new(optic(figures, 1), q, n)];
        let [.., a, b, middle] = figures;
        let surface = Surface { q2: q.dot(q), axes, sheet: [V::load(a), V::load(b)] };
        let start = V::load(middle) - surface.q2;
        let met = V::splat(GRAZING * GRAZING).lt(start);
        let start = start.max(V::splat(0.0)).sqrt() * V::splat(side);
        let (fast, fast_met) = surface.newton(start, 1.0, side);
        let (slow, slow_met) = surface.newton(start, -1.0, side);
        let (fast, _) = self.wave(figures, V::Mask::from_bits(0), n.fma(fast, q));
        let (slow, _) = self.wave(figures, V::Mask::from_bits(u16::MAX), n.fma(slow, q));
        (share_power(fast, slow, n), met & fast_met & slow_met)
    }

    /// u = a × N/|a × N|.
    #[inline(always)]
    fn across<V: Lanes>(axis: Triple<V>, normal: Triple<V>) -> Triple<V> {
        let vector = axis.cross(normal);
        let size = vector.dot(vector).sqrt();
        vector.scaled(V::splat(1.0) / size.max(V::splat(ON_AXIS)))
    }

    /// D ∥ u₁ ± u₂ with u = a × N/|a × N|, E = ε⁻¹D, H = N × E; and the lanes in which N is on the mode's sheet.
    ///
    /// Next to an optic axis a surface can have both its waves from one sheet, and `exact` then calls one of them by the
    /// other's mode. On the sheet N²(D·E) = D².
    #[inline(always)]
    pub fn wave<V: Lanes>(
        &self,
        figures: &Figures,
        second: V::Mask,
        normal: Triple<V>,
    ) -> (Wave<V>, V::Mask) {
        let sign = V::select(second, V::splat(-1.0), V::splat(1.0));
        let first = Self::across(optic(figures, 0), normal);
        let second = Self::across(optic(figures, 1), normal);
        let (same, other) = (second.fma(sign, first), second.fnma(sign, first));
        let longer = !same.dot(same).lt(other.dot(other));
        let displacement = Triple::select(longer, same, normal.cross(other));
        let part = displacement.dot(normal) / normal.dot(normal);
        let displacement = normal.fnma(part, displacement);
        let mut electric = Triple::splat([0.0; 3]);
        for (axis, inverse) in self.axes.iter().zip(figures) {
            let axis = Triple::splat(*axis);
            electric = axis.fma(axis.dot(displacement) * V::load(inverse), electric);
        }
        let (square, size) = (displacement.dot(displacement), normal.dot(normal));
        let off = size.fma(displacement.dot(electric), -square).abs();
        let wave = Wave { normal, electric, magnetic: normal.cross(electric) };
        (wave, off.lt(V::splat(ON_SHEET) * square))
    }
}

/// An optic axis.
#[inline(always)]
pub(super) fn optic<V: Lanes>(figures: &Figures, i: usize) -> Triple<V> {
    let [x, y, z] = [3, 4, 5].map(|k| &figures[k + 3 * i]);
    Triple { x: V::load(x), y: V::load(y), z: V::load(z) }
}

/// Two waves of one surface whose powers add up: near an optic axis rounding has left a common part.
#[inline(always)]
fn share_power<V: Lanes>(first: Wave<V>, second: Wave<V>, n: Triple<V>) -> [Wave<V>; 2] {
    let common = first.electric.cross(second.magnetic).plus(second.electric.cross(first.magnetic)).dot(n);
    let common = V::splat(0.5) * common;
    let (one, two) = (first.poynting().dot(n), second.poynting().dot(n));
    let keep = !one.abs().lt(two.abs());
    let (to_second, to_first) =
        (V::select(keep, common / one, V::splat(0.0)), V::select(keep, V::splat(0.0), common / two));
    [less(first, to_first, &second), less(second, to_second, &first)]
}

/// A wave less `factor` times another's fields.
#[inline(always)]
fn less<V: Lanes>(wave: Wave<V>, factor: V, other: &Wave<V>) -> Wave<V> {
    Wave {
        electric: other.electric.fnma(factor, wave.electric),
        magnetic: other.magnetic.fnma(factor, wave.magnetic),
        ..wave
    }
}
