//! Spectra as tables: a quantity at ascending wavelengths, linearly interpolated.
//!
//! The CIE recommends linear interpolation for its 1 nm tables. It neither overshoots nor makes a non-negative table
//! negative. Wavelengths are nanometres in vacuum throughout the crate.
//!
//! ```
//! use spectral_core::spectrum::Tabulated;
//! let table = Tabulated::from_csv("# my glass\nnm,1/mm\n400,0.2\n500,0.4\n", "glass.csv")?;
//! assert!((table.at(425.0) - 0.25).abs() < 1e-15);
//! assert_eq!(table.at(900.0), 0.4); // beyond its ends, the value of the nearer end
//! # Ok::<(), spectral_core::Error>(())
//! ```

use crate::wavelength::WavelengthGrid;
use crate::{Error, shown};

/// The wavelengths a table may hold, in nm: wide enough for ultraviolet and infrared data, narrow enough to
/// catch micrometres and ångströms.
const TABLE_RANGE: [f64; 2] = [100.0, 20_000.0];

/// The values of a table outside its wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ends {
    /// The value of the nearer end.
    #[default]
    Extend,
    /// Zero.
    Zero,
}

/// A quantity tabulated at strictly ascending wavelengths in nm, linearly interpolated.
#[derive(Debug, Clone, PartialEq)]
pub struct Tabulated {
    nm: Vec<f64>,
    values: Vec<f64>,
    ends: Ends,
}

impl Tabulated {
    /// A table from its wavelengths (nm, strictly ascending) and as many finite values.
    ///
    /// # Errors
    /// [`Error::Value`] naming the first entry that is not finite, out of order or out of range, or the lengths if they
    /// differ or are zero.
    pub fn new(nm: Vec<f64>, values: Vec<f64>, ends: Ends) -> Result<Self, Error> {
        if nm.len() != values.len() || nm.is_empty() {
            let found = format!("{} wavelengths and {} values", nm.len(), values.len());
            return Err(Error::value("table", found, "give at least one wavelength, and one value for each"));
        }
        for (i, (&wavelength, &value)) in nm.iter().zip(&values).enumerate() {
            let previous = if i > 0 { nm.get(i - 1).copied() } else { None };
            check_entry(previous, wavelength, value).map_err(|message| {
                Error::value(format!("table entry {}", i + 1), format!("({wavelength}, {value})"), message)
            })?;
        }
        Ok(Tabulated { nm, values, ends })
    }

    /// A table from text with two columns, nm and value, separated by commas, semicolons or blanks.
    ///
    /// Empty lines, everything after `#` and one header line are skipped. `what` names the text in messages, such as a file
    /// name. The ends extend; see [`with_ends`](Self::with_ends).
    ///
    /// # Errors
    /// [`Error::Data`] with the line that does not parse, is out of order or is not finite.
    pub fn from_csv(text: &str, what: &str) -> Result<Self, Error> {
        let (mut nm, mut values) = (Vec::new(), Vec::new());
        for (line, [wavelength, value]) in columns::<2>(text, what)? {
            check_entry(nm.last().copied(), wavelength, value).map_err(|message| Error::Data {
                what: what.to_owned(),
                line,
                message,
            })?;
            nm.push(wavelength);
            values.push(value);
        }
        Ok(Tabulated { nm, values, ends: Ends::Extend })
    }

    /// The same table with another rule beyond its ends.
    #[must_use]
    pub fn with_ends(mut self, ends: Ends) -> Self {
        self.ends = ends;
        self
    }

    /// The same table with every value multiplied by `factor`.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.values.iter_mut().for_each(|v| *v *= factor);
        self
    }

    /// The value at a wavelength in nm.
    pub fn at(&self, nm: f64) -> f64 {
        let above = self.nm.partition_point(|&x| x <= nm);
        match (above.checked_sub(1).and_then(|i| self.point(i)), self.point(above)) {
            (Some((x0, y0)), Some((x1, y1))) => y0 + (y1 - y0) * ((nm - x0) / (x1 - x0)),
            (Some((x, y)), None) | (None, Some((x, y))) if self.ends == Ends::Extend || x == nm => y,
            _ => 0.0,
        }
    }

    /// The values at every wavelength of a grid, in its order.
    pub fn sample(&self, grid: &WavelengthGrid) -> Vec<f64> {
        grid.nm().iter().map(|&nm| self.at(nm)).collect()
    }

    /// The tabulated wavelengths in nm, strictly ascending.
    pub fn nm(&self) -> &[f64] {
        &self.nm
    }

    /// The tabulated values, one for each wavelength.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The rule outside its wavelengths.
    pub fn ends(&self) -> Ends {
        self.ends
    }

    fn point(&self, i: usize) -> Option<(f64, f64)> {
        Some((*self.nm.get(i)?, *self.values.get(i)?))
    }
}

