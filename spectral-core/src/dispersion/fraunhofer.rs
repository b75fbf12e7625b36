//! Fraunhofer's lines, at which indices are measured and compared: wavelengths in nm in air, as in the literature on gems
//! and glass.

/// Oxygen, red.
pub const B: f64 = 686.72;
/// Hydrogen α.
pub const C: f64 = 656.27;
/// Sodium, the mean of the doublet: the gemmologist's refractometer.
pub const D: f64 = 589.29;
/// Helium, "d": the lens designer's reference line.
pub const LOWER_D: f64 = 587.56;
/// Mercury, "e", green.
pub const LOWER_E: f64 = 546.07;
/// Hydrogen β.
pub const F: f64 = 486.13;
/// Mercury, "g".
pub const LOWER_G: f64 = 435.83;
/// Iron and calcium, violet.
pub const G: f64 = 430.79;
/// Mercury, "h".
pub const LOWER_H: f64 = 404.66;

/// Every line, by name, from red to violet.
pub const LINES: [(&str, f64); 9] = [
    ("B", B),
    ("C", C),
    ("D", D),
    ("d", LOWER_D),
    ("e", LOWER_E),
    ("F", F),
    ("g", LOWER_G),
    ("G", G),
    ("h", LOWER_H),
];
