//! Any scene: several stones, nested and touching, non-convex, metals. A path is a tree.

mod carrier;
mod packet;

use crate::{
    account::Account,
    block::Block,
    environment::Light,
    planes::Planes,
    schedule::{Finished, Stop, TileTracer},
    surface::{Crossing, Surfaces},
    throughput::{Mean, Polarized},
};
use accel::lanes::Lanes;
use accel::{Instructions, Task};
use carrier::{Carrier, Mixed};
use glam::Vec3;
use packet::Walk;
use spectral_core::{
    camera::CameraRay,
    film::Tile,
    lattice::power,
    prepare::{FacetPlane, Geometry, Nest, PreparedScene, PreparedStone, Rank},
    scene::Background,
    settings::{Leftover, RenderSettings},
};
use std::ops::Range;
use std::sync::Arc;

/// The rules of transport over the scene's surfaces.
#[derive(Debug)]
pub(crate) struct Tree {
    surfaces: Arc<Surfaces>,
    /// By rank: the planes of the convex stones that nothing else comes near.
    alone: Vec<Option<Planes>>,
    /// By rank: a sphere about each stone, centre and squared radius, where there are few stones.
    spheres: Vec<(Vec3, f32)>,
    max_depth: u32,
    threshold: f32,
    leftover: Leftover,
    /// Of two modes of which one is lighter than this, one is followed for both.
    split: f32,
    polarized: bool,
    /// Where any stone is a crystal: by surface event, its part in the choices of modes (`lattice::power`).
    powers: Vec<u32>,
    /// The stones that the eye is in.
    eye_nest: Nest,
    instructions: Instructions,
}

/// A camera ray's first crossing, if it has one.
#[derive(Debug, Clone, Copy)]
struct Arrival {
    origin: Vec3,
    direction: Vec3,
    crossing: Option<Crossing>,
    /// The light behind the stones, for a ray that meets none.
    colour: [f32; 3],
}

/// A tree with its light.
pub(crate) struct TreeTracer<'a> {
    pub tree: &'a Tree,
    pub scene: &'a PreparedScene,
    pub light: &'a Light,
}

/// A tile's paths, for any instruction set.
struct Paths<'a> {
    tracer: &'a TreeTracer<'a>,
    /// The samples of each pixel in turn.
    arrivals: &'a [Arrival],
    /// Samples a pixel.
    samples: usize,
    blocks: &'a [Block],
    radiances: &'a mut [f32],
    account: &'a mut Account,
    stop: &'a Stop<'a>,
}

/// With more stones than this, their spheres are not tested one by one.
const FEW: usize = 16;

impl Tree {
    pub fn new(scene: &PreparedScene, surfaces: Arc<Surfaces>, instructions: Instructions) -> Self {
        let RenderSettings { max_depth, threshold, leftover, split, polarized, .. } = scene.settings;
        let geometry = &scene.geometry;
        let by_rank = || (0..geometry.stones.len()).map(|rank| geometry.stone(rank as Rank));
        let lone = alone(geometry);
        let planes = |&stone: &u32| {
            lone[stone as usize].then(|| Planes::new(geometry, &geometry.stones[stone as usize]))
        };
        let alone = geometry.stone_of_rank.iter().map(planes).collect();
        let few = geometry.stones.len() <= FEW;
        let crystals = geometry.stones.iter().any(|stone| stone.crystal);
        let spheres = if few { by_rank().map(sphere).collect() } else { Vec::new() };
        Tree {
            surfaces,
            alone,
            spheres,
            max_depth,
            threshold: threshold as f32,
            leftover,
            split: split as f32,
            polarized,
            powers: if crystals { (0..=max_depth).map(power).collect() } else { Vec::new() },
            eye_nest: scene.eye_nest,
            instructions,
        }
    }

    /// The planes of the stone that rays with this nest are in, if nothing else can be met there.
    #[inline]
    fn planes(&self, nest: Nest) -> Option<(Rank, &Planes)> {
        let rank = nest.top()?;
        let planes = self.alone[rank as usize].as_ref()?;
        (nest == Nest::default().toggled(rank)).then_some((rank, planes))
    }
}

