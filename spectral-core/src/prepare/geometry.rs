//! The stones' surfaces as flat arrays in local coordinates.

use super::{
    nest::{Nest, Rank},
    substance::substances,
};
use crate::{
    Error, memory,
    mesh::{Mesh, Placement, Plane, solid_angle},
    scene::{Stone, Up},
};
use glam::DVec3;
use std::ops::Range;
use std::sync::{Arc, Weak};

/// The exact plane of a facet: n·x = offset, n the unit normal out of the stone.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FacetPlane {
    /// Unit, outward.
    pub normal: DVec3,
    /// mm from the local origin along the normal.
    pub offset: f64,
    /// Index into [`Geometry::stones`].
    pub stone: u32,
}

/// One stone's share of the flat arrays. A stone that is the union of several solids counts as one stone a solid.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PreparedStone {
    /// For messages.
    pub name: String,
    /// Its facets.
    pub facets: Range<u32>,
    /// Its triangles.
    pub triangles: Range<u32>,
    /// Index into [`SpectralTable::media`](super::SpectralTable::media) of its material; equal materials
    /// share one, crystals if they lie alike.
    pub material: u32,
    /// Its place in the order of priority.
    pub rank: Rank,
    /// Whether it is convex.
    pub convex: bool,
    /// Whether it is a metal.
    pub conductor: bool,
    /// Whether it is traced as a doubly refracting crystal.
    pub crystal: bool,
    /// Lowest corner of its bounds.
    pub low: DVec3,
    /// Highest corner of its bounds.
    pub high: DVec3,
}

impl PreparedStone {
    /// Stones with more facets are intersected through a hierarchy, not plane by plane.
    pub const MOST_PLANES: u32 = 1024;

    /// Whether it is convex, with few enough facets to be intersected plane by plane.
    pub fn has_few_planes(&self) -> bool {
        self.convex && self.facets.len() <= Self::MOST_PLANES as usize
    }
}

/// What a stone's surface is made of, beside what [`PreparedStone`] says. The mesh is not kept alive: large ones are
/// given back once they are prepared.
#[derive(Debug, Clone)]
struct Source {
    mesh: Weak<Mesh>,
    place: Place,
    /// Its first solid, an index into [`Geometry::stones`].
    first: u32,
}

/// A stone's upright axis, width, rotation, position and priority.
type Place = (Up, Option<f64>, DVec3, DVec3, i32);

fn place(stone: &Stone) -> Place {
    (stone.up, stone.width, stone.rotation, stone.position, stone.priority)
}

/// All stones' surfaces. Lengths in mm.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Geometry {
    /// The local origin in the world: the middle of the stones.
    pub origin: DVec3,
    /// Vertices.
    pub positions: Vec<DVec3>,
    /// Vertex indices, counter-clockwise seen from outside the stone.
    pub triangles: Vec<[u32; 3]>,
    /// The facet of each triangle.
    pub facet_of: Vec<u32>,
    /// Exact planes.
    pub facets: Vec<FacetPlane>,
    /// The stones, or the solids that they are the union of, in the order of the scene.
    pub stones: Vec<PreparedStone>,
    /// The index of the stone of each rank.
    pub stone_of_rank: Vec<u32>,
    /// Radius of a sphere about the local origin that holds everything.
    pub radius: f64,
    /// Whether two stones come so near each other that their surfaces may be in optical contact.
    pub contacts: bool,
    /// By stone of the scene.
    sources: Vec<Source>,
}

/// The most that a triangle takes while a hierarchy is built over it, as `cli/tests/memory.rs` measures.
const BYTES_A_TRIANGLE: u64 = 268;

impl Geometry {
    /// Surfaces nearer than this share of [`Geometry::radius`] are in optical contact: no air between.
    ///
    /// 10 ppm of a 6.5 mm stone's radius is 33 nm, a tenth of a wavelength, across which light tunnels; it
    /// is also some 80 units in the last place of a single-precision coordinate.
    pub const CONTACT: f64 = 1e-5;