/// What is wrong with a table's entry, given the wavelength before it.
fn check_entry(previous: Option<f64>, nm: f64, value: f64) -> Result<(), String> {
    let [min, max] = TABLE_RANGE;
    if !(nm >= min && nm <= max) {
        let hint =
            if nm > 0.1 && nm < 20.0 { format!("; {nm} looks like micrometres") } else { String::new() };
        return Err(format!("the wavelength {nm} must lie within {min} to {max} nanometres{hint}"));
    }
    if !value.is_finite() {
        return Err(format!("the value {value} is not a finite number"));
    }
    match previous {
        Some(p) if p >= nm => Err(format!("wavelengths must ascend, but {nm} follows {p}")),
        _ => Ok(()),
    }
}

/// The rows of a text table of `N` numbers a line, each with its 1-based line number.
///
/// # Errors
/// [`Error::Data`] for a line that does not hold `N` numbers (one header line before the first row is
/// allowed), or when there is no row at all.
pub(crate) fn columns<const N: usize>(text: &str, what: &str) -> Result<Vec<(usize, [f64; N])>, Error> {
    let data = |line, message| Error::Data { what: what.to_owned(), line, message };
    let mut rows: Vec<(usize, [f64; N])> = Vec::new();
    let mut header_allowed = true;
    for (index, raw) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = raw.split('#').next().unwrap_or_default();
        let fields: Vec<&str> =
            line.split([',', ';', ' ', '\t', '\r']).filter(|field| !field.is_empty()).collect();
        if fields.is_empty() {
            continue;
        }
        let numbers: Vec<f64> = fields.iter().filter_map(|field| field.parse().ok()).collect();
        if numbers.is_empty() && std::mem::take(&mut header_allowed) {
            continue;
        }
        header_allowed = false;
        let complete = numbers.len() == fields.len();
        match (complete, <[f64; N]>::try_from(numbers)) {
            (true, Ok(row)) => rows.push((index + 1, row)),
            _ => {
                return Err(data(
                    index + 1,
                    format!("'{}' must be {N} numbers, such as 550,1.5", shown(raw.trim())),
                ));
            }
        }
    }
    if rows.is_empty() {
        return Err(data(0, format!("there is no line of {N} numbers in it")));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Tabulated {
        Tabulated::new(vec![400.0, 500.0, 700.0], vec![1.0, 2.0, 0.0], Ends::Extend).unwrap()
    }

    #[test]
    fn lines_join_the_points_and_the_points_are_exact() {
        assert_eq!([400.0, 450.0, 500.0, 600.0, 700.0].map(|nm| ramp().at(nm)), [1.0, 1.5, 2.0, 1.0, 0.0]);
    }

    #[test]
    fn each_end_rule_holds_on_both_sides() {
        let zero = ramp().scaled(3.0).with_ends(Ends::Zero);
        assert_eq!([300.0, 400.0, 700.0, 701.0].map(|nm| zero.at(nm)), [0.0, 3.0, 0.0, 0.0]);
        assert_eq!([300.0, 800.0].map(|nm| ramp().at(nm)), [1.0, 0.0]);
        let single = Tabulated::new(vec![589.0], vec![7.0], Ends::Zero).unwrap();
        assert_eq!([588.0, 589.0, 590.0].map(|nm| single.at(nm)), [0.0, 7.0, 0.0]);
    }

    #[test]
    fn csv_takes_comments_a_header_and_any_usual_separator() {
        let text = "\u{feff}# source\nwavelength;absorption\n\n400 ; 1 # first\n500\t2\r\n600, 3e0\n";
        let table = Tabulated::from_csv(text, "t.csv").unwrap();
        assert_eq!((table.nm(), table.values()), (&[400.0, 500.0, 600.0][..], &[1.0, 2.0, 3.0][..]));
    }

    #[test]
    fn bad_tables_say_where_and_what() {
        for (text, expected) in [
            ("", "t.csv, line 0: there is no line of 2 numbers in it"),
            ("nm,value\nnm,value", "t.csv, line 2: 'nm,value' must be 2 numbers"),
            ("400,1\n500,x", "t.csv, line 2: '500,x' must be 2 numbers"),
            ("400,1,2", "t.csv, line 1: '400,1,2' must be 2 numbers"),
            ("40O,1", "t.csv, line 1: '40O,1' must be 2 numbers"),
            ("400,1\n400,2", "line 2: wavelengths must ascend, but 400 follows 400"),
            ("0.4,1", "0.4 looks like micrometres"),
            ("400,inf", "the value inf is not a finite number"),
            ("nan,1", "the wavelength NaN must lie within"),
        ] {
            let message = Tabulated::from_csv(text, "t.csv").unwrap_err().to_string();
            assert!(message.contains(expected), "{text:?} gave {message:?}");
        }
        let message = Tabulated::new(vec![400.0], vec![], Ends::Extend).unwrap_err().to_string();
        assert!(message.contains("1 wavelengths and 0 values"), "{message}");
        assert!(Tabulated::new(vec![500.0, 400.0], vec![1.0, 1.0], Ends::Zero).is_err());
    }
}
