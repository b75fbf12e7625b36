//! The stones of a scene as the page draws them: edges and facets, at the pose that is none.

use crate::scene_file::LoadedScene;
use crate::tier;
use glam::{DMat3, DQuat, DVec3, EulerRot};
use serde_json::{Value, json};
use spectral_core::mesh::{Mesh, Plane};
use spectral_core::scene::Stone;
use std::collections::HashMap;

/// Stones of more triangles than this are drawn without edges.
const MOST_TRIANGLES: usize = 40_000;

/// The stones of a scene that its pose turns, and how to undo the pose.
pub struct Solid<'a> {
    stones: Vec<&'a Stone>,
    pub middle: DVec3,
    back: DMat3,
}

/// A facet of a scene: the stone and the facet of its mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    pub stone: usize,
    pub facet: usize,
}

impl<'a> Solid<'a> {
    pub fn new(loaded: &'a LoadedScene, pose: DQuat) -> Self {
        let stones = loaded.scene.stones.iter().filter(|stone| stone.name != "the ground").collect();
        let middle = loaded.pivot.unwrap_or(DVec3::ZERO);
        Solid { stones, middle, back: DMat3::from_quat(pose).transpose() }
    }

    /// A point of the posed scene as it would be without the pose.
    pub fn unposed(&self, point: DVec3) -> DVec3 {
        self.middle + self.back * (point - self.middle)
    }

    /// A direction likewise.
    pub fn unturned(&self, direction: DVec3) -> DVec3 {
        self.back * direction
    }

    /// Facets of all stones.
    pub fn facet_count(&self) -> usize {
        self.stones.iter().map(|stone| stone.mesh.facets().len()).sum()
    }

    /// The facet of a number that counts through the facets of all stones.
    pub fn place(&self, number: usize) -> Option<Place> {
        let mut left = number;
        for (stone, mesh) in self.stones.iter().map(|stone| &stone.mesh).enumerate() {
            if left < mesh.facets().len() {
                return Some(Place { stone, facet: left });
            }
            left -= mesh.facets().len();
        }
        None
    }

    /// How a stone is turned without the pose, degrees about x, then y, then z.
    pub fn rotation(&self, stone: &Stone) -> DVec3 {
        let (z, y, x) = (self.back * turned(stone)).to_euler(EulerRot::ZYX);
        DVec3::new(x, y, z) * 180.0 / std::f64::consts::PI
    }

    /// The normal of the first stone's table.
    pub fn normal(&self) -> DVec3 {
        self.unturned(self.stones.first().map_or(DVec3::Z, |stone| turned(stone) * DVec3::Z))
    }

    /// All vertices.
    pub fn corners(&self) -> Vec<DVec3> {
        let placed = self.stones.iter().filter_map(|stone| stone.placed().ok());
        placed.flat_map(|mesh| mesh.positions().to_vec()).map(|corner| self.unposed(corner)).collect()
    }

    /// Edges between facets, each with the outward normals of the two: `[p, q, n, m]`.
    pub fn edges(&self) -> Value {
        let all: usize = self.stones.iter().map(|stone| stone.mesh.triangles().len()).sum();
        let drawn = self.stones.iter().filter(|_| all <= MOST_TRIANGLES);
        let placed: Vec<Mesh> = drawn.filter_map(|stone| stone.placed().ok()).collect();
        let edges = placed.iter().flat_map(|mesh| {
            let point = |vertex: u32| shown(self.unposed(mesh.positions()[vertex as usize]));
            let normal = |facet: u32| shown(self.unturned(mesh.facets()[facet as usize].plane.normal));
            between(mesh).into_iter().map(move |(ends, facets)| {
                json!([point(ends[0]), point(ends[1]), normal(facets[0]), normal(facets[1])])
            })
        });
        Value::Array(edges.collect())
    }

    /// The corners of a facet, in order; empty if it is not there.
    pub fn outline(&self, place: Place) -> Vec<DVec3> {
        let Some(mesh) = self.stones.get(place.stone).and_then(|stone| stone.placed().ok()) else {
            return Vec::new();
        };
        boundary(&mesh, place.facet as u32)
            .into_iter()
            .map(|v| self.unposed(mesh.positions()[v as usize]))
            .collect()
    }

