//! What a render is asked to do: samples, wavelengths, depth and thresholds.

use crate::{Error, film::BLOCK, lattice, wavelength::WavelengthGrid};

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

impl Leftover {
    /// Both of them.
    pub const ALL: [Leftover; 2] = [Leftover::Exit, Leftover::Drop];

    /// The name in scene files, on a command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Leftover::Exit => "exit",
            Leftover::Drop => "drop",
        }
    }

    /// The rule of that name.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the nearest name.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        by_name("leftover", name, Self::ALL, Self::name)
    }
}

/// The one of `all` that has that name.
fn by_name<T: Copy, const N: usize>(
    what: &'static str,
    name: &str,
    all: [T; N],
    name_of: fn(T) -> &'static str,
) -> Result<T, Error> {
    let found = all.into_iter().find(|one| name_of(*one) == name);
    found.ok_or_else(|| Error::unknown(what, name, all.map(name_of)))
}

/// What a pixel's samples are.
///
/// Areas are for one convex stone, seen from outside as a whole. Their error falls with the square of the number of
/// samples, that of points with its ⅔ power.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coverage {
    /// Areas where scene and device can, else points.
    #[default]
    Auto,
    /// Rays through points of the pixel, each with wavelengths of its own.
    Points,
    /// The pixel's whole area, each time at other wavelengths ([`beam`](crate::beam)). Where a scene cannot, points with a
    /// warning.
    Area,
}

impl Coverage {
    /// All of them.
    pub const ALL: [Coverage; 3] = [Coverage::Auto, Coverage::Points, Coverage::Area];

    /// The name in scene files, on a command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Coverage::Auto => "auto",
            Coverage::Points => "points",
            Coverage::Area => "area",
        }
    }

    /// The coverage of that name.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the nearest name.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        by_name("coverage", name, Self::ALL, Self::name)
    }
}

/// How many samples a pixel gets where each is its whole area: they differ in their wavelengths alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// The most places of the wavelengths in their cells.
    pub offsets: u32,
    /// As [`RenderSettings::tolerance`], for blocks of 2 × 2 pixels.
    pub tolerance: f64,
    /// As [`RenderSettings::split`], but here the weight is throughput × share of the pixel.
    pub split: f64,
}

/// How much work a picture takes: settings chosen together, for [`RenderSettings::at`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quality {
    /// To see quickly whether the scene is as intended.
    Draft,
    /// To look at.
    #[default]
    Normal,
    /// To print, or to measure.
    Final,
}

impl Quality {
    /// All of them, the quickest first.
    pub const ALL: [Quality; 3] = [Quality::Draft, Quality::Normal, Quality::Final];

    /// The name in scene files and on a command line.
    pub fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Normal => "normal",
            Quality::Final => "final",
        }
    }

    /// The quality of that name.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the nearest name.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        by_name("quality", name, Self::ALL, Self::name)
    }
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
    /// What samples are. In a prepared scene it is what they are there, and `samples`, `tolerance` and `split` are those of `area`
    /// where it is areas.
    pub coverage: Coverage,
    /// What takes the place of `samples`, `tolerance` and `split` where samples are areas.
    pub area: Area,
    /// Samples a pixel; where there is a `tolerance`, the most. They lie in the pixel as [`offset`](Self::offset) says.
    pub samples: u32,
    /// Adaptive sampling: a part of the picture takes no more samples once three times as many have changed it by no
    /// more than this, ΔE00 (see [`Film::settle`](crate::film::Film::settle)). 0: every pixel takes all of them.
    pub tolerance: f64,
    /// The wavelengths traced for each sample.
    pub wavelengths: WavelengthGrid,
    /// Shift the wavelengths within their cells from sample to sample, as [`grid`](Self::grid) says.
    pub jitter: bool,
    /// Surface events on a path, the entry being the first.
    pub max_depth: u32,
    /// What becomes of the energy at `max_depth`.
    pub leftover: Leftover,
    /// A ray inside a stone whose throughput falls below this is spent. 0 traces every ray to `max_depth`.
    pub threshold: f64,
    /// In a crystal, where an event sends on two modes on one side: if one has less weight than this, one of them is followed
    /// with the weight of both, by [`choice`](crate::lattice::choice) in proportion to their weights. Energy stays exact. 0
    /// follows every mode down to `threshold`.
    pub split: f64,
    /// Carry a Stokes vector (true), or average s and p at every event (false, the classical algorithm).
    pub polarized: bool,
    /// Keep the radiance of every wavelength in the film.
    pub spectral: bool,
}

impl RenderSettings {
    /// The most samples a pixel that are accepted.
    pub const MAX_SAMPLES: u32 = 65_536;
    /// The most samples of a lattice whose wavelengths repeat as they come. With as many, three share a place of the wavelengths,
    /// and the error is 3 % larger than if none did.
    const MOST_AS_THEY_COME: u32 = 3 * lattice::PLACES;
    /// The largest depth limit accepted: bounds the explicit stack of a path.
    pub const MAX_DEPTH: u32 = 4_096;

