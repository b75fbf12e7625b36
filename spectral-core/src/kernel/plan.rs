//! The buffers of a batch, and which of them each shader binds: one plan for every backend.

use super::{
    Form, WORKGROUP,
    block::{Batch, Primary, RESULT_BYTES, Tally, ray_bytes, walk_bytes},
};
use crate::prepare::PreparedScene;

/// A shader of the kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Makes the camera rays: one invocation a pixel sample.
    Prime,
    /// Follows them: one invocation a pixel sample and wavelength.
    Trace,
    /// Adds them up: one invocation a pixel.
    Gather,
}

impl Stage {
    /// All of them, in the order in which they run.
    pub const ALL: [Stage; 3] = [Stage::Prime, Stage::Trace, Stage::Gather];

    /// The name of its entry point.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Prime => "prime",
            Stage::Trace => "trace",
            Stage::Gather => "gather",
        }
    }

    /// Bindings of group 0, the scene's, that it reads. Of `trace` those of its intersection follow, from 5 on.
    pub fn scene_bindings(self) -> &'static [u32] {
        match self {
            Stage::Prime => &[SCENE, LIGHT, PLANES, OFFSETS],
            Stage::Trace => &[SCENE, LIGHT, OPTICS, PLANES, MATERIALS],
            Stage::Gather => &[SCENE, OPTICS],
        }
    }

    /// The buffers of group 1, the batch's, that it binds, each at the number of its binding.
    pub fn parts(self, chain: bool) -> &'static [Part] {
        match self {
            Stage::Prime => &[Part::Batch, Part::Pixels, Part::Primaries],
            Stage::Trace if chain => &[Part::Batch, Part::Primaries, Part::Results],
            Stage::Trace => &[Part::Batch, Part::Primaries, Part::Results, Part::Stack],
            Stage::Gather => {
                &[Part::Batch, Part::Primaries, Part::Results, Part::Sums, Part::Tallies, Part::Radiances]
            }
        }
    }

    /// Invocations that a batch takes.
    pub fn invocations(self, batch: &Batch, lines: u32) -> u32 {
        match self {
            Stage::Prime => batch.pixels * batch.count,
            Stage::Trace => batch.pixels * batch.count * lines,
            Stage::Gather => batch.pixels,
        }
    }
}

/// Binding of the block of constants in group 0.
pub const SCENE: u32 = 0;
/// Binding of the environment's image in group 0.
pub const LIGHT: u32 = 1;
/// Binding of the optics in group 0.
pub const OPTICS: u32 = 2;
/// Binding of the facet planes in group 0.
pub const PLANES: u32 = 3;
/// Binding of the materials by rank in group 0.
pub const MATERIALS: u32 = 4;
/// First binding of what rays are intersected with in group 0; at most two.
pub const SURFACES: u32 = 5;
/// Binding of the samples' places in group 0.
pub const OFFSETS: u32 = 7;

/// A buffer of group 1, the batch's; its number is that of its binding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The uniform block [`Batch`].
    Batch = 0,
    /// Pixel numbers, row by row; from the host.
    Pixels = 1,
    /// Camera rays.
    Primaries = 2,
    /// What work items have come to, with what is left to follow.
    Results = 3,
    /// Rays that wait.
    Stack = 4,
    /// XYZ and coverage of each pixel; from the host and back.
    Sums = 5,
    /// A [`Tally`] for each workgroup of pixels; to the host.
    Tallies = 6,
    /// Radiances by pixel and wavelength; from the host and back.
    Radiances = 7,
}

impl Part {
    /// All of them, by number.
    pub const ALL: [Part; 8] = [
        Part::Batch,
        Part::Pixels,
        Part::Primaries,
        Part::Results,
        Part::Stack,
        Part::Sums,
        Part::Tallies,
        Part::Radiances,
    ];

    /// Whether batches that are under way at the same time share it: dispatches follow one another, so only what the host
    /// reads or writes must be there once for each.
    pub fn is_shared(self) -> bool {
        matches!(self, Part::Primaries | Part::Results | Part::Stack)
    }

