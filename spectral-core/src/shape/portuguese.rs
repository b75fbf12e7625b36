//! The Portuguese cut.

use serde::Deserialize;

use super::{GEAR, angles, girdle, offset, sin_cos, tier};
use crate::{Error, cut::Cut, cut::CutFacet};

/// Half the girdle's diameter.
const RADIUS: f64 = 0.5;

/// The round Portuguese cut: rows of kites, each turned by half a facet against the previous row and cut to the meets of the
/// two previous rows; see [`crate::shape`] for units and frame.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Portuguese {
    /// Facets in each row and in the girdle.
    pub facets: u32,
    /// Angles of the crown's rows from the girdle to the table, decreasing.
    pub crown: Vec<f64>,
    /// Angles of the pavilion's rows from the girdle to the culet, decreasing.
    pub pavilion: Vec<f64>,
    /// Girdle thickness.
    pub girdle: f64,
}

impl Default for Portuguese {
    fn default() -> Self {
        Portuguese {
            facets: 16,
            crown: vec![55.0, 47.0, 38.5, 29.0],
            pavilion: vec![60.0, 54.0, 49.0, 45.5, 43.0],
            girdle: 0.03,
        }
    }
}

impl Portuguese {
    fn check(&self) -> Result<(), Error> {
        if !self.facets.is_multiple_of(4) || !(8..=96).contains(&self.facets) {
            return Err(Error::value("facets", self.facets, "it must be a multiple of 4 from 8 to 96"));
        }
        girdle(self.girdle)?;
        angles("crown", &self.crown)?;
        angles("pavilion", &self.pavilion)
    }

    /// The cut with these proportions.
    ///
    /// # Errors
    /// [`Error::Value`] naming the parameter and what it may be.
    ///
    /// ```
    /// let cut = spectral_core::shape::Portuguese::default().cut()?;
    /// assert_eq!(cut.facets.len(), 16 * (1 + 5 + 4) + 1);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn cut(&self) -> Result<Cut, Error> {
        self.check()?;
        let mut facets = Vec::new();
        let half = 180.0 / f64::from(self.facets);
        tier(&mut facets, "girdle", -90.0, RADIUS * sin_cos(half).1, half, self.facets);
        self.rows(&mut facets, "pavilion", -1.0, &self.pavilion)?;
        let table = self.rows(&mut facets, "crown", 1.0, &self.crown)?;
        tier(&mut facets, "table", 0.0, table, 0.0, 1);
        Ok(Cut { facets, title: vec!["Portuguese cut".to_owned()], gear: Some(GEAR), ..Cut::default() })
    }

    /// The rows of the crown (`side` 1) or pavilion (−1); returns the height of the last row's meets.
    ///
    /// The first row contains the edges of the girdle and the second its corners. Each later facet passes through the point
    /// where two neighbours of the previous row meet the facet of the row before, at the azimuth between them.
    fn rows(&self, facets: &mut Vec<CutFacet>, part: &str, side: f64, angles: &[f64]) -> Result<f64, Error> {
        let half = 180.0 / f64::from(self.facets);
        let cos_half = sin_cos(half).1;
        let rim = self.girdle / 2.0;
        let mut meet = (RADIUS, rim);
        let mut before: Option<(f64, f64)> = None;
        for (k, &angle) in angles.iter().enumerate() {
            let distance = match before {
                None => offset(angle, RADIUS * cos_half, rim),
                Some(_) => offset(angle, meet.0, meet.1),
            };
            let first = if k % 2 == 0 { half } else { 0.0 };
            tier(facets, &format!("{part} {}", k + 1), side * angle, distance, first, self.facets);
            if let Some(last) = before {
                let next = crossing(last, (angle, distance), cos_half);
                if !(next.0 > 0.0 && next.0 < meet.0) {
                    let expected =
                        "this row would not meet the one before inside the stone; give a flatter angle";
                    return Err(Error::value(format!("{part}[{k}]"), angle, expected));
                }
                meet = next;
            }
            before = Some((angle, distance));
        }
        Ok(match angles.len() {
            // A single row has no meets: the table has half its width.
            1 => rim + 0.5 * RADIUS * cos_half * angles[0].to_radians().tan(),
            _ => meet.1,
        })
    }
}

/// Distance from the axis and height of the point where a facet (angle, offset), at its own azimuth, meets the edge of two
/// facets of the next row, which are half a facet to each side.
fn crossing(own: (f64, f64), next: (f64, f64), cos_half: f64) -> (f64, f64) {
    let ((sin_a, cos_a), (sin_b, cos_b)) = (sin_cos(own.0), sin_cos(next.0));
    let determinant = sin_a * cos_b - cos_half * sin_b * cos_a;
    let out = (own.1 * cos_b - next.1 * cos_a) / determinant;
    let up = (sin_a * next.1 - cos_half * sin_b * own.1) / determinant;
    (out, up)
}
