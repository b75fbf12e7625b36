//! Light at sixteen wavelengths for linear sRGB colours: the twin of `spectral_core::upsample::smits`.

use accel::lanes::{Lanes, Row, Triple};
use spectral_core::upsample::BASES;

/// Radiance of the bases, a wavelength a lane, light and scale included.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Basis([Row; BASES]);

impl Basis {
    /// From the bases on each lane.
    pub fn new<'a>(lane: impl Fn(usize) -> &'a [f64; BASES]) -> Self {
        Basis(std::array::from_fn(|base| Row(std::array::from_fn(|place| lane(place)[base] as f32))))
    }

    /// Those of a lane.
    pub fn of(&self, lane: usize) -> [f32; BASES] {
        std::array::from_fn(|base| self.0[base].0[lane])
    }

    /// Replaces those of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, values: &[f32; BASES]) {
        for (row, value) in self.0.iter_mut().zip(values) {
            row.0[lane] = *value;
        }
    }

    /// Radiances of non-negative colours by Smits's expansion: the least component is white, what the middle one has
    /// more is the secondary of the two larger, the rest is the primary of the largest. Where two components are
    /// equal, either choice gives the same, since the weight is their difference.
    #[inline(always)]
    pub fn expand<V: Lanes>(&self, colour: Triple<V>) -> V {
        Self::expand_by(&self.0, colour)
    }

    /// The same by bases in rows.
    #[inline(always)]
    pub fn expand_by<V: Lanes>(rows: &[Row; BASES], Triple { x: r, y: g, z: b }: Triple<V>) -> V {
        let [white, cyan, magenta, yellow, red, green, blue] = rows;
        let least = r.min(g).min(b);
        let most = r.max(g).max(b);
        let middle = r.min(g).max(r.max(g).min(b));
        // The secondary lacks the least component; the primary is the greatest.
        let (r_over, g_over) = (least.lt(r), least.lt(g));
        let secondary =
            V::select(r_over, V::select(g_over, V::load(yellow), V::load(magenta)), V::load(cyan));
        let (r_under, g_under) = (r.lt(most), g.lt(most));
        let primary = V::select(r_under, V::select(g_under, V::load(blue), V::load(green)), V::load(red));
        (most - middle).fma(primary, (middle - least).fma(secondary, least * V::load(white)))
    }
}
