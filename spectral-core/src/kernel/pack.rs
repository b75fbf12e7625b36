//! A prepared scene as the blocks that the kernel reads.

use super::{
    Form,
    block::{Plane, Scene},
    medium, stack_places,
};
use crate::{
    Error,
    environment::{Environment, Ground, GroundFrame, Source},
    prepare::{Geometry, Nest, PreparedScene, SpectralTable},
    scene::Background,
    settings::Leftover,
    upsample::BASES,
};
use glam::DVec3;

impl Nest {
    /// The most stones of a scene whose ranks fit the kernel's 16 bits.
    pub const MOST_STONES: usize = 0xfffe;

    /// The set as the kernel keeps it: ranks plus one in descending order, 16 bits each, the first in the low half
    /// of the first word; unused places are 0.
    ///
    /// ```
    /// use spectral_core::prepare::Nest;
    /// assert_eq!(Nest::default().toggled(0).toggled(4).marks(), [0x0001_0005, 0, 0]);
    /// ```
    pub fn marks(&self) -> [u32; 3] {
        let mut words = [0; 3];
        for (slot, &rank) in self.ranks().iter().enumerate() {
            words[slot / 2] |= (rank + 1) << (16 * (slot % 2));
        }
        words
    }
}

/// The choices that a scene asks of the kernel.
pub fn form(scene: &PreparedScene) -> Form {
    let crystals = has_crystals(scene);
    Form {
        polarized: scene.settings.polarized,
        contacts: scene.geometry.contacts,
        crystals,
        stack: stack_places(&scene.settings, crystals),
    }
}

/// Whether a material is traced as a doubly refracting crystal. The optics say so themselves: a device keeps them apart from
/// the stones.
fn has_crystals(scene: &PreparedScene) -> bool {
    let media = scene.optics.tables.iter().flat_map(|table| &table.media).flatten();
    media.into_iter().any(|medium| medium.crystal.is_some())
}

/// Refuses a scene that the kernel's number formats do not hold.
///
/// # Errors
/// [`Error::Value`] for more than [`Nest::MOST_STONES`] stones.
pub fn check(scene: &PreparedScene) -> Result<(), Error> {
    let stones = scene.geometry.stones.len();
    if stones > Nest::MOST_STONES {
        let expected = format!("at most {} on a GPU; the CPU backend takes any number", Nest::MOST_STONES);
        return Err(Error::value("stones", stones, expected));
    }
    Ok(())
}

/// The block that is the same for every ray, with factors of 1 for the device's own representations.
pub fn scene(scene: &PreparedScene) -> Scene {
    let rounding = scene.geometry.rounding();
    let (light, image) = match &scene.environment.source {
        Source::Uniform(rgb) => (rgb.map(|c| c as f32), 0),
        Source::Image(_) => ([0.0; 3], 1),
    };
    let settings = &scene.settings;
    Scene {
        light,
        turn: scene.environment.turn(),
        margin: rounding.margin,
        behind: rounding.behind,
        contact: rounding.contact,
        threshold: settings.threshold as f32,
        split: settings.split as f32,
        eye_nest: scene.eye_nest.marks(),
        max_depth: settings.max_depth,
        lines: scene.wavelength_count() as u32,
        materials: materials(scene),
        image,
        leave_at_limit: u32::from(settings.leftover == Leftover::Exit),
        transparent: u32::from(scene.background == Background::Transparent),
        builder_scale: 1.0,
        gain: 1.0,
        facets: scene.lone_convex_stone().map_or(0, |stone| stone.facets.len() as u32),
        ..camera(scene, below(&scene.environment))
    }
}

/// How the device makes camera rays.
fn camera(scene: &PreparedScene, block: Scene) -> Scene {
    // A little outside of every stone, whatever rounding does.
    let reach = scene.geometry.radius * 1.001;
    let frame = scene.view.frame(reach.max(1e-3));
    let vector = |v: DVec3| v.as_vec3().extend(0.0).to_array();
    Scene {
        width: scene.width,
        tables: scene.optics.tables.len() as u32,
        reach: reach as f32,
        middle: frame.middle.map(|v| v as f32),
        depth: frame.depth as f32,
        centre: vector(frame.centre),
        right: vector(frame.right),
        down: vector(frame.down),
        forward: vector(frame.forward),
        across: vector(frame.across),
        along: vector(frame.along),
        eye: scene
            .view
            .eye()
            .map_or([0.0; 4], |eye| eye.as_vec3().extend(if scene.close_up { 2.0 } else { 1.0 }).to_array()),
        ..block
    }
}

/// Where each sample lies in its pixel.
pub fn offsets(scene: &PreparedScene) -> Vec<[f32; 2]> {
    let settings = &scene.settings;
    (0..settings.samples).map(|sample| settings.offset(sample).map(|v| v as f32)).collect()
}

/// Where the lights end in the image, and where the ground's picture lies.
fn below(environment: &Environment) -> Scene {
    let sky = match &environment.source {
        Source::Image(image) => image.sky(),
        Source::Uniform(_) => [1; 2],
    };
    let block = Scene { sky, ..Scene::default() };
    let Some(GroundFrame { height, low, per_mm, last }) = environment.ground.as_ref().map(|g| g.frame())
    else {
        return block;
    };
    Scene {
        ground_low: low,
        ground_height: height,
        ground_per_mm: per_mm,
        ground_last: last,
        grazing: Ground::GRAZING as f32,
        ..block
    }
}

fn materials(scene: &PreparedScene) -> u32 {
    scene.optics.tables.first().map_or(0, |table| table.media.len() as u32)
}

/// Every facet's plane, by its index in the geometry.
pub fn planes(geometry: &Geometry) -> Vec<Plane> {
    let plane = |facet: &crate::prepare::FacetPlane| Plane {
        normal: facet.normal.as_vec3().to_array(),
        offset: facet.offset as f32,
        rank: geometry.stones[facet.stone as usize].rank,
        padding: [0; 3],
    };
    geometry.facets.iter().map(plane).collect()
}

/// Vectors of four numbers that a line's basis takes in the optics.
pub(super) const BASIS_VECTORS: usize = BASES.div_ceil(4);

/// All tables' lines one after another: for each line its basis, its weights (X, Y, Z, –), then the optics of each
/// material. Each begins with a vector of its own; what is left of its last one is 0.
pub fn optics(scene: &PreparedScene) -> Vec<[f32; 4]> {
    let crystals = has_crystals(scene);
    let lines = |table| (0..scene.wavelength_count()).flat_map(move |i| line(table, i, crystals));
    scene.optics.tables.iter().flat_map(lines).collect()
}

fn line(table: &SpectralTable, index: usize, crystals: bool) -> Vec<[f32; 4]> {
    let mut vectors = vec![[0.0; 4]; BASIS_VECTORS];
    for (slot, base) in vectors.as_flattened_mut().iter_mut().zip(table.basis[index]) {
        *slot = base as f32;
    }
    let [x, y, z] = table.response[index].map(|w| w as f32);
    vectors.push([x, y, z, 0.0]);
    vectors.extend(table.media.iter().flat_map(|medium| medium::packed(&medium[index], crystals)));
    vectors
}
