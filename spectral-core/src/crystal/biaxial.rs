//! Waves in a biaxial crystal, sheet by sheet of its index surface.

use super::polynomial::roots;
use super::vector::{
    Complex3, Real3, along, at, complex, complex_root, cross_complex, norm_sqr, plus, plus_complex, real,
    root, square,
};
use super::wave::Wave;
use crate::color::matrix::{cross, dot};
use crate::stokes::any_axis;
use num_complex::Complex64;

/// A biaxial crystal at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Biaxial {
    /// ε along each axis of the crystal.
    pub permittivity: [f64; 3],
    /// The axes of the crystal, unit.
    pub axes: [Real3; 3],
    /// The optic axes, unit.
    pub optic: [Real3; 2],
    /// A and B = ½(1/n_α² ± 1/n_γ²).
    pub sheet: [f64; 2],
    /// n_β²: along the optic axes both sheets have this index.
    pub middle: f64,
}

/// One of the two sheets of the index surface.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Sheet {
    /// G₊: the smaller index.
    Fast,
    /// G₋: the larger index.
    Slow,
}

impl Sheet {
    fn sign(self) -> f64 {
        if self == Sheet::Fast { 1.0 } else { -1.0 }
    }
}

/// More steps than Newton's method has been seen to take; what takes more is left to the quartic.
const MOST_STEPS: u32 = 24;

