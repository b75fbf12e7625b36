//! Files between the programs: little-endian floats, ray packets and meshes.

use crate::Failure;
use accel::testing::Mesh;
use glam::Vec3;
use spectral_core::prepare::PreparedScene;
use std::{fmt::Write as _, fs, path::Path};

/// Rays of a packet.
pub const WIDTH: usize = 16;

/// Sixteen rays: x, y, z of the origins and of the directions, and the active ones as bits.
#[derive(Clone, Copy, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Packet {
    pub origin: [[f32; WIDTH]; 3],
    pub direction: [[f32; WIDTH]; 3],
    pub alive: u32,
}

impl Packet {
    /// Ray `lane`.
    pub fn ray(&self, lane: usize) -> (Vec3, Vec3) {
        (self.origin.map(|row| row[lane]).into(), self.direction.map(|row| row[lane]).into())
    }

    /// Adds ray `lane`.
    pub fn put(&mut self, lane: usize, origin: Vec3, direction: Vec3) {
        for axis in 0..3 {
            self.origin[axis][lane] = origin[axis];
            self.direction[axis][lane] = direction[axis];
        }
        self.alive |= 1 << lane;
    }

    /// The lanes that hold a ray.
    pub fn lanes(&self) -> impl Iterator<Item = usize> {
        let alive = self.alive;
        (0..WIDTH).filter(move |lane| alive >> lane & 1 == 1)
    }
}

/// Writes floats.
pub fn write_numbers(file: &Path, numbers: &[f32]) -> Result<(), Failure> {
    Ok(fs::write(file, bytemuck::cast_slice(numbers))?)
}

/// Writes ray packets.
pub fn write_packets(file: &Path, packets: &[Packet]) -> Result<(), Failure> {
    Ok(fs::write(file, bytemuck::cast_slice(packets))?)
}

/// Reads ray packets.
pub fn read_packets(file: &Path) -> Result<Vec<Packet>, Failure> {
    Ok(bytemuck::pod_collect_to_vec(&fs::read(file)?))
}

/// Writes a mesh: two counts, positions, indices.
pub fn write_mesh(file: &Path, mesh: &Mesh) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    bytes.extend((mesh.positions.len() as u32).to_le_bytes());
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for position in &mesh.positions {
        bytes.extend_from_slice(bytemuck::cast_slice(&position.to_array()));
    }
    bytes.extend_from_slice(bytemuck::cast_slice(&mesh.triangles));
    Ok(fs::write(file, bytes)?)
}

/// Reads a mesh.
pub fn read_mesh(file: &Path) -> Result<Mesh, Failure> {
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&fs::read(file)?);
    let (counts, rest) = words.split_at_checked(2).ok_or("a mesh begins with two counts")?;
    let (positions, triangles) =
        rest.split_at_checked(3 * counts[0] as usize).ok_or("a mesh has as many positions as it says")?;
    let position = |p: &[u32; 3]| Vec3::from(p.map(f32::from_bits));
    Ok(Mesh {
        positions: positions.as_chunks().0.iter().map(position).collect(),
        triangles: triangles.as_chunks().0.to_vec(),
    })
}

/// The scene's only stone as a PLY mesh without shared normals: facets are flat.
pub fn write_ply(file: &Path, scene: &PreparedScene) -> Result<(), Failure> {
    let geometry = &scene.geometry;
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        geometry.positions.len(),
        geometry.triangles.len()
    );
    for p in &geometry.positions {
        writeln!(text, "{} {} {}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in &geometry.triangles {
        writeln!(text, "3 {a} {b} {c}")?;
    }
    Ok(fs::write(file, text)?)
}