    /// Places the stones.
    pub(super) fn new(stones: &[Stone]) -> Result<Geometry, Error> {
        let placed = stones.iter().map(Placed::new).collect::<Result<Vec<_>, _>>()?;
        let mut low = DVec3::splat(f64::INFINITY);
        let mut high = -low;
        for (l, h) in placed.iter().flat_map(|placed| &placed.solids) {
            (low, high) = (low.min(*l), high.max(*h));
        }
        let origin = if stones.is_empty() { DVec3::ZERO } else { (low + high) / 2.0 };
        let mut geometry = Geometry { origin, ..Geometry::with_room(&placed)? };
        geometry.stone_of_rank = order(&placed);
        let (distinct, materials) = substances(stones)?;
        for (placed, material) in placed.iter().zip(materials) {
            geometry.push(placed, material, distinct[material as usize].axes.is_some());
        }
        for (rank, &stone) in geometry.stone_of_rank.iter().enumerate() {
            geometry.stones[stone as usize].rank = rank as Rank;
        }
        geometry.radius = geometry.positions.iter().map(|p| p.length()).fold(0.0, f64::max);
        let contacts = geometry.near_pairs(geometry.radius * Self::CONTACT).next().is_some();
        geometry.contacts = contacts;
        geometry.check_overlaps()?;
        Ok(geometry)
    }

    /// Whether these stones would give this very geometry.
    pub(super) fn is_of(&self, stones: &[Stone]) -> bool {
        let made = self.sources.iter().map(|source| (&self.stones[source.first as usize], source));
        let Ok((distinct, materials)) = substances(stones) else { return false };
        let same = |(((prepared, source), stone), material): (((&PreparedStone, &Source), &Stone), u32)| {
            source.place == place(stone)
                && (prepared.material, prepared.conductor) == (material, stone.material.is_conductor())
                && prepared.crystal == distinct[material as usize].axes.is_some()
                && prepared.name == stone.name
                && source.mesh.upgrade().is_some_and(|m| Arc::ptr_eq(&m, &stone.mesh) || m == stone.mesh)
        };
        self.sources.len() == stones.len() && made.zip(stones).zip(materials).all(same)
    }

    /// Empty, with the memory that the stones will take.
    fn with_room(placed: &[Placed]) -> Result<Geometry, Error> {
        let total = |count: fn(&Mesh) -> usize| placed.iter().map(|p| count(&p.stone.mesh)).sum();
        let triangles = total(|m| m.triangles().len());
        let what = || format!("a scene of {triangles} triangles");
        memory::check(triangles as u64 * BYTES_A_TRIANGLE, what)?;
        Ok(Geometry {
            positions: memory::reserved(total(|m| m.positions().len()), what)?,
            triangles: memory::reserved(triangles, what)?,
            facet_of: memory::reserved(triangles, what)?,
            facets: memory::reserved(total(|m| m.facets().len()), what)?,
            ..Geometry::default()
        })
    }

    fn push(&mut self, placed: &Placed, material: u32, crystal: bool) {
        let Placed { stone: Stone { mesh, name, material: substance, .. }, placement, solids } = placed;
        let (stone, origin) = (self.stones.len() as u32, self.origin);
        let (vertex, triangle, facet) =
            (self.positions.len() as u32, self.triangles.len() as u32, self.facets.len() as u32);
        self.sources.push(Source { mesh: Arc::downgrade(mesh), place: place(placed.stone), first: stone });
        self.positions.extend(mesh.positions().iter().map(|p| placement.point(*p) - origin));
        self.triangles.extend(mesh.triangles().iter().map(|t| t.map(|v| v + vertex)));
        self.facet_of.extend(mesh.facet_of().iter().map(|f| f + facet));
        // Facets are numbered as the triangles are, so those of a solid follow each other.
        let facet_at = |t: u32| mesh.facet_of().get(t as usize).map_or(mesh.facets().len() as u32, |f| *f);
        for ((solid, (low, high)), number) in mesh.solids().zip(solids).zip(stone..) {
            let facets = facet_at(solid.start)..facet_at(solid.end);
            let own = &mesh.facets()[facets.start as usize..facets.end as usize];
            self.facets.extend(own.iter().map(|f| {
                let Plane { normal, offset } = placement.plane(&f.plane);
                FacetPlane { normal, offset: offset - normal.dot(origin), stone: number }
            }));
            self.stones.push(PreparedStone {
                name: name.clone(),
                facets: facet + facets.start..facet + facets.end,
                triangles: triangle + solid.start..triangle + solid.end,
                material,
                rank: 0,
                convex: mesh.is_convex(),
                conductor: substance.is_conductor(),
                crystal,
                low: *low - origin,
                high: *high - origin,
            });
        }
    }

