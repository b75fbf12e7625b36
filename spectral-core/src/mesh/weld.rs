//! From loose triangles to shared vertices: input checks, joining, and the removal of triangles without area.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::topology::{self, Fault, Surface};
use super::{bounds, polygon};
use crate::{Error, Warning};

/// Coordinates beyond this are refused: volumes and their differences stay far inside the range of `f64`.
pub(super) const LARGEST: f64 = 1e12;
/// The same in words.
pub(super) const RANGE: &str = "coordinates must be finite and at most 1e12 in size";
/// Meshes smaller than this are refused: products of coordinates must not underflow.
const SMALLEST: f64 = 1e-30;
/// Triangles thinner than this fraction of the extent have no direction worth the name.
const THIN: f64 = 1e-12;

pub(super) fn check_input(positions: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), Error> {
    if triangles.is_empty() {
        return Err(Error::value("mesh", "no triangles", "a solid needs at least four"));
    }
    if triangles.len() > (u32::MAX / 4) as usize {
        return Err(Error::value(
            "mesh",
            format!("{} triangles", triangles.len()),
            "at most 1073741823 can be numbered",
        ));
    }
    for (k, p) in positions.iter().enumerate() {
        for (axis, value) in ["x", "y", "z"].iter().zip(p.to_array()) {
            if !value.is_finite() || value.abs() > LARGEST {
                return Err(Error::value(format!("vertex {k}, {axis}"), value, RANGE));
            }
        }
    }
    for (k, triangle) in triangles.iter().enumerate() {
        if let Some(v) = triangle.iter().find(|&&v| v as usize >= positions.len()) {
            let expected = format!("the mesh has vertices 0 to {}", positions.len() as i64 - 1);
            return Err(Error::value(format!("triangle {k}"), format!("vertex {v}"), expected));
        }
    }
    Ok(())
}

/// The closed surface that the triangles make once coincident vertices are joined.
///
/// Exact duplicates come first, since they keep every detail of a file that is sound; nearness only helps where that
/// leaves the surface open. Triangles whose corners lie on a line are left out if the surface closes without them, and
/// kept where they are what fills a T-junction.
pub(super) fn close(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    weld: f64,
    warnings: &mut Vec<Warning>,
) -> Result<Surface, Error> {
    let exact = Joined::new(positions, triangles, &join_exact(positions, triangles));
    let (low, high) = bounds(&exact.positions);
    let extent = (high - low).max_element();
    if exact.triangles.is_empty() || extent < SMALLEST {
        let message = "the mesh has no triangle with an area".to_owned();
        return Err(Error::Solid { message, place: positions.first().map(|p| p.to_array()) });
    }
    // Coordinates far from the origin carry their own rounding.
    let rounding = 4.0 * f64::EPSILON * low.abs().max(high.abs()).max_element();
    let thin = (THIN * extent).max(rounding);
    let error = match exact.surface(thin, extent) {
        Ok((surface, notes)) => {
            warnings.extend(notes);
            return Ok(surface);
        }
        Err(error) => error,
    };
    let tolerance = (weld * extent).max(rounding);
    if weld == 0.0 || !error.is_open {
        return Err(error.into());
    }
    let map = join_near(&exact.positions, low, tolerance);
    let joined = map.iter().enumerate().filter(|&(k, &v)| k != v as usize).count();
    if joined == 0 {
        return Err(error.into());
    }
    let mut near = Joined::new(&exact.positions, &exact.triangles, &map);
    near.collapsed += exact.collapsed;
    near.repeated += exact.repeated;
    let (surface, notes) = near.surface(thin, extent)?;
    warnings.push(Warning::new(format!(
        "{joined} vertices were joined to others within {tolerance:.2e} to close the mesh"
    )));
    warnings.extend(notes);
    Ok(surface)
}

/// For each vertex the first used vertex with the very same coordinates.
fn join_exact(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut first: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    first.reserve(positions.len());
    let mut map = vec![u32::MAX; positions.len()];
    for &v in triangles.iter().flatten() {
        if map[v as usize] == u32::MAX {
            // Adding zero makes −0 and +0 the same.
            let key = (positions[v as usize] + DVec3::ZERO).to_array().map(f64::to_bits);
            map[v as usize] = *first.entry(key).or_insert(v);
        }
    }
    map
}

