//! Parametric cuts: the classical shapes from the figures of a grading report or a faceting diagram.
//!
//! Every shape has width 1 (the smaller of its x and y extents), +z as its table's normal and the middle of its girdle
//! at z = 0. Angles are degrees from the girdle's plane; sizes are fractions of the width.

use serde::Deserialize;

use crate::{Error, cut::Cut, cut::CutFacet, mesh::Plane};

mod brilliant;
mod portuguese;
mod step;

pub use brilliant::RoundBrilliant;
pub use portuguese::Portuguese;
pub use step::Step;

/// A shape by name with its parameters, as in a scene file; missing parameters have the default of the shape.
///
/// ```
/// use spectral_core::shape::ShapeSpec;
/// let text = "name = 'round-brilliant'\ntable = 0.55\ncrown = 34.5\npavilion = 40.75";
/// let shape: ShapeSpec = toml::from_str(text).unwrap();
/// let (mesh, warnings) = shape.cut()?.solid()?;
/// assert!(warnings.is_empty() && mesh.facets().len() == 57 + 64);
/// # Ok::<(), spectral_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "name", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ShapeSpec {
    /// `round-brilliant`
    RoundBrilliant(RoundBrilliant),
    /// `step`, also `emerald`
    #[serde(alias = "emerald")]
    Step(Step),
    /// `portuguese`
    Portuguese(Portuguese),
}

impl ShapeSpec {
    /// The names in scene files.
    pub const NAMES: [&str; 3] = ["round-brilliant", "step", "portuguese"];

    /// The shape of this name with its default parameters.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the nearest name.
    ///
    /// ```
    /// use spectral_core::shape::ShapeSpec;
    /// assert!(ShapeSpec::by_name("round-briliant").unwrap_err().to_string().contains("'round-brilliant'"));
    /// ```
    pub fn by_name(name: &str) -> Result<Self, Error> {
        match name {
            "round-brilliant" => Ok(ShapeSpec::RoundBrilliant(RoundBrilliant::default())),
            "step" | "emerald" => Ok(ShapeSpec::Step(Step::default())),
            "portuguese" => Ok(ShapeSpec::Portuguese(Portuguese::default())),
            _ => Err(Error::unknown("shape", name, Self::NAMES)),
        }
    }

    /// The cut with these parameters.
    ///
    /// # Errors
    /// [`Error::Value`] for a parameter outside its range, with the range.
    pub fn cut(&self) -> Result<Cut, Error> {
        match self {
            ShapeSpec::RoundBrilliant(shape) => shape.cut(),
            ShapeSpec::Step(shape) => shape.cut(),
            ShapeSpec::Portuguese(shape) => shape.cut(),
        }
    }
}

/// Index gear of the designs: 96 divides into 2, 3, 4, 8, 16 and 32.
const GEAR: i32 = 96;

/// Checks that `value` lies strictly between the bounds.
fn between(name: &str, value: f64, low: f64, high: f64) -> Result<(), Error> {
    if value > low && value < high {
        return Ok(());
    }
    Err(Error::value(name, value, format!("it must lie between {} and {}", rounded(low), rounded(high))))
}

/// Checks the thickness of a girdle.
fn girdle(value: f64) -> Result<(), Error> {
    if (0.0..=0.5).contains(&value) {
        return Ok(());
    }
    Err(Error::value("girdle", value, "it must lie between 0 (a knife edge) and 0.5"))
}

/// Checks a list of tier angles from the girdle inwards, which must decrease.
fn angles(name: &str, list: &[f64]) -> Result<(), Error> {
    if list.is_empty() || list.len() > 50 {
        return Err(Error::value(
            name,
            format!("{} angles", list.len()),
            "give from 1 to 50, from the girdle inwards",
        ));
    }
    for (k, &angle) in list.iter().enumerate() {
        let steepest = if k == 0 { 90.0 } else { list[k - 1] };
        between(&format!("{name}[{k}]"), angle, 0.0, steepest)?;
    }
    Ok(())
}

/// A bound for a message.
fn rounded(x: f64) -> f64 {
    (x * 1e4).round() / 1e4
}

/// Sine and cosine of degrees.
fn sin_cos(degrees: f64) -> (f64, f64) {
    degrees.to_radians().sin_cos()
}

/// Offset of a plane at `angle` (degrees) through the point at horizontal distance `out` along the azimuth of the plane and
/// vertical distance `up` from the middle of the girdle, towards the table (crown) or the culet (pavilion).
fn offset(angle: f64, out: f64, up: f64) -> f64 {
    let (sin, cos) = sin_cos(angle);
    sin * out + cos * up
}

/// `count` facets of one tier at equal distances about the axis, the first at `first` degrees from +y. A negative `angle`
/// means the pavilion.
fn tier(facets: &mut Vec<CutFacet>, name: &str, angle: f64, distance: f64, first: f64, count: u32) {
    for k in 0..count {
        let azimuth = first + 360.0 * f64::from(k) / f64::from(count);
        facets.push(CutFacet::named(Plane::from_angles(angle, azimuth, distance), name));
    }
}
