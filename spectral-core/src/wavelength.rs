//! The wavelengths of a picture.
//!
//! A [`WavelengthGrid`] divides a range into cells, each represented by one wavelength: an integral over the range becomes
//! Σ L(λᵢ)·Δᵢ. With the wavelength in the middle of the cell this is the midpoint rule. For the smooth, compact
//! colour-matching functions it is more accurate than Gauss rules of the same size.
//!
//! The midpoint rule misses lines narrower than a cell. So a grid can be **jittered**: for pixel sample s every wavelength
//! moves within its cell to the fraction uₛ = frac(½ + s·φ⁻¹), the Kronecker sequence of the golden ratio, whose first n
//! members are evenly distributed in [0, 1) for every n. All cells have the same offset, so the spacing stays even. Sample
//! 0 has the midpoint grid.
//!
//! ```
//! use spectral_core::wavelength::WavelengthGrid;
//! let grid = WavelengthGrid::midpoints([380.0, 740.0], 4)?;
//! assert_eq!(grid.nm(), [425.0, 515.0, 605.0, 695.0]);
//! assert_eq!(grid.widths(), [90.0; 4]);
//! # Ok::<(), spectral_core::Error>(())
//! ```

use crate::Error;

/// The shortest and longest wavelength a grid may hold, in nm.
pub const LIMITS: [f64; 2] = [200.0, 2000.0];

/// The most wavelengths a grid may hold.
pub const MAX_COUNT: usize = 1024;

/// The inverse golden ratio, the step of the jitter's Kronecker sequence.
const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// Wavelengths in nm, strictly ascending, each with the width of its cell.
#[derive(Debug, Clone, PartialEq)]
pub struct WavelengthGrid {
    nm: Vec<f64>,
    widths: Vec<f64>,
    range: [f64; 2],
    layout: Layout,
}

/// Whether the wavelengths may move within their cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    Cells,
    List,
}

impl WavelengthGrid {
    /// `count` equal cells over `range` (nm), each with its wavelength in the middle.
    ///
    /// # Errors
    /// [`Error::Value`] if the count is not within 1 to [`MAX_COUNT`], or the range is empty, reversed or
    /// outside [`LIMITS`].
    pub fn midpoints(range: [f64; 2], count: usize) -> Result<Self, Error> {
        check_count(count)?;
        for end in range {
            check_wavelength("wavelength range", end)?;
        }
        let [min, max] = range;
        if min >= max {
            let found = format!("[{min}, {max}]");
            return Err(Error::value("wavelength range", found, "the first end must be below the second"));
        }
        Ok(Self::cells(range, count, 0.5))
    }

    /// The given wavelengths (nm, strictly ascending).
    ///
    /// Each cell extends half-way to its neighbours; the first and last cell are symmetric. A single wavelength has a cell
    /// of 1 nm. A list is not jittered.
    ///
    /// # Errors
    /// [`Error::Value`] naming the wavelength that is outside [`LIMITS`], not finite or out of order, or the
    /// count if it is not within 1 to [`MAX_COUNT`].
    pub fn list(nm: Vec<f64>) -> Result<Self, Error> {
        check_count(nm.len())?;
        for (i, &wavelength) in nm.iter().enumerate() {
            check_wavelength(&format!("wavelengths[{i}]"), wavelength)?;
        }
        for (i, pair) in nm.windows(2).enumerate() {
            if let [a, b] = pair
                && a >= b
            {
                let what = format!("wavelengths[{}]", i + 1);
                return Err(Error::value(what, b, format!("a list must ascend, but it follows {a}")));
            }
        }
        let gaps: Vec<f64> = nm.iter().zip(nm.iter().skip(1)).map(|(a, b)| b - a).collect();
        let first = gaps.first().copied().unwrap_or(1.0);
        let last = gaps.last().copied().unwrap_or(1.0);
        let before = std::iter::once(first).chain(gaps.iter().copied());
        let after = gaps.iter().copied().chain(std::iter::once(last));
        let widths: Vec<f64> = before.zip(after).map(|(b, a)| 0.5 * (b + a)).collect();
        let end = |x: Option<&f64>| x.copied().unwrap_or_default();
        let range = [end(nm.first()) - 0.5 * first, end(nm.last()) + 0.5 * last];
        Ok(WavelengthGrid { nm, widths, range, layout: Layout::List })
    }

