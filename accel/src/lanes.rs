//! Sixteen numbers at a time, in whatever registers the machine has.
//!
//! The packet width is logical: every form of [`Lanes`] holds sixteen lanes, in one AVX-512 register, two AVX
//! registers or an array, and does the same correctly rounded operations, fused multiply-add included, in each
//! lane by itself. So one source gives the same bits on every machine, and no lane's result depends on what
//! its neighbours hold.

mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::slabs::Slabs;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

pub use portable::{Flags, Portable};
#[cfg(target_arch = "x86_64")]
// Not to be named elsewhere: their values may exist only where `Instructions` has found the registers.
pub(crate) use x86::{Avx2, Avx512};

/// Lanes of a packet.
pub const WIDTH: usize = 16;

/// Sixteen numbers in memory.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Row(
    /// Lane by lane.
    pub [f32; WIDTH],
);

/// A yes or no for each lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Lane i is bit i.
    fn from_bits(bits: u16) -> Self;
    /// Lane i is bit i.
    fn bits(self) -> u16;
}

/// Sixteen `f32`. Comparisons with NaN are false; `min` and `max` of NaN are unspecified, so nothing here
/// passes one.
///
/// Every method is meant to be inlined into a function that enables the instruction set at hand.
pub trait Lanes:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// The result of comparisons.
    type Mask: Mask;
    /// The test of eight boxes against one ray.
    type Slabs: Slabs;

    /// The same number in every lane.
    fn splat(value: f32) -> Self;
    /// From memory.
    fn load(row: &Row) -> Self;
    /// To memory.
    fn store(self, row: &mut Row);
    /// self · a + b, rounded once.
    fn fma(self, a: Self, b: Self) -> Self;
    /// b − self · a, rounded once.
    fn fnma(self, a: Self, b: Self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The smaller.
    fn min(self, other: Self) -> Self;
    /// The larger.
    fn max(self, other: Self) -> Self;
    /// Without the sign.
    fn abs(self) -> Self;
    /// The next integer down.
    fn floor(self) -> Self;
    /// self < other.
    fn lt(self, other: Self) -> Self::Mask;
    /// `yes` where the mask is set, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// 2 to the power of an integer from −126 to 127.
    fn power_of_two(self) -> Self;
    /// The smallest of all lanes.
    fn least(self) -> f32;
    /// The numbers of the lanes whose bit is set to memory, without gaps; what follows them there is spoilt.
    fn pack(self, lanes: u16, to: &mut [f32; WIDTH]);
    /// From memory, of each lane's record the four numbers at `place`.
    fn fours<const N: usize>(records: &[&[[f32; 4]; N]; WIDTH], place: usize) -> [Self; 4];
    /// row · pitch + 3 · column where the mask is set, else 0. Rows and columns are whole and the result is in
    /// 0..2³¹.
    fn offsets(mask: Self::Mask, row: Self, column: Self, pitch: u32) -> [u32; WIDTH];
    /// Red, green and blue between four texels: those at and after each offset, and those `pitch` later; first
    /// down the column by `down`, then along the row by `across`.
    ///
    /// # Panics
    /// Where an offset + `pitch` + 8 is beyond the end of `texels`.
    fn bilinear(texels: &[f32], offsets: &[u32; WIDTH], pitch: u32, across: Self, down: &Row) -> [Self; 3];

    /// Runs a piece of work as a function of its own, with the instruction set of these lanes: what is inlined
    /// everywhere takes the compiler for ever.
    fn apart<W: Work>(work: W) -> W::Output;

    /// Lane `lane`, through memory.
    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        self.stored().0[lane % WIDTH]
    }

    /// The numbers of the lanes whose bit is set, 0 in the others.
    #[inline(always)]
    fn only(self, lanes: u16) -> [f32; WIDTH] {
        Self::select(Self::Mask::from_bits(lanes), self, Self::splat(0.0)).stored().0
    }

    /// In memory.
    #[inline(always)]
    fn stored(self) -> Row {
        let mut row = Row::default();
        self.store(&mut row);
        row
    }
}

/// Work to be done by [`Lanes::apart`].
pub trait Work {
    /// What it gives.
    type Output;

    /// Does it. To be marked `#[inline(always)]`.
    fn work(self) -> Self::Output;
}

/// A vector in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Triple<V> {
    /// First coordinates.
    pub x: V,
    /// Second coordinates.
    pub y: V,
    /// Third coordinates.
    pub z: V,
}

impl<V: Lanes> Triple<V> {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat([x, y, z]: [f32; 3]) -> Self {
        Triple { x: V::splat(x), y: V::splat(y), z: V::splat(z) }
    }

    /// From memory.
    #[inline(always)]
    pub fn load([x, y, z]: &[Row; 3]) -> Self {
        Triple { x: V::load(x), y: V::load(y), z: V::load(z) }
    }

    /// In memory.
    #[inline(always)]
    pub fn stored(self) -> [Row; 3] {
        [self.x.stored(), self.y.stored(), self.z.stored()]
    }

