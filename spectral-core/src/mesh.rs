//! Closed triangle meshes whose triangles are grouped into planar facets.
//!
//! A stone is bounded by polished planes. Backends may intersect triangles, but reflection and refraction use the exact
//! [`Plane`] of the facet, so the triangles of a facet do not differ by rounding. [`Mesh::from_triangles`] accepts the
//! triangles of any file. It repairs what can be repaired without guessing, with a [`Warning`], and refuses the rest with
//! the place of the fault.

use glam::{DMat3, DVec3};
use std::ops::Range;

use crate::{Error, Warning};

mod convexity;
mod facet;
mod gap;
mod half_spaces;
mod hull;
mod placement;
pub mod polygon;
mod polytope;
pub(crate) mod proximity;
mod rounded;
mod sheet;
mod solid;
mod topology;
mod union;
mod weld;

use facet::Grouped;
pub(crate) use placement::Placement;
use topology::Surface;

/// An oriented plane `normal · x = offset`; the solid lies where `normal · x <= offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit vector pointing out of the solid.
    pub normal: DVec3,
    /// Signed distance of the plane from the origin along `normal`, in the solid's unit of length.
    pub offset: f64,
}

impl Plane {
    /// The plane `normal · x = offset` for a `normal` of any length; both are divided by that length.
    ///
    /// # Errors
    /// [`Error::Value`] if a figure is not finite or the normal is zero.
    ///
    /// ```
    /// use {glam::DVec3, spectral_core::mesh::Plane};
    /// let plane = Plane::new(DVec3::new(0.0, 0.0, 2.0), 1.0)?;
    /// assert_eq!(plane.distance(DVec3::ZERO), -0.5);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn new(normal: DVec3, offset: f64) -> Result<Self, Error> {
        // Dividing by the largest component first avoids over- and underflow of the length.
        let largest = normal.abs().max_element();
        let unit = (normal / largest).normalize_or_zero();
        let length = (normal / largest).length() * largest;
        let plane = Plane { normal: unit, offset: offset / length };
        if normal.is_finite() && unit != DVec3::ZERO && plane.offset.is_finite() {
            return Ok(plane);
        }
        Err(Error::value(
            "plane",
            format!("normal {normal}, offset {offset}"),
            "give finite figures and a normal that is not zero",
        ))
    }

    /// The plane cut by a faceting machine, in the convention of GemCad's text format: `angle` in degrees from the
    /// horizontal (0 for the table, 90 for the girdle; negative for the pavilion, including −0.0), `azimuth` in degrees
    /// clockwise from +y as seen from +z, `distance` from the origin.
    ///
    /// ```
    /// use {glam::DVec3, spectral_core::mesh::Plane};
    /// let plane = Plane::from_angles(-90.0, 90.0, 1.0);
    /// assert!((plane.normal - DVec3::X).length() < 1e-15);
    /// ```
    pub fn from_angles(angle: f64, azimuth: f64, distance: f64) -> Self {
        let (sin_tilt, cos_tilt) = sin_cos_degrees(angle.abs());
        let (sin_azimuth, cos_azimuth) = sin_cos_degrees(azimuth);
        let up = if angle.is_sign_negative() { -cos_tilt } else { cos_tilt };
        Plane { normal: DVec3::new(sin_azimuth * sin_tilt, cos_azimuth * sin_tilt, up), offset: distance }
    }

    /// Signed distance of `point` from the plane, positive outside the solid.
    #[inline]
    pub fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90°, so that tables are exactly level and girdles exactly
/// upright.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    let quarter = (turn / 90.0).round();
    let (sin, cos) = (turn - 90.0 * quarter).to_radians().sin_cos();
    match quarter as u8 {
        1 => (cos, -sin),
        2 => (-sin, -cos),
        3 => (-cos, sin),
        _ => (sin, cos),
    }
}

/// One planar facet of a [`Mesh`].
#[derive(Debug, Clone, PartialEq)]
pub struct Facet {
    /// The facet's plane: exact where the mesh was made from planes, fitted where it was made from triangles.
    pub plane: Plane,
    /// Its name in the design, if it has one.
    pub name: Option<String>,
}

/// How [`Mesh::from_triangles`] joins vertices and groups triangles. Lengths are fractions of the extent of the mesh, which
/// is the longest side of its bounding box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshOptions {
    /// Vertices nearer than this are joined, but only if the mesh is open with exact duplicates joined.
    pub weld: f64,
    /// The largest angle between the normals of a triangle and its facet, degrees.
    pub coplanar_angle: f64,
    /// The largest distance of a triangle's vertices from the plane of its facet. Increase it for noisy scans.
    pub coplanar_distance: f64,
}

impl Default for MeshOptions {
    fn default() -> Self {
        MeshOptions { weld: 1e-7, coplanar_angle: 0.1, coplanar_distance: 1e-5 }
    }
}