    /// For messages.
    pub fn name(self) -> &'static str {
        match self {
            Part::Batch => "the batch",
            Part::Pixels => "the pixels",
            Part::Primaries => "the camera rays",
            Part::Results => "the paths",
            Part::Stack => "the stacks",
            Part::Sums => "the sums",
            Part::Tallies => "the account",
            Part::Radiances => "the radiances",
        }
    }
}

/// How large the batches of a scene may be on a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    form: Form,
    /// Whether every path is a chain, which ends in one dispatch.
    pub chain: bool,
    /// Wavelengths of a sample.
    pub lines: u32,
    /// Whether the film keeps radiances.
    pub spectral: bool,
    /// The most pixel samples of a batch; 0 where not one fits.
    pub samples: u32,
    /// The most pixels of a batch.
    pub pixels: u32,
}

impl Plan {
    /// The most memory for the paths of a batch, bytes.
    pub const MEMORY: u64 = 512 << 20;

    /// The plan for a device whose storage buffers have at most `largest` bytes.
    pub fn new(scene: &PreparedScene, form: Form, chain: bool, largest: u64) -> Self {
        let lines = scene.wavelength_count() as u64;
        let pixels = u64::from(scene.width) * u64::from(scene.height);
        let mut plan = Plan {
            form,
            chain,
            lines: lines as u32,
            spectral: scene.settings.spectral,
            samples: 1,
            pixels: 1,
        };
        let of_sample = |part| plan.bytes(part);
        let [results, stack] = [Part::Results, Part::Stack].map(of_sample);
        let by_buffer = largest / results.max(stack).max(size_of::<Primary>() as u64);
        let by_memory = Self::MEMORY / (results + stack);
        let wanted = pixels * u64::from(scene.settings.samples);
        plan.samples = by_buffer.min(by_memory).min(wanted).min(u64::from(u32::MAX) / lines) as u32;
        let by_buffer = largest / if plan.spectral { 16.max(4 * lines) } else { 16 };
        plan.pixels = pixels.min(by_buffer).min(u64::from(plan.samples)) as u32;
        plan
    }

    /// Bytes of a buffer; 0 for one that is not in use.
    pub fn bytes(&self, part: Part) -> u64 {
        let (pixels, samples) = (u64::from(self.pixels), u64::from(self.samples));
        let items = samples * u64::from(self.lines);
        let rows = self.form.rows();
        match part {
            Part::Batch => size_of::<Batch>() as u64,
            Part::Pixels => pixels * 4,
            Part::Primaries => samples * size_of::<Primary>() as u64,
            Part::Results if self.chain => items * RESULT_BYTES,
            Part::Results => items * walk_bytes(rows),
            Part::Stack if self.chain => 0,
            Part::Stack => items * ray_bytes(rows) * u64::from(self.form.stack),
            Part::Sums => pixels * 16,
            Part::Tallies => pixels.div_ceil(u64::from(WORKGROUP)) * size_of::<Tally>() as u64,
            Part::Radiances if self.spectral => pixels * u64::from(self.lines) * 4,
            Part::Radiances => 0,
        }
    }

    /// Bytes of what `pixels` pixels bring back: sums, tallies and radiances.
    pub fn returned(&self, pixels: u32) -> [(Part, u64); 3] {
        let batch = Plan { pixels, ..*self };
        [Part::Sums, Part::Tallies, Part::Radiances].map(|part| (part, batch.bytes(part)))
    }

    /// Batches that may be under way at the same time: one is made ready and another read back while a third is traced. A
    /// walk that is resumed needs its buffers for longer.
    pub fn slots(&self) -> usize {
        if self.chain { 3 } else { 1 }
    }
}

/// Rows and columns of workgroups for so many invocations: devices bound each by 65,535.
pub fn workgroups(invocations: u32) -> [u32; 2] {
    const ROW: u32 = 1 << 15;
    let groups = invocations.div_ceil(WORKGROUP).max(1);
    [groups.min(ROW), groups.div_ceil(ROW)]
}
