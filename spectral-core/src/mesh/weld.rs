//! Shared vertices for loose triangles: input checks, joining, and the removal of triangles without area.

use glam::DVec3;
use rustc_hash::{FxBuildHasher, FxHashMap};
use std::hash::{BuildHasher, Hash};
use std::mem::take;

use super::topology::{self, Fault, Joints, Surface};
use super::{bounds, gap, polygon};
use crate::{Error, Warning};

/// Larger coordinates are refused, so that volumes and their differences stay within the range of `f64`.
pub(super) const LARGEST: f64 = 1e12;
/// [`LARGEST`] in words.
pub(super) const RANGE: &str = "coordinates must be finite and at most 1e12 in size";
/// Smaller meshes are refused, so that products of coordinates do not underflow.
const SMALLEST: f64 = 1e-30;
/// Triangles thinner than this fraction of the extent have no meaningful normal.
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

/// The closed surface of the triangles with coincident vertices joined.
///
/// Exact duplicates are joined first, which preserves every detail of a correct file. Near vertices are joined only if the
/// surface is still open. Triangles whose corners lie on a line are removed if the surface closes without them, and kept
/// where they fill a T-junction.
pub(super) fn close(
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    weld: f64,
    warnings: &mut Vec<Warning>,
) -> Result<Surface, Error> {
    let first = positions.first().map(|p| p.to_array());
    let map = join_exact(&positions, &triangles);
    let mut exact = Joined::new(&positions, triangles, &map);
    drop((positions, map));
    let (low, high) = bounds(&exact.positions);
    let extent = (high - low).max_element();
    if exact.triangles.is_empty() || extent < SMALLEST {
        let message = "the mesh has no triangle with an area".to_owned();
        return Err(Error::Solid { message, place: first });
    }
    // The rounding of coordinates far from the origin.
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
        return mend(&exact, error, thin, extent, warnings);
    }
    let mut near = Joined::new(&exact.positions, exact.triangles, &map);
    drop((exact.positions, map));
    near.collapsed += exact.collapsed;
    near.repeated += exact.repeated;
    match near.surface(thin, extent) {
        Ok((surface, notes)) => {
            warnings.push(Warning::new(format!(
                "{joined} vertices were joined to others within {tolerance:.2e} to close the mesh"
            )));
            warnings.extend(notes);
            Ok(surface)
        }
        Err(error) if error.is_open => mend(&near, error, thin, extent, warnings),
        Err(error) => Err(error.into()),
    }
}

/// The surface with its hairline gaps closed, the widest of which a warning names; or how wide its gaps are.
fn mend(
    open: &Joined,
    error: Fault,
    thin: f64,
    extent: f64,
    warnings: &mut Vec<Warning>,
) -> Result<Surface, Error> {
    for tolerance in gap::TRIED.map(|share| share * extent) {
        let joined = gap::joined(&open.positions, &open.triangles, tolerance);
        let (map, mut widest) = joined.unwrap_or_else(|| ((0..open.positions.len() as u32).collect(), 0.0));
        let mut mended = Joined::new(&open.positions, open.triangles.clone(), &map);
        mended.collapsed += open.collapsed;
        mended.repeated += open.repeated;
        let mut surface = mended.surface(thin, extent);
        if surface.as_ref().is_err_and(|error| error.is_open)
            && let Some((stitched, apart)) = gap::stitched(&mended.positions, &mended.triangles, tolerance)
        {
            mended.triangles = stitched;
            widest = widest.max(apart);
            surface = mended.surface(thin, extent);
        }
        if let Ok((surface, notes)) = surface {
            let share = 100.0 * widest / extent;
            warnings.push(Warning::new(format!(
                "its surface had gaps, the largest {widest:.2e} wide ({share:.2} % of its size); they were closed"
            )));
            warnings.extend(notes);
            return Ok(surface);
        }
    }
    let widest = gap::widest(&open.positions, &open.triangles);
    let (share, most) = (100.0 * widest / extent, 100.0 * gap::WIDEST);
    let apart = format!(
        "; its largest opening is {widest:.2e} wide ({share:.2} % of its size), and gaps of up to {most} % are closed"
    );
    Err(error.with(if widest.is_finite() { &apart } else { "" }).into())
}

/// The triangles over joined vertices, whether or not they are closed.
pub(super) fn loose(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let map = join_exact(&positions, &triangles);
    let Joined { positions, triangles, .. } = Joined::new(&positions, triangles, &map);
    (positions, triangles)
}

