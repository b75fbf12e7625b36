//! Topology: the triangle across each edge, closedness, orientation and shells.

use glam::DVec3;

use super::{bounds, signed_volume};
use crate::{Error, Warning};

/// No triangle: several shells touch along this edge.
pub(super) const NONE: u32 = u32::MAX;

/// A closed, oriented surface.
pub(super) struct Surface {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle, the triangle across its edge `k`, from corner `k` to corner `k + 1`; or [`NONE`].
    pub across: Vec<[u32; 3]>,
    pub shells: usize,
    /// Longest side of the bounding box.
    pub extent: f64,
    /// Height under which a triangle has no direction of its own.
    pub thin: f64,
}

/// How the triangles of a [`Surface`] are connected.
pub(super) struct Joints {
    pub across: Vec<[u32; 3]>,
    pub shells: usize,
}

/// Why triangles do not form a closed surface.
pub(super) struct Fault {
    message: String,
    place: DVec3,
    /// Whether joining vertices might close it.
    pub is_open: bool,
}

impl Fault {
    /// The same with more in its message.
    pub fn with(mut self, more: &str) -> Self {
        self.message.push_str(more);
        self
    }
}

impl From<Fault> for Error {
    fn from(fault: Fault) -> Self {
        Error::Solid { message: fault.message, place: Some(fault.place.to_array()) }
    }
}

/// The sides of edges, sorted by the lower vertex of the edge: those of vertex `v` are `sides[starts[v]..starts[v + 1]]`. Each
/// has the upper vertex and `4 · triangle + k`.
struct Sides {
    starts: Vec<u32>,
    sides: Vec<(u32, u32)>,
}

impl Sides {
    /// A counting sort, which takes linear time.
    fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0_u32; vertices + 1];
        for_each_side(triangles, |low, _, _| starts[low as usize + 1] += 1);
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut sides = vec![(0, 0); 3 * triangles.len()];
        // The starts serve as the next free places, so in the end each is that of the next vertex.
        for_each_side(triangles, |low, high, side| {
            let place = &mut starts[low as usize];
            sides[*place as usize] = (high, side);
            *place += 1;
        });
        starts.rotate_right(1);
        starts[0] = 0;
        for range in starts.windows(2) {
            sides[range[0] as usize..range[1] as usize].sort_unstable();
        }
        Sides { starts, sides }
    }

    /// The edges in order: the packed lower and upper vertex, and the sides.
    fn edges(&self) -> impl Iterator<Item = (u64, &[(u32, u32)])> {
        self.starts.windows(2).enumerate().flat_map(|(low, range)| {
            let around = &self.sides[range[0] as usize..range[1] as usize];
            let key = move |high: u32| ((low as u64) << 32) | u64::from(high);
            around.chunk_by(|a, b| a.0 == b.0).map(move |group| (key(group[0].0), group))
        })
    }
}

/// Calls `then` with the lower vertex, the upper vertex and the number `4 · triangle + k` of each side.
fn for_each_side(triangles: &[[u32; 3]], mut then: impl FnMut(u32, u32, u32)) {
    for (t, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            then(a.min(b), a.max(b), (4 * t + k) as u32);
        }
    }
}

/// Checks that the triangles form a closed surface, and orients them.
pub(super) fn build(
    positions: &[DVec3],
    triangles: &mut [[u32; 3]],
    extent: f64,
    warnings: &mut Vec<Warning>,
) -> Result<Joints, Fault> {
    let sides = Sides::new(positions.len(), triangles);
    let mut across = pair(positions, triangles, &sides)?;
    let (shell_of, shells, flipped) = orient(positions, triangles, &across)?;
    let turned = flipped.iter().filter(|&&f| f).count();
    if turned > 0 {
        warnings.push(Warning::new(format!(
            "{turned} triangles were wound against their neighbours and were turned"
        )));
    }
    for (t, _) in flipped.iter().enumerate().filter(|(_, f)| **f) {
        flip(&mut triangles[t], &mut across[t]);
    }
    check_balance(positions, triangles, &sides)?;
    drop(sides);
    let volume = signed_volume(positions, triangles);
    if volume.abs() <= 1e-12 * extent.powi(3) {
        let message = "the mesh encloses no volume: its surface lies on itself".to_owned();
        let place = positions.first().copied().unwrap_or_default();
        return Err(Fault { message, place, is_open: false });
    }
    if volume < 0.0 {
        warnings.push(Warning::new("the mesh was inside out (its triangles faced inwards) and was turned"));
        triangles.iter_mut().zip(&mut across).for_each(|(t, a)| flip(t, a));
    }
    note_cavities(positions, triangles, &shell_of, shells, warnings);
    Ok(Joints { across, shells })
}

