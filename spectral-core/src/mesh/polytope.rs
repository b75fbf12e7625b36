//! A convex polyhedron under successive cuts by planes.
//!
//! The combinatorics (which vertices bound which face) are explicit, and each cut classifies the vertices as in, out or on
//! the plane, with a tolerance. So the polyhedron stays closed with any rounding, or the cut fails with an error.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::Plane;

/// A face: its vertices counter-clockwise seen from outside, and the number of its plane.
#[derive(Debug, Clone)]
pub(super) struct Face {
    pub plane: usize,
    pub corners: Vec<u32>,
}

/// The polyhedron; `points` also contains vertices that were cut off.
#[derive(Debug, Clone)]
pub(super) struct Polytope {
    pub points: Vec<DVec3>,
    pub faces: Vec<Face>,
}

/// The result of a cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// It removed a part.
    Cut,
    /// Everything was behind the plane already.
    Redundant,
    /// The plane lies on the face of plane `.0`.
    Repeats(usize),
    /// Nothing is left behind the plane.
    Empty,
    /// Rounding made the classification of the vertices contradictory.
    Confused,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    In,
    On,
    Out,
}

impl Polytope {
    /// The cube of half-width `reach` about the origin. Its faces have the plane numbers `first` to `first + 5`, towards −x,
    /// +x, −y, +y, −z, +z.
    pub fn cube(reach: f64, first: usize) -> Self {
        let corner =
            |k: u32| DVec3::from_array([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { reach } else { -reach }));
        let loops = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let face = |(k, corners): (usize, [u32; 4])| Face { plane: first + k, corners: corners.to_vec() };
        Polytope {
            points: (0..8).map(corner).collect(),
            faces: loops.into_iter().enumerate().map(face).collect(),
        }
    }

    /// Removes the part in front of `plane`. Vertices within `tolerance` of it count as on it.
    pub fn cut(&mut self, plane: &Plane, number: usize, tolerance: f64) -> Outcome {
        let distances: Vec<f64> = self.points.iter().map(|p| plane.distance(*p)).collect();
        let place = |v: u32| match distances[v as usize] {
            d if d > tolerance => Place::Out,
            d if d < -tolerance => Place::In,
            _ => Place::On,
        };
        let any = |wanted| self.faces.iter().flat_map(|f| &f.corners).any(|&v| place(v) == wanted);
        if !any(Place::Out) {
            let on = self.faces.iter().find(|f| f.corners.iter().all(|&v| place(v) == Place::On));
            return on.map_or(Outcome::Redundant, |f| Outcome::Repeats(f.plane));
        }
        if !any(Place::In) {
            return Outcome::Empty;
        }
        let (mut faces, mut rim) = (Vec::with_capacity(self.faces.len() + 1), Rim::default());
        let mut meets = FxHashMap::default();
        for face in std::mem::take(&mut self.faces) {
            let has = |wanted| face.corners.iter().any(|&v| place(v) == wanted);
            match (has(Place::In), has(Place::Out)) {
                (true, false) => faces.push(face),
                (true, true) => {
                    let Some(corners) = self.clip(&face.corners, &distances, place, &mut meets, &mut rim)
                    else {
                        return Outcome::Confused;
                    };
                    faces.push(Face { plane: face.plane, corners });
                }
                (false, _) => rim.add_dropped(&face.corners, place),
            }
        }
        match rim.into_loop() {
            Some(corners) => faces.push(Face { plane: number, corners }),
            None => return Outcome::Confused,
        }
        self.faces = faces;
        Outcome::Cut
    }