    /// Name and angles of a facet; the gear of the design makes an index of its azimuth.
    pub fn facet(&self, place: Place, gear: Option<i32>) -> Option<Value> {
        let stone = self.stones.get(place.stone)?;
        let facet = stone.mesh.facets().get(place.facet)?;
        let normal = stone.up.matrix() * facet.plane.normal;
        let plane = Plane { normal, ..facet.plane };
        let tilt = normal.z.clamp(-1.0, 1.0).acos().to_degrees();
        let level = !(0.01..179.99).contains(&tilt);
        let index = gear.filter(|gear| *gear != 0 && !level).map(|gear| index(&plane, gear));
        Some(json!({
            "name": facet.name.clone().unwrap_or_else(|| format!("facet {}", place.facet + 1)),
            "tier": facet.name, "part": tier::part(tilt), "angle": tilt.min(180.0 - tilt), "index": index,
            "stone": stone.name,
        }))
    }

    /// The tiers of the first stone: facets of one angle and distance.
    pub fn tiers(&self) -> Value {
        let Some(mesh) =
            self.stones.first().map(|stone| &stone.mesh).filter(|mesh| mesh.facets().len() <= 2000)
        else {
            return json!([]);
        };
        let facets: Vec<_> =
            mesh.facets().iter().map(|facet| (&facet.plane, facet.name.as_deref())).collect();
        let row = |tier: tier::Tier| json!({ "name": tier.name, "part": tier.part(), "count": tier.facets, "angle": tier.angle() });
        Value::Array(tier::group(&facets).into_iter().map(row).collect())
    }
}

/// How a stone is turned.
fn turned(stone: &Stone) -> DMat3 {
    let angles = stone.rotation * std::f64::consts::PI / 180.0;
    DMat3::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x)
}

/// The index of a facet on a gear of so many teeth: azimuths count clockwise from +y as seen from +z.
fn index(plane: &Plane, gear: i32) -> f64 {
    let azimuth = plane.normal.x.atan2(plane.normal.y).to_degrees();
    let teeth = f64::from(gear.abs());
    let index = (azimuth / 360.0 * f64::from(gear)).rem_euclid(teeth);
    // What is a whole tooth but for rounding is one, and the first is the last.
    let whole = (index * 100.0).round() / 100.0;
    if whole == 0.0 { teeth } else { whole }
}

/// A point or a direction with the digits that a picture needs.
pub fn shown(v: DVec3) -> [f64; 3] {
    v.to_array().map(|c| (c * 1e5).round() / 1e5)
}

/// The edges between different facets: their ends and the two facets.
fn between(mesh: &Mesh) -> Vec<([u32; 2], [u32; 2])> {
    let mut first: HashMap<[u32; 2], u32> = HashMap::new();
    let mut found = Vec::new();
    for (triangle, facet) in mesh.triangles().iter().zip(mesh.facet_of()) {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            let ends = [a.min(b), a.max(b)];
            match first.remove(&ends) {
                None => drop(first.insert(ends, *facet)),
                Some(other) if other != *facet => found.push((ends, [other, *facet])),
                Some(_) => {}
            }
        }
    }
    found
}

/// The vertices around a facet; of one with holes, one of its borders.
fn boundary(mesh: &Mesh, facet: u32) -> Vec<u32> {
    let own = mesh.triangles().iter().zip(mesh.facet_of()).filter(|(_, of)| **of == facet);
    let sides: Vec<[u32; 2]> = own.flat_map(|(t, _)| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).collect();
    let outer = sides.iter().filter(|[a, b]| !sides.contains(&[*b, *a]));
    let next: HashMap<u32, u32> = outer.map(|[a, b]| (*a, *b)).collect();
    let Some(start) = next.keys().min().copied() else { return Vec::new() };
    let mut around = vec![start];
    while let Some(&vertex) = around.last().and_then(|last| next.get(last))
        && vertex != start
        && around.len() <= next.len()
    {
        around.push(vertex);
    }
    around
}