/// Pairs the two sides of each edge. At edges with an even number of sides, four or more, shells touch: they stay unpaired,
/// and [`check_balance`] checks them after the orientation.
fn pair(positions: &[DVec3], triangles: &[[u32; 3]], sides: &Sides) -> Result<Vec<[u32; 3]>, Fault> {
    let mut across = vec![[NONE; 3]; triangles.len()];
    let (mut open, mut odd) = ((0_usize, 0_u64), (0_usize, 0_u64));
    for (key, group) in sides.edges() {
        match group {
            [(_, a), (_, b)] => {
                across[(a / 4) as usize][(a % 4) as usize] = b / 4;
                across[(b / 4) as usize][(b % 4) as usize] = a / 4;
            }
            [_] => open = (open.0 + 1, if open.0 == 0 { key } else { open.1 }),
            _ if group.len() % 2 == 1 => odd = (odd.0 + 1, if odd.0 == 0 { key } else { odd.1 }),
            _ => {}
        }
    }
    if odd.0 > 0 {
        let what = "non-manifold mesh: N edge{s} {are} shared by an odd number of triangles, three or more";
        return Err(at_edge(positions, what, odd));
    }
    if open.0 > 0 {
        let what = "open mesh: N edge{s} {have} a triangle on one side only";
        return Err(Fault { is_open: true, ..at_edge(positions, what, open) });
    }
    Ok(across)
}

/// The fault at `count` edges, of which the first has the vertices packed in `key`; `what` says "N edge{s}" and
/// "{have}" or "{are}".
fn at_edge(positions: &[DVec3], what: &str, (count, key): (usize, u64)) -> Fault {
    let [a, b] = [key >> 32, key & 0xffff_ffff].map(|v| positions[v as usize]);
    let one = count == 1;
    let head = what
        .replace('N', &count.to_string())
        .replace("{s}", if one { "" } else { "s" })
        .replace("{have}", if one { "has" } else { "have" })
        .replace("{are}", if one { "is" } else { "are" });
    let first = if one { "" } else { "the first " };
    let message =
        format!("{head}, {first}between ({}, {}, {}) and ({}, {}, {})", a.x, a.y, a.z, b.x, b.y, b.z);
    Fault { message, place: 0.5 * (a + b), is_open: false }
}

/// Traverses each shell and finds the triangles wound against the majority. Returns the shell of each triangle, the number
/// of shells, and whether to reverse each triangle.
fn orient(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    across: &[[u32; 3]],
) -> Result<(Vec<u32>, usize, Vec<bool>), Fault> {
    let mut shell_of = vec![NONE; triangles.len()];
    let mut flipped = vec![false; triangles.len()];
    let (mut shells, mut members) = (0, Vec::<u32>::new());
    for seed in 0..triangles.len() {
        if shell_of[seed] != NONE {
            continue;
        }
        shell_of[seed] = shells;
        members.clear();
        members.push(seed as u32);
        let mut next = 0;
        while let Some(&t) = members.get(next) {
            let t = t as usize;
            next += 1;
            for k in 0..3 {
                let u = across[t][k] as usize;
                if across[t][k] == NONE {
                    continue;
                }
                let (a, b) = (triangles[t][k], triangles[t][(k + 1) % 3]);
                let wanted = flipped[t] ^ runs(&triangles[u], a, b);
                if shell_of[u] == NONE {
                    shell_of[u] = shells;
                    flipped[u] = wanted;
                    members.push(u as u32);
                } else if flipped[u] != wanted {
                    let key = (u64::from(a) << 32) | u64::from(b);
                    let what = "the mesh cannot be oriented (like a Möbius strip it has one side): no winding suits N edge";
                    return Err(at_edge(positions, what, (1, key)));
                }
            }
        }
        if 2 * members.iter().filter(|&&t| flipped[t as usize]).count() > members.len() {
            members.iter().for_each(|&t| flipped[t as usize] ^= true);
        }
        shells += 1;
    }
    Ok((shell_of, shells as usize, flipped))
}

/// Whether the triangle has an edge running from `a` to `b`.
fn runs(triangle: &[u32; 3], a: u32, b: u32) -> bool {
    (0..3).any(|k| triangle[k] == a && triangle[(k + 1) % 3] == b)
}

/// Reverses a triangle; edge `k` is then the old edge `2 − k`.
pub(super) fn flip(triangle: &mut [u32; 3], across: &mut [u32; 3]) {
    triangle.swap(1, 2);
    across.swap(0, 2);
}

/// Where shells touch along an edge, the same number of triangles must have it in either direction.
fn check_balance(positions: &[DVec3], triangles: &[[u32; 3]], sides: &Sides) -> Result<(), Fault> {
    let mut bad = (0, 0);
    for (key, group) in sides.edges().filter(|(_, group)| group.len() > 2) {
        let low = (key >> 32) as u32;
        let forward =
            group.iter().filter(|(_, s)| runs(&triangles[(s / 4) as usize], low, key as u32)).count();
        if 2 * forward != group.len() {
            bad = (bad.0 + 1, if bad.0 == 0 { key } else { bad.1 });
        }
    }
    if bad.0 == 0 {
        return Ok(());
    }
    Err(at_edge(
        positions,
        "non-manifold mesh: N edge{s} {are} run along one way by more triangles than the other",
        bad,
    ))
}

fn note_cavities(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    shell_of: &[u32],
    shells: usize,
    warnings: &mut Vec<Warning>,
) {
    if shells < 2 {
        return;
    }
    let (low, high) = bounds(positions);
    let mut volumes = vec![0.0; shells];
    for (triangle, &shell) in triangles.iter().zip(shell_of) {
        let [a, b, c] = triangle.map(|v| positions[v as usize] - 0.5 * (low + high));
        volumes[shell as usize] += a.dot(b.cross(c));
    }
    let inward = volumes.iter().filter(|&&v| v < 0.0).count();
    if inward > 0 {
        warnings.push(Warning::new(format!(
            "{inward} of the mesh's {shells} shells face inwards and are taken as cavities"
        )));
    }
}
