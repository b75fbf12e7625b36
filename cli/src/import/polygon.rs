//! Polygons of meshes cut into triangles that use every corner.

use glam::DVec3;

/// The most corners of a polygon that is not convex: clipping its ears costs the square to the cube of them.
const MAX_CORNERS: usize = 1024;

/// Appends the triangles of the polygon `corners` (indices into `positions`, all valid).
///
/// Ears are clipped thickest first, so that corners on a straight edge are not lost in triangles without
/// area: a neighbouring face uses them too, and the mesh would come apart there.
pub(super) fn triangulate(
    positions: &[DVec3],
    corners: &[u32],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), String> {
    match *corners {
        [a, b, c] => triangles.push([a, b, c]),
        _ if corners.len() > MAX_CORNERS => {
            let count = corners.len();
            return Err(format!("a polygon with {count} corners; at most {MAX_CORNERS} are read, split it"));
        }
        _ => clip(positions, corners.to_vec(), triangles),
    }
    Ok(())
}

fn clip(positions: &[DVec3], mut ring: Vec<u32>, triangles: &mut Vec<[u32; 3]>) {
    let at = |i: u32| positions[i as usize];
    // Newell's normal: twice the vector area, right for polygons that are not convex and not quite flat.
    let normal: DVec3 = (0..ring.len()).map(|k| at(ring[k]).cross(at(ring[(k + 1) % ring.len()]))).sum();
    let turn = |[a, b, c]: [u32; 3]| (at(b) - at(a)).cross(at(c) - at(b)).dot(normal);
    let around = |ring: &[u32], k: usize| {
        let n = ring.len();
        [ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]]
    };
    while ring.len() > 3 {
        let reflex: Vec<u32> = (0..ring.len())
            .map(|k| around(&ring, k))
            .filter(|ear| turn(*ear) < 0.0)
            .map(|[_, b, _]| b)
            .collect();
        let empty = |ear: [u32; 3]| !reflex.iter().any(|p| !ear.contains(p) && inside(&turn, ear, *p));
        let best = (0..ring.len())
            .map(|k| (thickness(&turn, around(&ring, k).map(at), around(&ring, k)), k))
            .filter(|(height, k)| *height > 0.0 && empty(around(&ring, *k)))
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        // A polygon that crosses itself may have no ear left; whatever closes it goes to the mesh's own checks.
        let k = best.map_or(0, |(_, k)| k);
        triangles.push(around(&ring, k));
        ring.remove(k);
    }
    if let [a, b, c] = ring[..] {
        triangles.push([a, b, c]);
    }
}

/// How far an ear is from a line: its signed area over its longest side squared.
fn thickness(turn: &impl Fn([u32; 3]) -> f64, [a, b, c]: [DVec3; 3], ear: [u32; 3]) -> f64 {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    turn(ear) / longest
}

fn inside(turn: &impl Fn([u32; 3]) -> f64, [a, b, c]: [u32; 3], p: u32) -> bool {
    turn([a, b, p]) >= 0.0 && turn([b, c, p]) >= 0.0 && turn([c, a, p]) >= 0.0
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
