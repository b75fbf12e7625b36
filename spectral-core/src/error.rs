//! The one error type of this crate.

use crate::shown;

/// An error of the caller, with a message from which a person can correct it.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A value outside the valid range.
    #[error("{what}: {value} is not valid; {expected}")]
    Value {
        /// The quantity, as the caller knows it (`"fov"`, `"measured[2]"`).
        what: String,
        /// The value given.
        value: String,
        /// What would be valid.
        expected: String,
    },
    /// An unknown name.
    #[error("unknown {kind} '{name}'{}", hint(.nearest, .valid))]
    Unknown {
        /// What was looked up (`"material"`, `"shape"`, `"illuminant"`).
        kind: &'static str,
        /// The name given.
        name: String,
        /// The nearest valid name, if one is similar.
        nearest: Option<String>,
        /// Every valid name.
        valid: Vec<String>,
    },
    /// Data in a file or text that does not parse.
    #[error("{what}, line {line}: {message}")]
    Data {
        /// The file or table.
        what: String,
        /// 1-based line; 0 for the whole.
        line: usize,
        /// What is wrong and what would be valid.
        message: String,
    },
    /// A device that failed, not because of the scene.
    #[error("{device}: {message}")]
    Device {
        /// The device's name.
        device: String,
        /// What happened.
        message: String,
    },
    /// More memory than there is.
    #[error("not enough memory: {what} needs {:.1} GiB", *bytes as f64 / f64::from(1 << 30))]
    Memory {
        /// What it was for.
        what: String,
        /// How much it would take, bytes.
        bytes: u64,
    },
    /// A surface or a set of planes that does not bound a solid.
    #[error("{message}")]
    Solid {
        /// What is wrong, where, and what would be valid.
        message: String,
        /// A point at the fault, in the units of the input; `None` if it concerns the whole.
        place: Option<[f64; 3]>,
    },
}

impl Error {
    /// An [`Error::Value`] from anything printable.
    pub fn value(what: impl Into<String>, value: impl ToString, expected: impl Into<String>) -> Self {
        Error::Value { what: what.into(), value: shown(&value.to_string()), expected: expected.into() }
    }

    /// An [`Error::Unknown`] that names the nearest of the `valid` names.
    pub fn unknown<S: AsRef<str>>(
        kind: &'static str,
        name: &str,
        valid: impl IntoIterator<Item = S>,
    ) -> Self {
        let valid: Vec<String> = valid.into_iter().map(|s| s.as_ref().to_owned()).collect();
        let nearest = nearest_name(name, valid.iter().map(String::as_str)).map(str::to_owned);
        Error::Unknown { kind, name: shown(name), nearest, valid }
    }
}

/// Longer names are like no other: comparing takes the product of the lengths.
const LONGEST_NAME: usize = 200;
/// How many valid names a message lists.
const LISTED: usize = 60;

/// The candidate most similar to `name`, or `None` if none is similar or the name is longer than 200 bytes.
///
/// ```
/// assert_eq!(spectral_core::nearest_name("saphire", ["ruby", "sapphire"]), Some("sapphire"));
/// assert_eq!(spectral_core::nearest_name("granite", ["ruby", "sapphire"]), None);
/// ```
pub fn nearest_name<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > LONGEST_NAME {
        return None;
    }
    let allowed = (name.chars().count() / 3).max(1);
    let lower = name.to_lowercase();
    candidates
        .into_iter()
        .filter(|c| c.len() <= 2 * LONGEST_NAME)
        .map(|c| (strsim::damerau_levenshtein(&lower, &c.to_lowercase()), c))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, c)| c)
}

fn hint(nearest: &Option<String>, valid: &[String]) -> String {
    match nearest {
        Some(n) => format!("; did you mean '{}'?", shown(n)),
        None if valid.is_empty() => String::new(),
        None => {
            let names: Vec<String> = valid.iter().take(LISTED).map(|name| shown(name)).collect();
            let more = valid.len().saturating_sub(LISTED);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            format!("; valid: {}{more}", names.join(", "))
        }
    }
}