impl Biaxial {
    /// `index` along each of the `axes`, in any order.
    pub fn new(index: [f64; 3], axes: [Real3; 3]) -> Self {
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| index[a].total_cmp(&index[b]));
        let [low, middle, high] = order.map(|i| index[i]);
        let difference = |a: f64, b: f64| (b - a) * (b + a);
        // tan V = (n_γ/n_α)√((n_β² − n_α²)/(n_γ² − n_β²)), V from the axis of n_γ.
        let across = high * difference(low, middle).sqrt();
        let beside = low * difference(middle, high).sqrt();
        let v = across.atan2(beside);
        let (sin, cos) = v.sin_cos();
        let [x, _, z] = order.map(|i| axes[i]);
        let (x2, z2) = (low.powi(-2), high.powi(-2));
        Biaxial {
            permittivity: index.map(|n| n * n),
            axes,
            optic: [1.0, -1.0].map(|side| plus(z.map(|c| c * cos), side * sin, x)),
            sheet: [0.5 * (x2 + z2), 0.5 * (x2 - z2)],
            middle: middle * middle,
        }
    }

    /// Half the angle between the optic axes about the axis of the largest index, radians.
    pub fn half_angle(&self) -> f64 {
        let [a, b] = self.optic;
        let between = cross(a, b);
        0.5 * dot(between, between).sqrt().atan2(dot(a, b))
    }

    fn by_axes(&self, v: &Complex3, factor: impl Fn(usize) -> f64) -> Complex3 {
        let shares: [Complex64; 3] = std::array::from_fn(|k| along(v, self.axes[k]) * factor(k));
        std::array::from_fn(|i| (0..3).map(|k| shares[k] * self.axes[k][i]).sum())
    }

    /// Both waves with the tangential wave vector q and energy on the side σ of a surface with normal n.
    ///
    /// Each sheet by itself: in N = q + ζn the index surface is
    ///
    /// ```text
    /// G∓(N) = A N² + B[(a₁·N)(a₂·N) ∓ |a₁×N||a₂×N|] = 1
    /// ```
    ///
    /// (Born & Wolf, §15.2–3, made homogeneous; a₁, a₂ the optic axes). The ray is along ∇G, so Newton's method in ζ from
    /// σ√(n_β² − q²) finds the root on the side of σ, in complex numbers where both waves are evanescent. Nothing cancels
    /// near an axis, where the quartic has a double root. Where only one sheet is met the quartic has to serve.
    pub fn waves(&self, q: Real3, n: Real3, side: f64) -> [Wave; 2] {
        self.sheet_by_sheet(q, n, side)
            .unwrap_or_else(|| select(&self.by_roots(q, n, Vec::new(), &self.roots(q, n)), side, n))
    }

    fn sheet_by_sheet(&self, q: Real3, n: Real3, side: f64) -> Option<[Wave; 2]> {
        let start = root(self.middle - dot(q, q)) * side;
        let from = |sheet, start| {
            let (zeta, across) = self.newton(sheet, q, n, start)?;
            let wave = self.wave(sheet, &at(q, n, zeta), n, &across);
            (wave.flux * side > 0.0 || zeta.im * side > 1e-9).then_some(wave)
        };
        let mut found = [Sheet::Fast, Sheet::Slow].map(|sheet| from(sheet, start));
        if let ([None, Some(slow)], true) = (&found, start.re != 0.0)
            && slow.propagates()
        {
            // In complex numbers the sheets are one surface: what propagates is the wave of the other.
            let beyond = self.evanescent(q, n, start.re).and_then(|start| from(Sheet::Fast, start));
            found[0] = beyond.filter(|wave| !wave.propagates() && !parallel(&wave.electric, &slow.electric));
        }
        match found {
            [Some(fast), Some(slow)] if fast.propagates() != slow.propagates() => Some([fast, slow]),
            [Some(fast), Some(slow)] if start.re != 0.0 => {
                // On an axis whose cone the surface cuts, the two are a wave and its reflection.
                Some(share_power(fast, slow, n))
                    .filter(|waves| waves.iter().all(|wave| wave.flux * side > 0.0))
            }
            // In complex numbers the sheets are one surface, and both ways may lead to the same wave.
            [Some(fast), Some(slow)] if !parallel(&fast.electric, &slow.electric) => Some([fast, slow]),
            _ => None,
        }
    }

    /// About where ζ is if the sheet of the smaller index is missed from `start`: the root of G's parabola there, whose
    /// curvature is nearly 2A.
    fn evanescent(&self, q: Real3, n: Real3, start: f64) -> Option<Complex64> {
        let at_start = at(q, n, Complex64::from(start));
        let [value, slope] = self.surface(Sheet::Fast, &at_start, n, &mut [Complex64::ONE; 2]);
        let centre = slope.re / (2.0 * self.sheet[0]);
        let height = (value.re - 1.0) / self.sheet[0] - centre * centre;
        (height > 0.0).then(|| Complex64::new(start - centre, height.sqrt() * start.signum()))
    }

    /// G, ∂G/∂ζ and the wave's D ∥ u₁ ± u₂, u = a × N/|a × N|, at N. `across` are |a₁ × N| and |a₂ × N| at the point
    /// before: of a root's two values that nearest to it is taken, so that the sheet stays the same.
    fn surface(
        &self,
        sheet: Sheet,
        normal: &Complex3,
        n: Real3,
        before: &mut [Complex64; 2],
    ) -> [Complex64; 2] {
        let [a, b] = self.sheet;
        let along_axis = self.optic.map(|axis| along(normal, axis));
        let slope = self.optic.map(|axis| dot(axis, n));
        // d|a × N|/dζ; on the axis itself the surface has a corner, and any slope of its cone serves.
        let mut widens = [Complex64::ZERO; 2];
        for i in 0..2 {
            let vector = cross_complex(&complex(self.optic[i]), normal);
            before[i] = length(&vector, before[i]);
            if before[i] != Complex64::ZERO {
                widens[i] = along(&vector, cross(self.optic[i], n)) / before[i];
            }
        }
        let across = *before;
        let sign = sheet.sign();
        let value = a * square(normal) + b * (along_axis[0] * along_axis[1] + sign * across[0] * across[1]);
        let both = slope[0] * along_axis[1] + along_axis[0] * slope[1];
        let widening = widens[0] * across[1] + across[0] * widens[1];
        [value, 2.0 * a * along(normal, n) + b * (both + sign * widening)]
    }

    /// ζ on a sheet with |a₁ × N| and |a₂ × N| there; `None` where Newton's method does not settle.
    fn newton(
        &self,
        sheet: Sheet,
        q: Real3,
        n: Real3,
        start: Complex64,
    ) -> Option<(Complex64, [Complex64; 2])> {
        let (mut zeta, mut across) = (start, [Complex64::ONE; 2]);
        for _ in 0..MOST_STEPS {
            let [value, slope] = self.surface(sheet, &at(q, n, zeta), n, &mut across);
            let step = (value - 1.0) / slope;
            zeta -= step;
            if step.norm_sqr() <= 1e-26 {
                // From a complex start a real root is met but for rounding.
                let real = zeta.im.abs() <= 1e-12;
                return Some((if real { Complex64::from(zeta.re) } else { zeta }, across));
            }
        }
        None
    }

    /// The wave of a sheet: D ∥ u₁ ± u₂ with u = a × N/|a × N|, E = ε⁻¹D, H = N × E.
    fn wave(&self, sheet: Sheet, normal: &Complex3, n: Real3, across: &[Complex64; 2]) -> Wave {
        let u: [Complex3; 2] = std::array::from_fn(|i| {
            let axis = self.optic[i];
            let vector = cross_complex(&complex(axis), normal);
            let length = length(&vector, across[i]);
            // On the axis any vector across it serves.
            if length.norm_sqr() > 1e-28 { vector.map(|x| x / length) } else { complex(any_axis(axis)) }
        });
        // The two are perpendicular; the shorter one has lost digits, or vanished.
        let [same, other] =
            [1.0, -1.0].map(|sign| plus_complex(&u[0], Complex64::from(sign * sheet.sign()), &u[1]));
        let displacement =
            if norm_sqr(&same) >= norm_sqr(&other) { same } else { cross_complex(normal, &other) };
        // Near an axis rounding has left a part along N.
        let along_normal: Complex64 = displacement.iter().zip(normal).map(|(d, n)| d * n).sum();
        let displacement = plus_complex(&displacement, -along_normal / square(normal), normal);
        let propagates = normal.iter().all(|x| x.im == 0.0);
        Wave::by_field(*normal, self.electric(&displacement), n, propagates)
    }

    /// E = ε⁻¹D.
    fn electric(&self, displacement: &Complex3) -> Complex3 {
        self.by_axes(displacement, |k| self.permittivity[k].recip())
    }

    /// The waves that may be reflected of `incident`.
    ///
    /// On an optic axis a wave's E may have any direction across N, and rays lie on a cone. Where the surface cuts this cone
    /// a reflected wave has the same N, and its E is given by the incident one's: their powers must add up.
    pub fn reflections(&self, incident: &Wave, q: Real3, n: Real3) -> [Wave; 2] {
        let normal = incident.wave_vector();
        let beside = self.optic.map(|axis| cross(axis, normal)).map(|across| dot(across, across));
        let (known, off_axis) = (dot(normal, n), beside[0].min(beside[1]).sqrt());
        let by_sheet = || self.by_slow(known, q, n).or_else(|| self.sheet_by_sheet(q, n, -1.0));
        let by_sheet = (off_axis > 1e-8).then(by_sheet).flatten();
        let waves = by_sheet.unwrap_or_else(|| {
            if off_axis > 1e-3 {
                return select(&self.by_roots(q, n, Vec::new(), &self.roots(q, n)), -1.0, n);
            }
            let others = roots::<3>(&deflated(self.booker(q, n), known));
            select(&self.by_roots(q, n, vec![incident.at(n)], &others)[1..], -1.0, n)
        });
        let beside = |wave: &Wave| wave.propagates() && (along(&wave.normal, n) - known).norm() < 1e-4;
        let part = |wave: Wave| wave.plus(-common(incident, &wave, n) / incident.flux, incident, n);
        waves.map(|wave| if beside(&wave) { part(wave) } else { wave })
    }

    /// The waves that may be reflected of one with N·n = `known`, where the one of the smaller index is evanescent: of Booker's
    /// four roots two are then known, and the others are those of a quadratic.
    fn by_slow(&self, known: f64, q: Real3, n: Real3) -> Option<[Wave; 2]> {
        let least = self.permittivity.into_iter().fold(f64::INFINITY, f64::min);
        // Else both propagate.
        if dot(q, q) < least {
            return None;
        }
        let (zeta, across) = self.newton(Sheet::Slow, q, n, Complex64::from(-known))?;
        let slow = self.wave(Sheet::Slow, &at(q, n, zeta), n, &across);
        let [_, _, square, cubic, leading] = self.booker(q, n);
        let sum = -cubic / leading - known - zeta.re;
        let product = square / leading - known * zeta.re - (known + zeta.re) * sum;
        let height = product - 0.25 * sum * sum;
        // Near grazing the difference has no digits left.
        let settled = zeta.im == 0.0 && slow.flux < 0.0 && height > 1e-6;
        let fast = settled.then(|| self.by_root(q, n, Complex64::new(0.5 * sum, -height.sqrt())))?;
        (!fast.propagates() && along(&fast.normal, n).im < 0.0).then_some([fast, slow])
    }

    /// The wave of power along n with the tangential wave vector q and N·n near `known`.
    pub(super) fn near(&self, known: f64, q: Real3, n: Real3) -> Option<Wave> {
        let known = Complex64::from(known);
        let off = |sheet| {
            let [value, _] = self.surface(sheet, &at(q, n, known), n, &mut [Complex64::ONE; 2]);
            (value.re - 1.0).abs()
        };
        let sheet = if off(Sheet::Fast) <= off(Sheet::Slow) { Sheet::Fast } else { Sheet::Slow };
        let (zeta, across) = self.newton(sheet, q, n, known)?;
        let wave = self.wave(sheet, &at(q, n, zeta), n, &across);
        ((zeta - known).norm_sqr() < 1e-10 && wave.flux > 0.0).then_some(wave)
    }

    /// The smaller and the larger index of waves whose N has this unit direction.
    pub(super) fn indices_along(&self, direction: Real3) -> [f64; 2] {
        let [a, b] = self.sheet;
        let [first, second] = self.optic.map(|axis| {
            let across = cross(axis, direction);
            (dot(axis, direction), dot(across, across).sqrt())
        });
        let index = |sign: f64| (a + b * (first.0 * second.0 + sign * first.1 * second.1)).sqrt().recip();
        [index(1.0), index(-1.0)]
    }

    /// The roots of Booker's quartic. Near an optic axis along the surface two nearly coincide; one of them is found on
    /// its sheet, and the other is then a simple root of a cubic.
    fn roots(&self, q: Real3, n: Real3) -> [Complex64; 4] {
        let quartic = self.booker(q, n);
        let found = roots::<4>(&quartic);
        let near = |i: usize, j: usize| i != j && (found[i] - found[j]).norm() < 1e-3;
        let Some(double) = (0..4).find(|&i| (0..4).any(|j| near(i, j))) else { return found };
        let on_sheet = [Sheet::Fast, Sheet::Slow].into_iter().find_map(|sheet| {
            let (zeta, _) = self.newton(sheet, q, n, Complex64::from(found[double].re))?;
            ((zeta - found[double]).norm() < 1e-2).then_some(zeta)
        });
        let Some(zeta) = on_sheet else { return found };
        let [a, b, c] = roots::<3>(&deflated(quartic, zeta.re));
        [zeta, a, b, c]
    }

    /// Adds the waves of some roots ζ of Booker's quartic. On an optic axis, where two roots are one, the second wave is
    /// the first one's partner.
    fn by_roots(&self, q: Real3, n: Real3, mut waves: Vec<Wave>, roots: &[Complex64]) -> Vec<Wave> {
        for zeta in roots {
            let same = |wave: &&Wave| wave.propagates() && (along(&wave.normal, n) - zeta).norm() < 1e-8;
            let wave = match waves.iter().find(same) {
                Some(first) => self.partner(first, n),
                None => self.by_root(q, n, *zeta),
            };
            waves.push(wave);
        }
        waves
    }

    /// The other wave with the same N on an optic axis: their powers add up.
    fn partner(&self, first: &Wave, n: Real3) -> Wave {
        let displacement = self.by_axes(&first.electric, |k| self.permittivity[k]);
        let electric = self.electric(&cross_complex(&first.normal, &displacement));
        let partner = Wave::by_field(first.normal, electric, n, true);
        partner.plus(-common(first, &partner, n) / first.flux, first, n)
    }

    /// Booker's quartic (Booker 1939), det(ε + NNᵀ − N²) = 0:
    ///
    /// ```text
    /// N²(N·εN) − N·ρN + ε₁ε₂ε₃ = 0,   ρ = diag(ε_i(ε_j + ε_k))
    /// ```
    fn booker(&self, q: Real3, n: Real3) -> [f64; 5] {
        let [x, y, z] = self.permittivity;
        let weights = [self.permittivity, [x * (y + z), y * (z + x), z * (x + y)]];
        let [p, r] = weights.map(|weight| {
            let form = |a: Real3, b: Real3| -> f64 {
                (0..3).map(|k| weight[k] * dot(a, self.axes[k]) * dot(b, self.axes[k])).sum()
            };
            [form(q, q), 2.0 * form(q, n), form(n, n)]
        });
        let q2 = dot(q, q);
        [q2 * p[0] - r[0] + x * y * z, q2 * p[1] - r[1], p[0] + q2 * p[2] - r[2], p[1], p[2]]
    }

    /// A double root comes out as a pair that rounding has moved off the real axis.
    fn by_root(&self, q: Real3, n: Real3, zeta: Complex64) -> Wave {
        let polished = |zeta| {
            let sheets = [Sheet::Fast, Sheet::Slow].map(|sheet| {
                let mut across = [Complex64::ONE; 2];
                let [value, _] = self.surface(sheet, &at(q, n, zeta), n, &mut across);
                ((value - 1.0).norm_sqr(), sheet, zeta, across)
            });
            let (_, sheet, zeta, across) = if sheets[0].0 <= sheets[1].0 { sheets[0] } else { sheets[1] };
            let better =
                self.newton(sheet, q, n, zeta).filter(|(better, _)| (better - zeta).norm_sqr() < 1e-12);
            (better.is_some(), sheet, better.unwrap_or((zeta, across)))
        };
        let real = (zeta.im.abs() <= 1e-7).then(|| polished(Complex64::from(zeta.re)));
        let real = real.filter(|(better, ..)| *better || zeta.im.abs() <= 1e-12);
        let (_, sheet, (zeta, across)) = real.unwrap_or_else(|| polished(zeta));
        self.wave(sheet, &at(q, n, zeta), n, &across)
    }
}