    /// The inner product, every operation fused that can be.
    #[inline(always)]
    pub fn dot(self, other: Self) -> V {
        self.z.fma(other.z, self.y.fma(other.y, self.x * other.x))
    }

    /// The inner product, no operation fused: as shaders compute it, which have no say in what is fused.
    #[inline(always)]
    pub fn dot_unfused(self, other: Self) -> V {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The sum, and with [`scaled`](Self::scaled) the unfused form of [`fma`](Self::fma).
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Triple { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }

    /// The vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Triple {
            x: self.z.fnma(other.y, self.y * other.z),
            y: self.x.fnma(other.z, self.z * other.x),
            z: self.y.fnma(other.x, self.x * other.y),
        }
    }

    /// self · factor + other.
    #[inline(always)]
    pub fn fma(self, factor: V, other: Self) -> Self {
        Triple {
            x: self.x.fma(factor, other.x),
            y: self.y.fma(factor, other.y),
            z: self.z.fma(factor, other.z),
        }
    }

    /// other − self · factor.
    #[inline(always)]
    pub fn fnma(self, factor: V, other: Self) -> Self {
        Triple {
            x: self.x.fnma(factor, other.x),
            y: self.y.fnma(factor, other.y),
            z: self.z.fnma(factor, other.z),
        }
    }

    /// Times a number.
    #[inline(always)]
    pub fn scaled(self, factor: V) -> Self {
        Triple { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }

    /// One Newton step towards length 1: keeps the rounding of a hundred reflections from adding up.
    #[inline(always)]
    pub fn renormalized(self) -> Self {
        self.scaled(V::splat(1.5) - V::splat(0.5) * self.dot_unfused(self))
    }

    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub fn select(mask: V::Mask, yes: Self, no: Self) -> Self {
        Triple {
            x: V::select(mask, yes.x, no.x),
            y: V::select(mask, yes.y, no.y),
            z: V::select(mask, yes.z, no.z),
        }
    }
}

/// The largest offset at which [`Lanes::bilinear`] stays within the image, for its check.
#[inline(always)]
fn furthest(offsets: &[u32; WIDTH]) -> usize {
    let mut furthest = 0;
    for offset in offsets {
        furthest = furthest.max(*offset);
    }
    furthest as usize
}

/// Colours between those on the left and on the right.
#[inline(always)]
fn mixed<V: Lanes>(left: [V; 3], right: [V; 3], across: V) -> [V; 3] {
    [
        (right[0] - left[0]).fma(across, left[0]),
        (right[1] - left[1]).fma(across, left[1]),
        (right[2] - left[2]).fma(across, left[2]),
    ]
}

/// Puts a vector into a lane.
#[inline(always)]
pub fn put(rows: &mut [Row; 3], lane: usize, vector: [f32; 3]) {
    for (row, coordinate) in rows.iter_mut().zip(vector) {
        row.0[lane] = coordinate;
    }
}

/// 2ˣ to 2 · 10⁻⁹ of its value before rounding; x ≤ 127, and what is below −126 counts as −126.
#[inline(always)]
pub fn exp2<V: Lanes>(x: V) -> V {
    // Minimax on [−½, ½] in relative error.
    const C: [f32; 7] = [
        1.0,
        std::f32::consts::LN_2,
        0.240_226_47,
        0.055_503_29,
        0.009_618_489,
        0.001_339_993_2,
        0.000_153_458_08,
    ];
    let x = x.max(V::splat(-126.0));
    let whole = (x + V::splat(0.5)).floor();
    polynomial(x - whole, &C) * whole.power_of_two()
}

/// The angle of (x, y) from the x axis, in turns from −½ to ½; 0 for (0, 0). To 2 · 10⁻⁸ of its value before
/// rounding.
#[inline(always)]
pub fn turns<V: Lanes>(y: V, x: V) -> V {
    // Minimax of atan(q)/(2πq) in q² on [0, 1], in relative error.
    const C: [f32; 9] = [
        0.159_154_94,
        -0.053_051_234,
        0.031_819_243,
        -0.022_605_8,
        0.016_935_56,
        -0.011_943_429,
        0.006_794_533,
        -0.002_557_380_3,
        0.000_453_568_47,
    ];
    let (zero, ax, ay) = (V::splat(0.0), x.abs(), y.abs());
    let (low, high) = (ax.min(ay), ax.max(ay));
    let q = low / high.max(V::splat(f32::MIN_POSITIVE));
    let angle = q * polynomial(q * q, &C);
    let angle = V::select(ax.lt(ay), V::splat(0.25) - angle, angle);
    let angle = V::select(x.lt(zero), V::splat(0.5) - angle, angle);
    V::select(y.lt(zero), -angle, angle)
}

/// Horner's rule, lowest coefficient first.
#[inline(always)]
fn polynomial<V: Lanes, const N: usize>(x: V, coefficients: &[f32; N]) -> V {
    let mut sum = V::splat(coefficients[N - 1]);
    for k in 1..N {
        sum = sum.fma(x, V::splat(coefficients[N - 1 - k]));
    }
    sum
}

#[cfg(test)]
mod tests;
