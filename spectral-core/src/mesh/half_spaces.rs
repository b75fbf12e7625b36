//! From half-spaces to a mesh: robust combinatorics, then exact vertices, then the contraction of short edges.

use glam::{DMat3, DVec3};
use rustc_hash::FxHashMap;

use super::polytope::{Face, Outcome, Polytope, directed};
use super::{Facet, Mesh, Plane};
use crate::{Error, Warning, shown};

/// The largest number of half-spaces.
pub const MOST_FACETS: usize = 10_000;
/// Edges shorter than this fraction of the radius are contracted.
const CONTRACT: f64 = 1e-6;
/// The distance from a plane within which a vertex counts as on it, as a fraction of the radius. Designs have 8 to 10
/// decimals, so 1e-8 recognises their meets. The others are tried if rounding is contradictory with the first.
const TOLERANCES: [f64; 7] = [1e-8, 1e-9, 1e-7, 1e-10, 1e-11, 3e-7, 1e-12];
/// The cube from which the facets are cut, in radii. A solid that still touches it is unbounded.
const REACH: f64 = 1e4;
/// Larger offsets are refused.
const LARGEST: f64 = 1e12;
/// Smaller solids are refused, so that products of coordinates do not underflow.
const SMALLEST: f64 = 1e-30;
/// Directions of the cube's faces.
const TOWARDS: [&str; 6] = ["-x", "+x", "-y", "+y", "-z", "+z"];
/// Names listed in a warning before it says "and N more".
const LISTED: usize = 8;

pub(super) fn build(facets: &[Facet]) -> Result<(Mesh, Vec<Warning>), Error> {
    check(facets)?;
    let planes: Vec<Plane> = facets.iter().map(|f| f.plane).collect();
    let mut error = None;
    let [largest, median] = guesses(&planes);
    for (guess, tolerance) in [largest, median].into_iter().flat_map(|g| TOLERANCES.map(|t| (g, t))) {
        match attempt(&planes, guess, tolerance) {
            Ok(solid) => return Ok(finish(facets, solid)),
            // With the smaller guess a facet may lie outside; with the larger one there is none.
            Err(Failure::Unbounded(sides)) if guess == largest => {
                let sides: Vec<&str> = sides.iter().map(|&k| TOWARDS[k]).collect();
                let message =
                    format!("the cut does not close: no facet bounds it towards {}", sides.join(", "));
                return Err(Error::Solid { message, place: None });
            }
            Err(Failure::Confused | Failure::Unbounded(_)) => {}
            // A coarse tolerance may make a thin solid empty.
            Err(Failure::Empty(k)) => error = error.or(Some(empty(facets, k))),
        }
    }
    Err(error.unwrap_or_else(|| {
        let message = "the facets do not close to a solid: some are so nearly the same that their edges cannot be told \
                       apart; leave out one of each such pair";
        Error::Solid { message: message.to_owned(), place: None }
    }))
}

fn check(facets: &[Facet]) -> Result<(), Error> {
    if facets.len() > MOST_FACETS {
        return Err(Error::value("facets", facets.len(), format!("a cut has at most {MOST_FACETS}")));
    }
    for (k, facet) in facets.iter().enumerate() {
        let Plane { normal, offset } = facet.plane;
        if !offset.is_finite() || offset.abs() > LARGEST {
            let expected = "its distance from the origin must be finite and at most 1e12";
            return Err(Error::value(label(facets, k), offset, expected));
        }
        if !normal.is_finite() || (normal.length() - 1.0).abs() > 1e-6 {
            return Err(Error::value(label(facets, k), normal, "its normal must have length 1"));
        }
    }
    Ok(())
}

/// How messages name facet `k`.
fn label(facets: &[Facet], k: usize) -> String {
    match &facets[k].name {
        Some(name) => format!("facet {} ({})", k + 1, shown(name)),
        None => format!("facet {}", k + 1),
    }
}

fn empty(facets: &[Facet], k: usize) -> Error {
    let message = format!(
        "the facets leave no solid: {} cuts away all that those before it leave; is it on the wrong side?",
        label(facets, k)
    );
    Error::Solid { message, place: None }
}

enum Failure {
    /// The remaining faces of the cube.
    Unbounded(Vec<usize>),
    /// The facet that removed the rest.
    Empty(usize),
    /// Rounding; another tolerance may help.
    Confused,
}

