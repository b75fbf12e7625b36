//! Sixteen lanes in AVX-512 and in AVX registers.
//!
//! Values of these types are made only inside functions that [`crate::instructions`] enters after it has found
//! the instruction set on the machine at hand; that is what every `SAFETY` line here rests on.

use super::{Lanes, Mask, Row, WIDTH, Work, furthest, mixed};
use crate::slabs::Eight;
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// One 512-bit register.
#[derive(Debug, Clone, Copy)]
pub struct Avx512(__m512);

/// Two 256-bit registers.
#[derive(Debug, Clone, Copy)]
pub struct Avx2([__m256; 2]);

/// A mask register.
#[derive(Debug, Clone, Copy)]
pub struct Mask512(__mmask16);

/// All ones or all zeros, lane by lane.
#[derive(Debug, Clone, Copy)]
pub struct Mask256([__m256; 2]);

macro_rules! operator {
    ($trait:ident, $method:ident, $wide:ident, $half:ident) => {
        impl $trait for Avx512 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: values of this type exist only where AVX-512 F does.
                Avx512(unsafe { $wide(self.0, other.0) })
            }
        }
        impl $trait for Avx2 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: values of this type exist only where AVX2 does.
                Avx2(unsafe { [$half(self.0[0], other.0[0]), $half(self.0[1], other.0[1])] })
            }
        }
    };
}

operator!(Add, add, _mm512_add_ps, _mm256_add_ps);
operator!(Sub, sub, _mm512_sub_ps, _mm256_sub_ps);
operator!(Mul, mul, _mm512_mul_ps, _mm256_mul_ps);
operator!(Div, div, _mm512_div_ps, _mm256_div_ps);

impl Neg for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 DQ does.
        Avx512(unsafe { _mm512_xor_ps(self.0, _mm512_set1_ps(-0.0)) })
    }
}

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Avx2(unsafe {
            let sign = _mm256_set1_ps(-0.0);
            [_mm256_xor_ps(self.0[0], sign), _mm256_xor_ps(self.0[1], sign)]
        })
    }
}

macro_rules! mask_operator {
    ($trait:ident, $method:ident, $operator:tt, $half:ident) => {
        impl $trait for Mask512 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Mask512(self.0 $operator other.0)
            }
        }
        impl $trait for Mask256 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: values of this type exist only where AVX2 does.
                Mask256(unsafe { [$half(self.0[0], other.0[0]), $half(self.0[1], other.0[1])] })
            }
        }
    };
}

mask_operator!(BitAnd, bitand, &, _mm256_and_ps);
mask_operator!(BitOr, bitor, |, _mm256_or_ps);

impl Not for Mask512 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Mask512(!self.0)
    }
}

impl Not for Mask256 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Mask256(unsafe {
            let ones = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
            [_mm256_xor_ps(self.0[0], ones), _mm256_xor_ps(self.0[1], ones)]
        })
    }
}

impl Mask for Mask512 {
    #[inline(always)]
    fn from_bits(bits: u16) -> Self {
        Mask512(bits)
    }

    #[inline(always)]
    fn bits(self) -> u16 {
        self.0
    }
}

impl Mask for Mask256 {
    #[inline(always)]
    fn from_bits(bits: u16) -> Self {
        // SAFETY: values of this type are made only where AVX2 is.
        Mask256(unsafe {
            let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let low = _mm256_and_si256(_mm256_set1_epi32(i32::from(bits)), lane);
            let high = _mm256_and_si256(_mm256_set1_epi32(i32::from(bits >> 8)), lane);
            [
                _mm256_castsi256_ps(_mm256_cmpeq_epi32(low, lane)),
                _mm256_castsi256_ps(_mm256_cmpeq_epi32(high, lane)),
            ]
        })
    }

    #[inline(always)]
    fn bits(self) -> u16 {
        // SAFETY: values of this type exist only where AVX2 does.
        unsafe { (_mm256_movemask_ps(self.0[0]) | _mm256_movemask_ps(self.0[1]) << 8) as u16 }
    }
}

