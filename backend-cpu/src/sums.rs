//! Radiances in fixed point: the same in any order.

use crate::environment::Light;
use accel::lanes::{Row, WIDTH};
use spectral_core::prepare::PreparedScene;

/// One sum for each wavelength of each sample.
pub(crate) struct Sums {
    sums: Vec<i64>,
    /// Parts of a unit of radiance: a power of two.
    unit: f64,
}

/// A path sees no more than the brightest light there is, which is so many parts in the first samples' wavelengths; the others
/// may show up to 2⁸ times as much of it.
const MOST: i32 = 54;

/// Parts of a unit of radiance for a scene: the same for all tiles, so that they do not show.
pub(crate) fn unit(scene: &PreparedScene, light: &Light) -> f64 {
    let bases = scene.table(0).basis.iter().flatten().copied().fold(0.0, f64::max);
    let brightest = (f64::from(light.most()) * bases).max(f64::MIN_POSITIVE);
    2.0_f64.powi(MOST - brightest.log2().ceil() as i32)
}

impl Sums {
    pub fn new(unit: f64, count: usize) -> Self {
        Sums { sums: vec![0; count], unit }
    }

    #[inline(always)]
    pub fn add(&mut self, place: usize, radiance: f32) {
        let sum = &mut self.sums[place];
        *sum = sum.saturating_add((f64::from(radiance) * self.unit) as i64);
    }

    /// Adds the numbers of the lanes whose bit is set.
    #[inline(always)]
    pub fn add_lanes(&mut self, places: &[u32; WIDTH], radiances: &Row, lanes: u16) {
        let mut rest = lanes;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % WIDTH;
            rest &= rest - 1;
            self.add(places[lane] as usize, radiances.0[lane]);
        }
    }

    pub fn radiances(&self) -> Vec<f32> {
        self.sums.iter().map(|sum| (*sum as f64 / self.unit) as f32).collect()
    }
}
