//! How rays turn with their wave vectors: the twin of `spectral_core::crystal::Crystal::ray_by`.

use super::{Biaxial, Form, Optics, Uniaxial, biaxial::optic};
use accel::lanes::{Lanes, Row, Triple};

/// As the core has it: nearer to an optic axis rays turn as they do there.
const FROM_AXIS: f32 = 1e-3;

impl Optics<'_> {
    /// The derivatives of the unit rays of a mode, `second` or first, whose wave vectors N have the derivatives `by`.
    #[inline(always)]
    pub fn rays_by<V: Lanes>(
        &self,
        second: bool,
        [vector, ray]: [Triple<V>; 2],
        by: &[Triple<V>; 2],
    ) -> [Triple<V>; 2] {
        match &self.frame.form {
            Form::Uniaxial(uniaxial) => uniaxial.rays_by(self.rows(0), second, [vector, ray], by),
            Form::Biaxial(_) => Biaxial::rays_by(self.rows(0), second, [vector, ray], by),
        }
    }
}

/// Of the derivative of a vector along `ray`, that of its direction.
#[inline(always)]
fn turned<V: Lanes>(ray: Triple<V>, by: Triple<V>, size: V) -> Triple<V> {
    ray.fnma(ray.dot(by), by).scaled(V::splat(1.0) / size)
}

impl Uniaxial {
    /// The extraordinary ray is along ε_o N + Δ(c·N)c.
    #[inline(always)]
    fn rays_by<V: Lanes>(
        &self,
        [ordinary, difference, ..]: &[Row; Self::FIGURES],
        second: bool,
        [vector, ray]: [Triple<V>; 2],
        by: &[Triple<V>; 2],
    ) -> [Triple<V>; 2] {
        let (ordinary, difference, axis) = (V::load(ordinary), V::load(difference), Triple::splat(self.axis));
        if !second {
            let size = ordinary.sqrt();
            return [turned(ray, by[0], size), turned(ray, by[1], size)];
        }
        let along = Along { axis, ordinary, difference };
        let size = along.of(vector).dot(ray);
        [turned(ray, along.of(by[0]), size), turned(ray, along.of(by[1]), size)]
    }
}

/// ε_o v + Δ(c·v)c.
struct Along<V> {
    axis: Triple<V>,
    ordinary: V,
    difference: V,
}

impl<V: Lanes> Along<V> {
    #[inline(always)]
    fn of(&self, v: Triple<V>) -> Triple<V> {
        self.axis.fma(self.difference * self.axis.dot(v), v.scaled(self.ordinary))
    }
}

/// N beside an optic axis: its part P across the axis, and P².
struct Across<V> {
    axis: Triple<V>,
    part: Triple<V>,
    square: V,
}

impl<V: Lanes> Across<V> {
    #[inline(always)]
    fn new(axis: Triple<V>, vector: Triple<V>) -> Self {
        let part = axis.fnma(axis.dot(vector), vector);
        Across { axis, part, square: part.dot(part).max(V::splat(FROM_AXIS * FROM_AXIS)) }
    }
}

/// ½∇G of a sheet, all but what depends on its argument.
struct Gradient<V> {
    /// A and ½B, this with the sheet's sign too.
    sheet: [V; 3],
    axes: [Across<V>; 2],
    /// |a₂ × N|/|a₁ × N| and its inverse.
    ratio: [V; 2],
}

impl<V: Lanes> Gradient<V> {
    /// A v + ½B(a₁(a₂·v) + a₂(a₁·v)) ± ½B(ρ P₁ + P₂/ρ), with P₁ and P₂ of v.
    #[inline(always)]
    fn of(&self, v: Triple<V>, parts: [Triple<V>; 2]) -> Triple<V> {
        let ([a, half, signed], [one, two]) = (self.sheet, &self.axes);
        let both = two.axis.fma(half * one.axis.dot(v), v.scaled(a));
        let both = one.axis.fma(half * two.axis.dot(v), both);
        parts[1].fma(signed * self.ratio[1], parts[0].fma(signed * self.ratio[0], both))
    }

    /// Its derivative.
    #[inline(always)]
    fn by(&self, by: Triple<V>) -> Triple<V> {
        let [one, two] = &self.axes;
        // ∂ρ/ρ.
        let grows = two.part.dot(by) / two.square - one.part.dot(by) / one.square;
        let first = one.part.fma(grows, one.axis.fnma(one.axis.dot(by), by));
        let second = two.part.fnma(grows, two.axis.fnma(two.axis.dot(by), by));
        self.of(by, [first, second])
    }
}

impl Biaxial {
    #[inline(always)]
    fn rays_by<V: Lanes>(
        figures: &[Row; Self::FIGURES],
        second: bool,
        [vector, ray]: [Triple<V>; 2],
        by: &[Triple<V>; 2],
    ) -> [Triple<V>; 2] {
        let axes = [Across::new(optic(figures, 0), vector), Across::new(optic(figures, 1), vector)];
        let [.., a, b, _] = figures;
        let half = V::splat(0.5) * V::load(b);
        let sheet = [V::load(a), half, if second { -half } else { half }];
        let ratio = (axes[1].square / axes[0].square).sqrt();
        let gradient = Gradient { sheet, axes, ratio: [ratio, V::splat(1.0) / ratio] };
        let size = gradient.of(vector, [gradient.axes[0].part, gradient.axes[1].part]).dot(ray);
        [turned(ray, gradient.by(by[0]), size), turned(ray, gradient.by(by[1]), size)]
    }
}
