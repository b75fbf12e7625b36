//! The step cut, with cropped corners the emerald cut.

use serde::Deserialize;

use super::{GEAR, angles, between, girdle, offset, rounded};
use crate::{Error, cut::Cut, cut::CutFacet, mesh::Plane};

/// The step or emerald cut: level rows of trapezoids around a rectangle; see [`crate::shape`] for units and frame.
///
/// The width is along x, the length along y. All facets of a row have the same angle and meet the rows above and below in
/// level edges. The pavilion ends in a keel, or in a point if `length` is 1.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Step {
    /// Length over width, at least 1.
    pub length: f64,
    /// The length cropped from each side at a corner; 0 for square corners.
    pub corner: f64,
    /// Table width.
    pub table: f64,
    /// Angles of the crown's rows from the girdle to the table, decreasing.
    pub crown: Vec<f64>,
    /// Angles of the pavilion's rows from the girdle to the keel, decreasing.
    pub pavilion: Vec<f64>,
    /// Widths of the stone between the rows of the crown; evenly spaced by default.
    pub crown_levels: Option<Vec<f64>>,
    /// The same for the pavilion.
    pub pavilion_levels: Option<Vec<f64>>,
    /// Girdle thickness.
    pub girdle: f64,
}

impl Default for Step {
    fn default() -> Self {
        Step {
            length: 1.4,
            corner: 0.3,
            table: 0.61,
            crown: vec![48.0, 38.0, 28.0],
            pavilion: vec![58.0, 50.0, 43.0],
            crown_levels: None,
            pavilion_levels: None,
            girdle: 0.03,
        }
    }
}

impl Step {
    fn check(&self) -> Result<(), Error> {
        if !(1.0..=10.0).contains(&self.length) {
            return Err(Error::value("length", self.length, "it must lie between 1 and 10 widths"));
        }
        if !(0.0..0.5).contains(&self.corner) {
            return Err(Error::value("corner", self.corner, "it must lie between 0 and 0.5 of the width"));
        }
        girdle(self.girdle)?;
        between("table", self.table, 0.0, 1.0)?;
        angles("crown", &self.crown)?;
        angles("pavilion", &self.pavilion)
    }

    /// The cut with these proportions.
    ///
    /// # Errors
    /// [`Error::Value`] naming the parameter and what it may be.
    ///
    /// ```
    /// let cut = spectral_core::shape::Step::default().cut()?;
    /// assert_eq!(cut.facets.len(), 8 * (1 + 3 + 3) + 1);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn cut(&self) -> Result<Cut, Error> {
        self.check()?;
        let crown_levels = levels("crown_levels", &self.crown_levels, self.crown.len(), self.table)?;
        let pavilion_levels = levels("pavilion_levels", &self.pavilion_levels, self.pavilion.len(), 0.0)?;
        let mut facets = Vec::new();
        self.row(&mut facets, "girdle", -90.0, 0.0, 0.0);
        self.rows(&mut facets, "pavilion", -1.0, &self.pavilion, &pavilion_levels);
        let table = self.rows(&mut facets, "crown", 1.0, &self.crown, &crown_levels);
        facets.push(CutFacet::named(Plane::from_angles(0.0, 0.0, table), "table"));
        Ok(Cut { facets, title: vec!["step cut".to_owned()], gear: Some(GEAR), ..Cut::default() })
    }

    /// The rows of the crown (`side` 1) or pavilion (−1); returns the height at which the last one ends.
    fn rows(&self, facets: &mut Vec<CutFacet>, part: &str, side: f64, angles: &[f64], levels: &[f64]) -> f64 {
        let mut height = self.girdle / 2.0;
        let mut width = 1.0;
        for (k, (&angle, &level)) in angles.iter().zip(levels).enumerate() {
            self.row(facets, &format!("{part} {}", k + 1), side * angle, (1.0 - width) / 2.0, height);
            height += (width - level) / 2.0 * angle.to_radians().tan();
            width = level;
        }
        height
    }

    /// The eight facets of a row that starts `inset` inside the outline and `height` from the girdle's middle.
    fn row(&self, facets: &mut Vec<CutFacet>, name: &str, angle: f64, inset: f64, height: f64) {
        let corner = (0.5 + 0.5 * self.length - self.corner) * std::f64::consts::FRAC_1_SQRT_2;
        for k in 0..8 {
            let out = match k % 4 {
                0 => 0.5 * self.length,
                2 => 0.5,
                _ if self.corner > 0.0 => corner,
                _ => continue,
            };
            let distance = offset(angle.abs(), out - inset, height);
            facets.push(CutFacet::named(Plane::from_angles(angle, 45.0 * f64::from(k), distance), name));
        }
    }
}

/// The width at the inner end of each of `rows` rows; the last ends at `inner`.
fn levels(name: &str, given: &Option<Vec<f64>>, rows: usize, inner: f64) -> Result<Vec<f64>, Error> {
    let mut levels = match given {
        Some(list) if list.len() + 1 != rows => {
            let expected = format!("{rows} rows meet at {} levels", rows - 1);
            return Err(Error::value(name, format!("{} levels", list.len()), expected));
        }
        Some(list) => list.clone(),
        None => (1..rows).map(|k| 1.0 + (inner - 1.0) * k as f64 / rows as f64).collect(),
    };
    let mut outer = 1.0;
    for (k, &level) in levels.iter().enumerate() {
        if !(level > inner && level < outer) {
            let expected = format!("it must lie between {} and {}", rounded(inner), rounded(outer));
            return Err(Error::value(format!("{name}[{k}]"), level, expected));
        }
        outer = level;
    }
    levels.push(inner);
    Ok(levels)
}
