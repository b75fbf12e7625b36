//! Areas of pixels on one convex stone or crystal, straight from the equations of [`spectral_core::beam`].

mod crystal;

use super::{Light, Ray, Reference, Walk, refracted, surface::Crossing};
use crate::{
    account::Account,
    schedule::{Finished, Stop},
};
use glam::DVec3;
use spectral_core::{
    beam::{LEAST_AREA, LEAST_DISTANCE, Limits, Pencil, Piece, Polygon, Silhouette, Vectors},
    film::Tile,
    lattice,
    prepare::{FacetPlane, Geometry, Medium, Nest, PreparedScene, PreparedStone},
    stokes::{StokesRow, any_axis},
    tracer::Energy,
};
use std::ops::Range;

/// The facets of a stone, each with those that bound its polygon.
pub(super) struct Facets {
    planes: Vec<FacetPlane>,
    around: Vec<Vec<u32>>,
    inside: Nest,
}

impl Facets {
    pub fn new(geometry: &Geometry, stone: &PreparedStone) -> Self {
        let outlines = geometry.outlines(stone);
        Facets {
            planes: geometry.facets_of(stone).to_vec(),
            around: outlines.into_iter().map(|outline| outline.around).collect(),
            inside: Nest::default().toggled(stone.rank),
        }
    }

    /// The plane that a ray from within meets first.
    fn exit(&self, origin: DVec3, direction: DVec3) -> usize {
        let ahead = self.planes.iter().enumerate().filter_map(|(facet, plane)| {
            let towards = plane.normal.dot(direction);
            (towards > 0.0).then(|| (facet, (plane.offset - plane.normal.dot(origin)) / towards))
        });
        ahead.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(facet, _)| facet)
    }
}

/// A part of a pixel on its way within the stone.
#[derive(Clone, Copy)]
struct Beam {
    /// About the ray of its centroid, beginning at the surface that it comes from.
    pencil: Pencil,
    /// About its centroid.
    polygon: Polygon,
    /// Its intensity is throughput × share of the pixel.
    carried: Carried,
    depth: u32,
    /// The place of its next choice of a mode among the lattice's.
    choice: u32,
}

/// What a beam carries.
#[derive(Clone, Copy)]
enum Carried {
    /// A row with the first axis of its frame.
    Row(StokesRow<f64>, [f64; 3]),
    /// A mode of a crystal, by the sheet that its wave vectors are on.
    Mode { weight: f64, sheet: usize, vectors: Vectors },
}

impl Carried {
    fn intensity(&self) -> f64 {
        match self {
            Carried::Row(row, _) => row.intensity(),
            Carried::Mode { weight, .. } => *weight,
        }
    }
}

impl Beam {
    /// A part of it, in this medium.
    fn part(&self, polygon: &Polygon, share: f64, medium: &Medium) -> Self {
        let centroid = polygon.centroid();
        let mut pencil = self.pencil.about(centroid);
        let carried = match (self.carried, &medium.crystal) {
            (Carried::Mode { weight, sheet, vectors }, Some((crystal, _))) => {
                let vectors = vectors.about(centroid, crystal, sheet);
                pencil = pencil.of_mode(crystal, sheet, &vectors);
                Carried::Mode { weight: weight * share, sheet, vectors }
            }
            (Carried::Row(row, axis), _) => {
                let (axis, along) = (DVec3::from(axis), pencil.direction);
                let axis = (axis - along * along.dot(axis)).normalize().to_array();
                Carried::Row(row.scaled(share), axis)
            }
            (mode, None) => mode,
        };
        Beam { polygon: polygon.moved(centroid.map(|c| -c)), carried, pencil, ..*self }
    }
}

/// What follows the beams of one wavelength.
struct Follower<'a, 'b> {
    walk: &'a mut Walk<'b>,
    facets: &'a Facets,
    medium: Medium,
    limits: Limits,
    pending: Vec<Beam>,
}

impl Reference {
    /// Some samples of every pixel of a tile.
    pub(super) fn areas(
        &self,
        facets: &Facets,
        silhouette: &Silhouette,
        tile: Tile,
        samples: Range<u32>,
        stop: &Stop<'_>,
    ) -> Option<Finished> {
        let scene = &self.scene;
        let limits = silhouette.limits(&scene.settings);
        let (mut account, mut radiances, mut covered) = (Account::default(), Vec::<f64>::new(), Vec::new());
        let mut pieces = Vec::new();
        let row = |y| (tile.x..tile.x + tile.width).map(move |x| (x, y));
        for (x, y) in (tile.y..tile.y + tile.height).flat_map(row) {
            let rest = silhouette.pieces(x, y, &mut pieces);
            let behind = rest.map(|rest| {
                let [u, v] = rest.centroid;
                (rest.area, scene.view.ray(f64::from(x) + 0.5 + u, f64::from(y) + 0.5 + v))
            });
            for sample in samples.clone() {
                let energy = Energy { started: scene.wavelength_count() as f64, ..Energy::default() };
                let mut walk = Walk { energy, ..Walk::new(self, scene.table(sample), sample) };
                for line in 0..scene.wavelength_count() {
                    walk.line = line;
                    let mut sum = 0.0;
                    if let Some((area, ray)) = behind.filter(|_| shows(scene)) {
                        walk.rays += 1;
                        sum += area * walk.light(ray.origin, ray.direction);
                    }
                    let medium = walk.medium(facets.inside);
                    let mut follower =
                        Follower { walk: &mut walk, facets, medium, limits, pending: Vec::new() };
                    for piece in &pieces {
                        sum += follower.enter(piece) + follower.follow(stop);
                    }
                    radiances.push(sum);
                }
                account.add_sample(walk.rays, &walk.energy);
                covered.push(1.0 - rest.map_or(0.0, |rest| rest.area) as f32);
                if stop() {
                    return None;
                }
            }
        }
        Some(Finished::new(scene, tile, samples, radiances, &covered, account))
    }
}

