//! How many pixels and samples fit in the time of a frame.

use spectral_core::prepare::PreparedScene;
use std::time::Duration;

/// The time that a frame should take while something moves.
pub const FRAME: Duration = Duration::from_millis(45);
/// The time that a frame of fewer than [`ENOUGH`] pixels may take: more than ten a second.
const SLOW: Duration = Duration::from_millis(75);
/// A frame that takes longer than this is broken off and begun again with fewer pixels.
pub const LIMIT: Duration = Duration::from_millis(150);
/// With so many pixels facets can be told apart.
const ENOUGH: f64 = 256.0 * 256.0;
/// The smallest frame, pixels.
const FEWEST: f64 = 48.0 * 48.0;
/// Parts of an edge in which frames grow, so that few sizes come up.
const STEPS: f64 = 24.0;
/// How much the last frame counts.
const WEIGHT: f64 = 0.5;

/// How many pixel samples a second are traced, by the kind of scene.
#[derive(Debug, Clone)]
pub struct Pace {
    rates: [f64; 4],
    kind: usize,
}

impl Default for Pace {
    /// Cautious: a first picture that is coarse is better than one that is late.
    fn default() -> Self {
        Pace { rates: [6e5, 2e5, 6e4, 2e4], kind: 0 }
    }
}

/// The size and the samples of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    pub size: [u32; 2],
    pub samples: u32,
}

impl Pace {
    /// What the next frames are of: chains in one convex stone, trees, uniaxial and biaxial crystals differ most.
    pub fn expect(&mut self, scene: &PreparedScene) {
        let crystal = scene.geometry.stones.iter().any(|stone| stone.crystal);
        self.kind = match (scene.lone_convex_stone().is_some(), crystal) {
            (true, _) => 0,
            (false, false) => 1,
            (false, true) if is_uniaxial(scene) => 2,
            (false, true) => 3,
        };
    }

    /// A frame for a view of this size that takes `share` of the time of a frame.
    pub fn frame(&self, [width, height]: [u32; 2], share: f64) -> Frame {
        let whole = f64::from(width) * f64::from(height);
        let [quick, slow] = [FRAME, SLOW].map(|time| self.rates[self.kind] * time.as_secs_f64() * share);
        let fit = quick.max(slow.min(ENOUGH)).max(FEWEST);
        if fit >= whole {
            let samples = if fit >= 9.0 * whole {
                9
            } else if fit >= 4.0 * whole {
                4
            } else {
                1
            };
            return Frame { size: [width, height], samples };
        }
        let steps = (fit / whole).sqrt() * STEPS;
        // What is enough is no less for its steps.
        let part = if fit == ENOUGH { steps.ceil() } else { steps.floor().max(1.0) } / STEPS;
        let edge = |edge: u32| ((f64::from(edge) * part).round() as u32).max(1);
        Frame { size: [edge(width), edge(height)], samples: 1 }
    }

    /// So many pixel samples took so long.
    pub fn learn(&mut self, done: u64, took: Duration) {
        if done > 0 && took > Duration::ZERO {
            let rate = &mut self.rates[self.kind];
            *rate += WEIGHT * (done as f64 / took.as_secs_f64() - *rate);
        }
    }
}

fn is_uniaxial(scene: &PreparedScene) -> bool {
    let media = scene.table(0).media.iter().flatten();
    let forms = media.filter_map(|medium| medium.crystal.as_ref()).map(|(crystal, _)| crystal.form());
    forms.into_iter().all(|form| matches!(form, spectral_core::crystal::Form::Uniaxial(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_fit_their_time() {
        let mut pace = Pace::default();
        for _ in 0..20 {
            pace.learn(1_000_000, Duration::from_secs(1));
        }
        assert_eq!(pace.frame([512, 512], 1.0), Frame { size: [256, 256], samples: 1 });
        let [width, height] = pace.frame([1120, 820], 1.0).size;
        assert!((65_536..80_000).contains(&(width * height)), "{width} {height}");
        assert!(pace.frame([512, 512], 0.5).size[0] < 256);
        let small = pace.frame([100, 40], 1.0);
        assert_eq!(small, Frame { size: [100, 40], samples: 9 });
        for _ in 0..20 {
            pace.learn(10, Duration::from_secs(1));
        }
        assert_eq!(pace.frame([480, 480], 1.0).size, [40, 40]);
        for _ in 0..20 {
            pace.learn(4_000_000, Duration::from_secs(1));
        }
        let pixels = pace.frame([512, 512], 1.0).size.map(f64::from).iter().product::<f64>();
        assert!((160_000.0..180_000.0).contains(&pixels), "{pixels}");
    }
}
