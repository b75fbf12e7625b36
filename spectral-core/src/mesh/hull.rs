//! Convex hulls, by Quickhull (Barber, Dobkin & Huhdanpaa 1996).

use super::{Mesh, MeshOptions, bounds};
use crate::{Error, Warning};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// A point nearer to a face than this fraction of the extent lies in it.
const FLAT: f64 = 1e-9;

/// A face of the hull, counter-clockwise from outside, with the points that it does not hold back.
struct Face {
    corners: [u32; 3],
    normal: DVec3,
    offset: f64,
    outside: Vec<u32>,
    is_gone: bool,
}

impl Mesh {
    /// The convex hull of points, the vertices of a file for instance.
    ///
    /// # Errors
    /// [`Error::Solid`] for points that lie in a plane; otherwise as [`from_triangles`](Self::from_triangles).
    ///
    /// ```
    /// use {glam::DVec3, spectral_core::mesh::{Mesh, MeshOptions}};
    /// let cube = (0..8).map(|k| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64));
    /// let points = cube.chain([DVec3::splat(0.5)]).collect();
    /// let (hull, _) = Mesh::convex_hull(points, &MeshOptions::default())?;
    /// assert!(hull.is_convex() && hull.facets().len() == 6 && (hull.volume() - 1.0).abs() < 1e-12);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn convex_hull(points: Vec<DVec3>, options: &MeshOptions) -> Result<(Mesh, Vec<Warning>), Error> {
        let (low, high) = bounds(&points);
        let extent = (high - low).max_element();
        let faces = first(&points, FLAT * extent).map(|start| grow(&points, start, FLAT * extent));
        let flat =
            || Error::Solid { message: "its points lie in a plane and have no hull".to_owned(), place: None };
        Mesh::from_triangles(points, faces.ok_or_else(flat)?, options)
    }
}

/// A tetrahedron of points that are far apart.
fn first(points: &[DVec3], flat: f64) -> Option<[u32; 4]> {
    let farthest = |from: &dyn Fn(DVec3) -> f64| {
        let far = points.iter().enumerate().map(|(k, p)| (k as u32, from(*p)));
        far.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, far)| *far > flat).map(|(k, _)| k)
    };
    let point = |k: u32| points[k as usize];
    let origin = *points.first()?;
    let a = farthest(&|p| p.distance(origin))?;
    let b = farthest(&|p| p.distance(point(a)))?;
    let along = (point(b) - point(a)).normalize();
    let c = farthest(&|p| (p - point(a)).cross(along).length())?;
    let normal = along.cross(point(c) - point(a)).normalize();
    let d = farthest(&|p| (p - point(a)).dot(normal).abs())?;
    Some(if (point(d) - point(a)).dot(normal) < 0.0 { [a, b, c, d] } else { [a, c, b, d] })
}

fn grow(points: &[DVec3], [a, b, c, d]: [u32; 4], flat: f64) -> Vec<[u32; 3]> {
    let face = |corners: [u32; 3]| {
        let [p, q, r] = corners.map(|v| points[v as usize]);
        let normal = (q - p).cross(r - p).normalize_or_zero();
        Face { corners, normal, offset: normal.dot(p), outside: Vec::new(), is_gone: false }
    };
    let height = |face: &Face, v: u32| face.normal.dot(points[v as usize]) - face.offset;
    let mut faces: Vec<Face> = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(face).into();
    let mut beyond: FxHashMap<(u32, u32), usize> = FxHashMap::default();
    let sides = |[a, b, c]: [u32; 3]| [(a, b), (b, c), (c, a)];
    for (k, face) in faces.iter().enumerate() {
        beyond.extend(sides(face.corners).map(|side| (side, k)));
    }
    let assign = |faces: &mut [Face], v: u32, mut among: std::ops::Range<usize>| {
        let seen = among.find(|&k| !faces[k].is_gone && height(&faces[k], v) > flat);
        if let Some(k) = seen {
            faces[k].outside.push(v);
        }
    };
    (0..points.len() as u32).for_each(|v| assign(&mut faces, v, 0..4));
    let mut next = 0;
    while next < faces.len() {
        let face_now = &faces[next];
        let far = face_now
            .outside
            .iter()
            .copied()
            .max_by(|v, w| height(face_now, *v).total_cmp(&height(face_now, *w)));
        let Some(eye) = far.filter(|_| !face_now.is_gone) else {
            next += 1;
            continue;
        };
        // All faces that the point sees, connected to this one, and the rim around them.
        let (mut seen, mut rim, mut k) = (vec![next], Vec::new(), 0);
        faces[next].is_gone = true;
        while let Some(&now) = seen.get(k) {
            k += 1;
            for (a, b) in sides(faces[now].corners) {
                let Some(&other) = beyond.get(&(b, a)) else { continue };
                if faces[other].is_gone {
                    continue;
                }
                if height(&faces[other], eye) > flat {
                    faces[other].is_gone = true;
                    seen.push(other);
                } else {
                    rim.push((a, b));
                }
            }
        }
        let mut left: Vec<u32> = Vec::new();
        for &gone in &seen {
            for side in sides(faces[gone].corners) {
                beyond.remove(&side);
            }
            left.append(&mut faces[gone].outside);
        }
        let start = faces.len();
        for (a, b) in rim {
            let corners = [a, b, eye];
            beyond.extend(sides(corners).map(|side| (side, faces.len())));
            faces.push(face(corners));
        }
        let end = faces.len();
        left.into_iter().filter(|v| *v != eye).for_each(|v| assign(&mut faces, v, start..end));
        next += 1;
    }
    faces.iter().filter(|face| !face.is_gone).map(|face| face.corners).collect()
}