    /// A stone's facets.
    pub fn facets_of(&self, stone: &PreparedStone) -> &[FacetPlane] {
        &self.facets[stone.facets.start as usize..stone.facets.end as usize]
    }

    /// A stone's triangles.
    pub fn triangles_of(&self, stone: &PreparedStone) -> &[[u32; 3]] {
        &self.triangles[stone.triangles.start as usize..stone.triangles.end as usize]
    }

    /// The index of the material of the stone of each rank.
    pub fn material_of_rank(&self) -> Vec<u32> {
        (0..).zip(&self.stone_of_rank).map(|(rank, _)| self.stone(rank).material).collect()
    }

    /// The stone of a rank.
    pub fn stone(&self, rank: Rank) -> &PreparedStone {
        &self.stones[self.stone_of_rank[rank as usize] as usize]
    }

    /// The stones that a point lies in, by their winding number about it.
    pub fn nest_at(&self, point: DVec3) -> Nest {
        self.stones
            .iter()
            .filter(|s| self.winding(s, point) > 0.5)
            .fold(Nest::default(), |n, s| n.toggled(s.rank))
    }

    /// How often a stone's surface goes around a point: 1 inside, 0 outside.
    pub(super) fn winding(&self, stone: &PreparedStone, point: DVec3) -> f64 {
        if (stone.low - point).max_element() > 0.0 || (point - stone.high).max_element() > 0.0 {
            return 0.0;
        }
        let angle = |t: &[u32; 3]| solid_angle(t.map(|v| self.positions[v as usize] - point));
        self.triangles_of(stone).iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
    }
}

/// A stone and where it stands. The placed mesh is not made: a large one would take its memory twice.
struct Placed<'a> {
    stone: &'a Stone,
    placement: Placement,
    /// The bounds of each solid in the world.
    solids: Vec<(DVec3, DVec3)>,
}

impl<'a> Placed<'a> {
    fn new(stone: &'a Stone) -> Result<Self, Error> {
        let placement = stone.placement()?;
        let mesh = &stone.mesh;
        let bounds = |solid| placement.bounds(mesh, solid);
        Ok(Placed { stone, placement, solids: mesh.solids().map(bounds).collect() })
    }
}

/// Indices of solids from the lowest priority to the highest. Those of one stone follow each other.
fn order(placed: &[Placed]) -> Vec<u32> {
    struct Solid {
        priority: i32,
        /// Of the whole stone, and of the solid.
        volumes: [f64; 2],
        stone: usize,
    }
    let solids_of = |(stone, placed): (usize, &Placed)| -> Vec<Solid> {
        let Placed { stone: Stone { mesh, priority, .. }, placement, solids } = placed;
        let volume = |(solid, bounds)| placement.volume(mesh, solid, bounds);
        let volumes: Vec<f64> = mesh.solids().zip(solids.iter().copied()).map(volume).collect();
        let whole = volumes.iter().sum();
        volumes.iter().map(|&own| Solid { priority: *priority, volumes: [whole, own], stone }).collect()
    };
    let solids: Vec<Solid> = placed.iter().enumerate().flat_map(solids_of).collect();
    let mut order: Vec<u32> = (0..solids.len() as u32).collect();
    order.sort_by(|&a, &b| {
        let [p, q] = [a, b].map(|k| &solids[k as usize]);
        // Descending volume: the smaller one ranks higher.
        let by_volume = |k: usize| q.volumes[k].total_cmp(&p.volumes[k]);
        p.priority
            .cmp(&q.priority)
            .then(by_volume(0))
            .then(p.stone.cmp(&q.stone))
            .then(by_volume(1))
            .then(a.cmp(&b))
    });
    order
}
