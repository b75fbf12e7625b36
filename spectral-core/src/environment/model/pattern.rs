//! The formulas.

use crate::Error;
use std::f64::consts::TAU;

/// How bright it is in each direction above the horizon, θ degrees from the zenith.
#[derive(Debug, Clone, PartialEq)]
pub enum Pattern {
    /// 1: light from everywhere above (Strickland, GemRay: ISO).
    Iso,
    /// cos θ: bright at the zenith, dark at the horizon (GemRay: COS).
    Cos,
    /// 2 sin θ cos θ: brightest at 45°, dark at the zenith and at the horizon (GemRay: SC2).
    Sc2,
    /// Values from 0 to 1 in patches: one at each point of a 17 × 17 grid over the square about the unit disc on
    /// which directions fall by their components level with the horizon, joined bilinearly (after GemRay's RANDOM).
    RandomPatch {
        /// Chooses the values.
        seed: u64,
    },
    /// The angular spectrum of AGS Laboratories: blue within 15° of the zenith, red up to 45°, green down to the
    /// horizon.
    Aset,
    /// The Ideal-Scope: black within 15° of the zenith, red down to the horizon, white below it.
    IdealScope,
    /// 1 up to an angle from the zenith, 0 beyond.
    Dome {
        /// Degrees.
        half_angle: f64,
    },
    /// Round lights of radiance 1, evenly spread over the hemisphere on a spiral of golden angles.
    Spots {
        /// How many.
        count: u32,
        /// From the middle of a light to its edge, degrees.
        radius: f64,
    },
}

/// Edges of ASET's zones, degrees from the zenith: elevations of 75° and 45°.
const ASET: [f64; 2] = [15.0, 45.0];
/// What the Ideal-Scope's eyepiece and the eye hide, degrees from the zenith.
const EYEPIECE: f64 = 15.0;
/// Values along an edge of the random patches' grid.
const PATCHES: usize = 17;

impl Pattern {
    /// The names of all patterns.
    pub const NAMES: [&'static str; 8] =
        ["iso", "cos", "sc2", "random-patch", "aset", "ideal-scope", "dome", "spots"];

    /// The pattern of a name, with the default of each of its figures.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing [`NAMES`](Self::NAMES).
    pub fn by_name(name: &str) -> Result<Self, Error> {
        Ok(match name {
            "iso" => Pattern::Iso,
            "cos" => Pattern::Cos,
            "sc2" => Pattern::Sc2,
            "random-patch" => Pattern::RandomPatch { seed: 1 },
            "aset" => Pattern::Aset,
            "ideal-scope" => Pattern::IdealScope,
            "dome" => Pattern::Dome { half_angle: 60.0 },
            "spots" => Pattern::Spots { count: 20, radius: 2.5 },
            _ => return Err(Error::unknown("light model", name, Self::NAMES)),
        })
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Pattern::Iso => "iso",
            Pattern::Cos => "cos",
            Pattern::Sc2 => "sc2",
            Pattern::RandomPatch { .. } => "random-patch",
            Pattern::Aset => "aset",
            Pattern::IdealScope => "ideal-scope",
            Pattern::Dome { .. } => "dome",
            Pattern::Spots { .. } => "spots",
        }
    }

    /// Linear sRGB below the horizon: black but for instruments that light the stone from behind.
    pub(super) fn below(&self) -> [f64; 3] {
        if *self == Pattern::IdealScope { [1.0; 3] } else { [0.0; 3] }
    }

    /// The middles of its spots, from the zenith down, for [`rgb`](Self::rgb); none for other patterns.
    pub(super) fn spots(&self) -> Vec<[f64; 3]> {
        let &Pattern::Spots { count, .. } = self else { return Vec::new() };
        (0..count).map(|k| spot(k, count)).collect()
    }

    /// Linear sRGB in the direction with these components level with the horizon and this height above it.
    pub(super) fn rgb(&self, across: [f64; 2], up: f64, spots: &[[f64; 3]]) -> [f64; 3] {
        let within = |degrees: f64| up > degrees.to_radians().cos();
        let grey = match *self {
            Pattern::Iso => 1.0,
            Pattern::Cos => up,
            Pattern::Sc2 => 2.0 * up * (1.0 - up * up).sqrt(),
            Pattern::RandomPatch { seed } => patch(seed, across),
            Pattern::Aset => {
                return match ASET.map(within) {
                    [true, _] => [0.0, 0.0, 1.0],
                    [_, true] => [1.0, 0.0, 0.0],
                    _ => [0.0, 1.0, 0.0],
                };
            }
            Pattern::IdealScope if within(EYEPIECE) => 0.0,
            Pattern::IdealScope => return [1.0, 0.0, 0.0],
            Pattern::Dome { half_angle } => f64::from(u8::from(within(half_angle))),
            Pattern::Spots { radius, .. } => {
                f64::from(u8::from(is_lit([across[0], across[1], up], spots, radius.to_radians())))
            }
        };
        [grey; 3]
    }

    /// Whether it depends on the angle from the zenith alone.
    pub(super) fn is_zonal(&self) -> bool {
        !matches!(self, Pattern::RandomPatch { .. } | Pattern::Spots { .. })
    }