    /// These settings with the samples, the number of wavelengths, the depth and the thresholds of a quality. Unchanged
    /// are the range of wavelengths, the rule for leftovers and polarisation, and the whole grid if it is a list or the
    /// film is spectral.
    ///
    /// ```
    /// use spectral_core::settings::{Quality, RenderSettings};
    /// let draft = RenderSettings::default().at(Quality::Draft);
    /// assert!(draft.samples < RenderSettings::default().samples);
    /// ```
    #[must_use]
    pub fn at(&self, quality: Quality) -> Self {
        // A draft has one sample and so one grid: with sixteen wavelengths dispersion does not show as bands. The grids
        // of many samples differ, and eight wavelengths carry every colour exactly; more would cost samples. Normal is
        // the least work that brings 95 % of a diamond's pixels under lamps within ΔE00 1 of the converged picture.
        let (samples, count, tolerance, max_depth, threshold, split) = match quality {
            Quality::Draft => (1, 16, 0.0, 24, 1e-2, 0.25),
            Quality::Normal => (729, 8, 0.6, 64, 1e-4, 0.1),
            Quality::Final => (2187, 8, 0.3, 256, 1e-5, 0.1),
        };
        // With areas the error falls as the number's inverse square, and so is an eighth of what three times as many change.
        let (coverage, offsets, change) = match quality {
            Quality::Draft => (Coverage::Points, 3, 0.0),
            Quality::Normal => (Coverage::Auto, 27, 4.5),
            Quality::Final => (Coverage::Auto, 81, 1.0),
        };
        // Of areas few samples choose, but many beams. To follow more of them costs little: most of the work is for heavy ones.
        let area = Area { offsets, tolerance: change, split: 20.0 * threshold };
        let kept = self.spectral || !self.wavelengths.can_jitter();
        let wavelengths = if kept { self.wavelengths.clone() } else { self.wavelengths.with_count(count) };
        let chosen = RenderSettings { samples, tolerance, coverage, area, ..self.clone() };
        RenderSettings { max_depth, threshold, split, wavelengths, ..chosen }
    }

    /// These settings with exactly `samples` for every pixel, so without a tolerance. They are points unless areas are asked for
    /// by name.
    #[must_use]
    pub fn with_samples(&self, samples: u32) -> Self {
        let coverage = if self.coverage == Coverage::Area { Coverage::Area } else { Coverage::Points };
        let area = Area { offsets: samples, tolerance: 0.0, ..self.area };
        RenderSettings { samples, tolerance: 0.0, coverage, area, ..self.clone() }
    }

    /// These settings with a tolerance, for points and areas alike.
    #[must_use]
    pub fn with_tolerance(&self, tolerance: f64) -> Self {
        RenderSettings { tolerance, area: Area { tolerance, ..self.area }, ..self.clone() }
    }

    /// These settings with a weight of modes, for points and areas alike.
    #[must_use]
    pub fn with_split(&self, split: f64) -> Self {
        RenderSettings { split, area: Area { split, ..self.area }, ..self.clone() }
    }

    /// These settings for a scene whose samples are areas: `samples`, `tolerance` and `split` are those of `area`. If wavelengths
    /// do not move, one sample is all.
    pub(crate) fn of_area(&self) -> Self {
        let Area { offsets, tolerance, split } = self.area;
        let moves = self.jitter && self.wavelengths.can_jitter();
        let (samples, tolerance) = if moves { (offsets, tolerance) } else { (1, 0.0) };
        RenderSettings { coverage: Coverage::Area, samples, tolerance, split, ..self.clone() }
    }

    /// Edge of the blocks of pixels that are [settled](crate::film::Film::settle) together. All points of one pixel may miss a
    /// small lamp, but those of sixteen pixels rarely do. An area misses nothing, but three positions of its wavelengths may happen
    /// to be as the first alone, which those of four pixels rarely are.
    pub fn block(&self) -> u32 {
        if self.coverage == Coverage::Area { 2 } else { BLOCK }
    }

    /// Where sample `index` lies in its pixel, as [`pixel_offset`] has it; where there is a tolerance, as
    /// [`lattice::point`], since then pixels stop at different numbers of samples, or of many as [`lattice::sharing`]. Of areas
    /// it is the middle.
    pub fn offset(&self, index: u32) -> [f64; 2] {
        if self.coverage == Coverage::Area {
            [0.5; 2]
        } else if self.tolerance > 0.0 && self.samples > Self::MOST_AS_THEY_COME {
            lattice::sharing(index)
        } else if self.tolerance > 0.0 {
            let [x, y, _] = lattice::point(index);
            [x, y]
        } else {
            pixel_offset(index, self.samples)
        }
    }

