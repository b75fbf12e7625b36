//! Beams: a pixel's area on one convex stone, followed exactly.
//!
//! A ray through a point of a pixel samples a function that jumps wherever neighbouring rays meet different facets. But
//! within a pixel the rays of one wavelength and one sequence of facets are very nearly linear in the place (u, v) where
//! they pass through the pixel, and so the borders between facets are very nearly straight lines. A beam is a convex
//! [`Polygon`] of such places with the linear rays through it, a [`Pencil`]. Where a facet's border crosses the polygon, the
//! beam is split in two. What is left is continuous in u, v and the wavelength, and is taken at each polygon's centroid.
//!
//! (Heckbert & Hanrahan 1984, "Beam tracing polygonal objects", without refraction; Igehy 1999, "Tracing ray
//! differentials", for the derivatives.)
//!
//! * [`Silhouette`]: the facets that are seen, and the [`Piece`]s of a pixel that they cover.
//! * [`Pencil`]: how a beam's rays travel, are reflected and refracted.
//! * [`Vectors`]: in a crystal, the wave vectors that go with the rays of a mode.
//! * [`Polygon`]: how its area is split.

mod pencil;
mod polygon;
mod silhouette;
mod vectors;

pub use pencil::{Line, Pencil};
pub use polygon::Polygon;
pub use silhouette::{Piece, Silhouette, Uncovered};
pub use vectors::Vectors;

/// When beams are no longer split, and when they are ended: where throughput × share of the pixel falls below these.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// A beam that carries less goes as a whole where its centroid's ray goes.
    pub split: f64,
    /// A beam that carries less is ended, and reported as dropped below the threshold.
    pub end: f64,
    /// In a crystal, of two modes of which one carries less than this, one is followed for both.
    pub choice: f64,
}

/// The smallest part of a polygon that is followed by itself, in pixels: rounding makes smaller ones.
pub const LEAST_AREA: f64 = 1e-9;

/// A line that passes a polygon's vertices by no more than this, in pixels, does not split it.
pub const LEAST_DISTANCE: f64 = 1e-7;
