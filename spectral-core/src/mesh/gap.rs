//! Gaps along the edges of a surface that is nearly closed: how wide they are, and how hairline ones are mended.
//!
//! Programs that write the parts of a stone one by one leave them apart by their rounding. Only vertices at open edges are moved,
//! so that details elsewhere stay.

use glam::DVec3;
use rustc_hash::FxHashMap;

/// The widest gap that is mended, as a fraction of the extent.
pub(super) const WIDEST: f64 = 1e-3;
/// What is tried, as fractions of the extent: the least that closes the surface is taken.
pub(super) const TRIED: [f64; 5] = [1e-6, 1e-5, 1e-4, 3e-4, WIDEST];
/// More open vertices are not compared with each other.
const MOST: usize = 20_000;

/// The open edges, each from corner to corner as its triangle has it, with this triangle's number.
fn open_edges(triangles: &[[u32; 3]]) -> Vec<(u32, u32, usize)> {
    let mut sides: FxHashMap<(u32, u32), (usize, u32, u32, usize)> = FxHashMap::default();
    for (t, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            sides.entry((a.min(b), a.max(b))).or_insert((0, a, b, t)).0 += 1;
        }
    }
    let mut open: Vec<_> =
        sides.into_values().filter(|side| side.0 == 1).map(|(_, a, b, t)| (a, b, t)).collect();
    open.sort_unstable_by_key(|&(a, b, t)| (t, a, b));
    open
}

fn ends(open: &[(u32, u32, usize)]) -> Vec<u32> {
    let mut vertices: Vec<u32> = open.iter().flat_map(|&(a, b, _)| [a, b]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// For each vertex the one that it is joined to across a gap of at most `tolerance`, and the widest gap joined; `None` where no
/// vertices are so near.
pub(super) fn joined(positions: &[DVec3], triangles: &[[u32; 3]], tolerance: f64) -> Option<(Vec<u32>, f64)> {
    let open = ends(&open_edges(triangles));
    let mut map: Vec<u32> = (0..positions.len() as u32).collect();
    let cell = |p: DVec3| (p / tolerance).floor().to_array().map(|c| c as i64);
    let mut kept: FxHashMap<[i64; 3], Vec<u32>> = FxHashMap::default();
    let mut widest = 0.0_f64;
    for v in open {
        let p = positions[v as usize];
        let [x, y, z] = cell(p);
        let around =
            (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
        let near = around.filter_map(|cell| kept.get(&cell)).flatten();
        let apart = |w: &u32| positions[*w as usize].distance(p);
        match near.copied().min_by(|a, b| apart(a).total_cmp(&apart(b))).filter(|w| apart(w) <= tolerance) {
            Some(w) => {
                widest = widest.max(apart(&w));
                map[v as usize] = w;
            }
            None => kept.entry(cell(p)).or_default().push(v),
        }
    }
    (widest > 0.0).then_some((map, widest))
}

/// The triangles with each open edge cut at the open vertices that lie within `tolerance` of it; `None` where there are none. A
/// seam whose two sides have different vertices meets then.
pub(super) fn stitched(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    tolerance: f64,
) -> Option<(Vec<[u32; 3]>, f64)> {
    let open = open_edges(triangles);
    let vertices = ends(&open);
    if open.is_empty() || vertices.len() > MOST {
        return None;
    }
    let (mut cut, mut widest): (FxHashMap<usize, Vec<Vec<u32>>>, f64) = (FxHashMap::default(), 0.0);
    for (a, b, t) in open {
        let (from, to) = (positions[a as usize], positions[b as usize]);
        let along = to - from;
        let place = |v: u32| {
            let share = (positions[v as usize] - from).dot(along) / along.length_squared();
            (share, positions[v as usize].distance(from + share * along))
        };
        let beside = |v: &u32| {
            let (share, apart) = place(*v);
            let end = tolerance / along.length();
            ![a, b].contains(v) && share > end && share < 1.0 - end && apart <= tolerance
        };
        let mut between: Vec<u32> = vertices.iter().copied().filter(beside).collect();
        if !between.is_empty() {
            between.sort_by(|v, w| place(*v).0.total_cmp(&place(*w).0));
            widest = between.iter().map(|v| place(*v).1).fold(widest, f64::max);
            let chain: Vec<u32> = std::iter::once(a).chain(between).chain([b]).collect();
            cut.entry(t).or_default().push(chain);
        }
    }
    if cut.is_empty() {
        return None;
    }
    let mut whole = Vec::with_capacity(triangles.len());
    for (t, triangle) in triangles.iter().enumerate() {
        match cut.get(&t) {
            Some(chains) => fan(positions, triangle, chains, &mut whole),
            None => whole.push(*triangle),
        }
    }
    Some((whole, widest))
}

/// A triangle whose sides are chains of vertices, as triangles.
fn fan(positions: &[DVec3], triangle: &[u32; 3], chains: &[Vec<u32>], whole: &mut Vec<[u32; 3]>) {
    let side = |k: usize| {
        let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
        let chain = chains.iter().find(|chain| chain[0] == a && chain[chain.len() - 1] == b);
        chain.map_or_else(|| vec![a], |chain| chain[..chain.len() - 1].to_vec())
    };
    let outline: Vec<u32> = (0..3).flat_map(side).collect();
    // It has few corners and is convex but for the tolerance.
    super::polygon::triangulate_convex(positions, &outline, whole);
}

/// How far the surface is from being closed: of its openings the widest. An opening between two rims is as wide as they are apart,
/// one with a single rim as wide as that.
pub(super) fn widest(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let open = open_edges(triangles);
    let rims = rims(&open);
    let points = |rim: &[u32]| rim.iter().map(|v| positions[*v as usize]).collect::<Vec<_>>();
    let rims: Vec<Vec<DVec3>> = rims.iter().map(|rim| points(rim)).collect();
    if rims.iter().map(Vec::len).sum::<usize>() > MOST {
        return f64::INFINITY;
    }
    let across = |(own, rim): (usize, &Vec<DVec3>)| {
        let (low, high) = super::bounds(rim);
        let others =
            || rims.iter().enumerate().filter(move |(other, _)| *other != own).flat_map(|(_, rim)| rim);
        let nearest = |p: &DVec3| others().map(|q| p.distance(*q)).fold(f64::INFINITY, f64::min);
        rim.iter().map(nearest).fold(0.0, f64::max).min((high - low).max_element())
    };
    rims.iter().enumerate().map(across).fold(0.0, f64::max)
}

/// The vertices of open edges that hang together.
fn rims(open: &[(u32, u32, usize)]) -> Vec<Vec<u32>> {
    let mut beside: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    for &(a, b, _) in open {
        beside.entry(a).or_default().push(b);
        beside.entry(b).or_default().push(a);
    }
    let mut rims = Vec::new();
    for seed in ends(open) {
        let Some(first) = beside.remove(&seed) else { continue };
        let (mut rim, mut next) = (vec![seed], first);
        while let Some(v) = next.pop() {
            if let Some(more) = beside.remove(&v) {
                rim.push(v);
                next.extend(more);
            }
        }
        rims.push(rim);
    }
    rims
}
