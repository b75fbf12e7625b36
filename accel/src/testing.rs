//! Meshes and random numbers for tests, benchmarks and examples, the same on every machine.

use crate::{BuildOptions, Bvh};
use glam::{Quat, Vec3};
use obvhs::triangle::Triangle;
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

/// A triangle mesh: corner positions, and three indices a triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corner positions.
    pub positions: Vec<Vec3>,
    /// Indices into `positions`, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The hierarchy over it with default options.
    ///
    /// # Panics
    /// If the mesh is not valid.
    pub fn bvh(&self) -> Bvh {
        Bvh::build(&self.positions, &self.triangles, &BuildOptions::default()).expect("a valid mesh")
    }

    /// Its triangles for `obvhs`.
    pub fn obvhs(&self) -> Vec<Triangle> {
        let corners = (0..self.triangles.len()).map(|i| self.corners(i).map(Into::into));
        corners.map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect()
    }

    /// Adds a triangle with corners of its own.
    pub fn push(&mut self, corners: [Vec3; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }

    /// Every position replaced by `f` of it.
    pub fn map(mut self, f: impl Fn(Vec3) -> Vec3) -> Mesh {
        self.positions.iter_mut().for_each(|p| *p = f(*p));
        self
    }

    /// The corners of triangle `i`.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn corners(&self, i: usize) -> [Vec3; 3] {
        self.triangles[i].map(|index| self.positions[index as usize])
    }
}

/// Random numbers by SplitMix64 (Steele, Lea & Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `[0, 1)`.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// Uniform in `[0, 1)³`.
    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }

    /// Uniform below `count`, which must not be 0.
    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.unit();
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * cos, r * sin, z)
    }
}

/// Slivers: `count` triangles of random orientation with centres in the unit cube, lengths between 0.1 and 1 and width
/// `width`. They are the worst case of hierarchies without spatial splits.
pub fn slivers(count: usize, width: f32, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let mut mesh = Mesh::default();
    for _ in 0..count {
        let centre = random.point();
        let along = random.direction();
        let across = along.cross(random.direction()).normalize_or(Vec3::X);
        let half = along * (0.5 * (0.1 + 0.9 * random.unit()));
        mesh.push([centre - half, centre + half, centre - half + across * width]);
    }
    mesh
}

/// `count` random triangles with centres in the unit cube and corners within about `size` of them.
pub fn soup(count: usize, size: f32, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let mut mesh = Mesh::default();
    for _ in 0..count {
        let centre = random.point();
        mesh.push([0; 3].map(|_| centre + (random.point() - 0.5) * size));
    }
    mesh
}

/// A unit sphere about the origin: an icosahedron whose triangles are divided in four `levels` times.
/// Closed, wound counter-clockwise seen from outside; 20·4^levels triangles.
pub fn icosphere(levels: u32) -> Mesh {
    let golden = (1.0 + 5f32.sqrt()) / 2.0;
    let mut positions = Vec::new();
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        positions.push(Vec3::new(a, b, 0.0));
    }
    for i in 0..8 {
        let Vec3 { x, y, .. } = positions[i % 4];
        positions.push(if i < 4 { Vec3::new(0.0, x, y) } else { Vec3::new(y, 0.0, x) });
    }
    // A fan about each of two opposite vertices and a strip between them.
    let (upper, lower) = ([11, 5, 1, 7, 10], [4, 9, 8, 6, 2]);
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for (i, j) in [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0)] {
        let [a, b, c, d] = [upper[i], upper[j], lower[i], lower[j]];
        triangles.extend([[0, a, b], [3, d, c], [a, c, b], [c, d, b]]);
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]) / 2.0);
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh { positions, triangles }.map(Vec3::normalize)
}

/// A torus about the z axis with radii 1 and `tube`, of `around × across` quads in two triangles each. Closed,
/// wound counter-clockwise seen from outside.
pub fn torus(tube: f32, around: u32, across: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..around {
        for j in 0..across {
            let (sin_i, cos_i) = (TAU * i as f32 / around as f32).sin_cos();
            let (sin_j, cos_j) = (TAU * j as f32 / across as f32).sin_cos();
            let r = 1.0 + tube * cos_j;
            mesh.positions.push(Vec3::new(r * cos_i, r * sin_i, tube * sin_j));
            let index = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A faceted convex stone about the origin: a flat table, rings of `sides` corners (crown, girdle, pavilion) and a
/// pointed culet, at which long thin facets meet. Closed, wound counter-clockwise seen from outside.
pub fn stone(sides: u32) -> Mesh {
    let rings = [(0.55, 0.34), (0.8, 0.24), (1.0, 0.02), (1.0, -0.02), (0.4, -0.55)];
    let mut positions = vec![Vec3::new(0.0, 0.0, 0.34)];
    for (ring, (r, z)) in rings.into_iter().enumerate() {
        for i in 0..sides {
            let shift = if ring == 1 { 0.5 } else { 0.0 };
            let (sin, cos) = (TAU * (i as f32 + shift) / sides as f32).sin_cos();
            positions.push(Vec3::new(r * cos, r * sin, z));
        }
    }
    let culet = positions.len() as u32;
    positions.push(Vec3::new(0.0, 0.0, -0.87));
    let at = |ring: u32, i: u32| 1 + ring * sides + i % sides;
    let mut triangles = Vec::new();
    for i in 0..sides {
        triangles.push([0, at(0, i), at(0, i + 1)]);
        for ring in 0..4 {
            let [a, b, c, d] = [at(ring, i), at(ring + 1, i), at(ring + 1, i + 1), at(ring, i + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([culet, at(4, i + 1), at(4, i)]);
    }
    Mesh { positions, triangles }
}

/// The side of a cylinder of radius 0.1 and length 2, in `sides` quads of two long triangles each, turned by 45° about x
/// and then about z, so that no edge is parallel to an axis.
pub fn slanted_cylinder(sides: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let turn = Quat::from_rotation_z(PI / 4.0) * Quat::from_rotation_x(PI / 4.0);
    for i in 0..sides {
        let (sin, cos) = (TAU * i as f32 / sides as f32).sin_cos();
        mesh.positions.extend([-1.0, 1.0].map(|z| turn * Vec3::new(0.1 * cos, 0.1 * sin, z)));
        let [a, b, c, d] = [2 * i, 2 * ((i + 1) % sides), 2 * ((i + 1) % sides) + 1, 2 * i + 1];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}
