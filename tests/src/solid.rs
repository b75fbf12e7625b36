//! Solids: boxes and prisms with closed-form optics, curved and non-convex meshes, built-in cuts.

use glam::{DVec2, DVec3};
use spectral_core::{mesh::Mesh, mesh::MeshOptions, shape::ShapeSpec};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// The names of the built-in cuts.
pub const CUTS: [&str; 3] = ShapeSpec::NAMES;

/// An axis-aligned box between two corners.
pub fn cuboid(low: DVec3, high: DVec3) -> Arc<Mesh> {
    let outline = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
    extruded(&outline.map(|(x, y)| DVec2::new(x, y)), low.z, high.z)
}

/// A plate of `size` × `size` × `thickness` mm, its upper face in the plane z = 0.
pub fn plate(size: f64, thickness: f64) -> Arc<Mesh> {
    let half = size / 2.0;
    cuboid(DVec3::new(-half, -half, -thickness), DVec3::new(half, half, 0.0))
}

/// A polygon in the xy plane (counter-clockwise, star-shaped about the mean of its corners) swept along z.
pub fn extruded(outline: &[DVec2], bottom: f64, top: f64) -> Arc<Mesh> {
    let n = outline.len() as u32;
    let centre = outline.iter().sum::<DVec2>() / f64::from(n);
    let level = |z: f64| outline.iter().chain([&centre]).map(move |p| p.extend(z));
    let positions: Vec<DVec3> = level(bottom).chain(level(top)).collect();
    let up = n + 1;
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[i, j, up + j], [i, up + j, up + i], [j, i, n], [up + i, up + j, up + n]]);
    }
    build(positions, triangles)
}

/// A prism whose edge runs along x at (y, z) = (0, 0), with the apex angle `apex` (degrees) and the base below;
/// the two faces are mirror images in the plane y = 0, each `side` mm long, and the prism reaches ±`side` along x.
pub fn prism(apex: f64, side: f64) -> Arc<Mesh> {
    let (sin, cos) = (apex.to_radians() / 2.0).sin_cos();
    let corners = [(0.0, 0.0), (-side * sin, -side * cos), (side * sin, -side * cos)];
    let at = |x: f64| corners.map(|(y, z)| DVec3::new(x, y, z));
    let positions = [at(-side), at(side)].concat();
    let triangles =
        vec![[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
    build(positions, triangles)
}

/// An extruded star with `points` points: reflex edges all round.
pub fn star(points: u32, inner: f64, outer: f64, height: f64) -> Arc<Mesh> {
    let corner = |k: u32| {
        let radius = if k.is_multiple_of(2) { outer } else { inner };
        DVec2::from_angle(PI * f64::from(k) / f64::from(points)) * radius
    };
    let outline: Vec<DVec2> = (0..2 * points).map(corner).collect();
    extruded(&outline, -height / 2.0, height / 2.0)
}

/// A sphere of flat quadrilaterals about the origin; convex.
pub fn sphere(radius: f64, rings: u32, sectors: u32) -> Arc<Mesh> {
    let point = |i: u32, j: u32| {
        let (polar, azimuth) =
            (PI * f64::from(i) / f64::from(rings), TAU * f64::from(j) / f64::from(sectors));
        radius * DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
    };
    let mut positions = vec![DVec3::Z * radius, -DVec3::Z * radius];
    positions.extend((1..rings).flat_map(|i| (0..sectors).map(move |j| point(i, j))));
    let index = |i: u32, j: u32| 2 + (i - 1) * sectors + j % sectors;
    let mut triangles = Vec::new();
    for j in 0..sectors {
        triangles.push([0, index(1, j), index(1, j + 1)]);
        triangles.push([1, index(rings - 1, j + 1), index(rings - 1, j)]);
        for i in 1..rings - 1 {
            triangles.push([index(i, j), index(i + 1, j), index(i + 1, j + 1)]);
            triangles.push([index(i, j), index(i + 1, j + 1), index(i, j + 1)]);
        }
    }
    build(positions, triangles)
}

/// A torus about the z axis.
pub fn torus(major: f64, minor: f64, around: u32, across: u32) -> Arc<Mesh> {
    let point = |i: u32, j: u32| {
        let (a, b) = (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(across));
        let out = major + minor * b.cos();
        DVec3::new(out * a.cos(), out * a.sin(), minor * b.sin())
    };
    let positions = (0..around).flat_map(|i| (0..across).map(move |j| point(i, j))).collect();
    let index = |i: u32, j: u32| (i % around) * across + j % across;
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let corners = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            triangles.push([corners[0], corners[1], corners[2]]);
            triangles.push([corners[0], corners[2], corners[3]]);
        }
    }
    build(positions, triangles)
}

/// A built-in cut with its default proportions; width 1.
pub fn cut(name: &str) -> Arc<Mesh> {
    let cut = ShapeSpec::by_name(name).and_then(|shape| shape.cut()).expect("a built-in shape");
    Arc::new(cut.solid().expect("a built-in cut closes").0)
}

fn build(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Arc<Mesh> {
    let (mesh, warnings) =
        Mesh::from_triangles(positions, triangles, &MeshOptions::default()).expect("a closed mesh");
    assert!(warnings.is_empty(), "{warnings:?}");
    Arc::new(mesh)
}
