//! Surfaces of metals, which need no inside.

use super::facet::{self, Grouped};
use super::topology::{NONE, Surface};
use super::{Facet, Mesh, MeshOptions, Plane, bounds, polygon, weld};
use crate::{Error, Warning};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// How far the back of a surface lies behind its front, as a fraction of the extent: a ray that starts at the one does not meet
/// the other by rounding.
const THICKNESS: f64 = 1e-4;

impl Mesh {
    /// As [`from_triangles`](Self::from_triangles), for something opaque: where the triangles bound no solid, a thin sheet
    /// with a front and a back, so that light is reflected on either side and never gets between.
    ///
    /// # Errors
    /// [`Error::Value`] as there; [`Error::Solid`] where no triangle has an area.
    pub fn opaque(
        positions: Vec<DVec3>,
        triangles: Vec<[u32; 3]>,
        options: &MeshOptions,
    ) -> Result<(Mesh, Vec<Warning>), Error> {
        let (points, corners) = (positions.clone(), triangles.clone());
        match Mesh::from_triangles(positions, triangles, options) {
            Err(Error::Solid { message, .. }) => {
                let mesh = sheet(points, corners, options)?;
                let warning =
                    format!("{message}; the metal is rendered as a thin sheet, which needs no inside");
                Ok((mesh, vec![Warning::new(warning)]))
            }
            other => other,
        }
    }
}

fn sheet(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>, options: &MeshOptions) -> Result<Mesh, Error> {
    let (positions, mut triangles) = weld::loose(positions, triangles);
    let (low, high) = bounds(&positions);
    let extent = (high - low).max_element();
    let none = || Error::Solid { message: "the mesh has no triangle with an area".to_owned(), place: None };
    let thin = 1e-12 * extent;
    triangles.retain(|t| polygon::height(t.map(|v| positions[v as usize])) > thin);
    if triangles.is_empty() {
        return Err(none());
    }
    let across = neighbours(&triangles);
    let surface = Surface { positions, triangles, across, shells: 1, extent, thin };
    let Grouped { facet_of, planes } = facet::group(&surface, options, facet::ROUNDING);
    if planes.is_empty() {
        return Err(none());
    }
    let whole = vec![2 * surface.triangles.len() as u32];
    let (mut mesh, _) = Mesh::of(surface, whole, facet_of, planes);
    let depth = THICKNESS * extent;
    for t in 0..mesh.triangles.len() {
        let facet = mesh.facet_of[t];
        let normal = mesh.facets[facet as usize].plane.normal;
        let first = mesh.positions.len() as u32;
        let back = mesh.triangles[t].map(|v| mesh.positions[v as usize] - depth * normal);
        mesh.positions.extend(back);
        mesh.triangles.push([first, first + 2, first + 1]);
        mesh.facet_of.push(facet + mesh.facets.len() as u32);
    }
    let backs: Vec<Facet> = mesh.facets.iter().map(|facet| behind(facet, depth)).collect();
    mesh.facets.extend(backs);
    Ok(mesh)
}

fn behind(facet: &Facet, depth: f64) -> Facet {
    let Plane { normal, offset } = facet.plane;
    Facet { plane: Plane { normal: -normal, offset: depth - offset }, name: None }
}

/// A triangle, the number of its side, and whether that runs to the higher vertex.
type Side = (usize, usize, bool);

/// The triangle across each edge where it has exactly two, which wind alike.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sides: FxHashMap<(u32, u32), Vec<Side>> = FxHashMap::default();
    for (t, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            sides.entry((a.min(b), a.max(b))).or_default().push((t, k, a < b));
        }
    }
    let mut across = vec![[NONE; 3]; triangles.len()];
    for pair in sides.values() {
        if let [(t, i, up), (u, k, down)] = pair[..]
            && up != down
        {
            (across[t][i], across[u][k]) = (u as u32, t as u32);
        }
    }
    across
}
