//! The rays and the energy of a trace, summed so that the order of work does not show.

use accel::lanes::{Row, WIDTH};
use spectral_core::tracer::Energy;

/// Sums in fixed point, in the order of [`Fate`]: integers add up to the same total in any order.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Account {
    rays: u64,
    started: u64,
    energies: [u128; 4],
}

/// What may become of throughput that neither arrives nor is absorbed; as [`Energy`] has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fate {
    DroppedDepth,
    DroppedThreshold,
    LeftAtLimit,
    Lost,
}

/// 2⁴⁸ parts of one unit of throughput.
const UNIT: f64 = (1u64 << 48) as f64;

impl Account {
    /// Adds one pixel sample's rays and energy.
    pub fn add_sample(&mut self, rays: u64, energy: &Energy) {
        self.count(rays);
        self.start(energy.started as usize);
        let parts = [energy.dropped_depth, energy.dropped_threshold, energy.left_at_limit, energy.lost];
        for (sum, part) in self.energies.iter_mut().zip(parts) {
            *sum += (part * UNIT) as u128;
        }
    }

    /// Counts a tile's pixel samples × wavelengths.
    pub fn start(&mut self, started: usize) {
        self.started += started as u64;
    }

    /// Counts rays.
    #[inline(always)]
    pub fn count(&mut self, rays: u64) {
        self.rays += rays;
    }

    /// Adds shares of throughput.
    #[inline(always)]
    pub fn add(&mut self, fate: Fate, shares: &[f32; WIDTH]) {
        // A share is at most 1, or a little more by rounding: the sum of sixteen fits.
        let parts: u64 = shares.iter().map(|share| (f64::from(*share) * UNIT) as u64).sum();
        self.energies[fate as usize] += u128::from(parts);
    }

    /// Adds the throughput of some lanes, of which there are few.
    #[inline(always)]
    pub fn add_few(&mut self, fate: Fate, shares: &Row, mut lanes: u16) {
        let mut parts = 0;
        while lanes != 0 {
            parts += (f64::from(shares.0[lanes.trailing_zeros() as usize]) * UNIT) as u64;
            lanes &= lanes - 1;
        }
        self.energies[fate as usize] += u128::from(parts);
    }

    pub fn rays(&self) -> u64 {
        self.rays
    }

    pub fn energy(&self) -> Energy {
        let [dropped_depth, dropped_threshold, left_at_limit, lost] =
            self.energies.map(|parts| parts as f64 / UNIT);
        Energy { started: self.started as f64, dropped_depth, dropped_threshold, left_at_limit, lost }
    }
}

impl std::ops::AddAssign for Account {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.started += other.started;
        for (sum, part) in self.energies.iter_mut().zip(other.energies) {
            *sum += part;
        }
    }
}
