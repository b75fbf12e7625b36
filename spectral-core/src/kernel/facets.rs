//! One convex stone by its facets: what `intersect_planes.wgsl` is put together from, and the table it reads.
//!
//! Every form gives the same picture, bit for bit: a guess counts only where it is what a search would find. So a form
//! is a matter of speed alone, and of what a device can do.

use super::wgsl;
use crate::prepare::{Outline, PreparedScene};
use std::fmt::Write;

/// Which facet is tried before all planes are searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Guess {
    /// None: every ray is compared exactly with every plane, read from storage buffers. What the other forms are held to.
    Nothing,
    /// Outside, the facet that a camera ray was seen to come to; inside, the nearest plane by a quick search.
    Start,
    /// Outside the same; inside, the facet that the invocations of a subgroup find together for one of them, and where
    /// that serves too few, the nearest plane for each.
    Subgroup,
}

impl Guess {
    /// Every form, the one that needs least of a device first.
    pub const ALL: [Guess; 3] = [Guess::Nothing, Guess::Start, Guess::Subgroup];

    /// What a device gets that is not asked for a form. `subgroups` says whether it has the operations that
    /// [`Guess::Subgroup`] needs.
    ///
    /// ```
    /// use spectral_core::kernel::facets::Guess;
    /// assert_eq!(Guess::by_default(true), Guess::Subgroup);
    /// assert_eq!(Guess::by_default(false), Guess::Start);
    /// ```
    pub fn by_default(subgroups: bool) -> Self {
        if subgroups { Guess::Subgroup } else { Guess::Start }
    }

    /// Its name: `nothing`, `start` or `subgroup`.
    pub fn name(self) -> &'static str {
        match self {
            Guess::Nothing => "nothing",
            Guess::Start => "start",
            Guess::Subgroup => "subgroup",
        }
    }

    fn text(self) -> &'static str {
        match self {
            Guess::Nothing => include_str!("guess_nothing.wgsl"),
            Guess::Start => include_str!("guess_start.wgsl"),
            Guess::Subgroup => include_str!("guess_subgroup.wgsl"),
        }
    }
}

/// The facets of a scene that is one convex stone, or none, and how its rays find them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Facets {
    /// `outlines` of `intersect_planes.wgsl`.
    pub outlines: Vec<u32>,
    /// Facets.
    pub count: u32,
    guess: Guess,
    /// Whether a workgroup keeps them in its own memory.
    shared: bool,
}

impl Facets {
    /// Bytes of workgroup memory that the facets may take; more are read from storage buffers.
    ///
    /// Every device of Vulkan or WebGPU has 16 KiB. With three quarters of that, which holds some 250 facets, a
    /// processor with 100 KiB or more still runs enough workgroups of 64 side by side to hide latency.
    pub const WORKGROUP_BYTES: u32 = 12 << 10;
    /// Margins by which a point must be inside a facet's polygon.
    ///
    /// One covers correctly rounded arithmetic, and is what the CPU backend takes. A device's division may be off by
    /// 2.5 units in the last place, and a surface counts up to a margin behind a ray's start.
    pub const MARGINS: f32 = 2.0;
    /// A subgroup stops searching together once a round has served less than the inverse of this of those who asked.
    /// Measured on an H200 with 2, 3, 4, 6, 10 and 32: 67, 66, 65, 63, 61 and 61 ms.
    pub const SERVES: u32 = 10;
    /// It goes on if no more than these are left. A round takes a seventh of the time of a search by oneself.
    pub const FEW: u32 = 4;

    /// The facets of a scene's only stone, on a device with so many bytes of workgroup memory.
    pub fn new(scene: &PreparedScene, guess: Guess, workgroup_memory: u32) -> Self {
        let outlines = scene.geometry.stones.first().map_or_else(Vec::new, |s| scene.geometry.outlines(s));
        let count = outlines.len() as u32;
        let mut facets = Facets { outlines: table(&outlines), count, guess, shared: false };
        let [planes, words] = facets.room();
        let fits = planes * 16 + words * 4 <= Self::WORKGROUP_BYTES.min(workgroup_memory);
        facets.shared = fits && facets.verifies();
        facets
    }

    /// Whether guesses are verified, so that the shader reads `outlines`.
    pub fn verifies(&self) -> bool {
        self.guess != Guess::Nothing
    }

    /// Whether a workgroup keeps them in its own memory.
    pub fn fits(&self) -> bool {
        self.shared
    }

    /// Planes and words of the table, rounded up so that stones share compiled shaders.
    fn room(&self) -> [u32; 2] {
        [self.count.max(1).next_multiple_of(64), (self.outlines.len() as u32).next_multiple_of(256)]
    }

    /// `intersect` with all its parts and constants; needs [`SURFACE`](super::SURFACE).
    pub fn intersect(&self) -> String {
        let mut text = String::new();
        let [planes, words] = self.room();
        // As few as number the planes, rounded up as above: they are taken from a distance.
        let bits = planes.next_power_of_two() - 1;
        for (name, kind, value) in [
            ("FACET_ROOM", "u32", planes.to_string()),
            ("WORD_ROOM", "u32", words.to_string()),
            ("FACET_BITS", "u32", format!("{bits}u")),
            ("ROUND_SERVES", "u32", format!("{}u", Self::SERVES)),
            ("FEW_LEFT", "u32", format!("{}u", Self::FEW)),
            ("GUESS_MARGINS", "f32", wgsl(Self::MARGINS)),
        ] {
            writeln!(text, "const {name}: {kind} = {value};").expect("a string takes any text");
        }
        let memory = if self.shared {
            include_str!("facets_workgroup.wgsl")
        } else {
            include_str!("facets_storage.wgsl")
        };
        [&text, include_str!("intersect_planes.wgsl"), memory, self.guess.text()].join("\n")
    }

    /// The entry point that goes with [`Facets::intersect`].
    pub(super) fn main(&self) -> &'static str {
        match self.guess {
            Guess::Nothing | Guess::Start => include_str!("main_planes.wgsl"),
            Guess::Subgroup => include_str!("main_subgroup.wgsl"),
        }
    }
}

/// Where each facet's list begins and the last one ends, then the lists.
fn table(outlines: &[Outline]) -> Vec<u32> {
    let mut words = Vec::new();
    let mut end = outlines.len() as u32 + 1;
    for outline in outlines {
        words.push(end);
        end += outline.around.len() as u32;
    }
    words.push(end);
    words.extend(outlines.iter().flat_map(|outline| &outline.around));
    words
}