impl MeshOptions {
    fn check(&self) -> Result<(), Error> {
        let fields = [
            ("weld", self.weld, 0.01),
            ("coplanar_angle", self.coplanar_angle, 45.0),
            ("coplanar_distance", self.coplanar_distance, 0.01),
        ];
        for (name, value, most) in fields {
            if !(0.0..=most).contains(&value) {
                return Err(Error::value(name, value, format!("give a figure from 0 to {most}")));
            }
        }
        Ok(())
    }
}

/// A closed, outward-oriented triangle mesh whose triangles are grouped into planar facets with exact planes.
///
/// Every edge has the same number of triangles in either direction, and the enclosed volume is positive.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    facet_of: Vec<u32>,
    facets: Vec<Facet>,
    shells: usize,
    /// For each of [`Mesh::solids`] the end of its triangles.
    solids: Vec<u32>,
    convex: bool,
}

impl Mesh {
    /// A mesh from the triangles of a file: `triangles` index `positions`, counter-clockwise seen from outside, in any unit
    /// of length.
    ///
    /// Coincident vertices are joined, gaps of up to a thousandth of the extent closed, triangles without area removed, triangles wound against their neighbours reversed, and
    /// an inverted mesh is turned inside out; each is reported. There may be several shells; an inward one is a cavity of
    /// the shell around it, and the mesh is the union of those that overlap. Connected coplanar triangles become one
    /// [`Facet`] with the area-weighted best plane.
    ///
    /// # Errors
    /// [`Error::Value`] if there are no triangles, or for an index or coordinate out of range; [`Error::Solid`], with the
    /// place, for a surface that is open, non-manifold, not orientable or without volume.
    ///
    /// ```
    /// use {glam::DVec3, spectral_core::mesh::{Mesh, MeshOptions}};
    /// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    /// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let (mesh, warnings) = Mesh::from_triangles(corners, faces, &MeshOptions::default())?;
    /// assert!(warnings.is_empty() && mesh.is_convex());
    /// assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-15);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn from_triangles(
        positions: Vec<DVec3>,
        triangles: Vec<[u32; 3]>,
        options: &MeshOptions,
    ) -> Result<(Mesh, Vec<Warning>), Error> {
        options.check()?;
        weld::check_input(&positions, &triangles)?;
        let mut warnings = Vec::new();
        let mut surface = weld::close(positions, triangles, options.weld, &mut warnings)?;
        let solids = solid::separate(&mut surface, &mut warnings);
        let Grouped { facet_of, planes } = facet::group(&surface, options, facet::ROUNDING);
        let (mut mesh, surface) = Mesh::of(surface, solids, facet_of, planes);
        mesh.convex = convexity::is_convex(&mesh, &surface.across, convexity::TOLERANCE * surface.extent);
        if !mesh.convex {
            mesh = rounded::solid(mesh, surface, options);
        }
        Ok((mesh, warnings))
    }

    /// The grouped triangles of a surface, which is given back without its vertices and triangles.
    fn of(surface: Surface, solids: Vec<u32>, facet_of: Vec<u32>, planes: Vec<Plane>) -> (Mesh, Surface) {
        let facets = planes.into_iter().map(|plane| Facet { plane, name: None }).collect();
        let Surface { positions, triangles, shells, .. } = surface;
        let mesh = Mesh { positions, triangles, facet_of, facets, shells, solids, convex: false };
        (mesh, Surface { positions: Vec::new(), triangles: Vec::new(), ..surface })
    }

    /// The largest number of half-spaces of [`from_half_spaces`](Self::from_half_spaces).
    pub const MOST_FACETS: usize = half_spaces::MOST_FACETS;

    /// The convex solid behind all planes. It has one facet for each plane that touches it, in the order given.
    ///
    /// In published designs, facets meet only approximately: four facets that should meet in a point leave an edge of 1e-7
    /// or 1e-3 of the stone. Edges shorter than 1e-6 of the radius are contracted, so vertices lie within this distance of
    /// the planes; a vertex of exactly three facets is at their intersection. Longer edges are kept. Facets that do not
    /// touch the solid, or repeat another, are omitted and reported.
    ///
    /// # Errors
    /// [`Error::Value`] for a plane that is not finite or too many facets; [`Error::Solid`] if the solid is unbounded (with
    /// the direction) or empty.
    ///
    pub fn from_half_spaces(facets: &[Facet]) -> Result<(Mesh, Vec<Warning>), Error> {
        half_spaces::build(facets)
    }

    /// A convex mesh from one polygon for each facet: a loop of indices into `positions`, counter-clockwise seen from
    /// outside. The polygons must form a closed surface.
    fn from_polygons(positions: Vec<DVec3>, polygons: &[Vec<u32>], facets: Vec<Facet>) -> Mesh {
        let (mut triangles, mut facet_of) = (Vec::new(), Vec::new());
        for (k, loop_) in polygons.iter().enumerate() {
            polygon::triangulate_convex(&positions, loop_, &mut triangles);
            facet_of.resize(triangles.len(), k as u32);
        }
        let solids = vec![triangles.len() as u32];
        Mesh { positions, triangles, facet_of, facets, shells: 1, solids, convex: true }
    }

    /// The vertices.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Three indices into [`positions`](Self::positions) a triangle, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The facet of each triangle, an index into [`facets`](Self::facets).
    pub fn facet_of(&self) -> &[u32] {
        &self.facet_of
    }

    /// The planar facets.
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// The number of surfaces connected across edges with two triangles, including cavities. Shells that touch along an edge
    /// count separately; if they touch along a face, each triangle of this face counts as a surface.
    pub fn shells(&self) -> usize {
        self.shells
    }

    /// The solids that the mesh is the union of: for each its triangles, a range of [`triangles`](Self::triangles). There is
    /// one, with all shells, unless shells overlap or touch.
    pub fn solids(&self) -> impl ExactSizeIterator<Item = Range<u32>> + '_ {
        let start = |k: usize| if k == 0 { 0 } else { self.solids[k - 1] };
        self.solids.iter().enumerate().map(move |(k, &end)| start(k)..end)
    }

    /// Whether the solid is the intersection of its facets' half-spaces, to 1e-6 of its extent. A mesh that is convex
    /// but for the rounding of its file is replaced by the intersection, so it counts.
    pub fn is_convex(&self) -> bool {
        self.convex
    }

    /// The least and the greatest corner of the axis-aligned bounding box.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        bounds(&self.positions)
    }

    /// The enclosed volume; always positive. Where [`solids`](Self::solids) overlap, that of their union, or above 30,000
    /// triangles the sum of theirs.
    pub fn volume(&self) -> f64 {
        if self.is_union() {
            return union::measure(self).0;
        }
        signed_volume(&self.positions, &self.triangles)
    }

    /// The area of the whole surface; where [`solids`](Self::solids) overlap, as [`volume`](Self::volume).
    pub fn area(&self) -> f64 {
        if self.is_union() {
            return union::measure(self).1;
        }
        self.facet_areas().iter().sum()
    }

    fn is_union(&self) -> bool {
        self.solids.len() > 1 && self.triangles.len() <= union::MOST_TRIANGLES
    }

    /// The area of each facet, the sum over its triangles.
    pub fn facet_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.facets.len()];
        for (triangle, &k) in self.triangles.iter().zip(&self.facet_of) {
            areas[k as usize] += 0.5 * cross(&self.positions, triangle).length();
        }
        areas
    }

    /// The mesh after `x -> scale · rotation · x + translation`. The planes are transformed, not fitted again.
    ///
    /// # Errors
    /// [`Error::Value`] for a `scale` that is not positive, a `rotation` that is not a rotation (a reflection would invert
    /// the mesh), or a figure that is not finite.
    ///
    /// ```
    /// use {glam::{DMat3, DVec3}, spectral_core::mesh::{Mesh, MeshOptions}};
    /// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    /// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let (mesh, _) = Mesh::from_triangles(corners, faces, &MeshOptions::default())?;
    /// let twice = mesh.transformed(DMat3::IDENTITY, 2.0, DVec3::ZERO)?;
    /// assert!((twice.volume() / mesh.volume() - 8.0).abs() < 1e-12);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn transformed(&self, rotation: DMat3, scale: f64, translation: DVec3) -> Result<Mesh, Error> {
        let placement = Placement::new(rotation, scale, translation)?;
        placement.check(self)?;
        let mut mesh = self.clone();
        mesh.positions.iter_mut().for_each(|p| *p = placement.point(*p));
        mesh.facets.iter_mut().for_each(|facet| facet.plane = placement.plane(&facet.plane));
        Ok(mesh)
    }
}

/// Least and greatest corner of the box around `points`; zero for none.
fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    bounds_of(points.iter().copied())
}

fn bounds_of(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.map(|p| (p, p)).reduce(|(low, high), (p, _)| (low.min(p), high.max(p))).unwrap_or_default()
}

/// Twice the area of a triangle along its normal.
fn cross(positions: &[DVec3], triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| positions[v as usize]);
    (b - a).cross(c - a)
}

/// The solid angle that a triangle takes up, seen from the origin; negative from its back (van Oosterom & Strackee 1983).
pub(crate) fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(below)
}

/// Sum of the signed tetrahedra between the triangles and the middle of the bounding box. This apex is nearer than the
/// origin, so a distant mesh loses no digits.
fn signed_volume(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    volume_about(bounds(positions), triangles, |v| positions[v as usize])
}

/// The same for vertices at `position` within the given bounding box.
fn volume_about((low, high): (DVec3, DVec3), triangles: &[[u32; 3]], position: impl Fn(u32) -> DVec3) -> f64 {
    let middle = 0.5 * (low + high);
    let six: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| position(v) - middle);
            a.dot(b.cross(c))
        })
        .sum();
    six / 6.0
}
