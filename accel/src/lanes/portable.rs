//! Sixteen lanes as an array: for NEON, whose registers the compiler fills by itself, and for machines without
//! fused multiply-add, which is then rounded by way of double precision.

// Every loop runs over the lanes of several arrays.
#![allow(clippy::needless_range_loop)]

use super::{Lanes, Mask, Row, WIDTH, Work};
use crate::slabs::Plain;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// An array.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub struct Portable([f32; WIDTH]);

/// All ones or all zeros, lane by lane.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub struct Flags([u32; WIDTH]);

/// A lane-by-lane result.
macro_rules! each {
    ($type:ident, $lane:ident => $value:expr) => {{
        let mut result = [Default::default(); WIDTH];
        for $lane in 0..WIDTH {
            result[$lane] = $value;
        }
        $type(result)
    }};
}

/// Functions that are inlined where this is the fastest form there is. On x86-64 they are calls: what is inlined
/// everywhere is a megabyte there, for processors that are rare.
macro_rules! functions {
    ($(fn $name:ident($($arguments:tt)*) -> $result:ty $body:block)*) => {$(
        #[cfg_attr(target_arch = "x86_64", inline(never))]
        #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
        fn $name($($arguments)*) -> $result $body
    )*};
}

macro_rules! operator {
    ($trait:ident, $method:ident, $operator:tt, $type:ident) => {
        impl $trait for $type {
            type Output = Self;

            functions! {
                fn $method(self, other: Self) -> Self {
                    each!($type, i => self.0[i] $operator other.0[i])
                }
            }
        }
    };
}

operator!(Add, add, +, Portable);
operator!(Sub, sub, -, Portable);
operator!(Mul, mul, *, Portable);
operator!(Div, div, /, Portable);
operator!(BitAnd, bitand, &, Flags);
operator!(BitOr, bitor, |, Flags);

impl Neg for Portable {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each!(Portable, i => -self.0[i])
    }
}

impl Not for Flags {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        each!(Flags, i => !self.0[i])
    }
}

impl Mask for Flags {
    #[inline(always)]
    fn from_bits(bits: u16) -> Self {
        each!(Flags, i => u32::from(bits >> i & 1).wrapping_neg())
    }

    functions! {
        fn bits(self) -> u16 {
            let mut bits = 0;
            for i in 0..WIDTH {
                bits |= ((self.0[i] & 1) as u16) << i;
            }
            bits
        }
    }
}

impl Lanes for Portable {
    type Mask = Flags;
    type Slabs = Plain;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Portable([value; WIDTH])
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        Portable(row.0)
    }

    #[inline(always)]
    fn store(self, row: &mut Row) {
        row.0 = self.0;
    }

    #[inline(always)]
    fn fours<const N: usize>(records: &[&[[f32; 4]; N]; WIDTH], place: usize) -> [Self; 4] {
        let mut fours = [Portable([0.0; WIDTH]); 4];
        for i in 0..WIDTH {
            for k in 0..4 {
                fours[k].0[i] = records[i][place][k];
            }
        }
        fours
    }

    #[inline(always)]
    fn pack(self, lanes: u16, to: &mut [f32; WIDTH]) {
        let mut place = 0;
        for i in 0..WIDTH {
            to[place % WIDTH] = self.0[i];
            place += usize::from(lanes >> i & 1);
        }
    }

    functions! {
        fn fma(self, a: Self, b: Self) -> Self {
            Portable(fused(&self.0, &a.0, &b.0))
        }

        fn fnma(self, a: Self, b: Self) -> Self {
            Portable(fused(&(-self).0, &a.0, &b.0))
        }

        fn sqrt(self) -> Self {
            each!(Portable, i => self.0[i].sqrt())
        }

        fn min(self, other: Self) -> Self {
            each!(Portable, i => if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] })
        }

        fn max(self, other: Self) -> Self {
            each!(Portable, i => if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] })
        }

        fn abs(self) -> Self {
            each!(Portable, i => self.0[i].abs())
        }

        fn floor(self) -> Self {
            // Not f32::floor, which is a call where SSE4.1 is not to be had. Values beyond the integers, which are
            // whole, are none of the callers'.
            each!(Portable, i => {
                let whole = self.0[i] as i32 as f32;
                if whole > self.0[i] { whole - 1.0 } else { whole }
            })
        }

        fn lt(self, other: Self) -> Flags {
            each!(Flags, i => u32::from(self.0[i] < other.0[i]).wrapping_neg())
        }

        fn select(mask: Flags, yes: Self, no: Self) -> Self {
            each!(Portable, i => f32::from_bits(
                yes.0[i].to_bits() & mask.0[i] | no.0[i].to_bits() & !mask.0[i]
            ))
        }

        fn power_of_two(self) -> Self {
            each!(Portable, i => f32::from_bits(((self.0[i] as i32 + 127) as u32) << 23))
        }

        fn least(self) -> f32 {
            let mut least = self.0[0];
            for i in 1..WIDTH {
                least = if self.0[i] < least { self.0[i] } else { least };
            }
            least
        }

        fn offsets(mask: Flags, row: Self, column: Self, pitch: u32) -> [u32; WIDTH] {
            let mut offsets = [0; WIDTH];
            for i in 0..WIDTH {
                let offset = (row.0[i] as i32 as u32).wrapping_mul(pitch);
                offsets[i] = offset.wrapping_add(3 * (column.0[i] as i32 as u32)) & mask.0[i];
            }
            offsets
        }

        fn bilinear(texels: &[f32], offsets: &[u32; WIDTH], pitch: u32, across: Self, down: &Row) -> [Self; 3] {
            let mut colours = [[0.0; WIDTH]; 3];
            for i in 0..WIDTH {
                let top = &texels[offsets[i] as usize..][..8];
                let bottom = &texels[offsets[i] as usize + pitch as usize..][..8];
                for k in 0..3 {
                    let left = scalar_fused(bottom[k] - top[k], down.0[i], top[k]);
                    let right = scalar_fused(bottom[k + 3] - top[k + 3], down.0[i], top[k + 3]);
                    colours[k][i] = scalar_fused(right - left, across.0[i], left);
                }
            }
            colours.map(Portable)
        }
    }

    #[inline(always)]
    fn apart<W: Work>(work: W) -> W::Output {
        apart(work)
    }
}