    /// Angles from the zenith, degrees, at which a zonal pattern jumps, apart from the horizon.
    pub(super) fn edges(&self) -> Vec<f64> {
        match *self {
            Pattern::Aset => ASET.to_vec(),
            Pattern::IdealScope => vec![EYEPIECE],
            Pattern::Dome { half_angle } => vec![half_angle],
            _ => Vec::new(),
        }
    }

    pub(super) fn validate(&self) -> Result<(), Error> {
        match *self {
            Pattern::Dome { half_angle } if !(half_angle > 0.0 && half_angle <= 90.0) => {
                let expected = "an angle from the zenith in degrees, above 0 and at most 90";
                Err(Error::value("environment.half_angle", half_angle, expected))
            }
            Pattern::Spots { count, .. } if !(1..=1000).contains(&count) => {
                Err(Error::value("environment.count", count, "a number of spots from 1 to 1000"))
            }
            // A smaller one could slip between the texels that are looked at first.
            Pattern::Spots { radius, .. } if !(0.5..=45.0).contains(&radius) => {
                Err(Error::value("environment.radius", radius, "a half-angle in degrees, from 0.5 to 45"))
            }
            _ => Ok(()),
        }
    }
}

/// The middle of spot `k`: heights in equal steps, so that every spot has the same share of the hemisphere, azimuths
/// by the golden angle (Vogel 1979, there for the disc).
fn spot(k: u32, count: u32) -> [f64; 3] {
    const GOLDEN_TURN: f64 = 0.381_966_011_250_105_1;
    let z = 1.0 - (f64::from(k) + 0.5) / f64::from(count);
    let (y, x) = (f64::from(k) * GOLDEN_TURN * TAU).sin_cos();
    let flat = (1.0 - z * z).sqrt();
    [flat * x, flat * y, z]
}

/// Whether a direction lies within `radius` of a spot, looking only at those of nearly its height: spot k of n is
/// 1 − (k + ½)/n high.
fn is_lit(direction: [f64; 3], spots: &[[f64; 3]], radius: f64) -> bool {
    let angle = direction[2].clamp(-1.0, 1.0).acos();
    let index = |angle: f64| (spots.len() as f64 * (1.0 - angle.cos()) - 0.5).max(0.0);
    let first = index((angle - radius).max(0.0)) as usize;
    let end = (index(angle + radius) as usize + 2).min(spots.len());
    let edge = radius.cos();
    let dot = |spot: &[f64; 3]| (0..3).map(|c| spot[c] * direction[c]).sum::<f64>();
    spots[first.min(end)..end].iter().any(|spot| dot(spot) > edge)
}

fn patch(seed: u64, across: [f64; 2]) -> f64 {
    let place = across.map(|c| (c.clamp(-1.0, 1.0) + 1.0) / 2.0 * (PATCHES - 1) as f64);
    let [i, j] = place.map(|p| (p as usize).min(PATCHES - 2));
    let [s, t] = [place[0] - i as f64, place[1] - j as f64];
    let value = |i: usize, j: usize| uniform(seed, (j * PATCHES + i) as u64);
    let near = value(i, j) * (1.0 - s) + value(i + 1, j) * s;
    let far = value(i, j + 1) * (1.0 - s) + value(i + 1, j + 1) * s;
    near * (1.0 - t) + far * t
}

/// Number `index` of the sequence of SplitMix64 (Steele, Lea & Flood 2014) that starts at `seed`, in [0, 1).
fn uniform(seed: u64, index: u64) -> f64 {
    let mut z = seed.wrapping_add((index + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_patterns_are_one_to_one() {
        for name in Pattern::NAMES {
            let pattern = Pattern::by_name(name).unwrap();
            assert_eq!(pattern.name(), name);
            pattern.validate().unwrap();
        }
    }

    #[test]
    fn random_numbers_are_those_of_splitmix64() {
        // The reference implementation's first output for seed 1234567 is 6457827717110365317.
        let first = 6_457_827_717_110_365_317_u64 >> 11;
        assert_eq!(uniform(1_234_567, 0), first as f64 / (1_u64 << 53) as f64);
    }

    #[test]
    fn spots_are_found_by_their_height() {
        for (count, radius) in [(1, 45.0), (20, 2.5), (333, 1.0), (1000, 6.0)] {
            let spots = Pattern::Spots { count, radius }.spots();
            let edge = radius.to_radians().cos();
            let mut lit = 0;
            for k in 0..5000 {
                let direction = spot(k, 5000);
                let dot = |s: &[f64; 3]| (0..3).map(|c| s[c] * direction[c]).sum::<f64>();
                let found = is_lit(direction, &spots, radius.to_radians());
                assert_eq!(found, spots.iter().any(|s| dot(s) > edge), "{count} of {radius}°: {direction:?}");
                lit += u32::from(found);
            }
            assert!(lit > 0);
        }
    }

    #[test]
    fn spots_lie_above_the_horizon_with_a_mean_height_of_one_half() {
        for count in [1, 2, 20, 333] {
            let mean: f64 = (0..count).map(|k| spot(k, count)[2]).sum::<f64>() / f64::from(count);
            assert!((mean - 0.5).abs() < 1e-12);
            assert!(
                (0..count)
                    .map(|k| spot(k, count))
                    .all(|[x, y, z]| { z > 0.0 && (x * x + y * y + z * z - 1.0).abs() < 1e-12 })
            );
        }
    }
}