/// Of each stone whether it is convex, transparent, and apart from all others, as their boxes or one of its facets' planes
/// show.
fn alone(geometry: &Geometry) -> Vec<bool> {
    let gap = 2.0 * f64::from(geometry.rounding().contact.max(geometry.rounding().margin));
    let beyond = |other: &PreparedStone, facet: &FacetPlane| {
        let corners =
            geometry.triangles_of(other).iter().flatten().map(|&corner| geometry.positions[corner as usize]);
        corners.into_iter().all(|corner| facet.normal.dot(corner) > facet.offset + gap)
    };
    let apart = |stone: &PreparedStone, other: &PreparedStone| {
        (stone.low - gap).cmpgt(other.high).any()
            || (stone.high + gap).cmplt(other.low).any()
            || geometry.facets_of(stone).iter().any(|facet| beyond(other, facet))
    };
    let stones = &geometry.stones;
    let mut alone: Vec<bool> =
        stones.iter().map(|stone| stone.has_few_planes() && !stone.conductor).collect();
    // Twice the gap, so that no pair is left out by rounding.
    for (a, b) in geometry.near_pairs(2.0 * gap) {
        for (one, other) in [(a, b), (b, a)] {
            alone[one] = alone[one] && apart(&stones[one], &stones[other]);
        }
    }
    alone
}

/// A sphere about a stone's box, a little larger than rounding needs.
fn sphere(stone: &PreparedStone) -> (Vec3, f32) {
    let radius = (stone.high - stone.low).length() / 2.0 * 1.001;
    (((stone.low + stone.high) / 2.0).as_vec3(), (radius * radius) as f32)
}

impl TileTracer for TreeTracer<'_> {
    fn tile(&self, tile: Tile, samples: Range<u32>, stop: &Stop<'_>) -> Option<Finished> {
        let tables = samples.clone().map(|sample| self.scene.table(sample));
        let blocks = match self.tree.powers.as_slice() {
            [] => Block::all(1, tables),
            _ => Block::choosing(samples.start, tables),
        };
        let rays = self.scene.camera_rays(tile, samples.clone());
        let arrival = |(_, ray): (u32, CameraRay)| if stop() { None } else { Some(self.arrival(&ray)) };
        let arrivals: Vec<Arrival> = rays.map(arrival).collect::<Option<_>>()?;
        let mut radiances = vec![0.0; arrivals.len() * self.scene.wavelength_count()];
        let mut account = Account::default();
        account.start(radiances.len());
        let finished = self.tree.instructions.run(Paths {
            tracer: self,
            arrivals: &arrivals,
            samples: samples.len(),
            blocks: &blocks,
            radiances: &mut radiances,
            account: &mut account,
            stop,
        });
        let covered: Vec<bool> = arrivals.iter().map(|arrival| arrival.crossing.is_some()).collect();
        finished.then(|| Finished::new(self.scene, tile, samples, radiances, &covered, account))
    }
}

impl TreeTracer<'_> {
    fn arrival(&self, ray: &CameraRay) -> Arrival {
        let scene = self.scene;
        let direction = ray.direction.as_vec3();
        let start = scene.geometry.approach(ray).map(|start| start.as_vec3());
        let origin = start.unwrap_or_default();
        let crossing = start.and_then(|origin| self.tree.surfaces.next(origin, direction, scene.eye_nest));
        let colour = if crossing.is_none() { scene.background_of(ray) } else { [0.0; 3] };
        Arrival { origin, direction, crossing, colour }
    }
}

impl Task for Paths<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<V: Lanes>(self) -> bool {
        if !self.tracer.tree.powers.is_empty() {
            self.follow::<V, Mixed<V>>()
        } else if self.tracer.tree.polarized {
            self.follow::<V, Polarized<V>>()
        } else {
            self.follow::<V, Mean<V>>()
        }
    }
}

impl Paths<'_> {
    /// Follows all paths; false if broken off.
    #[inline(always)]
    fn follow<V: Lanes, T: Carrier<V>>(self) -> bool {
        let TreeTracer { tree, scene, light } = self.tracer;
        let behind = scene.background != Background::Transparent;
        let lines = scene.wavelength_count() * self.samples;
        let mut walk = Walk::<V, T>::new(tree, light, self.account, self.stop);
        for (pixel, arrivals) in self.arrivals.chunks_exact(self.samples).enumerate() {
            for block in self.blocks {
                let radiances = walk.radiance(block, arrivals, behind);
                block.scatter(radiances, &mut self.radiances[pixel * lines..][..lines]);
            }
            if (self.stop)() {
                return false;
            }
        }
        true
    }
}