#[inline(never)]
fn apart<W: Work>(work: W) -> W::Output {
    work.work()
}

/// Where the compiler has an instruction for it.
const FUSED: bool = cfg!(any(target_arch = "aarch64", target_feature = "fma"));
/// The bits of an f64 that an f32 has no room for, and the pattern that is exactly half way.
const BEYOND: u64 = (1 << 29) - 1;
const HALF_WAY: u64 = 1 << 28;

/// a · b + c, rounded once.
///
/// In double precision the product is exact and the sum is rounded to 53 bits; rounding that to 24 is a second
/// rounding, which matters only where the first ends exactly half way between two f32, or in the range of
/// subnormal f32. Those lanes are done by the (slow) library function.
#[inline(always)]
fn fused(a: &[f32; WIDTH], b: &[f32; WIDTH], c: &[f32; WIDTH]) -> [f32; WIDTH] {
    if FUSED { exactly_fused(a, b, c) } else { fused_in_double(a, b, c) }
}

#[inline(always)]
fn exactly_fused(a: &[f32; WIDTH], b: &[f32; WIDTH], c: &[f32; WIDTH]) -> [f32; WIDTH] {
    let mut result = [0.0; WIDTH];
    for i in 0..WIDTH {
        result[i] = a[i].mul_add(b[i], c[i]);
    }
    result
}

/// A function of its own: it is much code, and stands wherever something is multiplied.
#[inline(never)]
fn fused_in_double(a: &[f32; WIDTH], b: &[f32; WIDTH], c: &[f32; WIDTH]) -> [f32; WIDTH] {
    let mut result = [0.0; WIDTH];
    let mut doubtful = 0u64;
    for i in 0..WIDTH {
        let sum = f64::from(a[i]) * f64::from(b[i]) + f64::from(c[i]);
        result[i] = sum as f32;
        doubtful |= u64::from(is_doubtful(sum));
    }
    if doubtful == 0 { result } else { exactly_fused(a, b, c) }
}

#[inline(always)]
fn scalar_fused(a: f32, b: f32, c: f32) -> f32 {
    let sum = f64::from(a) * f64::from(b) + f64::from(c);
    if FUSED || is_doubtful(sum) { a.mul_add(b, c) } else { sum as f32 }
}

#[inline(always)]
fn is_doubtful(sum: f64) -> bool {
    let small = sum.abs() < f64::from(f32::MIN_POSITIVE) && sum != 0.0;
    (sum.to_bits() & BEYOND == HALF_WAY) | small
}
