//! Which instruction set packets and single rays run in: one source, chosen at run time.

use crate::lanes::{self, Lanes};

/// An instruction set for [`Lanes`]. Results are the same, bit for bit, in all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instructions {
    /// AVX-512 (F, VL, DQ, BW): sixteen lanes a register.
    Avx512,
    /// AVX2 and FMA, with the bit counts (BMI, LZCNT, POPCNT) that come with them: eight lanes a register.
    Avx2,
    /// Whatever the program was compiled for: NEON on 64-bit Arm, SSE2 on x86-64.
    Portable,
}

/// Work that is the same in every instruction set.
pub trait Task {
    /// What it gives.
    type Output;

    /// Does it. To be marked `#[inline(always)]`, as must be all that handles lanes within.
    fn run<V: Lanes>(self) -> Self::Output;
}

impl Instructions {
    /// All of them, the best first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Portable];

    /// The best that this machine has.
    pub fn best() -> Self {
        Self::ALL.into_iter().find(|set| set.available()).unwrap_or(Self::Portable)
    }

    /// Whether this machine has it.
    pub fn available(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512bw")
                    && Self::Avx2.available()
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("popcnt")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx512 | Self::Avx2 => false,
            Self::Portable => true,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "AVX-512",
            Self::Avx2 => "AVX2",
            Self::Portable => "portable",
        }
    }

    /// Runs a task in this instruction set, or the portable one where the machine lacks it.
    pub fn run<T: Task>(self, task: T) -> T::Output {
        Found(if self.available() { self } else { Self::Portable }).run(task)
    }
}

/// An instruction set that the machine has been found to have, which so needs to be asked for only once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found(Instructions);

impl Found {
    /// The best there is.
    pub fn best() -> Self {
        Found(Instructions::best())
    }

    /// Runs a task in it.
    #[inline(always)]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: a value of this type is made only where `available` has found the features.
            Instructions::Avx512 => unsafe { avx512::run(task) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            Instructions::Avx2 => unsafe { avx2::run(task) },
            _ => portable::run(task),
        }
    }
}

// Each in a module of its own: so the compiler translates them side by side.

#[cfg(target_arch = "x86_64")]
mod avx512 {
    use super::*;

    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,popcnt,bmi1,bmi2,lzcnt")]
    pub fn run<T: Task>(task: T) -> T::Output {
        task.run::<lanes::Avx512>()
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::*;

    #[target_feature(enable = "avx2,fma,popcnt,bmi1,bmi2,lzcnt")]
    pub fn run<T: Task>(task: T) -> T::Output {
        task.run::<lanes::Avx2>()
    }
}

mod portable {
    use super::*;

    #[inline(never)]
    pub fn run<T: Task>(task: T) -> T::Output {
        task.run::<lanes::Portable>()
    }
}
