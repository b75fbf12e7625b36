//! What a render is asked to do: samples, wavelengths, depth and thresholds.

use crate::{Error, wavelength::WavelengthGrid};

/// What becomes of the energy of a ray that would make one surface event more than
/// [`RenderSettings::max_depth`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Leftover {
    /// It leaves the stone there with all it has: along the refracted direction, or straight on where
    /// reflection is total. Energy is conserved, its last direction is approximate.
    #[default]
    Exit,
    /// It is dropped, and reported as dropped.
    Drop,
}

/// The settings of a render; everything that is not the scene.
///
/// ```
/// use spectral_core::settings::RenderSettings;
/// let settings = RenderSettings { samples: 4, ..RenderSettings::default() };
/// assert!(settings.validate().is_ok());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct RenderSettings {
    /// Samples a pixel, in the pattern of [`pixel_offset`].
    pub samples: u32,
    /// The wavelengths traced for each sample.
    pub wavelengths: WavelengthGrid,
    /// Shift the wavelengths within their cells from sample to sample (see [`WavelengthGrid::jittered`]).
    pub jitter: bool,
    /// Surface events on a path, the entry being the first.
    pub max_depth: u32,
    /// What becomes of the energy at `max_depth`.
    pub leftover: Leftover,
    /// A ray inside a stone whose throughput falls below this is spent. 0 traces every ray to `max_depth`.
    pub threshold: f64,
    /// Carry a Stokes vector (true), or average s and p at every event (false, the classical algorithm).
    pub polarized: bool,
    /// Keep the radiance of every wavelength in the film.
    pub spectral: bool,
}

impl RenderSettings {
    /// The most samples a pixel that are accepted.
    pub const MAX_SAMPLES: u32 = 65_536;
    /// The largest depth limit accepted: bounds the explicit stack of a path.
    pub const MAX_DEPTH: u32 = 4_096;

    /// Refuses settings that cannot be meant, with what would be valid.
    ///
    /// # Errors
    /// [`Error::Value`] for a count of samples or a depth outside its bounds, and for a threshold outside
    /// [0, 1).
    pub fn validate(&self) -> Result<(), Error> {
        let within = |what: &str, value: u32, most: u32| {
            if (1..=most).contains(&value) {
                return Ok(());
            }
            Err(Error::value(what, value, format!("a whole number from 1 to {most}")))
        };
        within("samples", self.samples, Self::MAX_SAMPLES)?;
        within("max_depth", self.max_depth, Self::MAX_DEPTH)?;
        if !(0.0..1.0).contains(&self.threshold) {
            return Err(Error::value(
                "threshold",
                self.threshold,
                "a throughput from 0 up to, not including, 1",
            ));
        }
        Ok(())
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        RenderSettings {
            samples: 16,
            wavelengths: WavelengthGrid::default(),
            jitter: true,
            max_depth: 64,
            leftover: Leftover::Exit,
            threshold: 1e-4,
            polarized: true,
            spectral: false,
        }
    }
}

/// Where sample `index` of `count` lies in its pixel, both coordinates in (0, 1); (0.5, 0.5) is the centre.
///
/// A square number of samples forms the regular k × k grid, row by row (the midpoint rule over a box
/// filter); any other number takes consecutive points of the R2 sequence (Roberts 2018: the two-dimensional
/// golden ratio), placed so that the pattern is symmetric about the centre: its mean is the centre exactly.
///
/// ```
/// use spectral_core::settings::pixel_offset;
/// assert_eq!(pixel_offset(0, 1), [0.5, 0.5]);
/// assert_eq!(pixel_offset(1, 4), [0.75, 0.25]);
/// ```
pub fn pixel_offset(index: u32, count: u32) -> [f64; 2] {
    let side = count.isqrt();
    if side * side == count && count > 0 {
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        return [place(index % side), place(index / side % side)];
    }
    // 1/g and 1/g² for the real root g of g³ = g + 1.
    const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    let from_middle = f64::from(index) - f64::from(count.saturating_sub(1)) / 2.0;
    R2.map(|step| (0.5 + from_middle * step).rem_euclid(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pattern_is_centred_in_the_pixel() {
        for count in [1, 2, 3, 4, 5, 9, 16, 17, 64] {
            let mut mean = [0.0; 2];
            for index in 0..count {
                let offset = pixel_offset(index, count);
                assert!(offset.iter().all(|v| (0.0..1.0).contains(v)));
                mean = [mean[0] + offset[0], mean[1] + offset[1]];
            }
            assert!(mean.iter().all(|v| (v / f64::from(count) - 0.5).abs() < 1e-12), "{count}: {mean:?}");
        }
    }

    #[test]
    fn bad_settings_are_refused_with_their_bounds() {
        let refuse = |settings: RenderSettings, what: &str| {
            let message = settings.validate().expect_err("must be refused").to_string();
            assert!(message.contains(what), "{message}");
        };
        let ok = RenderSettings::default;
        refuse(RenderSettings { samples: 0, ..ok() }, "samples: 0");
        refuse(RenderSettings { max_depth: 5000, ..ok() }, "from 1 to 4096");
        refuse(RenderSettings { threshold: f64::NAN, ..ok() }, "threshold: NaN");
    }
}
