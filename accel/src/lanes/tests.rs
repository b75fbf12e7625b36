use super::*;
use crate::instructions::{Instructions, Task};

/// Numbers of all sizes and signs, from a linear congruential generator.
fn numbers(seed: u64, range: i32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u32
        };
        let mantissa = f32::from_bits(0x3f80_0000 | next() & 0x7f_ffff);
        let sign = if next() & 1 == 0 { 1.0 } else { -1.0 };
        sign * mantissa * ((next() % (2 * range as u32)) as f32 - range as f32).exp2()
    }
}

fn row(next: &mut impl FnMut() -> f32) -> Row {
    Row(std::array::from_fn(|_| next()))
}

/// Every operation on the same numbers.
struct Operations([Row; 3]);

impl Task for Operations {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<V: Lanes>(self) -> Vec<u32> {
        let [a, b, c] = [V::load(&self.0[0]), V::load(&self.0[1]), V::load(&self.0[2])];
        let fraction = a / (a.abs() + b.abs() + V::splat(1.0));
        let texels = [self.0[0].0, self.0[1].0, self.0[2].0, self.0[0].0].concat();
        let share = fraction.abs() * V::splat(0.999);
        let (row, column) = ((share * V::splat(2.0)).floor(), (share * V::splat(5.0)).floor());
        let offsets = V::offsets(a.lt(b), row, column, 21);
        let [red, green, blue] = V::bilinear(&texels, &offsets, 21, share, &(b / a).stored());
        let mask = a.lt(b) & !b.lt(c) | V::Mask::from_bits(0x1248);
        let results = [
            a + b,
            a - b,
            a * b,
            a / b,
            -a,
            a.fma(b, c),
            a.fnma(b, c),
            a.abs().sqrt(),
            a.min(b),
            a.max(b),
            (fraction * V::splat(1000.0)).floor(),
            V::select(mask, a, b),
            red,
            green,
            blue,
            (fraction * V::splat(100.0)).floor().power_of_two(),
            exp2(fraction * V::splat(130.0)),
            turns(a, b),
            turns(b, c),
            V::splat(a.least()),
            Triple { x: a, y: b, z: c }.renormalized().y,
        ];
        let mut bits = vec![u32::from(mask.bits())];
        for result in results {
            let mut row = Row::default();
            result.store(&mut row);
            bits.extend(row.0.map(f32::to_bits));
        }
        bits.extend(offsets);
        let fours = texels.as_chunks::<4>().0.as_chunks::<2>().0;
        let records = std::array::from_fn(|lane| &fours[lane % 7]);
        for four in V::fours(&records, 1) {
            bits.extend(four.stored().0.map(f32::to_bits));
        }
        for lanes in [0, 1, 0x8000, 0x1248, 0xfeed, mask.bits(), u16::MAX] {
            let mut packed = [0.0; WIDTH];
            a.pack(lanes, &mut packed);
            let count = lanes.count_ones() as usize;
            bits.extend(packed[..count].iter().map(|x| x.to_bits()));
        }
        bits
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    for range in [1, 8, 60] {
        let mut next = numbers(7, range);
        for _ in 0..20_000 {
            let rows = [row(&mut next), row(&mut next), row(&mut next)];
            let expected = Instructions::Portable.run(Operations(rows));
            for set in Instructions::ALL.into_iter().filter(|set| set.available()) {
                assert_eq!(set.run(Operations(rows)), expected, "{}: {rows:?}", set.name());
            }
        }
    }
}

#[test]
fn fused_multiply_add_rounds_once() {
    let mut next = numbers(3, 70);
    for _ in 0..200_000 {
        let rows = [row(&mut next), row(&mut next), row(&mut next)];
        let mut sum = Row::default();
        Portable::load(&rows[0]).fma(Portable::load(&rows[1]), Portable::load(&rows[2])).store(&mut sum);
        for i in 0..WIDTH {
            let expected = rows[0].0[i].mul_add(rows[1].0[i], rows[2].0[i]);
            assert_eq!(sum.0[i].to_bits(), expected.to_bits(), "lane {i} of {rows:?}");
        }
    }
    // Exactly half way in double precision, and not so before.
    let (a, b, c) = (1.0 + f32::EPSILON, 1.0 + f32::EPSILON, 2.0_f32.powi(-60));
    let mut sum = Row::default();
    Portable::splat(a).fma(Portable::splat(b), Portable::splat(c)).store(&mut sum);
    assert_eq!(sum.0[0], a.mul_add(b, c));
}

#[test]
fn powers_and_angles_are_good_to_a_rounding_or_two() {
    let value = |v: Portable| f64::from(v.lane(0));
    for k in 0..200_000 {
        let x = -126.0 + k as f32 * 1.26e-3;
        let exact = f64::from(x).exp2();
        assert!((value(exp2(Portable::splat(x))) / exact - 1.0).abs() < 1.2e-7, "2^{x}");
        let angle = f64::from(k) * 3.7e-5 - 3.7;
        let (y, x) = (angle.sin() as f32, angle.cos() as f32);
        let exact = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU;
        let found = value(turns(Portable::splat(y), Portable::splat(x)));
        assert!((found - exact).abs() < 6e-8, "atan2({y}, {x}): {found} for {exact}");
    }
    assert_eq!(value(turns(Portable::splat(0.0), Portable::splat(0.0))), 0.0);
    assert_eq!(value(exp2(Portable::splat(-1e30))), 2.0_f64.powi(-126));
    assert_eq!(value(exp2(Portable::splat(0.0))), 1.0);
}