/// The two of the waves that have their energy, or where they are evanescent their decay, on the side σ.
fn select(waves: &[Wave], side: f64, n: Real3) -> [Wave; 2] {
    let towards = |wave: &Wave| side * if wave.propagates() { wave.flux } else { along(&wave.normal, n).im };
    let mut waves = waves.to_vec();
    waves.sort_by(|a, b| towards(b).total_cmp(&towards(a)));
    let (first, second) = (waves[0], waves[1]);
    if first.propagates() && second.propagates() { share_power(first, second, n) } else { [first, second] }
}

/// The cubic that is left of a quartic when one root is known.
fn deflated(quartic: [f64; 5], root: f64) -> [f64; 4] {
    let mut cubic = [0.0; 4];
    cubic[3] = quartic[4];
    for k in (0..3).rev() {
        cubic[k] = quartic[k + 1] + root * cubic[k + 1];
    }
    cubic
}

/// √(v·v), of its two values the nearer to `before`.
fn length(v: &Complex3, before: Complex64) -> Complex64 {
    let length = complex_root(square(v));
    if (length * before.conj()).re < 0.0 { -length } else { length }
}

/// Whether two fields are the same but for a factor.
fn parallel(a: &Complex3, b: &Complex3) -> bool {
    norm_sqr(&cross_complex(a, b)) < 1e-12 * norm_sqr(a) * norm_sqr(b)
}

/// Two waves of one surface whose powers add up: (E₁ × H₂ + E₂ × H₁)·n = 0. Exact solutions have this; on an optic axis,
/// where each field across N is a solution and u₁, u₂ are rounding error, it has to be chosen.
fn share_power(first: Wave, second: Wave, n: Real3) -> [Wave; 2] {
    let common = common(&first, &second, n);
    if first.flux.abs() >= second.flux.abs() {
        [first, second.plus(-common / first.flux, &first, n)]
    } else {
        [first.plus(-common / second.flux, &second, n), second]
    }
}

/// ½(E₁ × H₂ + E₂ × H₁)·n.
fn common(first: &Wave, second: &Wave, n: Real3) -> f64 {
    let [e1, h1, e2, h2] = [&first.electric, &first.magnetic, &second.electric, &second.magnetic].map(real);
    0.5 * (dot(cross(e1, h2), n) + dot(cross(e2, h1), n))
}
