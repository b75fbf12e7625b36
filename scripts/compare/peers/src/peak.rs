//! The peak of the core: fused multiply-adds on registers, with enough chains to hide their latency.

use crate::Failure;
use cpu_time::ProcessTime;
use serde_json::{Value, json};
use std::hint::black_box;

const STEPS: usize = 40_000_000;

/// Fused multiply-adds a second, by instruction set.
pub fn measure() -> Result<Value, Failure> {
    #[cfg(target_arch = "x86_64")]
    {
        let mut best = serde_json::Map::new();
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the machine has it.
            best.insert("avx512".into(), rate(16 * 16, || unsafe { avx512() }).into());
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: the machine has them.
            best.insert("avx2".into(), rate(8 * 12, || unsafe { avx2() }).into());
        }
        if !best.is_empty() {
            return Ok(json!(best));
        }
    }
    Err("peak rates are measured with AVX2 or AVX-512".into())
}

/// The read bandwidth of the core in bytes a second: for a block that fits the second cache, and for one that fits none.
pub fn bandwidth() -> Value {
    let rate = |bytes: usize, passes: usize| {
        let block = vec![1.0f32; bytes / size_of::<f32>()];
        // Enough sums to hide the latency of an addition.
        let pass = || {
            let mut sums = [0.0f32; 64];
            for row in block.chunks_exact(sums.len()) {
                sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
            }
            sums
        };
        black_box(pass());
        let time = ProcessTime::now();
        for _ in 0..passes {
            black_box(pass());
        }
        (bytes * passes) as f64 / time.elapsed().as_secs_f64()
    };
    json!({ "second cache": rate(512 << 10, 4000), "memory": rate(1 << 30, 2) })
}

/// The rate of a task with `numbers` operations a step.
#[cfg(target_arch = "x86_64")]
fn rate(numbers: usize, task: impl Fn() -> f32) -> f64 {
    let time = ProcessTime::now();
    black_box(task());
    (numbers * STEPS) as f64 / time.elapsed().as_secs_f64()
}

/// Sixteen chains of sixteen numbers.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn avx512() -> f32 {
    use std::arch::x86_64::{_mm512_fmadd_ps, _mm512_reduce_add_ps, _mm512_set1_ps};
    let (factor, term) = (_mm512_set1_ps(black_box(0.999)), _mm512_set1_ps(black_box(0.001)));
    let mut chains = [_mm512_set1_ps(black_box(0.5)); 16];
    for _ in 0..STEPS {
        for chain in &mut chains {
            *chain = _mm512_fmadd_ps(*chain, factor, term);
        }
    }
    chains.iter().map(|chain| _mm512_reduce_add_ps(*chain)).sum()
}

/// Twelve chains of eight numbers.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn avx2() -> f32 {
    use std::arch::x86_64::{_mm256_cvtss_f32, _mm256_fmadd_ps, _mm256_set1_ps};
    let (factor, term) = (_mm256_set1_ps(black_box(0.999)), _mm256_set1_ps(black_box(0.001)));
    // There are sixteen registers, two of them for the factor and the term.
    let mut chains = [_mm256_set1_ps(black_box(0.5)); 12];
    for _ in 0..STEPS {
        for chain in &mut chains {
            *chain = _mm256_fmadd_ps(*chain, factor, term);
        }
    }
    chains.iter().map(|chain| _mm256_cvtss_f32(*chain)).sum::<f32>()
}
