//! Whether a mesh is the intersection of its facets' half-spaces.

use glam::DVec3;

use super::topology::NONE;
use super::{Mesh, Plane, bounds};

/// How far a vertex may stand in front of a facet, as a fraction of the extent. Text files round to six decimals or more.
const TOLERANCE: f64 = 1e-6;
/// Vertices in a leaf of the search tree.
const LEAF: usize = 16;

/// `across` is the neighbour of each triangle across each of its edges.
///
/// The neighbours' vertices are looked at first, which settles nearly every mesh that is not convex; then all vertices,
/// through a tree of boxes: a tessellated dent may be too shallow to show between neighbours.
pub(super) fn is_convex(mesh: &Mesh, across: &[[u32; 3]]) -> bool {
    let (low, high) = mesh.bounds();
    let slack = TOLERANCE * (high - low).max_element();
    let behind = |plane: &Plane, t: u32| {
        mesh.triangles[t as usize].iter().all(|&v| plane.distance(mesh.positions[v as usize]) <= slack)
    };
    let locally = across.iter().zip(&mesh.facet_of).all(|(neighbours, &facet)| {
        let plane = &mesh.facets[facet as usize].plane;
        neighbours.iter().all(|&t| t != NONE && behind(plane, t))
    });
    if mesh.shells != 1 || !locally {
        return false;
    }
    let mut points = mesh.positions.clone();
    let mut boxes = Vec::new();
    build(&mut points, &mut boxes);
    mesh.facets.iter().all(|facet| !any_in_front(&facet.plane, slack, &points, &boxes))
}

/// A box, and where the box after its whole subtree is: a walk that misses a box goes on from there.
struct Node {
    low: DVec3,
    high: DVec3,
    skip: usize,
}

/// Sorts `points` into halves along the longest axis, recursively, and appends the boxes in depth-first order.
fn build(points: &mut [DVec3], boxes: &mut Vec<Node>) {
    let (low, high) = bounds(points);
    let own = boxes.len();
    boxes.push(Node { low, high, skip: 0 });
    if points.len() > LEAF {
        let axis = (high - low).max_position();
        let half = points.len() / 2;
        points.select_nth_unstable_by(half, |a, b| a[axis].total_cmp(&b[axis]));
        let (left, right) = points.split_at_mut(half);
        build(left, boxes);
        build(right, boxes);
    }
    boxes[own].skip = boxes.len();
}

/// Whether any point stands more than `slack` in front of the plane. A leaf's box is tested point by point.
fn any_in_front(plane: &Plane, slack: f64, points: &[DVec3], boxes: &[Node]) -> bool {
    let limit = plane.offset + slack;
    let n = plane.normal;
    // The points of the subtrees passed so far: leaves come in the order of the points.
    let mut stack = vec![(0, points)];
    while let Some((at, points)) = stack.pop() {
        let node = &boxes[at];
        let furthest = (n * node.low).max(n * node.high);
        if furthest.element_sum() <= limit {
            continue;
        }
        if points.len() <= LEAF {
            if points.iter().any(|p| n.dot(*p) > limit) {
                return true;
            }
            continue;
        }
        let (left, right) = points.split_at(points.len() / 2);
        stack.push((at + 1, left));
        stack.push((boxes[at + 1].skip, right));
    }
    false
}