/// A solid in the cut's own frame.
struct Solid {
    polytope: Polytope,
    /// Facets that repeat another, with the other.
    repeated: Vec<(usize, usize)>,
}

/// Estimates of the radius: the largest offset, and the median in case the largest belongs to a plane far from the stone.
fn guesses(planes: &[Plane]) -> [f64; 2] {
    let mut offsets: Vec<f64> = planes.iter().map(|p| p.offset.abs()).filter(|&d| d > 0.0).collect();
    offsets.sort_by(f64::total_cmp);
    let at = |k: usize| offsets.get(k).copied().unwrap_or(1.0);
    [at(offsets.len().saturating_sub(1)), at(offsets.len() / 2)]
}

/// The solid, cut at least twice: first about the origin with an estimated radius, then about its own middle with its own
/// radius, to which the tolerance refers.
fn attempt(planes: &[Plane], guess: f64, tolerance: f64) -> Result<Solid, Failure> {
    let (mut centre, mut radius) = (DVec3::ZERO, guess);
    for round in 0..4 {
        let Solid { mut polytope, repeated } = cut_all(planes, centre, radius, tolerance)?;
        polytope.compact();
        for p in &mut polytope.points {
            *p = centre + radius * *p;
        }
        sharpen(planes, &mut polytope, radius);
        let (middle, own) = frame(&polytope);
        let settled = (middle - centre).length() < 0.5 * own && own > 0.5 * radius;
        if !own.is_finite() || own < SMALLEST {
            return Err(Failure::Confused);
        }
        if settled || round == 3 {
            let polytope = contract(planes, polytope, own);
            let sound = polytope.is_sound() && agrees(planes, &polytope, own);
            return if sound { Ok(Solid { polytope, repeated }) } else { Err(Failure::Confused) };
        }
        (centre, radius) = (middle, own);
    }
    Err(Failure::Confused)
}

/// Cuts the cube with every plane in turn, with `centre` as the origin and `radius` as the unit.
fn cut_all(planes: &[Plane], centre: DVec3, radius: f64, tolerance: f64) -> Result<Solid, Failure> {
    let mut polytope = Polytope::cube(REACH, planes.len());
    let mut repeated = Vec::new();
    for (k, plane) in planes.iter().enumerate() {
        let local =
            Plane { normal: plane.normal, offset: (plane.offset - plane.normal.dot(centre)) / radius };
        match polytope.cut(&local, k, tolerance) {
            Outcome::Cut | Outcome::Redundant => {}
            Outcome::Repeats(other) => repeated.push((k, other)),
            Outcome::Empty => return Err(Failure::Empty(k)),
            Outcome::Confused => return Err(Failure::Confused),
        }
    }
    let unbounded: Vec<usize> =
        polytope.faces.iter().filter(|f| f.plane >= planes.len()).map(|f| f.plane - planes.len()).collect();
    if unbounded.is_empty() { Ok(Solid { polytope, repeated }) } else { Err(Failure::Unbounded(unbounded)) }
}

/// Middle of the bounding box and half its longest side.
fn frame(polytope: &Polytope) -> (DVec3, f64) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = polytope.points.iter().fold(start, |(l, h), p| (l.min(*p), h.max(*p)));
    (0.5 * (low + high), 0.5 * (high - low).max_element())
}

/// Moves each vertex to the intersection of the planes of its faces: exactly for three planes, by least squares for more.
fn sharpen(planes: &[Plane], polytope: &mut Polytope, radius: f64) {
    let mut normals = vec![DMat3::ZERO; polytope.points.len()];
    for face in &polytope.faces {
        let n = planes[face.plane].normal;
        let square = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        face.corners.iter().for_each(|&v| normals[v as usize] += square);
    }
    // Slight damping keeps a vertex between nearly parallel planes in place along their undetermined direction. The rounds
    // compensate for it in the other directions.
    let inverse: Vec<DMat3> =
        normals.iter().map(|m| (*m + DMat3::from_diagonal(DVec3::splat(1e-10))).inverse()).collect();
    for _ in 0..4 {
        let mut right = vec![DVec3::ZERO; polytope.points.len()];
        for face in &polytope.faces {
            let plane = &planes[face.plane];
            for &v in &face.corners {
                right[v as usize] -= plane.normal * plane.distance(polytope.points[v as usize]);
            }
        }
        for ((p, r), m) in polytope.points.iter_mut().zip(right).zip(&inverse) {
            let step = *m * r;
            // The combinatorics are valid near the tolerance only.
            if step.length() < 1e-5 * radius {
                *p += step;
            }
        }
    }
}