/// Whether what is past the stone is to be seen.
fn shows(scene: &PreparedScene) -> bool {
    scene.background == spectral_core::scene::Background::Environment
}

impl Follower<'_, '_> {
    /// Lists what a piece of a pixel sends into the stone; returns the radiance that it mirrors.
    fn enter(&mut self, piece: &Piece) -> f64 {
        let Pencil { origin, direction, .. } = piece.pencil;
        let normal = self.facets.planes[piece.facet].normal;
        let row = StokesRow::eye().scaled(piece.area);
        if self.medium.crystal.is_some() {
            return self.enter_crystal(piece, -normal);
        }
        let event = Medium::AIR.interface(&self.medium, -direction.dot(normal));
        let axis = any_axis(direction.to_array());
        let [back, on] = self.walk.split(direction, (row, axis), normal, &event);
        if let Light::Row { row, axis } = on {
            let pencil = piece.pencil.refracted(normal, 1.0 / self.medium.n, event.cos_t);
            let carried = Carried::Row(row, axis);
            self.go_on(Beam { pencil, polygon: piece.polygon, carried, depth: 1, choice: 0 });
        }
        self.walk.rays += 2;
        self.walk.light(origin, direction.reflect(normal)) * back.intensity()
    }

    /// Ends a beam that carries too little.
    fn go_on(&mut self, beam: Beam) {
        let share = beam.carried.intensity();
        if share < self.limits.end {
            self.walk.energy.dropped_threshold += share;
        } else if share > 0.0 {
            self.pending.push(beam);
        }
    }

    /// The radiance of all that is listed.
    fn follow(&mut self, stop: &Stop<'_>) -> f64 {
        let mut sum = 0.0;
        while let Some(beam) = self.pending.pop() {
            if stop() {
                self.pending.clear();
                break;
            }
            self.walk.rays += 1;
            let facet = self.facets.exit(beam.pencil.origin, beam.pencil.direction);
            let beam = self.within(facet, beam);
            sum += self.leave(facet, &beam);
        }
        sum
    }

    /// The part of a beam that meets one facet; the others are listed.
    fn within(&mut self, facet: usize, beam: Beam) -> Beam {
        if beam.carried.intensity() < self.limits.split {
            return beam;
        }
        let plane = self.facets.planes[facet];
        let there = beam.pencil.at_plane(plane.normal, plane.offset);
        let (whole, mut polygon) = (beam.polygon.area(), beam.polygon);
        let mut left = 1.0;
        for (number, &side) in self.facets.around[facet].iter().enumerate() {
            let side = self.facets.planes[side as usize];
            let line = there.before(side.normal, side.offset);
            let most = polygon.vertices().iter().map(|v| line.at(*v)).fold(f64::NEG_INFINITY, f64::max);
            if most <= LEAST_DISTANCE * (line.by[0].abs() + line.by[1].abs()) {
                continue;
            }
            let [inside, outside] = polygon.cut(|place| line.at(place));
            if inside.area().min(outside.area()) < LEAST_AREA {
                continue;
            }
            let share = outside.area() / whole;
            let choice = lattice::part(beam.choice, number);
            self.pending.push(Beam { choice, ..beam.part(&outside, share, &self.medium) });
            (polygon, left) = (inside, left - share);
        }
        if left == 1.0 { beam } else { beam.part(&polygon, left, &self.medium) }
    }

    /// Where a beam meets a facet from within: lists what is reflected; returns the radiance of what leaves.
    fn leave(&mut self, facet: usize, beam: &Beam) -> f64 {
        let FacetPlane { normal, offset, .. } = self.facets.planes[facet];
        let distance = beam.pencil.distance(normal, offset).max(0.0);
        let there = beam.pencil.at_plane(normal, offset);
        let (direction, inward) = (there.direction, -normal);
        let Carried::Row(row, axis) = beam.carried else {
            return self.leave_crystal(beam, &there, normal, distance);
        };
        let row = row.scaled(self.medium.transmittance(distance));
        if self.is_last(beam) {
            return self.at_limit(beam, Light::Row { row, axis }, inward, distance);
        }
        let event = self.medium.interface(&Medium::AIR, direction.dot(normal));
        let [back, on] = self.walk.split(direction, (row, axis), inward, &event);
        if let Light::Row { row, axis } = back {
            let (carried, depth) = (Carried::Row(row, axis), beam.depth + 1);
            self.go_on(Beam { pencil: there.reflected(normal), carried, depth, ..*beam });
        }
        if event.tir {
            return 0.0;
        }
        self.walk.rays += 1;
        let out = refracted(direction, inward, &event, self.medium.n);
        self.walk.light(there.origin, out) * on.intensity()
    }

    /// Whether it has met as many surfaces as it may.
    fn is_last(&self, beam: &Beam) -> bool {
        beam.depth == self.walk.reference.scene.settings.max_depth
    }

    fn at_limit(&mut self, beam: &Beam, light: Light, inward: DVec3, distance: f64) -> f64 {
        let Pencil { origin, direction, .. } = beam.pencil;
        let ray = Ray { origin, direction, light, nest: self.facets.inside, depth: beam.depth };
        let (before, after) = (self.facets.inside, Nest::default());
        self.walk.at_limit(&ray, &Crossing { distance, normal: inward, before, after })
    }
}