/// Finds the first number with the same key. The hash table stores only numbers, a few bytes each.
struct Firsts {
    slots: Vec<u32>,
}

impl Firsts {
    /// For up to `count` numbers.
    fn new(count: usize) -> Self {
        Firsts { slots: vec![u32::MAX; (count + count / 2 + 1).next_power_of_two()] }
    }

    /// The first number with the key of `number`; itself if there is none before.
    fn of<K: Hash + Eq>(&mut self, number: u32, key: impl Fn(u32) -> K) -> u32 {
        let wanted = key(number);
        let mut at = FxBuildHasher.hash_one(&wanted) as usize;
        loop {
            at &= self.slots.len() - 1;
            match self.slots[at] {
                u32::MAX => {
                    self.slots[at] = number;
                    return number;
                }
                other if key(other) == wanted => return other,
                _ => at += 1,
            }
        }
    }
}

/// For each vertex, the first used vertex with the same coordinates.
fn join_exact(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    // Adding zero makes −0 and +0 the same.
    let key = |v: u32| (positions[v as usize] + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut firsts = Firsts::new(positions.len());
    let mut map = vec![u32::MAX; positions.len()];
    for &v in triangles.iter().flatten() {
        if map[v as usize] == u32::MAX {
            map[v as usize] = firsts.of(v, key);
        }
    }
    map
}

/// For each point, the first kept point within `tolerance`, or itself.
fn join_near(points: &[DVec3], low: DVec3, tolerance: f64) -> Vec<u32> {
    // Cells of eight times the tolerance: most points search one cell only, and few points share a cell.
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
    /// `map` has for each vertex the one it is joined to. Unused vertices are removed.
    fn new(positions: &[DVec3], mut triangles: Vec<[u32; 3]>, map: &[u32]) -> Self {
        let before = triangles.len();
        triangles.iter_mut().flatten().for_each(|v| *v = map[*v as usize]);
        triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
        let collapsed = before - triangles.len();
        let mut firsts = Firsts::new(triangles.len());
        let first: Vec<bool> = (0..triangles.len() as u32)
            .map(|number| firsts.of(number, |t| turned(triangles[t as usize])) == number)
            .collect();
        drop(firsts);
        let mut first = first.into_iter();
        triangles.retain(|_| first.next() == Some(true));
        let repeated = before - collapsed - triangles.len();
        let (positions, triangles) = used(positions, triangles);
        Joined { positions, triangles, collapsed, repeated }
    }

    /// The closed surface, with warnings about repairs. Triangles with a height below `thin` count as without area. Consumes
    /// the contents unless the surface is open.
    fn surface(&mut self, thin: f64, extent: f64) -> Result<(Surface, Vec<Warning>), Fault> {
        let solid = |t: &&[u32; 3]| polygon::height(t.map(|v| self.positions[v as usize])) > thin;
        let flat = self.triangles.len() - self.triangles.iter().filter(solid).count();
        let mut kept = Vec::new();
        let mut notes = Vec::new();
        let mut surface = None;
        if flat > 0 {
            let rest = self.triangles.iter().filter(solid).copied().collect();
            let (positions, mut rest) = used(&self.positions, rest);
            if let Ok(joints) = topology::build(&positions, &mut rest, extent, &mut kept) {
                note(&mut notes, self.collapsed + flat, "without area {were} left out");
                surface = Some((positions, rest, joints));
            }
        }
        let (positions, triangles, Joints { across, shells }) = match surface {
            Some(surface) => surface,
            None => {
                kept.clear();
                let joints = topology::build(&self.positions, &mut self.triangles, extent, &mut kept)?;
                note(&mut notes, self.collapsed, "without area {were} left out");
                let line = "whose corners lie on a line {were} kept, since the mesh is open without";
                note(&mut notes, flat, line);
                (take(&mut self.positions), take(&mut self.triangles), joints)
            }
        };
        note(&mut notes, self.repeated, "given more than once {were} taken once");
        notes.extend(kept);
        Ok((Surface { positions, triangles, across, shells, extent, thin }, notes))
    }
}

/// The corners with the lowest first: the same for every rotation of the triangle.
fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    let least = a.min(b).min(c);
    if least == a {
        [a, b, c]
    } else if least == b {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Reports what was done with `count` triangles, if there are any.
fn note(notes: &mut Vec<Warning>, count: usize, what: &str) {
    if count > 0 {
        let (s, were) = if count == 1 { ("", "was") } else { ("s", "were") };
        notes.push(Warning::new(format!("{count} triangle{s} {what}").replace("{were}", were)));
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