/// Contracts edges shorter than [`CONTRACT`] radii; faces with two corners vanish. If the result is not a valid polyhedron,
/// nothing changes.
fn contract(planes: &[Plane], polytope: Polytope, radius: f64) -> Polytope {
    let mut root: Vec<u32> = (0..polytope.points.len() as u32).collect();
    let mut short = false;
    for (a, b) in polytope.faces.iter().flat_map(|f| directed(&f.corners)) {
        if polytope.points[a as usize].distance(polytope.points[b as usize]) < CONTRACT * radius {
            let (a, b) = (find(&mut root, a), find(&mut root, b));
            root[a.max(b) as usize] = a.min(b);
            short = true;
        }
    }
    if !short {
        return polytope;
    }
    let mut points = polytope.points.clone();
    let mut clusters: FxHashMap<u32, (DVec3, f64)> = FxHashMap::default();
    for (v, p) in polytope.points.iter().enumerate() {
        let cluster = clusters.entry(find(&mut root, v as u32)).or_insert((DVec3::ZERO, 0.0));
        *cluster = (cluster.0 + *p, cluster.1 + 1.0);
    }
    for (v, (sum, count)) in clusters {
        points[v as usize] = sum / count;
    }
    let faces = polytope.faces.iter().filter_map(|face| {
        let mut corners: Vec<u32> = face.corners.iter().map(|&v| find(&mut root, v)).collect();
        corners.dedup();
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        (corners.len() >= 3).then_some(Face { plane: face.plane, corners })
    });
    let mut contracted = Polytope { faces: faces.collect(), points };
    contracted.compact();
    sharpen(planes, &mut contracted, radius);
    if contracted.is_sound() && agrees(planes, &contracted, radius) { contracted } else { polytope }
}

/// The representative of `v` in a forest of merged vertices.
fn find(root: &mut [u32], mut v: u32) -> u32 {
    while root[v as usize] != v {
        root[v as usize] = root[root[v as usize] as usize];
        v = root[v as usize];
    }
    v
}

/// Whether no vertex is in front of any plane, or behind that of its own face, by more than contraction explains.
fn agrees(planes: &[Plane], polytope: &Polytope, radius: f64) -> bool {
    let slack = 2.0 * CONTRACT * radius;
    let on = |face: &Face, v: u32| planes[face.plane].distance(polytope.points[v as usize]) >= -slack;
    polytope.points.iter().all(|p| planes.iter().all(|plane| plane.distance(*p) <= slack))
        && polytope.faces.iter().all(|face| face.corners.iter().all(|&v| on(face, v)))
}

/// The mesh with its facets in the order of the cut, and warnings about facets that are not in it.
fn finish(facets: &[Facet], solid: Solid) -> (Mesh, Vec<Warning>) {
    let Solid { mut polytope, repeated } = solid;
    polytope.faces.sort_by_key(|f| f.plane);
    let mut present = vec![false; facets.len()];
    polytope.faces.iter().for_each(|f| present[f.plane] = true);
    let mut warnings = Vec::new();
    let mut pairs = Vec::new();
    for (k, other) in repeated {
        // What repeats a face of the cube that all begins with is not there, since the cube is cut away.
        if present.get(other) == Some(&true) {
            present[k] = true;
            pairs.push(format!("{} repeats {}", label(facets, k), label(facets, other)));
        }
    }
    if !pairs.is_empty() {
        warnings.push(Warning::new(format!("facets given twice were taken once: {}", list(&pairs))));
    }
    let absent: Vec<String> = (0..facets.len()).filter(|&k| !present[k]).map(|k| label(facets, k)).collect();
    if !absent.is_empty() {
        let all = list(&absent);
        warnings.push(Warning::new(format!("facets that do not touch the stone were left out: {all}")));
    }
    let kept = |f: &Face| Facet { plane: facets[f.plane].plane, name: facets[f.plane].name.clone() };
    let mesh_facets = polytope.faces.iter().map(kept).collect();
    let polygons: Vec<Vec<u32>> = polytope.faces.into_iter().map(|f| f.corners).collect();
    (Mesh::from_polygons(polytope.points, &polygons, mesh_facets), warnings)
}

fn list(items: &[String]) -> String {
    let shown = items[..items.len().min(LISTED)].join(", ");
    if items.len() > LISTED { format!("{shown} and {} more", items.len() - LISTED) } else { shown }
}