/// For each point the first point within `tolerance` that was kept, or itself.
fn join_near(points: &[DVec3], low: DVec3, tolerance: f64) -> Vec<u32> {
    // Cells eight times the tolerance: most points need look into one only, and few share one.
    let cell = |p: DVec3| ((p - low) / (8.0 * tolerance)).floor().to_array().map(|c| c as i64);
    let mut kept: FxHashMap<[i64; 3], Vec<u32>> = FxHashMap::default();
    let mut map = Vec::with_capacity(points.len());
    for (k, &p) in points.iter().enumerate() {
        let (from, to) = (cell(p - tolerance), cell(p + tolerance));
        let mut found = None;
        for x in from[0]..=to[0] {
            for y in from[1]..=to[1] {
                for z in from[2]..=to[2] {
                    let near = kept.get(&[x, y, z]).into_iter().flatten();
                    let near = near.copied().filter(|&v| points[v as usize].distance(p) <= tolerance);
                    found = found.into_iter().chain(near).min();
                }
            }
        }
        map.push(found.unwrap_or_else(|| {
            kept.entry(cell(p)).or_default().push(k as u32);
            k as u32
        }));
    }
    map
}

/// Triangles over joined vertices, none with two corners the same and none twice.
struct Joined {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    collapsed: usize,
    repeated: usize,
}

impl Joined {
    /// `map` gives each vertex the one it is joined to; vertices that no triangle uses are left out.
    fn new(positions: &[DVec3], triangles: &[[u32; 3]], map: &[u32]) -> Self {
        let (mut collapsed, mut repeated) = (0, 0);
        let mut seen: FxHashSet<[u32; 3]> = FxHashSet::default();
        seen.reserve(triangles.len());
        let mut kept = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            let [a, b, c] = triangle.map(|v| map[v as usize]);
            let least = a.min(b).min(c);
            let turned = if least == a {
                [a, b, c]
            } else if least == b {
                [b, c, a]
            } else {
                [c, a, b]
            };
            if a == b || b == c || c == a {
                collapsed += 1;
            } else if !seen.insert(turned) {
                repeated += 1;
            } else {
                kept.push([a, b, c]);
            }
        }
        let (positions, triangles) = used(positions, kept);
        Joined { positions, triangles, collapsed, repeated }
    }

    /// The closed surface, with what had to be done to get it. `thin` is the height under which a triangle counts as
    /// without area.
    fn surface(&self, thin: f64, extent: f64) -> Result<(Surface, Vec<Warning>), Fault> {
        let corners = |t: &[u32; 3]| t.map(|v| self.positions[v as usize]);
        let solid: Vec<[u32; 3]> =
            self.triangles.iter().copied().filter(|t| polygon::height(corners(t)) > thin).collect();
        let flat = self.triangles.len() - solid.len();
        let mut notes = Vec::new();
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                let (s, were) = if count == 1 { ("", "was") } else { ("s", "were") };
                notes.push(Warning::new(format!("{count} triangle{s} {what}").replace("{were}", were)));
            }
        };
        let mut kept = Vec::new();
        let (positions, solid) =
            if flat > 0 { used(&self.positions, solid) } else { (self.positions.clone(), solid) };
        let without = topology::build(positions, solid, extent, thin, &mut kept);
        let surface = match without {
            Ok(surface) => {
                note(self.collapsed + flat, "without area {were} left out");
                surface
            }
            Err(_) if flat > 0 => {
                kept.clear();
                let all = self.triangles.clone();
                let surface = topology::build(self.positions.clone(), all, extent, thin, &mut kept)?;
                note(self.collapsed, "without area {were} left out");
                note(flat, "whose corners lie on a line {were} kept, since the mesh is open without");
                surface
            }
            Err(error) => return Err(error),
        };
        note(self.repeated, "given more than once {were} taken once");
        notes.extend(kept);
        Ok((surface, notes))
    }
}

/// The positions that the triangles use, in order of first use, and the triangles over them.
fn used(positions: &[DVec3], mut triangles: Vec<[u32; 3]>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut number = vec![u32::MAX; positions.len()];
    let mut kept = Vec::new();
    for v in triangles.iter_mut().flatten() {
        let slot = &mut number[*v as usize];
        if *slot == u32::MAX {
            *slot = kept.len() as u32;
            kept.push(positions[*v as usize]);
        }
        *v = *slot;
    }
    (kept, triangles)
}