    /// The wavelengths from `first` to `last` (nm), **both included**, `step` nm apart: the grid of published tables. All
    /// cells are `step` wide, so they extend half a step beyond both ends. It is not jittered.
    ///
    /// ```
    /// let grid = spectral_core::wavelength::WavelengthGrid::stepped(380.0, 780.0, 5.0)?;
    /// assert_eq!((grid.len(), grid.nm()[80], grid.widths()[80]), (81, 780.0, 5.0));
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Value`] if `step` does not divide the distance, and as [`list`](Self::list).
    pub fn stepped(first: f64, last: f64, step: f64) -> Result<Self, Error> {
        check_wavelength("first wavelength", first)?;
        check_wavelength("last wavelength", last)?;
        let steps = ((last - first) / step).round();
        if !(step > 0.0 && steps >= 0.0 && (first + steps * step - last).abs() <= 1e-6) {
            let expected =
                format!("the step must be positive and divide the range from {first} to {last} nm");
            return Err(Error::value("wavelength step", step, expected));
        }
        // `as` saturates, and check_count refuses large numbers before anything is allocated.
        let count = (steps as usize).saturating_add(1);
        check_count(count)?;
        let mut grid = Self::list((0..count).map(|i| (first + step * i as f64).min(LIMITS[1])).collect())?;
        grid.widths.fill(step);
        grid.range = [first - 0.5 * step, last + 0.5 * step];
        Ok(grid)
    }

    /// The grid for pixel sample `sample`: λᵢ = min + (i + u)·Δ with u = frac(½ + sample·φ⁻¹).
    ///
    /// Cells, widths and range do not change. Sample 0 has the midpoint grid. A list does not change.
    #[must_use]
    pub fn jittered(&self, sample: u32) -> Self {
        self.shifted(0.5 + f64::from(sample) * INVERSE_GOLDEN_RATIO)
    }

    /// The grid with its wavelengths at the fraction `offset` (modulo 1) of their cells: λᵢ = min + (i + offset)·Δ.
    ///
    /// Cells, widths and range do not change. At 0.5 it is the midpoint grid. A list does not change.
    #[must_use]
    pub fn shifted(&self, offset: f64) -> Self {
        match self.layout {
            Layout::List => self.clone(),
            Layout::Cells => Self::cells(self.range, self.nm.len(), offset.rem_euclid(1.0)),
        }
    }

    /// The same range in `count` cells, at most [`MAX_COUNT`]; a list does not change.
    #[must_use]
    pub fn with_count(&self, count: usize) -> Self {
        match self.layout {
            Layout::List => self.clone(),
            Layout::Cells => Self::cells(self.range, count.clamp(1, MAX_COUNT), 0.5),
        }
    }

    /// Whether [`jittered`](Self::jittered) and [`shifted`](Self::shifted) move the wavelengths: true for [`midpoints`](Self::midpoints).
    pub fn can_jitter(&self) -> bool {
        self.layout == Layout::Cells
    }

    /// The wavelengths in nm, strictly ascending; at least one.
    pub fn nm(&self) -> &[f64] {
        &self.nm
    }

    /// The width of each wavelength's cell in nm.
    pub fn widths(&self) -> &[f64] {
        &self.widths
    }

    /// The lower edge of the first cell and the upper edge of the last, in nm.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// The number of wavelengths.
    #[expect(clippy::len_without_is_empty, reason = "a grid holds at least one wavelength")]
    pub fn len(&self) -> usize {
        self.nm.len()
    }

    fn cells(range: [f64; 2], count: usize, offset: f64) -> Self {
        let [min, max] = range;
        let width = (max - min) / count as f64;
        let nm = (0..count).map(|i| min + (i as f64 + offset) * width).collect();
        WavelengthGrid { nm, widths: vec![width; count], range, layout: Layout::Cells }
    }
}

/// 32 cells over 380–740 nm. With the absorptions of gems its colours are within ΔE00 0.11 of those of a 1 nm grid.
impl Default for WavelengthGrid {
    fn default() -> Self {
        Self::cells([380.0, 740.0], 32, 0.5)
    }
}

/// Refuses a number of wavelengths that is zero or too large.
fn check_count(count: usize) -> Result<(), Error> {
    if (1..=MAX_COUNT).contains(&count) {
        return Ok(());
    }
    Err(Error::value("wavelength count", count, format!("give 1 to {MAX_COUNT} wavelengths")))
}

/// Refuses a wavelength outside [`LIMITS`], and names a likely confusion of units.
fn check_wavelength(what: &str, nm: f64) -> Result<(), Error> {
    let [min, max] = LIMITS;
    if nm >= min && nm <= max {
        return Ok(());
    }
    let hint = match nm {
        x if (0.2..=2.0).contains(&x) => format!("; {nm} looks like micrometres"),
        x if (2e-7..=2e-6).contains(&x) => format!("; {nm} looks like metres"),
        x if x > max && x <= 20_000.0 => format!("; {nm} looks like \u{e5}ngstr\u{f6}ms"),
        _ => String::new(),
    };
    Err(Error::value(what, nm, format!("give {min} to {max} (nanometres{hint})")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn midpoint_cells_tile_the_range() {
        let grid = WavelengthGrid::midpoints([380.0, 740.0], 32).unwrap();
        assert_eq!((grid.len(), grid.range()), (32, [380.0, 740.0]));
        assert!((grid.nm()[0] - 385.625).abs() < 1e-12 && (grid.nm()[31] - 734.375).abs() < 1e-12);
        assert!((grid.widths().iter().sum::<f64>() - 360.0).abs() < 1e-12);
    }

    #[test]
    fn jitter_starts_at_the_middle_and_fills_the_cells_evenly() {
        let grid = WavelengthGrid::midpoints([400.0, 700.0], 3).unwrap();
        assert_eq!(grid.jittered(0), grid);
        assert!((grid.jittered(1).nm()[1] - (500.0 + 11.803_398_874_989_5)).abs() < 1e-9);
        let mut offsets: Vec<f64> = (0..64).map(|s| (grid.jittered(s).nm()[0] - 400.0) / 100.0).collect();
        offsets.sort_by(f64::total_cmp);
        // Three-distance theorem: gaps between golden-ratio points are powers of 1/φ, here φ⁻⁸ the widest.
        let widest = offsets.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        assert!((widest - INVERSE_GOLDEN_RATIO.powi(8)).abs() < 1e-12, "{widest}");
        assert!(offsets[0] >= 0.0 && offsets[63] < 1.0);
        assert_eq!(grid.jittered(7).jittered(0), grid);
        assert_eq!(grid.jittered(7).shifted(0.5), grid);
        assert_eq!(grid.shifted(0.25).nm(), [425.0, 525.0, 625.0]);
    }

    #[test]
    fn cells_of_a_list_meet_half_way_and_its_end_cells_are_symmetric() {
        let grid = WavelengthGrid::list(vec![400.0, 410.0, 440.0]).unwrap();
        assert_eq!((grid.widths(), grid.range()), (&[10.0, 20.0, 30.0][..], [395.0, 455.0]));
        assert_eq!(grid.jittered(5), grid);
        let line = WavelengthGrid::list(vec![589.3]).unwrap();
        assert_eq!((line.widths(), line.len()), (&[1.0][..], 1));
    }

    #[test]
    fn bad_grids_are_refused_with_the_reason() {
        let message = |result: Result<WavelengthGrid, Error>| result.unwrap_err().to_string();
        for (found, expected) in [
            (message(WavelengthGrid::midpoints([380.0, 740.0], 0)), "give 1 to 1024 wavelengths"),
            (message(WavelengthGrid::midpoints([380.0, 740.0], 1025)), "wavelength count: 1025"),
            (message(WavelengthGrid::midpoints([740.0, 380.0], 8)), "[740, 380]"),
            (message(WavelengthGrid::midpoints([0.38, 0.74], 8)), "nanometres; 0.38 looks like micrometres"),
            (message(WavelengthGrid::midpoints([380.0, f64::INFINITY], 8)), "inf is not valid"),
            (message(WavelengthGrid::list(vec![])), "give 1 to 1024 wavelengths"),
            (message(WavelengthGrid::list(vec![400.0, f64::NAN])), "wavelengths[1]: NaN"),
            (message(WavelengthGrid::list(vec![400.0, 400.0])), "wavelengths[1]: 400"),
            (message(WavelengthGrid::list(vec![5893.0])), "looks like \u{e5}ngstr\u{f6}ms"),
            (message(WavelengthGrid::stepped(380.0, 780.0, 7.0)), "wavelength step: 7"),
            (message(WavelengthGrid::stepped(380.0, 780.0, 0.0)), "wavelength step: 0"),
            (message(WavelengthGrid::stepped(380.0, 780.0, 1e-9)), "give 1 to 1024 wavelengths"),
        ] {
            assert!(found.contains(expected), "{found:?} lacks {expected:?}");
        }
    }
}
