//! The figures of some rays.

use super::raster::{Mask, Raster};
use spectral_core::environment::Pattern;

/// Means over some rays, as shares of what they would bring from light of radiance 1 all around.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Figures {
    /// Rays that were averaged over.
    pub rays: usize,
    /// Light return under each of the models asked for: the mean radiance, relative to the model's brightest.
    pub light_return: Vec<f64>,
    /// Windowing: what comes from below the horizon, and so is seen through the stone.
    pub leakage: f64,
    /// What comes from the viewer's head.
    pub extinction: f64,
    /// What comes from ASET's zones: within 15° of the zenith (blue), up to 45° (red), down to the
    /// horizon (green); the last is what the others and [`leakage`](Self::leakage) leave.
    pub aset: [f64; 3],
    /// RMS contrast (Peli 1990): the standard deviation of radiance under ISO and the head.
    pub contrast: f64,
    /// What is missing from the sum of all directions: absorbed, or dropped at the depth limit or the threshold.
    pub missing: f64,
    /// The experimental figures, where they were asked for.
    pub experimental: Option<Experimental>,
}

/// Figures without a standard, whose value depends on the lights as much as on the stone: for comparing stones under
/// the same conditions, and nothing else. Both are taken under the light model `spots`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experimental {
    /// Colour that dispersion makes: Σ ‖(X − Y·X̄/Ȳ, Z − Y·Z̄/Ȳ)‖ / Σ Y over the rays, with the means X̄, Ȳ, Z̄ over all
    /// of them; 0 where all have one colour.
    pub fire: f64,
    /// Change with a tilt of [`STEP`](Self::STEP): Σ |Y′ − Y| / Σ (Y′ + Y) over rays that meet the stone in both
    /// positions; from 0 to 1.
    pub scintillation: f64,
}

impl Figures {
    /// Every figure with its name, light return under the names of its models first: the columns of tables.
    pub fn named(&self, models: &[Pattern]) -> Vec<(&'static str, f64)> {
        let mut all: Vec<_> =
            models.iter().map(Pattern::name).zip(self.light_return.iter().copied()).collect();
        let [blue, red, green] = self.aset;
        all.extend([
            ("leakage", self.leakage),
            ("extinction", self.extinction),
            ("contrast", self.contrast),
            ("aset_blue", blue),
            ("aset_red", red),
            ("aset_green", green),
            ("missing", self.missing),
        ]);
        if let Some(Experimental { fire, scintillation }) = self.experimental {
            all.extend([("experimental_fire", fire), ("experimental_scintillation", scintillation)]);
        }
        all
    }

    pub(super) fn missing(mask: &Mask, all: &Raster) -> Self {
        Figures { rays: mask.of(all).count(), missing: 1.0 - mask.mean(all), ..Figures::default() }
    }
}

impl Experimental {
    /// The tilt between the two positions of scintillation, degrees.
    pub const STEP: f64 = 1.0;

    pub(super) fn of(mask: &Mask, now: &Raster, next: &Raster) -> Self {
        let sum = mask.of(now).fold([0.0; 3], |sum, xyz| std::array::from_fn(|c| sum[c] + xyz[c]));
        let [x_mean, z_mean] = [sum[0] / sum[1], sum[2] / sum[1]];
        let coloured = mask.of(now).map(|[x, y, z]| (x - y * x_mean).hypot(z - y * z_mean)).sum::<f64>();
        let (mut change, mut both) = (0.0, 0.0);
        for [[_, a, _], [_, b, _]] in mask.of_both([now, next]) {
            change += (b - a).abs();
            both += a + b;
        }
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let fire = if sum[1] > 0.0 { share(coloured, sum[1]) } else { 0.0 };
        Experimental { fire, scintillation: share(change, both) }
    }
}
