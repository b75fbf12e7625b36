//! Whether a mesh is the intersection of its facets' half-spaces.

use glam::{DMat3, DVec3};

use super::topology::NONE;
use super::{Mesh, Plane};

/// Largest distance of a vertex in front of a facet, as a fraction of the extent. Of meshes with more, [`rounded`] finds
/// those that only their rounding keeps from being convex.
///
/// [`rounded`]: super::rounded
pub(super) const TOLERANCE: f64 = 1e-6;
/// Vertices in a leaf of the search tree.
const LEAF: usize = 16;

/// Whether every vertex is behind every facet's plane, or at most `slack` before it. `across` is the neighbour of each
/// triangle across each of its edges.
///
/// The vertices of the neighbours are tested first, which decides almost every mesh that is not convex. Then all vertices
/// are tested with a tree of boxes, since a tessellated dent may be too shallow to show between neighbours.
pub(super) fn is_convex(mesh: &Mesh, across: &[[u32; 3]], slack: f64) -> bool {
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
    let mut points = vertices(mesh);
    let mut boxes = Vec::new();
    build(&mut points, &mut boxes);
    mesh.facets.iter().all(|facet| !any_in_front(&facet.plane, slack, &points, &boxes))
}

/// A vertex and the sum of the normals around it.
type Vertex = (DVec3, DVec3);

fn vertices(mesh: &Mesh) -> Vec<Vertex> {
    let mut points: Vec<Vertex> = mesh.positions.iter().map(|&p| (p, DVec3::ZERO)).collect();
    for (triangle, &facet) in mesh.triangles.iter().zip(&mesh.facet_of) {
        let normal = mesh.facets[facet as usize].plane.normal;
        triangle.iter().for_each(|&v| points[v as usize].1 += normal);
    }
    points
}

/// A box aligned with the surface, so that its thickness is the curvature of its patch and not the patch's width. An
/// axis-aligned box would extend far in front of the planes of its neighbours.
struct Node {
    /// Rows are the box's axes.
    axes: DMat3,
    low: DVec3,
    high: DVec3,
    /// Index of the node after this subtree.
    skip: usize,
}

/// Sorts `points` into halves along their longest axis, recursively, and appends the boxes in depth-first order.
fn build(points: &mut [Vertex], boxes: &mut Vec<Node>) {
    let up = points.iter().map(|p| p.1).sum::<DVec3>().normalize_or(DVec3::Z);
    let (right, forward) = up.any_orthonormal_pair();
    let axes = DMat3::from_cols(right, forward, up).transpose();
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let within = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
    let (low, high) = points.iter().fold(start, |b, p| within(b, axes * p.0));
    let own = boxes.len();
    boxes.push(Node { axes, low, high, skip: 0 });
    if points.len() > LEAF {
        let axis = axes.row((high - low).max_position());
        let half = points.len() / 2;
        points.select_nth_unstable_by(half, |a, b| axis.dot(a.0).total_cmp(&axis.dot(b.0)));
        let (left, right) = points.split_at_mut(half);
        build(left, boxes);
        build(right, boxes);
    }
    boxes[own].skip = boxes.len();
}

/// Whether any point is more than `slack` in front of the plane.
fn any_in_front(plane: &Plane, slack: f64, points: &[Vertex], boxes: &[Node]) -> bool {
    let limit = plane.offset + slack;
    // Nodes to visit, each with its points.
    let mut stack = vec![(0, points)];
    while let Some((at, points)) = stack.pop() {
        let node = &boxes[at];
        let normal = node.axes * plane.normal;
        let furthest = (normal * node.low).max(normal * node.high).element_sum();
        if furthest <= limit {
            continue;
        }
        if points.len() <= LEAF {
            if points.iter().any(|p| plane.normal.dot(p.0) > limit) {
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
