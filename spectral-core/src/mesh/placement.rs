//! The placement of a mesh.

use glam::{DMat3, DVec3};
use std::ops::Range;

use super::{Mesh, Plane, bounds_of, volume_about, weld};
use crate::Error;

/// `x -> scale · rotation · x + translation`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placement {
    rotation: DMat3,
    scale: f64,
    translation: DVec3,
}

impl Placement {
    /// # Errors
    /// [`Error::Value`] for a `scale` that is not positive, a `rotation` that is not a rotation, or a figure that is not
    /// finite.
    pub fn new(rotation: DMat3, scale: f64, translation: DVec3) -> Result<Self, Error> {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Error::value("scale", scale, "give a positive figure"));
        }
        let excess = rotation * rotation.transpose() - DMat3::IDENTITY;
        let error = excess.to_cols_array().iter().fold(0.0_f64, |most, e| most.max(e.abs()));
        if !(rotation.is_finite() && error < 1e-9 && rotation.determinant() > 0.0) {
            let expected = "give a rotation matrix: orthonormal, determinant +1";
            return Err(Error::value("rotation", rotation, expected));
        }
        if !translation.is_finite() {
            return Err(Error::value("translation", translation, "give finite figures"));
        }
        Ok(Placement { rotation, scale, translation })
    }

    /// Checks that the mesh stays within the range of coordinates.
    ///
    /// # Errors
    /// [`Error::Value`] for the first vertex that does not.
    pub fn check(&self, mesh: &Mesh) -> Result<(), Error> {
        let beyond = |p: DVec3| !p.is_finite() || p.abs().max_element() > weld::LARGEST;
        match mesh.positions.iter().map(|p| self.point(*p)).enumerate().find(|(_, p)| beyond(*p)) {
            Some((k, place)) => Err(Error::value(format!("vertex {k} after scaling"), place, weld::RANGE)),
            None => Ok(()),
        }
    }

    pub fn point(&self, point: DVec3) -> DVec3 {
        self.scale * (self.rotation * point) + self.translation
    }

    pub fn plane(&self, plane: &Plane) -> Plane {
        let normal = (self.rotation * plane.normal).normalize();
        Plane { normal, offset: self.scale * plane.offset + normal.dot(self.translation) }
    }

    /// The least and the greatest corner of the bounding box of one of the placed mesh's [solids](Mesh::solids).
    pub fn bounds(&self, mesh: &Mesh, solid: Range<u32>) -> (DVec3, DVec3) {
        if mesh.solids.len() == 1 {
            return bounds_of(mesh.positions.iter().map(|p| self.point(*p)));
        }
        let triangles = &mesh.triangles[solid.start as usize..solid.end as usize];
        bounds_of(triangles.iter().flatten().map(|&v| self.point(mesh.positions[v as usize])))
    }

    /// The volume of one of the placed mesh's solids within these bounds.
    pub fn volume(&self, mesh: &Mesh, solid: Range<u32>, bounds: (DVec3, DVec3)) -> f64 {
        let triangles = &mesh.triangles[solid.start as usize..solid.end as usize];
        volume_about(bounds, triangles, |v| self.point(mesh.positions[v as usize]))
    }
}