    /// The part of a face behind the plane; the new edge is added to `rim`.
    fn clip(
        &mut self,
        corners: &[u32],
        distances: &[f64],
        place: impl Fn(u32) -> Place,
        meets: &mut FxHashMap<(u32, u32), u32>,
        rim: &mut Rim,
    ) -> Option<Vec<u32>> {
        let n = corners.len();
        // Start at the first kept vertex after the removed ones, which must be contiguous.
        let mut starts = (0..n)
            .filter(|&k| place(corners[(k + n - 1) % n]) == Place::Out && place(corners[k]) != Place::Out);
        let start = starts.next()?;
        if starts.next().is_some() {
            return None;
        }
        let mut kept: Vec<u32> =
            (0..n).map(|k| corners[(start + k) % n]).take_while(|&v| place(v) != Place::Out).collect();
        let (first, last) = (*kept.first()?, *kept.last()?);
        let before = corners[(start + n - 1) % n];
        let after = corners[(start + kept.len()) % n];
        if place(last) == Place::In {
            kept.push(self.meet(last, after, distances, meets));
        }
        if place(first) == Place::In {
            kept.insert(0, self.meet(first, before, distances, meets));
        }
        let (from, to) = (*kept.last()?, *kept.first()?);
        rim.edges.push((to, from));
        (kept.len() >= 3).then_some(kept)
    }

    /// The vertex where the edge from `inside` to `outside` meets the plane; the same for both faces of the edge.
    fn meet(
        &mut self,
        inside: u32,
        outside: u32,
        distances: &[f64],
        meets: &mut FxHashMap<(u32, u32), u32>,
    ) -> u32 {
        *meets.entry((inside, outside)).or_insert_with(|| {
            let (d_in, d_out) = (distances[inside as usize], distances[outside as usize]);
            let (p, q) = (self.points[inside as usize], self.points[outside as usize]);
            self.points.push(p + (q - p) * (d_in / (d_in - d_out)));
            (self.points.len() - 1) as u32
        })
    }

    /// Removes the vertices that no face uses.
    pub fn compact(&mut self) {
        let mut number = FxHashMap::default();
        let mut points = Vec::new();
        for v in self.faces.iter_mut().flat_map(|f| &mut f.corners) {
            *v = *number.entry(*v).or_insert_with(|| {
                points.push(self.points[*v as usize]);
                (points.len() - 1) as u32
            });
        }
        self.points = points;
    }

    /// Whether every edge occurs once in each direction, every face is a simple polygon, and V − E + F = 2.
    pub fn is_sound(&self) -> bool {
        let mut edges = FxHashSet::default();
        let mut vertices = FxHashSet::default();
        for face in &self.faces {
            let simple: FxHashSet<u32> = face.corners.iter().copied().collect();
            if face.corners.len() < 3 || simple.len() != face.corners.len() {
                return false;
            }
            vertices.extend(simple);
            if !directed(&face.corners).all(|edge| edges.insert(edge)) {
                return false;
            }
        }
        edges.iter().all(|&(a, b)| edges.contains(&(b, a)))
            && 2 * (vertices.len() + self.faces.len()) == edges.len() + 4
    }
}

/// The directed edges of a loop.
pub(super) fn directed(corners: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// The edges where a cut opened the polyhedron, in the direction of the closing face.
#[derive(Default)]
struct Rim {
    edges: Vec<(u32, u32)>,
}

impl Rim {
    /// Adds the edges on the plane of a removed face, which may bound a kept face.
    fn add_dropped(&mut self, corners: &[u32], place: impl Fn(u32) -> Place) {
        let on = |&(a, b): &(u32, u32)| place(a) == Place::On && place(b) == Place::On;
        self.edges.extend(directed(corners).filter(on));
    }

    /// The closing face. Edges present in both directions lie between two removed faces, or join two clipped ones.
    fn into_loop(self) -> Option<Vec<u32>> {
        let all: FxHashSet<(u32, u32)> = self.edges.iter().copied().collect();
        let mut next = FxHashMap::default();
        let mut start = None;
        for &(a, b) in self.edges.iter().filter(|(a, b)| !all.contains(&(*b, *a))) {
            start = start.or(Some(a));
            if next.insert(a, b).is_some() {
                return None;
            }
        }
        let start = start?;
        let (mut corners, mut at) = (vec![start], *next.get(&start)?);
        while at != start {
            corners.push(at);
            if corners.len() > next.len() {
                return None;
            }
            at = *next.get(&at)?;
        }
        (corners.len() == next.len() && corners.len() >= 3).then_some(corners)
    }
}
