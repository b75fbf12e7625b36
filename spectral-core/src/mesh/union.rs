//! The volume and the surface of a union of solids.
//!
//! Of each triangle the part counts that lies in no other solid: the other solids cut its plane in oriented segments,
//! between which the covered area is a sum of trapezoids. The volume is then that of the cones over these parts.

use super::{Mesh, proximity::Corners};
use glam::{DVec2, DVec3};

/// Of two solids the first is taken to be larger by this share of the extent, so that no two faces lie in one plane.
const LARGER: f64 = 1e-8;

/// Every triangle is compared with all others, so larger meshes are not measured.
pub(super) const MOST_TRIANGLES: usize = 30_000;

/// A solid's triangles, as they are and a little larger.
struct Solid {
    exact: Vec<Corners>,
    larger: Vec<Corners>,
}

/// A segment in a triangle's plane, from left to right.
struct Segment {
    ends: [DVec2; 2],
    solid: usize,
    /// 1 where the solid lies above the segment, −1 where it lies below.
    turn: i32,
}

impl Segment {
    fn height(&self, x: f64) -> Option<f64> {
        let [a, b] = self.ends;
        (a.x < x && x < b.x).then(|| a.y + (b.y - a.y) * ((x - a.x) / (b.x - a.x)))
    }
}

/// The volume that the solids of a mesh take up together, and their common surface.
pub(super) fn measure(mesh: &Mesh) -> (f64, f64) {
    let solids = solids(mesh);
    let (low, high) = mesh.bounds();
    let middle = 0.5 * (low + high);
    let (mut volume, mut area) = (0.0, 0.0);
    for (number, solid) in solids.iter().enumerate() {
        for (k, triangle) in solid.exact.iter().enumerate() {
            let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
            let whole = 0.5 * normal.length();
            if whole == 0.0 {
                continue;
            }
            let open = whole - covered(&solids, number, k);
            area += open;
            volume += open * normal.normalize().dot(triangle[0] - middle) / 3.0;
        }
    }
    (volume, area)
}

fn solids(mesh: &Mesh) -> Vec<Solid> {
    let (low, high) = mesh.bounds();
    let step = LARGER * (high - low).max_element();
    let mut away = vec![DVec3::ZERO; mesh.positions.len()];
    for (triangle, &facet) in mesh.triangles.iter().zip(&mesh.facet_of) {
        triangle.iter().for_each(|&v| away[v as usize] += mesh.facets[facet as usize].plane.normal);
    }
    let exact = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
    let larger =
        |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize] + step * away[v as usize].normalize_or_zero());
    let solid = |range: std::ops::Range<u32>| {
        let own = &mesh.triangles[range.start as usize..range.end as usize];
        Solid { exact: own.iter().map(exact).collect(), larger: own.iter().map(larger).collect() }
    };
    mesh.solids().map(solid).collect()
}

/// The area of a triangle that lies within other solids.
fn covered(solids: &[Solid], number: usize, k: usize) -> f64 {
    let [a, b, c] = solids[number].exact[k];
    let normal = (b - a).cross(c - a).normalize();
    let across = (b - a).normalize();
    let up = normal.cross(across);
    let flat = |p: DVec3| DVec2::new(across.dot(p - a), up.dot(p - a));
    let corners = [a, b, c].map(flat);
    let [left, right] = extent(corners);
    let mut segments = Vec::new();
    for (other, solid) in solids.iter().enumerate().filter(|(other, _)| *other != number) {
        let (triangle, others) = if number < other {
            (solids[number].larger[k], &solid.exact)
        } else {
            (solids[number].exact[k], &solid.larger)
        };
        let sections = others.iter().filter_map(|cut| section(triangle[0], normal, cut, flat, other));
        segments.extend(sections.filter(|segment| segment.ends[0].x < right && left < segment.ends[1].x));
    }
    if segments.is_empty() { 0.0 } else { area_within(corners, &segments, solids.len()) }
}

/// Where a triangle crosses the plane through a point.
fn section(
    point: DVec3,
    normal: DVec3,
    cut: &Corners,
    flat: impl Fn(DVec3) -> DVec2,
    solid: usize,
) -> Option<Segment> {
    let heights = cut.map(|p| normal.dot(p - point));
    let mut ends = (0..3).filter_map(|k| {
        let (p, q) = (heights[k], heights[(k + 1) % 3]);
        ((p > 0.0) != (q > 0.0)).then(|| cut[k] + (cut[(k + 1) % 3] - cut[k]) * (p / (p - q)))
    });
    let (p, q) = (ends.next()?, ends.next()?);
    // The solid lies to the left of this direction.
    let direction = normal.cross((cut[1] - cut[0]).cross(cut[2] - cut[0]));
    let forward = direction.dot(q - p) > 0.0;
    let [p, q] = [p, q].map(flat);
    let [from, to] = if forward { [p, q] } else { [q, p] };
    let (ends, turn) = if from.x < to.x { ([from, to], 1) } else { ([to, from], -1) };
    Some(Segment { ends, solid, turn })
}

/// The least and the greatest abscissa.
fn extent(corners: [DVec2; 3]) -> [f64; 2] {
    let [a, b, c] = corners.map(|p| p.x);
    [a.min(b).min(c), a.max(b).max(c)]
}

/// The area of a triangle within any of the solids that the segments bound.
fn area_within(corners: [DVec2; 3], segments: &[Segment], solids: usize) -> f64 {
    let edge = |k: usize| {
        let (p, q) = (corners[k], corners[(k + 1) % 3]);
        Segment { ends: if p.x < q.x { [p, q] } else { [q, p] }, solid: 0, turn: 0 }
    };
    let edges = [0, 1, 2].map(edge);
    let lines: Vec<&Segment> = segments.iter().chain(&edges).collect();
    let mut places: Vec<f64> = lines.iter().flat_map(|line| line.ends.map(|end| end.x)).collect();
    for (k, a) in lines.iter().enumerate() {
        places.extend(lines[..k].iter().filter_map(|b| crossing(a.ends, b.ends)));
    }
    let [left, right] = extent(corners);
    places.retain(|x| (left..=right).contains(x));
    places.sort_by(f64::total_cmp);
    places
        .windows(2)
        .map(|pair| (pair[1] - pair[0]) * length_within(&edges, segments, 0.5 * (pair[0] + pair[1]), solids))
        .sum()
}

/// The length of the upright line at `x` that lies in the triangle and in any of the solids.
fn length_within(edges: &[Segment; 3], segments: &[Segment], x: f64, solids: usize) -> f64 {
    let mut bounds = edges.iter().filter_map(|edge| edge.height(x));
    let (Some(p), Some(q)) = (bounds.next(), bounds.next()) else { return 0.0 };
    let (low, high) = (p.min(q), p.max(q));
    let mut turns: Vec<(f64, &Segment)> = segments.iter().filter_map(|s| Some((s.height(x)?, s))).collect();
    turns.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut winding, mut at, mut length) = (vec![0; solids], low, 0.0);
    for (height, segment) in turns {
        let to = height.clamp(at, high.max(at));
        if winding.iter().any(|turns| *turns > 0) {
            length += to - at;
        }
        at = to;
        winding[segment.solid] += segment.turn;
    }
    length
}

/// The abscissa at which two segments cross.
fn crossing([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> Option<f64> {
    let (u, v) = (b - a, d - c);
    let share = (c - a).perp_dot(v) / u.perp_dot(v);
    let other = (c - a).perp_dot(u) / u.perp_dot(v);
    ((0.0..=1.0).contains(&share) && (0.0..=1.0).contains(&other)).then_some(a.x + share * u.x)
}
