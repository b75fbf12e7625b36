//! One convex crystal under an environment: a stream of rays.
//!
//! At each surface event light leaves the stone, and one or two modes stay. So the rays of a camera ray are a tree, and those
//! that are followed together soon differ in what they are: sixteen wavelengths that part at each choice of a mode would leave
//! most lanes empty. But nothing that leaves comes back, so a ray is a few numbers, and any sixteen rays of a tile make a
//! packet, whatever their modes, paths, samples and wavelengths. After each event those that go on are packed anew ("stream
//! compaction"; Wald, Gribble, Boulos & Kensler 2007, "SIMD Ray Stream Tracing").
//!
//! What a ray does depends on itself alone, and radiances are summed in fixed point (`sums`): how rays are packed does not show.

pub(crate) mod area;
mod beams;
mod event;
mod lines;
mod rays;

use crate::{
    account::Account,
    crystal::Frame,
    entry::Entry,
    environment::Light,
    planes::Planes,
    schedule::{Finished, Stop, TileTracer},
    sums::{self, Sums},
};
use accel::lanes::Lanes;
use accel::{Instructions, Task};
use event::Events;
use lines::Lines;
use spectral_core::{
    film::Tile,
    prepare::PreparedScene,
    scene::Background,
    settings::{Leftover, RenderSettings},
};
use std::ops::Range;

/// The scene reduced to one convex crystal.
#[derive(Debug)]
pub(crate) struct Stream {
    planes: Planes,
    material: usize,
    frame: Frame,
    max_depth: u32,
    threshold: f32,
    leftover: Leftover,
    /// Of two modes of which one is lighter than this, one is followed for both.
    split: f32,
    /// Of radiance in sums.
    unit: f64,
    instructions: Instructions,
}

/// A stream with its light.
pub(crate) struct StreamTracer<'a> {
    pub stream: &'a Stream,
    pub scene: &'a PreparedScene,
    pub light: &'a Light,
}

/// Where a camera ray meets the stone; without a point it passes by.
#[derive(Debug, Clone, Copy, Default)]
struct Arrival {
    covered: bool,
    point: [f32; 3],
    direction: [f32; 3],
    /// Unit normal into the stone.
    inward: [f32; 3],
    /// The light behind the stone, for a ray that passes by.
    colour: [f32; 3],
}

/// A tile's paths, for any instruction set.
struct Paths<'a> {
    tracer: &'a StreamTracer<'a>,
    /// The samples of each pixel in turn.
    arrivals: &'a [Arrival],
    lines: &'a Lines<'a>,
    sums: &'a mut Sums,
    account: &'a mut Account,
    stop: &'a Stop<'a>,
}

impl Stream {
    /// The stream for a scene, if it is one convex crystal seen from outside.
    pub fn new(scene: &PreparedScene, light: &Light, instructions: Instructions) -> Option<Self> {
        let stone = scene.lone_convex_crystal()?;
        let RenderSettings { max_depth, threshold, leftover, split, .. } = scene.settings;
        let material = stone.material as usize;
        let media = scene.optics.tables.iter().flat_map(|table| &table.media[material]);
        Some(Stream {
            planes: Planes::new(&scene.geometry, stone),
            material,
            frame: Frame::new(media.filter_map(|medium| medium.crystal.as_ref()))?,
            max_depth,
            threshold: threshold as f32,
            leftover,
            split: split as f32,
            unit: sums::unit(scene, light),
            instructions,
        })
    }
}

impl TileTracer for StreamTracer<'_> {
    fn tile(&self, tile: Tile, samples: Range<u32>, stop: &Stop<'_>) -> Option<Finished> {
        let (scene, stream) = (self.scene, self.stream);
        let lines = Lines::new(scene, samples.clone(), stream.material, &stream.frame);
        let arrivals = self.arrivals(tile, &samples);
        let mut account = Account::default();
        let count = arrivals.len() * scene.wavelength_count();
        account.start(count);
        let mut sums = Sums::new(stream.unit, count);
        let (arrivals, lines) = (&arrivals, &lines);
        let paths = Paths { tracer: self, arrivals, lines, sums: &mut sums, account: &mut account, stop };
        let finished = stream.instructions.run(paths);
        let covered: Vec<bool> = arrivals.iter().map(|arrival| arrival.covered).collect();
        finished.then(|| Finished::new(scene, tile, samples, sums.radiances(), &covered, account))
    }
}

impl StreamTracer<'_> {
    fn arrivals(&self, tile: Tile, samples: &Range<u32>) -> Vec<Arrival> {
        let (scene, planes) = (self.scene, &self.stream.planes);
        let mut entry = Entry::new(&scene.geometry, &scene.geometry.stones[0], planes);
        let rays = scene.camera_rays(tile, samples.clone());
        rays.map(|(_, ray)| {
            let direction = ray.direction.as_vec3().to_array();
            let Some((point, facet)) = entry.next(&ray) else {
                return Arrival { direction, colour: scene.background_of(&ray), ..Arrival::default() };
            };
            let inward = planes.normal(facet).map(|n| -n);
            Arrival { covered: true, point: point.as_vec3().to_array(), direction, inward, colour: [0.0; 3] }
        })
        .collect()
    }
}

impl Task for Paths<'_> {
    type Output = bool;

    /// Follows all paths; false if broken off.
    #[inline(always)]
    fn run<V: Lanes>(self) -> bool {
        let StreamTracer { stream, scene, light } = self.tracer;
        let behind = scene.background != Background::Transparent;
        let Paths { arrivals, lines, stop, .. } = self;
        let limits = [stream.threshold, stream.split];
        let mut events = Events::<V>::new(stream, light, lines, limits, self.sums, self.account);
        let pixels = arrivals.chunks_exact(lines.samples()).enumerate();
        let mut packets = pixels
            .filter(|(_, arrivals)| behind || arrivals.iter().any(|arrival| arrival.covered))
            .flat_map(|(pixel, arrivals)| (0..lines.blocks()).map(move |block| (pixel, arrivals, block)));
        loop {
            while !events.are_full()
                && let Some((pixel, arrivals, block)) = packets.next()
            {
                events.enter(pixel, arrivals, block, behind);
            }
            if events.are_over() {
                return true;
            }
            events.step();
            if stop() {
                return false;
            }
        }
    }
}
