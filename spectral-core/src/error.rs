//! The one error type of this crate.

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
        Error::Value { what: what.into(), value: value.to_string(), expected: expected.into() }
    }

    /// An [`Error::Unknown`] that names the nearest of the `valid` names.
    pub fn unknown<S: AsRef<str>>(
        kind: &'static str,
        name: &str,
        valid: impl IntoIterator<Item = S>,
    ) -> Self {
        let valid: Vec<String> = valid.into_iter().map(|s| s.as_ref().to_owned()).collect();
        let nearest = nearest_name(name, valid.iter().map(String::as_str)).map(str::to_owned);
        Error::Unknown { kind, name: name.to_owned(), nearest, valid }
    }
}

/// The candidate most similar to `name`, or `None` if none is similar.
///
/// ```
/// assert_eq!(spectral_core::nearest_name("saphire", ["ruby", "sapphire"]), Some("sapphire"));
/// assert_eq!(spectral_core::nearest_name("granite", ["ruby", "sapphire"]), None);
/// ```
pub fn nearest_name<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = (name.chars().count() / 3).max(1);
    let lower = name.to_lowercase();
    candidates
        .into_iter()
        .map(|c| (strsim::damerau_levenshtein(&lower, &c.to_lowercase()), c))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, c)| c)
}

fn hint(nearest: &Option<String>, valid: &[String]) -> String {
    match nearest {
        Some(n) => format!("; did you mean '{n}'?"),
        None if valid.is_empty() => String::new(),
        None => format!("; valid: {}", valid.join(", ")),
    }
}
