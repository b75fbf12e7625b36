//! Polygons cut into triangles that use every corner.

use earcut::{Earcut, utils3d::project3d_to_2d};
use glam::DVec3;

/// The optimum costs the cube of the count: of polygons with more corners ears are clipped, and convex ones are halved by
/// a chord.
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
    if n > OPTIMAL_UP_TO {
        clip(positions, corners, triangles);
        return Ok(());
    }
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

/// By ears, with the crate `earcut`, which leaves out corners on straight edges: they are put back, each by cutting the
/// triangle at its edge in two. What cannot be cut like this, such as an outline that crosses itself, becomes a fan.
fn clip(positions: &[DVec3], corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let n = corners.len() as u32;
    // From the first corner and in units of the extent, so that no digits are lost, wherever and how small it is.
    let arm = |corner: &u32| positions[*corner as usize] - positions[corners[0] as usize];
    let extent =
        corners.iter().map(|corner| arm(corner).abs().max_element()).fold(f64::MIN_POSITIVE, f64::max);
    let points: Vec<[f64; 3]> = corners.iter().map(|corner| (arm(corner) / extent).to_array()).collect();
    let (mut flat, mut cut) = (Vec::new(), Vec::new());
    if project3d_to_2d(&points, points.len(), &mut flat) {
        Earcut::new().earcut(flat, &[], &mut cut);
    }
    let mut clipped = with_every_corner(n, &cut);
    if clipped.len() + 2 != n as usize {
        clipped = (1..n - 1).map(|k| [0, k, k + 1]).collect();
    }
    triangles.extend(clipped.iter().map(|triangle| triangle.map(|k| corners[k as usize])));
}

/// Triangles of a polygon's `n` corners, each in the order of the outline, with the corners that `cut` leaves out.
fn with_every_corner(n: u32, cut: &[u32]) -> Vec<[u32; 3]> {
    let mut used = vec![false; n as usize];
    cut.iter().for_each(|&corner| used[corner as usize] = true);
    let ahead = |from: u32, to: u32| (to + n - from) % n;
    // A side of the polygon, but for corners between its ends that are not used.
    let hides = |from: u32, to: u32| {
        ahead(from, to) > 1 && (1..ahead(from, to)).all(|step| !used[((from + step) % n) as usize])
    };
    let mut open: Vec<[u32; 3]> = cut.as_chunks().0.to_vec();
    let mut whole = Vec::new();
    while let Some([a, b, c]) = open.pop() {
        let [a, b, c] = if ahead(a, b) < ahead(a, c) { [a, b, c] } else { [a, c, b] };
        match [[a, b, c], [b, c, a], [c, a, b]].into_iter().find(|&[from, to, _]| hides(from, to)) {
            Some([from, to, apex]) => {
                let next = (from + 1) % n;
                open.extend([[from, next, apex], [next, to, apex]]);
            }
            None => whole.push([a, b, c]),
        }
    }
    whole
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
    fn polygons_of_many_corners_are_cut_by_their_ears() {
        let round = |n: usize, radius: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
            let angle = |k: usize| std::f64::consts::TAU * k as f64 / n as f64;
            (0..n).map(|k| [radius(k) * angle(k).cos(), radius(k) * angle(k).sin()]).collect()
        };
        // A comb of 250 teeth, and a square with 1,000 corners on its edges.
        let tooth = |k: usize| {
            let x = k as f64;
            [[x, 0.0], [x + 0.5, 0.0], [x + 0.5, 1.0], [x + 1.0, 1.0]]
        };
        let comb: Vec<[f64; 2]> = (0..250).flat_map(tooth).chain([[250.0, 2.0], [0.0, 2.0]]).collect();
        let side = |k: usize| (k % 250) as f64 / 250.0;
        let square = (0..1000).map(|k| match k / 250 {
            0 => [side(k), 0.0],
            1 => [1.0, side(k)],
            2 => [1.0 - side(k), 1.0],
            _ => [0.0, 1.0 - side(k)],
        });
        let shapes = [
            ("circle", round(1024, &|_| 1.0)),
            ("star", round(1024, &|k| if k % 2 == 0 { 1.0 } else { 0.5 })),
            ("comb", comb),
            ("square", square.collect()),
        ];
        for (name, points) in shapes {
            let next = |k: usize| points[(k + 1) % points.len()];
            let cross = |k: usize| points[k][0] * next(k)[1] - next(k)[0] * points[k][1];
            let shoelace: f64 = (0..points.len()).map(cross).sum::<f64>() / 2.0;
            let (sum, least) = areas(&points);
            assert!((sum / shoelace - 1.0).abs() < 1e-9 && least > 0.0, "{name}: {sum} {shoelace} {least}");
        }
        // What is no polygon becomes triangles all the same: the mesh will say what is wrong with it.
        areas(&[[0.0; 2]; 60]);
        areas(&(0..60).map(|k| [f64::from(k), 0.0]).collect::<Vec<_>>());
        areas(&round(101, &|k| if k % 2 == 0 { 1.0 } else { -1.0 }));
    }

    #[test]
    fn too_many_corners_are_refused() {
        let positions = vec![DVec3::ZERO; 2000];
        let corners: Vec<u32> = (0..2000).collect();
        assert!(triangulate(&positions, &corners, &mut Vec::new()).unwrap_err().contains("2000 corners"));
    }
}
