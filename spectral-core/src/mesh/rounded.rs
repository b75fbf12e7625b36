//! Convex stones whose coordinates are rounded.
//!
//! The triangles of a facet are joined within [`MeshOptions::coplanar_distance`], and a file states its coordinates to so
//! many digits. Within these two bounds the vertices of a convex stone may lie before its facets' planes. A stone that
//! stays within them is replaced by the intersection of its half-spaces: then vertices, edges and planes agree again.

use super::facet::{self, Grouped};
use super::topology::{NONE, Surface};
use super::{Mesh, MeshOptions, Plane, convexity};
use glam::DVec3;

/// Coarser digits, as a fraction of the extent, are taken to be exact.
const COARSEST: f64 = 1e-3;
/// Of stones with more facets the planes are not intersected: no backend traces them plane by plane.
const MOST_FACETS: usize = 1024;
/// More digits than any of these files is rounded to.
const MOST_DIGITS: usize = 9;

/// The convex stone that the mesh is but for rounding, or the mesh as it is. `surface` has the rest of what the mesh was
/// made of.
pub(super) fn solid(mesh: Mesh, surface: Surface, options: &MeshOptions) -> Mesh {
    let digit = last_digit(&mesh.positions, surface.extent);
    // A plane fitted to vertices that are each off by half a digit along x, y and z passes all of them within two digits.
    let reach = (2.0 * digit).max(options.coplanar_distance * surface.extent);
    if mesh.shells != 1 || !nearly_convex(&mesh, &surface.across, reach) {
        return mesh;
    }
    let surface = Surface {
        positions: mesh.positions.clone(),
        triangles: mesh.triangles.clone(),
        thin: surface.thin.max(2.0 * digit),
        ..surface
    };
    let wider = MeshOptions { coplanar_distance: reach / surface.extent, ..*options };
    let rounding = facet::ROUNDING.max(digit / surface.extent);
    let Grouped { facet_of, planes } = facet::group(&surface, &wider, rounding);
    let (mut joined, surface) = Mesh::of(surface, mesh.solids.clone(), facet_of, planes);
    // A plane is fitted again after vertices within reach of it were found.
    let slack = 2.0 * reach;
    joined.convex = convexity::is_convex(&joined, &surface.across, slack);
    if joined.convex && joined.facets.len() > MOST_FACETS {
        return joined;
    }
    intersection(&joined, slack).filter(|_| joined.convex).unwrap_or(mesh)
}

/// Whether no edge is reflex by more than `reach`. Of two triangles the thinner one says where its neighbour's plane is,
/// since its own plane is known badly.
fn nearly_convex(mesh: &Mesh, across: &[[u32; 3]], reach: f64) -> bool {
    let plane = |t: usize| {
        let [a, b, c] = mesh.triangles[t].map(|v| mesh.positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        Plane { normal, offset: normal.dot(a) }
    };
    let before = |t: usize, u: usize| {
        let plane = plane(t);
        let distance = |&v: &u32| plane.distance(mesh.positions[v as usize]);
        mesh.triangles[u].iter().map(distance).fold(0.0, f64::max)
    };
    across.iter().enumerate().all(|(t, neighbours)| {
        neighbours.iter().all(|&u| u != NONE && before(t, u as usize).min(before(u as usize, t)) <= reach)
    })
}

/// The intersection of the facets' half-spaces, if it differs from the mesh by no more than a layer of thickness `slack`.
fn intersection(mesh: &Mesh, slack: f64) -> Option<Mesh> {
    let (solid, _) = Mesh::from_half_spaces(&mesh.facets).ok()?;
    ((solid.volume() - mesh.volume()).abs() <= slack * mesh.area()).then_some(solid)
}

/// The place value of the last digit of the largest coordinates that have all digits; 0 if coordinates have so many digits,
/// so few, or mostly fewer than the longest, that they are not rounded.
fn last_digit(positions: &[DVec3], extent: f64) -> f64 {
    // By number of digits: how many coordinates have so many, and the largest place value of the last.
    let mut found = [(0, 0.0_f64); MOST_DIGITS + 1];
    for coordinate in positions.iter().flat_map(DVec3::to_array) {
        let digits = significant(coordinate);
        let Some((count, place)) = found.get_mut(digits) else { return 0.0 };
        let last = 10_f64.powf(coordinate.abs().log10().floor() + 1.0 - digits as f64);
        (*count, *place) = (*count + 1, place.max(last));
    }
    let longest = found.iter().rposition(|(count, _)| *count > 0).unwrap_or_default();
    let long: usize = found[longest.saturating_sub(1)..=longest].iter().map(|(count, _)| count).sum();
    let digit = found[longest].1;
    if longest > 1 && 4 * long >= 3 * positions.len() && digit <= COARSEST * extent { digit } else { 0.0 }
}

/// The number of significant decimal digits; of a number in single precision those that tell it from its neighbours.
fn significant(number: f64) -> usize {
    let single = number as f32;
    let text = if f64::from(single) == number { format!("{single:e}") } else { format!("{number:e}") };
    text.bytes().take_while(|byte| *byte != b'e').filter(u8::is_ascii_digit).count()
}
