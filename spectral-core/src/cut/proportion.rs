//! The proportions of a stone as cutters and laboratories state them.

use glam::DVec3;

use crate::mesh::Mesh;

/// Facets within this many degrees of upright belong to the girdle.
const UPRIGHT: f64 = 2.0;
/// Facets within this many degrees of level are a table or a culet.
const LEVEL: f64 = 0.5;
/// Facets of one tier agree in angle to this, in degrees.
const TIER: f64 = 0.05;

/// Measures of a stone whose table faces +z, in the mesh's unit of length; angles in degrees from the girdle's plane.
///
/// The girdle is every facet within 2° of upright or, where there is none, the edge between crown and pavilion. Crown
/// and pavilion are the facets above and below.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Proportions {
    /// The smaller of the x and y extents.
    pub width: f64,
    /// The larger of them.
    pub length: f64,
    /// The table's extent along the width, as a percentage of the width; `None` without a table.
    pub table_percent: Option<f64>,
    /// Height from the highest point of the girdle to the top of the stone.
    pub crown_height: f64,
    /// Height between the highest and the lowest point of the girdle.
    pub girdle: f64,
    /// Height from the lowest point of the girdle to the bottom of the stone.
    pub pavilion_depth: f64,
    /// The z extent.
    pub total_depth: f64,
    /// Angle of the crown mains: the tier with the largest area from table to girdle, or else the largest of all.
    pub crown_angle: Option<f64>,
    /// Angle of the pavilion mains: the tier with the largest area from the lowest point to the girdle, or else the largest
    /// that touches the lowest point.
    pub pavilion_angle: Option<f64>,
    /// Facets above the girdle, the table included.
    pub crown_facets: usize,
    /// Facets of the girdle.
    pub girdle_facets: usize,
    /// Facets below the girdle, a culet included.
    pub pavilion_facets: usize,
    /// The enclosed volume.
    pub volume: f64,
}

/// The measures of a facet.
struct Measured {
    /// Degrees: 0 faces up, 90 is upright, 180 faces down.
    tilt: f64,
    area: f64,
    vertices: Vec<u32>,
}

impl Measured {
    fn is_girdle(&self) -> bool {
        (self.tilt - 90.0).abs() < UPRIGHT
    }

    fn is_crown(&self) -> bool {
        !self.is_girdle() && self.tilt < 90.0
    }

    fn is_pavilion(&self) -> bool {
        !self.is_girdle() && self.tilt > 90.0
    }
}

impl Proportions {
    /// Measures `mesh`.
    ///
    /// ```
    /// use spectral_core::{cut::Proportions, shape::RoundBrilliant};
    /// let (mesh, _) = RoundBrilliant { table: 0.55, ..Default::default() }.cut()?.solid()?;
    /// let table = Proportions::of(&mesh).table_percent.unwrap();
    /// assert!((table - 55.0).abs() < 1e-9);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn of(mesh: &Mesh) -> Self {
        let facets = measure(mesh);
        let at = |v: u32| mesh.positions()[v as usize];
        let (low, high) = mesh.bounds();
        let size = high - low;
        let near = 1e-4 * size.max_element();
        let axis = if size.x <= size.y { DVec3::X } else { DVec3::Y };
        let top = largest(facets.iter().filter(|f| f.tilt < LEVEL));
        let table_percent =
            top.map(|f| 100.0 * spread(f.vertices.iter().map(|&v| at(v).dot(axis))).2 / size.dot(axis));
        let rim = rim(&facets);
        let (rim_low, rim_high, girdle) = spread(rim.iter().map(|&v| at(v).z));
        let on_rim = |f: &Measured| f.vertices.iter().any(|v| rim.contains(v));
        let touches = |f: &Measured, z: f64| f.vertices.iter().any(|&v| (at(v).z - z).abs() < near);
        let on_table = |f: &Measured| match top {
            Some(table) => f.vertices.iter().any(|v| table.vertices.contains(v)),
            None => touches(f, high.z),
        };
        let crown: Vec<_> = facets.iter().filter(|f| f.is_crown() && f.tilt >= LEVEL).collect();
        let pavilion: Vec<_> = facets.iter().filter(|f| f.is_pavilion() && f.tilt <= 180.0 - LEVEL).collect();
        let crown_angle =
            main_tier(&crown, |f| on_table(f) && on_rim(f)).or_else(|| main_tier(&crown, |_| true));
        let pavilion_angle = main_tier(&pavilion, |f| touches(f, low.z) && on_rim(f))
            .or_else(|| main_tier(&pavilion, |f| touches(f, low.z)));
        let count = |part: fn(&Measured) -> bool| facets.iter().filter(|f| part(f)).count();
        Proportions {
            width: size.x.min(size.y),
            length: size.x.max(size.y),
            table_percent,
            crown_height: high.z - rim_high,
            girdle,
            pavilion_depth: rim_low - low.z,
            total_depth: size.z,
            crown_angle,
            pavilion_angle: pavilion_angle.map(|tilt| 180.0 - tilt),
            crown_facets: count(Measured::is_crown),
            girdle_facets: count(Measured::is_girdle),
            pavilion_facets: count(Measured::is_pavilion),
            volume: mesh.volume(),
        }
    }
}

fn measure(mesh: &Mesh) -> Vec<Measured> {
    let tilt = |n: DVec3| n.truncate().length().atan2(n.z).to_degrees();
    let mut facets: Vec<Measured> = mesh
        .facets()
        .iter()
        .zip(mesh.facet_areas())
        .map(|(f, area)| Measured { tilt: tilt(f.plane.normal), area, vertices: Vec::new() })
        .collect();
    for (triangle, &k) in mesh.triangles().iter().zip(mesh.facet_of()) {
        facets[k as usize].vertices.extend(triangle);
    }
    facets
}

fn largest<'a>(facets: impl Iterator<Item = &'a Measured>) -> Option<&'a Measured> {
    facets.max_by(|a, b| a.area.total_cmp(&b.area))
}

/// The girdle's vertices or, on a stone without girdle facets, those between crown and pavilion.
fn rim(facets: &[Measured]) -> rustc_hash::FxHashSet<u32> {
    let of = |part: fn(&Measured) -> bool| -> rustc_hash::FxHashSet<u32> {
        facets.iter().filter(|f| part(f)).flat_map(|f| f.vertices.iter().copied()).collect()
    };
    let girdle = of(Measured::is_girdle);
    if !girdle.is_empty() {
        return girdle;
    }
    of(Measured::is_crown).intersection(&of(Measured::is_pavilion)).copied().collect()
}

/// Least, greatest and their difference; zeros for none.
fn spread(values: impl Iterator<Item = f64>) -> (f64, f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low <= high { (low, high, high - low) } else { (0.0, 0.0, 0.0) }
}

/// The tilt of the tier with the largest area among the facets that pass; a tier is all facets of one tilt.
fn main_tier(facets: &[&Measured], pass: impl Fn(&Measured) -> bool) -> Option<f64> {
    let mut passing: Vec<&Measured> = facets.iter().copied().filter(|f| pass(f)).collect();
    passing.sort_by(|a, b| a.tilt.total_cmp(&b.tilt));
    let tiers = passing.chunk_by(|a, b| b.tilt - a.tilt < TIER);
    let area = |tier: &[&Measured]| tier.iter().map(|f| f.area).sum::<f64>();
    let best = tiers.max_by(|a, b| area(a).total_cmp(&area(b)))?;
    Some(best.iter().map(|f| f.tilt * f.area).sum::<f64>() / area(best))
}
