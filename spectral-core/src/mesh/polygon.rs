//! The triangulation of a convex polygon with the thickest triangles.

use glam::DVec3;

/// Larger polygons are halved by a chord first, since the optimum takes cubic time.
const OPTIMAL_UP_TO: usize = 48;

/// Appends the triangles of the convex polygon `corners` (indices into `positions`) to `triangles`.
///
/// The thinnest triangle is as thick as possible. A fan would have triangles without area where three corners lie on a
/// line, as they do where several facets meet along one edge.
pub(super) fn triangulate(positions: &[DVec3], corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let n = corners.len();
    if n > OPTIMAL_UP_TO {
        let half = n / 2;
        triangulate(positions, &corners[..=half], triangles);
        let rest: Vec<u32> = corners[half..].iter().chain(&corners[..1]).copied().collect();
        triangulate(positions, &rest, triangles);
        return;
    }
    // best[i][j]: the smallest height in the best triangulation of corners i..=j, and the apex over chord i–j (Klincsek
    // 1980, with the minimum in place of the sum).
    let mut best = vec![(f64::INFINITY, 0_usize); n * n];
    for span in 2..n {
        for i in 0..n - span {
            let j = i + span;
            best[i * n + j] = (i + 1..j)
                .map(|k| {
                    let own = height([i, k, j].map(|c| positions[corners[c] as usize]));
                    (own.min(best[i * n + k].0).min(best[k * n + j].0), k)
                })
                .fold((f64::NEG_INFINITY, i + 1), |a, b| if b.0 > a.0 { b } else { a });
        }
    }
    let mut open = vec![(0, n.saturating_sub(1))];
    while let Some((i, j)) = open.pop() {
        if j < i + 2 {
            continue;
        }
        let k = best[i * n + j].1;
        triangles.push([corners[i], corners[k], corners[j]]);
        open.push((i, k));
        open.push((k, j));
    }
}

/// The least height of a triangle: twice its area over its longest side.
pub(super) fn height([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared()).sqrt();
    if longest > 0.0 { (b - a).cross(c - a).length() / longest } else { 0.0 }
}