    /// The wavelengths of sample `index`. With `jitter` they move within their cells, by [`WavelengthGrid::jittered`], or
    /// where there is a tolerance by the third coordinate of [`lattice::point`]. Those of areas are at [`lattice::place`].
    pub fn grid(&self, index: u32) -> WavelengthGrid {
        if !self.jitter {
            self.wavelengths.clone()
        } else if self.coverage == Coverage::Area {
            self.wavelengths.shifted(lattice::place(index))
        } else if self.tolerance > 0.0 {
            let [.., offset] = lattice::point(index);
            self.wavelengths.shifted(offset)
        } else {
            self.wavelengths.jittered(index)
        }
    }

    /// Refuses impossible settings and says what would be valid.
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
        within("samples", self.area.offsets, Self::MAX_SAMPLES)?;
        within("max_depth", self.max_depth, Self::MAX_DEPTH)?;
        for tolerance in [self.tolerance, self.area.tolerance] {
            if !(0.0..=100.0).contains(&tolerance) {
                let expected = "a colour difference from 0 (every pixel takes all samples) to 100";
                return Err(Error::value("tolerance", tolerance, expected));
            }
        }
        let throughputs = [("threshold", self.threshold), ("split", self.split), ("split", self.area.split)];
        for (what, value) in throughputs {
            if !(0.0..1.0).contains(&value) {
                return Err(Error::value(what, value, "a throughput from 0 up to, not including, 1"));
            }
        }
        Ok(())
    }
}

impl Default for RenderSettings {
    /// [`Quality::default`], polarised, with jittered wavelengths from 380 to 740 nm.
    fn default() -> Self {
        let any = RenderSettings {
            coverage: Coverage::Auto,
            area: Area { offsets: 1, tolerance: 0.0, split: 0.0 },
            samples: 1,
            tolerance: 0.0,
            wavelengths: WavelengthGrid::default(),
            jitter: true,
            max_depth: 1,
            leftover: Leftover::default(),
            threshold: 0.0,
            split: 0.0,
            polarized: true,
            spectral: false,
        };
        any.at(Quality::default())
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
    fn with_a_tolerance_samples_are_points_of_the_lattice() {
        let plain = RenderSettings::default().with_samples(16);
        let nested = RenderSettings { tolerance: 1.0, ..plain.clone() };
        for index in 0..30 {
            let [x, y, offset] = lattice::point(index);
            assert_eq!(
                (nested.offset(index), nested.grid(index)),
                ([x, y], plain.wavelengths.shifted(offset))
            );
            assert_eq!(plain.offset(index), pixel_offset(index, plain.samples));
            assert_eq!(plain.grid(index), plain.wavelengths.jittered(index));
            let still = RenderSettings { jitter: false, ..nested.clone() };
            assert_eq!((still.offset(index), still.grid(index)), ([x, y], plain.wavelengths.clone()));
        }
    }

    #[test]
    fn counted_samples_are_points_unless_areas_are_asked_for() {
        let of = |coverage| RenderSettings { coverage, ..RenderSettings::default() }.with_samples(5);
        let coverage = Coverage::ALL.map(|coverage| of(coverage).coverage);
        assert_eq!(coverage, [Coverage::Points, Coverage::Points, Coverage::Area]);
        let area = of(Coverage::Area).of_area();
        assert_eq!((area.samples, area.tolerance, area.block()), (5, 0.0, 2));
        assert_eq!(RenderSettings::default().at(Quality::Draft).coverage, Coverage::Points);
    }

    #[test]
    fn samples_of_an_area_differ_in_their_wavelengths_alone() {
        let area = RenderSettings::default().of_area();
        assert_eq!((area.samples, area.tolerance), (area.area.offsets, area.area.tolerance));
        let mut first: Vec<f64> = (0..9).map(|index| area.grid(index).nm()[0]).collect();
        first.sort_by(f64::total_cmp);
        let cell = area.wavelengths.widths()[0];
        for (k, nm) in first.iter().enumerate() {
            assert!((nm - 380.0 - cell * (k as f64 + 0.5) / 9.0).abs() < 1e-9, "{first:?}");
            assert_eq!(area.offset(k as u32), [0.5; 2]);
        }
        // Without such a difference one of them is all.
        let still = RenderSettings { jitter: false, ..RenderSettings::default() }.of_area();
        assert_eq!((still.samples, still.tolerance), (1, 0.0));
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
        refuse(RenderSettings { tolerance: -1.0, ..ok() }, "tolerance: -1");
        refuse(RenderSettings { threshold: f64::NAN, ..ok() }, "threshold: NaN");
        refuse(RenderSettings { split: 1.0, ..ok() }, "split: 1");
    }
}
