//! Polygons cut into triangles that use every corner.

use glam::DVec3;

/// Convex polygons with more corners are halved by a chord first, since the optimum costs the cube of the count.
const OPTIMAL_UP_TO: usize = 48;
/// The most corners of a polygon that need not be convex.
const MAX_CORNERS: usize = 1024;

/// Appends the triangles of the polygon `corners` (indices into `positions`, all valid), convex or not.
///
/// A corner on a straight edge must not be lost in a triangle without area, since a neighbouring face uses it, too, and
/// the mesh would come apart there. Where every triangle turns as the polygon does, together they cover it exactly once,
/// so that notches need no test of their own.
///
/// # Errors
/// A message for people about a polygon with too many corners.
pub fn triangulate(
    positions: &[DVec3],
    corners: &[u32],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), String> {
    let n = corners.len();
    if let [a, b, c] = *corners {
        triangles.push([a, b, c]);
        return Ok(());
    }
    if n > MAX_CORNERS {
        return Err(format!("a polygon with {n} corners; at most {MAX_CORNERS} are read, split it"));
    }
    let point = |k: usize| positions[corners[k % n] as usize];
    // Newell's normal: twice the vector area, right for polygons that are not convex and not quite flat.
    let normal: DVec3 = (0..n).map(|k| point(k).cross(point(k + 1))).sum();
    optimal(positions, corners, |[a, b, c]| (b - a).cross(c - a).dot(normal) / longest([a, b, c]), triangles);
    Ok(())
}

/// The same for a convex polygon of any number of corners.
pub(super) fn triangulate_convex(positions: &[DVec3], corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let n = corners.len();
    if n > OPTIMAL_UP_TO {
        let half = n / 2;
        triangulate_convex(positions, &corners[..=half], triangles);
        let rest: Vec<u32> = corners[half..].iter().chain(&corners[..1]).copied().collect();
        triangulate_convex(positions, &rest, triangles);
    } else {
        optimal(positions, corners, height, triangles);
    }
}

/// Of all triangulations the one whose thinnest triangle is the thickest: a fan would make triangles without area wherever
/// three corners lie on a line, as they do where facets meet in a row (Klincsek 1980, with the minimum in place of the sum).
fn optimal(
    positions: &[DVec3],
    corners: &[u32],
    thickness: impl Fn([DVec3; 3]) -> f64,
    triangles: &mut Vec<[u32; 3]>,
) {
    let n = corners.len();
    // best[i·n + j]: the thinnest triangle of the best triangulation of corners i to j, and the apex over i–j.
    let mut best = vec![(f64::INFINITY, 0_usize); n * n];
    for span in 2..n {
        for i in 0..n - span {
            let j = i + span;
            best[i * n + j] = (i + 1..j)
                .map(|k| {
                    let own = thickness([i, k, j].map(|c| positions[corners[c] as usize]));
                    (own.min(best[i * n + k].0).min(best[k * n + j].0), k)
                })
                .fold((f64::NEG_INFINITY, i + 1), |a, b| if b.0 > a.0 { b } else { a });
        }
    }
    let mut open = vec![(0, n.saturating_sub(1))];
    while let Some((i, j)) = open.pop() {
        if j >= i + 2 {
            let k = best[i * n + j].1;
            triangles.push([corners[i], corners[k], corners[j]]);
            open.extend([(i, k), (k, j)]);
        }
    }
}

fn longest([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared()).sqrt()
}

/// The least height of a triangle: twice its area over its longest side.
pub(super) fn height([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = longest([a, b, c]);
    if longest > 0.0 { (b - a).cross(c - a).length() / longest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas(points: &[[f64; 2]]) -> (f64, f64) {
        let positions: Vec<DVec3> = points.iter().map(|p| DVec3::new(p[0], p[1], 0.0)).collect();
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        let mut triangles = Vec::new();
        triangulate(&positions, &corners, &mut triangles).unwrap();
        assert_eq!(triangles.len(), points.len() - 2);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            (b - a).cross(c - a).z / 2.0
        };
        (triangles.iter().map(area).sum(), triangles.iter().map(area).fold(f64::INFINITY, f64::min))
    }

    #[test]
    fn an_arrow_head_keeps_its_notch() {
        let (sum, least) = areas(&[[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]]);
        assert!((sum - 0.5).abs() < 1e-12 && least > 0.0, "{sum} {least}");
    }

    #[test]
    fn corners_on_a_straight_edge_make_no_empty_triangles() {
        let square = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
        let (sum, least) = areas(&square);
        assert!((sum - 9.0).abs() < 1e-12 && least > 0.1, "{sum} {least}");
    }

    #[test]
    fn a_spiral_is_covered_exactly() {
        let spiral: Vec<[f64; 2]> = (0..40)
            .map(|i| (f64::from(i) * 0.4, 1.0 + f64::from(i) * 0.1))
            .chain((0..40).rev().map(|i| (f64::from(i) * 0.4, 0.5 + f64::from(i) * 0.1)))
            .map(|(t, r)| [r * t.cos(), r * t.sin()])
            .collect();
        let shoelace: f64 = (0..80)
            .map(|i| {
                let ([ax, ay], [bx, by]) = (spiral[i], spiral[(i + 1) % 80]);
                (ax * by - ay * bx) / 2.0
            })
            .sum();
        let (sum, least) = areas(&spiral);
        assert!((sum - shoelace.abs()).abs() < 1e-9 && least >= 0.0, "{sum} {shoelace} {least}");
    }

    #[test]
    fn too_many_corners_are_refused() {
        let positions = vec![DVec3::ZERO; 2000];
        let corners: Vec<u32> = (0..2000).collect();
        assert!(triangulate(&positions, &corners, &mut Vec::new()).unwrap_err().contains("2000 corners"));
    }
}
