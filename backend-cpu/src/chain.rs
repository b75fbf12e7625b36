//! One convex stone under an environment: what leaves never returns, so a path is a chain of internal
//! reflections, not a tree, and the next facet is the nearest plane.

mod packet;

use crate::{
    account::Account,
    block::Block,
    entry::Entry,
    environment::{Light, Lookup},
    planes::Planes,
    schedule::{Finished, Stop, TileTracer},
    throughput::{Mean, Polarized, Throughput, first_axis},
};
use accel::lanes::{Lanes, Row, Triple, WIDTH, put};
use accel::{Instructions, Task};
use glam::DVec3;
use packet::{Arrival, Batch};
use spectral_core::{
    camera::CameraRay,
    film::Tile,
    prepare::PreparedScene,
    scene::Background,
    settings::{Leftover, RenderSettings},
};
use std::ops::Range;

/// The scene reduced to one convex stone.
#[derive(Debug, Clone)]
pub(crate) struct Chain {
    planes: Planes,
    pub material: usize,
    pub max_depth: u32,
    pub threshold: f32,
    pub leftover: Leftover,
    pub instructions: Instructions,
}

/// A chain with its light and its spectral lines.
pub(crate) struct ChainTracer<'a> {
    pub chain: &'a Chain,
    pub scene: &'a PreparedScene,
    pub light: &'a Light,
}

/// A tile's paths, for any instruction set.
struct Paths<'a> {
    tracer: &'a ChainTracer<'a>,
    /// The samples of each pixel in turn.
    arrivals: Vec<Arrival>,
    /// Samples a pixel.
    samples: usize,
    /// Pixels that share their blocks.
    pixels: usize,
    /// The first block of the last pixels, which may be fewer.
    last: usize,
    blocks: &'a [Block],
    radiances: &'a mut [f32],
    account: &'a mut Account,
    stop: &'a Stop<'a>,
}

impl Chain {
    /// The chain for a scene, if it is one convex stone seen from outside.
    pub fn new(scene: &PreparedScene, instructions: Instructions) -> Option<Self> {
        let stone = scene.lone_convex_stone()?;
        let RenderSettings { max_depth, threshold, leftover, .. } = scene.settings;
        Some(Chain {
            planes: Planes::new(&scene.geometry, stone),
            material: stone.material as usize,
            max_depth,
            threshold: threshold as f32,
            leftover,
            instructions,
        })
    }

    /// The stone's planes.
    pub fn planes(&self) -> &Planes {
        &self.planes
    }
}

impl TileTracer for ChainTracer<'_> {
    fn tile(&self, tile: Tile, samples: Range<u32>, stop: &Stop<'_>) -> Option<Finished> {
        let (wavelengths, count) = (self.scene.wavelength_count(), samples.len());
        let arrivals = self.arrivals(tile, &samples);
        let pixels = Block::pixels(wavelengths * count);
        let tables = || samples.clone().map(|sample| self.scene.table(sample));
        let rest = arrivals.len() / count % pixels;
        let blocks = [pixels, rest].map(|pixels| Block::all(pixels, tables()));
        let covered: Vec<bool> = arrivals.iter().map(|arrival| arrival.covered).collect();
        let mut radiances = vec![0.0; arrivals.len() * wavelengths];
        let mut account = Account::default();
        account.start(radiances.len());
        let finished = self.chain.instructions.run(Paths {
            tracer: self,
            arrivals,
            samples: count,
            pixels,
            last: blocks[0].len(),
            blocks: &blocks.concat(),
            radiances: &mut radiances,
            account: &mut account,
            stop,
        });
        finished.then(|| Finished::new(self.scene, tile, samples, radiances, &covered, account))
    }
}

impl ChainTracer<'_> {
    fn arrivals(&self, tile: Tile, samples: &Range<u32>) -> Vec<Arrival> {
        let scene = self.scene;
        let mut entry = Entry::new(&scene.geometry, &scene.geometry.stones[0], &self.chain.planes);
        let rays = scene.camera_rays(tile, samples.clone());
        rays.map(|(_, ray)| self.arrival(&ray, entry.next(&ray))).collect()
    }

    fn arrival(&self, ray: &CameraRay, entry: Option<(DVec3, usize)>) -> Arrival {
        let Some((point, facet)) = entry else {
            return Arrival { colour: self.scene.background_of(ray), ..Arrival::default() };
        };
        let (direction, normal) = (ray.direction.as_vec3(), self.chain.planes.normal(facet));
        Arrival {
            covered: true,
            point: point.as_vec3().to_array(),
            direction: direction.to_array(),
            inward: normal.map(|n| -n),
            axis: first_axis(direction.to_array(), normal),
            cosine: -direction.dot(normal.into()),
            colour: [0.0; 3],
        }
    }
}

impl Task for Paths<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<V: Lanes>(mut self) -> bool {
        self.mirror::<V>();
        if self.tracer.scene.settings.polarized {
            self.follow::<V, Polarized<V>>()
        } else {
            self.follow::<V, Mean<V>>()
        }
    }
}

impl Paths<'_> {
    /// Looks up what the first surface mirrors.
    #[inline(always)]
    fn mirror<V: Lanes>(&mut self) {
        for group in self.arrivals.chunks_mut(WIDTH) {
            let mut normal = [Row::default(); 3];
            let mut direction = [Row::default(); 3];
            let mut point = [Row::default(); 3];
            let (mut cosine, mut lanes) = (Row::default(), 0);
            for (lane, arrival) in group.iter().enumerate() {
                lanes |= u16::from(arrival.covered) << lane;
                cosine.0[lane] = 2.0 * arrival.cosine;
                put(&mut normal, lane, arrival.inward);
                put(&mut direction, lane, arrival.direction);
                put(&mut point, lane, arrival.point);
            }
            if lanes == 0 {
                continue;
            }
            let light = self.tracer.light;
            let mirrored = Triple::<V>::load(&normal).fnma(V::load(&cosine), Triple::load(&direction));
            let lookup = Lookup::new(light, Triple::load(&point), mirrored.renormalized());
            let colours = lookup.colours(light, lanes);
            let rows = colours.stored();
            for (lane, arrival) in group.iter_mut().enumerate() {
                if arrival.covered {
                    arrival.colour = [rows[0].0[lane], rows[1].0[lane], rows[2].0[lane]];
                }
            }
        }
    }

    /// Follows all paths; false if broken off.
    #[inline(always)]
    fn follow<V: Lanes, T: Throughput<V>>(self) -> bool {
        let ChainTracer { chain, scene, light, .. } = self.tracer;
        let behind = scene.background != Background::Transparent;
        let lines = scene.wavelength_count() * self.samples;
        let mut batch = Batch::<V, T>::new(chain, light, self.blocks, self.radiances, self.account);
        let group = self.samples * self.pixels;
        let groups = self.arrivals.chunks(group).enumerate();
        let mut packets = groups
            .filter(|(_, arrivals)| behind || arrivals.iter().any(|arrival| arrival.covered))
            .flat_map(|(number, arrivals)| {
                let blocks =
                    if arrivals.len() == group { 0..self.last } else { self.last..self.blocks.len() };
                blocks.map(move |block| (block, number * self.pixels * lines, arrivals))
            });
        // All that a step does is inlined, so there is one place for it.
        loop {
            while !batch.is_full()
                && let Some((block, place, arrivals)) = packets.next()
            {
                batch.enter(block, place, arrivals, behind);
            }
            if batch.is_empty() {
                return true;
            }
            batch.step();
            if (self.stop)() {
                return false;
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
