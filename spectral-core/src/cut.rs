//! Cuts: stones as a faceter describes them, with one plane for each facet.
//!
//! A cut is the intersection of the half-spaces of its facets. [`Cut::solid`] computes vertices and edges and keeps each
//! plane exactly as designed; [`Proportions`] measures the stone.

use crate::{Error, Warning, mesh::Facet, mesh::Mesh, mesh::Plane};

mod proportion;

pub use proportion::Proportions;

/// One facet of a [`Cut`].
#[derive(Debug, Clone, PartialEq)]
pub struct CutFacet {
    /// Its plane; the stone lies behind it.
    pub plane: Plane,
    /// Its name, or that of its tier (`"C1"`, `"table"`).
    pub name: Option<String>,
    /// The instructions for the faceter (`"Meet C1-G"`).
    pub instructions: Option<String>,
}

impl CutFacet {
    /// A facet with a name.
    pub fn named(plane: Plane, name: impl Into<String>) -> Self {
        CutFacet { plane, name: Some(name.into()), instructions: None }
    }
}

impl From<Plane> for CutFacet {
    fn from(plane: Plane) -> Self {
        CutFacet { plane, name: None, instructions: None }
    }
}

/// A faceting design. +z is the table's normal; the unit of length is the design's own.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cut {
    /// The facets, in the order of the design.
    pub facets: Vec<CutFacet>,
    /// Title lines.
    pub title: Vec<String>,
    /// Closing remarks.
    pub footnotes: Vec<String>,
    /// Teeth of the index gear, negative if it counts clockwise; for information.
    pub gear: Option<i32>,
    /// The index of refraction of the design; for information.
    pub index_of_refraction: Option<f64>,
    /// The colour that the design is shown in, linear sRGB; none for a white one.
    pub colour: Option<[f64; 3]>,
}

impl Cut {
    /// The largest number of facets. The largest published designs have about a thousand.
    pub const MAX_FACETS: usize = Mesh::MOST_FACETS;

    /// The convex solid behind all facets. Its mesh has one facet for each facet of the cut that touches it, in the order of
    /// the cut and with the same plane.
    ///
    /// How facets that meet only approximately are taken, and what is refused, says [`Mesh::from_half_spaces`].
    ///
    /// # Errors
    /// As there.
    ///
    /// ```
    /// use spectral_core::{cut::{Cut, CutFacet}, mesh::Plane};
    /// let side = |azimuth| CutFacet::from(Plane::from_angles(90.0, azimuth, 0.5));
    /// let mut facets: Vec<CutFacet> = [0.0, 90.0, 180.0, 270.0].map(side).into();
    /// facets.push(CutFacet::named(Plane::from_angles(0.0, 0.0, 0.5), "table"));
    /// let mut cut = Cut { facets, ..Cut::default() };
    /// assert!(cut.solid().unwrap_err().to_string().contains("towards -z"));
    /// cut.facets.push(Plane::from_angles(-0.0, 0.0, 0.5).into());
    /// let (cube, warnings) = cut.solid()?;
    /// assert!(warnings.is_empty() && (cube.volume() - 1.0).abs() < 1e-14);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn solid(&self) -> Result<(Mesh, Vec<Warning>), Error> {
        let facet = |f: &CutFacet| Facet { plane: f.plane, name: f.name.clone() };
        Mesh::from_half_spaces(&self.facets.iter().map(facet).collect::<Vec<_>>())
    }
}