impl Lanes for Avx512 {
    type Mask = Mask512;
    type Slabs = Eight;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: values of this type are made only where AVX-512 F is.
        Avx512(unsafe { _mm512_set1_ps(value) })
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        // SAFETY: a row is 64 bytes, and aligned to as many.
        Avx512(unsafe { _mm512_load_ps(row.0.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, row: &mut Row) {
        // SAFETY: a row is 64 bytes, and aligned to as many.
        unsafe { _mm512_store_ps(row.0.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn fma(self, a: Self, b: Self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Avx512(unsafe { _mm512_fmadd_ps(self.0, a.0, b.0) })
    }

    #[inline(always)]
    fn fnma(self, a: Self, b: Self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Avx512(unsafe { _mm512_fnmadd_ps(self.0, a.0, b.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Avx512(unsafe { _mm512_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Avx512(unsafe { _mm512_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Avx512(unsafe { _mm512_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Avx512(unsafe { _mm512_abs_ps(self.0) })
    }

    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Avx512(unsafe { _mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0) })
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Mask512 {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Mask512(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn select(mask: Mask512, yes: Self, no: Self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Avx512(unsafe { _mm512_mask_blend_ps(mask.0, no.0, yes.0) })
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        // SAFETY: values of this type exist only where AVX-512 F does.
        Avx512(unsafe {
            let biased = _mm512_add_epi32(_mm512_cvttps_epi32(self.0), _mm512_set1_epi32(127));
            _mm512_castsi512_ps(_mm512_slli_epi32::<23>(biased))
        })
    }

    #[inline(always)]
    fn least(self) -> f32 {
        // SAFETY: values of this type exist only where AVX-512 F does.
        unsafe { _mm512_reduce_min_ps(self.0) }
    }

    #[inline(always)]
    fn pack(self, lanes: u16, to: &mut [f32; WIDTH]) {
        // SAFETY: sixteen floats to sixteen; values of this type exist only where AVX-512 F does. In a register first: to memory the
        // instruction is slow on AMD's Zen 4.
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), _mm512_maskz_compress_ps(lanes, self.0)) }
    }

    #[inline(always)]
    fn offsets(mask: Mask512, row: Self, column: Self, pitch: u32) -> [u32; WIDTH] {
        // SAFETY: values of this type exist only where AVX-512 F does; both sides are 64 bytes of integers.
        unsafe {
            let row = _mm512_mullo_epi32(_mm512_cvttps_epi32(row.0), _mm512_set1_epi32(pitch as i32));
            let column = _mm512_mullo_epi32(_mm512_cvttps_epi32(column.0), _mm512_set1_epi32(3));
            std::mem::transmute(_mm512_maskz_add_epi32(mask.0, row, column))
        }
    }

    #[inline(always)]
    fn bilinear(texels: &[f32], offsets: &[u32; WIDTH], pitch: u32, across: Self, down: &Row) -> [Self; 3] {
        let columns = columns(texels, offsets, pitch, down);
        let [red, green, blue, next_red] = quarters(&columns[0]);
        let [next_green, next_blue, ..] = quarters(&columns[1]);
        mixed([red, green, blue], [next_red, next_green, next_blue], across)
    }

    #[inline(always)]
    fn fours<const N: usize>(records: &[&[[f32; 4]; N]; WIDTH], place: usize) -> [Self; 4] {
        quarters(&in_quarters(records, place))
    }

    #[inline(always)]
    fn apart<W: Work>(work: W) -> W::Output {
        // SAFETY: whoever names this type runs where its features are.
        unsafe { apart_512(work) }
    }
}

/// By the set ones of eight lanes: their numbers in order, a byte each.
static PACKED: [u64; 256] = {
    let mut packed = [0; 256];
    let mut lanes = 0;
    while lanes < 256 {
        let (mut lane, mut place) = (0, 0);
        while lane < 8 {
            if lanes >> lane & 1 == 1 {
                packed[lanes] |= (lane as u64) << (8 * place);
                place += 1;
            }
            lane += 1;
        }
        lanes += 1;
    }
    packed
};

#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn apart_512<W: Work>(work: W) -> W::Output {
    work.work()
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn apart_256<W: Work>(work: W) -> W::Output {
    work.work()
}

/// Two neighbouring texels of each lane, mixed with those below, six numbers of eight: the first four and the last
/// four, each with lane 4q + m at place 4m + q, so that four lanes in a row of a register are those of one
/// transposition.
#[inline(always)]
fn columns(texels: &[f32], offsets: &[u32; WIDTH], pitch: u32, down: &Row) -> [[[f32; 4]; WIDTH]; 2] {
    let pitch = pitch as usize;
    assert!(furthest(offsets) + pitch + 8 <= texels.len());
    let mut columns = [[[0.0; 4]; WIDTH]; 2];
    for quarter in 0..WIDTH / 4 {
        for m in 0..4 {
            let lane = 4 * quarter + m;
            // SAFETY: all offsets have been checked; four floats are stored to four, where AVX2 and FMA are.
            unsafe {
                let texel = texels.as_ptr().add(offsets[lane] as usize);
                let (top, bottom) = (_mm256_loadu_ps(texel), _mm256_loadu_ps(texel.add(pitch)));
                let column = _mm256_fmadd_ps(_mm256_sub_ps(bottom, top), _mm256_set1_ps(down.0[lane]), top);
                _mm_storeu_ps(columns[0][4 * m + quarter].as_mut_ptr(), _mm256_castps256_ps128(column));
                _mm_storeu_ps(columns[1][4 * m + quarter].as_mut_ptr(), _mm256_extractf128_ps::<1>(column));
            }
        }
    }
    columns
}

/// The four numbers at a place of each lane's record, in the order of [`columns`].
#[inline(always)]
fn in_quarters<const N: usize>(records: &[&[[f32; 4]; N]; WIDTH], place: usize) -> [[f32; 4]; WIDTH] {
    let mut fours = [[0.0; 4]; WIDTH];
    for quarter in 0..WIDTH / 4 {
        for m in 0..4 {
            fours[4 * m + quarter] = records[4 * quarter + m][place];
        }
    }
    fours
}

/// The first, second, third and fourth numbers of all lanes, from [`columns`].
#[inline(always)]
fn quarters(columns: &[[f32; 4]; WIDTH]) -> [Avx512; 4] {
    // SAFETY: 256 bytes, sixteen floats a register; called where AVX-512 F is.
    unsafe {
        let from = columns.as_ptr().cast::<f32>();
        let (a, b) = (_mm512_loadu_ps(from), _mm512_loadu_ps(from.add(16)));
        let (c, d) = (_mm512_loadu_ps(from.add(32)), _mm512_loadu_ps(from.add(48)));
        let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
        [
            Avx512(_mm512_shuffle_ps::<0x44>(ab, cd)),
            Avx512(_mm512_shuffle_ps::<0xee>(ab, cd)),
            Avx512(_mm512_shuffle_ps::<0x44>(ab_high, cd_high)),
            Avx512(_mm512_shuffle_ps::<0xee>(ab_high, cd_high)),
        ]
    }
}

/// The same for both halves.
macro_rules! halves {
    ($i:ident => $value:expr) => {{
        // SAFETY: values of this type are made and used only where AVX2 and FMA are.
        Avx2(unsafe {
            [
                {
                    let $i = 0;
                    $value
                },
                {
                    let $i = 1;
                    $value
                },
            ]
        })
    }};
}

impl Lanes for Avx2 {
    type Mask = Mask256;
    type Slabs = Eight;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: values of this type are made only where AVX2 is.
        Avx2(unsafe { [_mm256_set1_ps(value); 2] })
    }

    #[inline(always)]
    fn load(row: &Row) -> Self {
        // SAFETY: a row is twice 32 bytes, and aligned to as many.
        Avx2(unsafe { [_mm256_load_ps(row.0.as_ptr()), _mm256_load_ps(row.0.as_ptr().add(8))] })
    }

    #[inline(always)]
    fn store(self, row: &mut Row) {
        // SAFETY: a row is twice 32 bytes, and aligned to as many.
        unsafe {
            _mm256_store_ps(row.0.as_mut_ptr(), self.0[0]);
            _mm256_store_ps(row.0.as_mut_ptr().add(8), self.0[1]);
        }
    }

    #[inline(always)]
    fn fma(self, a: Self, b: Self) -> Self {
        halves!(i => _mm256_fmadd_ps(self.0[i], a.0[i], b.0[i]))
    }

    #[inline(always)]
    fn fnma(self, a: Self, b: Self) -> Self {
        halves!(i => _mm256_fnmadd_ps(self.0[i], a.0[i], b.0[i]))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        halves!(i => _mm256_sqrt_ps(self.0[i]))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        halves!(i => _mm256_min_ps(self.0[i], other.0[i]))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        halves!(i => _mm256_max_ps(self.0[i], other.0[i]))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        halves!(i => _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0[i]))
    }

    #[inline(always)]
    fn floor(self) -> Self {
        halves!(i => _mm256_floor_ps(self.0[i]))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Mask256 {
        Mask256(halves!(i => _mm256_cmp_ps::<_CMP_LT_OQ>(self.0[i], other.0[i])).0)
    }

    #[inline(always)]
    fn select(mask: Mask256, yes: Self, no: Self) -> Self {
        // As bytes: of a blend of words, one of them loaded from where the result goes, LLVM makes a masked store. On AMD's
        // Zen 2 and Zen 3 that takes some twenty operations, and a load from there waits for all of them.
        halves!(i => {
            let [no, yes, mask] = [_mm256_castps_si256(no.0[i]), _mm256_castps_si256(yes.0[i]), _mm256_castps_si256(mask.0[i])];
            _mm256_castsi256_ps(_mm256_blendv_epi8(no, yes, mask))
        })
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        halves!(i => {
            let biased = _mm256_add_epi32(_mm256_cvttps_epi32(self.0[i]), _mm256_set1_epi32(127));
            _mm256_castsi256_ps(_mm256_slli_epi32::<23>(biased))
        })
    }

    #[inline(always)]
    fn least(self) -> f32 {
        // SAFETY: values of this type exist only where AVX2 does.
        unsafe {
            let eight = _mm256_min_ps(self.0[0], self.0[1]);
            let four = _mm_min_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps::<1>(eight));
            let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_min_ss(two, _mm_shuffle_ps::<1>(two, two)))
        }
    }

    #[inline(always)]
    fn pack(self, lanes: u16, to: &mut [f32; WIDTH]) {
        let (low, high) = (usize::from(lanes & 0xff), usize::from(lanes >> 8));
        let first = low.count_ones() as usize;
        // SAFETY: eight floats at place `first`, which is at most 8, of sixteen; values of this type exist only where AVX2 does.
        unsafe {
            let low = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(PACKED[low] as i64));
            let high = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(PACKED[high] as i64));
            _mm256_storeu_ps(to.as_mut_ptr(), _mm256_permutevar8x32_ps(self.0[0], low));
            _mm256_storeu_ps(to.as_mut_ptr().add(first), _mm256_permutevar8x32_ps(self.0[1], high));
        }
    }

    #[inline(always)]
    fn offsets(mask: Mask256, row: Self, column: Self, pitch: u32) -> [u32; WIDTH] {
        let pitch = pitch as i32;
        let offsets = halves!(i => {
            let row = _mm256_mullo_epi32(_mm256_cvttps_epi32(row.0[i]), _mm256_set1_epi32(pitch));
            let column = _mm256_mullo_epi32(_mm256_cvttps_epi32(column.0[i]), _mm256_set1_epi32(3));
            _mm256_and_ps(_mm256_castsi256_ps(_mm256_add_epi32(row, column)), mask.0[i])
        });
        // SAFETY: both sides are 64 bytes.
        unsafe { std::mem::transmute(offsets.0) }
    }

    #[inline(always)]
    fn bilinear(texels: &[f32], offsets: &[u32; WIDTH], pitch: u32, across: Self, down: &Row) -> [Self; 3] {
        let columns = columns(texels, offsets, pitch, down);
        let [red, green, blue, next_red] = eighths(&columns[0]);
        let [next_green, next_blue, ..] = eighths(&columns[1]);
        mixed([red, green, blue], [next_red, next_green, next_blue], across)
    }

    #[inline(always)]
    fn fours<const N: usize>(records: &[&[[f32; 4]; N]; WIDTH], place: usize) -> [Self; 4] {
        eighths(&in_quarters(records, place))
    }

    #[inline(always)]
    fn apart<W: Work>(work: W) -> W::Output {
        // SAFETY: whoever names this type runs where its features are.
        unsafe { apart_256(work) }
    }
}

/// As [`quarters`], in two registers each.
#[inline(always)]
fn eighths(columns: &[[f32; 4]; WIDTH]) -> [Avx2; 4] {
    let (low, high) = (transposed(columns, 0), transposed(columns, 8));
    [Avx2([low[0], high[0]]), Avx2([low[1], high[1]]), Avx2([low[2], high[2]]), Avx2([low[3], high[3]])]
}

/// The numbers of eight lanes: rows of sixteen floats, of which eight from `first` on.
#[inline(always)]
fn transposed(columns: &[[f32; 4]; WIDTH], first: usize) -> [__m256; 4] {
    let floats = &columns.as_flattened()[first..][..3 * WIDTH + 8];
    // SAFETY: eight floats from each of four rows of sixteen, of which as many remain; called where AVX2 is.
    unsafe {
        let from = floats.as_ptr();
        let (a, b) = (_mm256_loadu_ps(from), _mm256_loadu_ps(from.add(16)));
        let (c, d) = (_mm256_loadu_ps(from.add(32)), _mm256_loadu_ps(from.add(48)));
        let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
        [
            _mm256_shuffle_ps::<0x44>(ab, cd),
            _mm256_shuffle_ps::<0xee>(ab, cd),
            _mm256_shuffle_ps::<0x44>(ab_high, cd_high),
            _mm256_shuffle_ps::<0xee>(ab_high, cd_high),
        ]
    }
}
