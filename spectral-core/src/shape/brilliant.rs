//! The standard round brilliant.

use serde::Deserialize;

use super::{GEAR, between, girdle, offset, rounded, sin_cos, tier};
use crate::{Error, cut::Cut, cut::CutFacet};

/// Half the girdle's diameter.
const RADIUS: f64 = 0.5;

/// The standard round brilliant of 57 facets (58 with a culet) and its girdle; see [`crate::shape`] for units and frame.
///
/// Eight bezels and eight mains have the eight principal azimuths, the first at +y, and extend to the full radius of the
/// girdle there. Stars, upper and lower girdle facets follow from the meet points.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RoundBrilliant {
    /// Table size between opposite corners.
    pub table: f64,
    /// Angle of the bezels.
    pub crown: f64,
    /// Angle of the pavilion mains.
    pub pavilion: f64,
    /// Star length: the share of the distance from the table's edge to the girdle, seen from above.
    pub star: f64,
    /// Length of the lower girdle facets: the share of the distance from the girdle to the centre, seen from below.
    pub lower_half: f64,
    /// Girdle thickness at the mains, where it is largest if `girdle_facets` is above 16.
    pub girdle: f64,
    /// Number of girdle facets, a multiple of 16.
    pub girdle_facets: u32,
    /// Culet size between opposite edges; 0 for a pointed culet.
    pub culet: f64,
}

impl Default for RoundBrilliant {
    fn default() -> Self {
        RoundBrilliant {
            table: 0.55,
            crown: 34.5,
            pavilion: 40.75,
            star: 0.5,
            lower_half: 0.77,
            girdle: 0.035,
            girdle_facets: 64,
            culet: 0.0,
        }
    }
}

impl RoundBrilliant {
    fn check(&self) -> Result<(), Error> {
        between("table", self.table, 0.0, 1.0)?;
        between("crown", self.crown, 0.0, 90.0)?;
        between("pavilion", self.pavilion, 0.0, 90.0)?;
        between("lower_half", self.lower_half, 0.0, 1.0)?;
        girdle(self.girdle)?;
        if !self.girdle_facets.is_multiple_of(16) || !(16..=960).contains(&self.girdle_facets) {
            let expected = "it must be a multiple of 16 from 16 to 960";
            return Err(Error::value("girdle_facets", self.girdle_facets, expected));
        }
        // The tip of the star must lie below the table: further out than the common edge of the bezels at table height.
        let (_, cos) = sin_cos(22.5);
        between("star", self.star, (self.table / cos - self.table * cos) / (1.0 - self.table * cos), 1.0)?;
        // The culet must lie inside the tips of the lower girdle facets.
        let most = (1.0 - self.lower_half) * cos;
        if !(0.0..most).contains(&self.culet) {
            let expected = format!("it must lie between 0 and {} for this lower_half", rounded(most));
            return Err(Error::value("culet", self.culet, expected));
        }
        Ok(())
    }

    /// The cut with these proportions.
    ///
    /// # Errors
    /// [`Error::Value`] naming the parameter and what it may be.
    ///
    /// ```
    /// use spectral_core::shape::RoundBrilliant;
    /// let cut = RoundBrilliant { girdle_facets: 16, ..Default::default() }.cut()?;
    /// assert_eq!(cut.facets.len(), 57 + 16);
    /// let wrong = RoundBrilliant { table: 1.2, ..Default::default() }.cut();
    /// assert!(wrong.unwrap_err().to_string().starts_with("table: 1.2"));
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn cut(&self) -> Result<Cut, Error> {
        self.check()?;
        let mut facets = Vec::new();
        let step = 360.0 / f64::from(self.girdle_facets);
        let flat = RADIUS * sin_cos(step / 2.0).1;
        tier(&mut facets, "girdle", -90.0, flat, step / 2.0, self.girdle_facets);
        self.pavilion(&mut facets);
        self.crown(&mut facets);
        Ok(Cut { facets, title: vec!["round brilliant".to_owned()], gear: Some(GEAR), ..Cut::default() })
    }

    fn pavilion(&self, facets: &mut Vec<CutFacet>) {
        let rim = self.girdle / 2.0;
        let (cos_eighth, cos_sixteenth) = (sin_cos(22.5).1, sin_cos(11.25).1);
        let main = offset(self.pavilion, RADIUS, rim);
        tier(facets, "pavilion main", -self.pavilion, main, 0.0, 8);
        // The tip lies on the edge of two mains. The lower girdle facet contains it and a sixteenth of the girdle's edge.
        let tip = (1.0 - self.lower_half) * RADIUS;
        let tan = self.pavilion.to_radians().tan();
        let rise = (RADIUS - tip * cos_eighth) * tan;
        let angle = rise.atan2(cos_sixteenth * (RADIUS - tip)).to_degrees();
        tier(facets, "lower girdle", -angle, offset(angle, cos_sixteenth * RADIUS, rim), 11.25, 16);
        if self.culet > 0.0 {
            let depth = rim + (RADIUS - self.culet * RADIUS) * tan;
            tier(facets, "culet", -0.0, depth, 0.0, 1);
        }
    }

    fn crown(&self, facets: &mut Vec<CutFacet>) {
        let rim = self.girdle / 2.0;
        let (cos_eighth, cos_sixteenth) = (sin_cos(22.5).1, sin_cos(11.25).1);
        let tan = self.crown.to_radians().tan();
        let table_corner = self.table * RADIUS;
        let table_edge = table_corner * cos_eighth;
        let table_height = rim + (RADIUS - table_corner) * tan;
        // The tip of the star lies on the edge of two bezels.
        let tip = table_edge + self.star * (RADIUS - table_edge);
        let rise = (RADIUS - tip * cos_eighth) * tan;
        let upper = rise.atan2(cos_sixteenth * (RADIUS - tip)).to_degrees();
        let star = (table_height - rim - rise).atan2(tip - table_edge).to_degrees();
        tier(facets, "upper girdle", upper, offset(upper, cos_sixteenth * RADIUS, rim), 11.25, 16);
        tier(facets, "bezel", self.crown, offset(self.crown, RADIUS, rim), 0.0, 8);
        tier(facets, "star", star, offset(star, table_edge, table_height), 22.5, 8);
        tier(facets, "table", 0.0, table_height, 0.0, 1);
    }
}
