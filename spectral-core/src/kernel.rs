//! The light transport as WGSL, written once for every GPU backend.
//!
//! The sources in `kernel/*.wgsl` mirror the Rust modules name for name and stand beside them; each is checked
//! against its Rust twin. A shader is their plain concatenation, after the constants that are generated from Rust:
//! no preprocessor, no build script. WGSL lets declarations stand in any order, so the order of the parts means
//! nothing.
//!
//! Only `intersect` is swapped (`surface.wgsl` states its contract): [`facets`] for one convex stone; a bounding volume
//! hierarchy or the device's own ray tracing for anything else.
//!
//! ```text
//! prime  = constants + scene + batch + line + light + direction + plane + main_prime
//! trace  = constants + scene + batch + line + light + nest + fresnel + stokes + throughput + direction + surface
//!        + medium + intersect + one of the two transports
//!     chain: results_chain + chain + one of main_planes, main_subgroup
//!     tree:  walk + results_walk + tree + main_trace + event + one of main_compute, main_pipeline
//!     event: event_isotropic, or where there is a crystal all of crystal/
//! gather = constants + scene + batch + line + nest + fresnel + stokes + throughput + results + main_gather
//! ```
//!
//! A work item is a pixel sample at one wavelength. `prime` makes the camera rays of a batch of pixels; `trace` follows
//! one convex stone's chains of reflections to their ends, and other scenes' trees of rays with a bounded stack and a
//! bounded number of rays a dispatch; `gather` adds the batch to each pixel's sums. [`block`] has the Rust twins of what
//! passes between host and device, [`plan`] says which buffers there are, [`pack`] fills them from a
//! [`PreparedScene`](crate::prepare::PreparedScene). [`facets`] does the same for one convex stone, [`texel`] for the
//! light, and [`schedule`] drives the device.

pub mod block;
pub mod facets;
pub mod medium;
pub mod pack;
pub mod plan;
pub mod schedule;
pub mod texel;

use crate::{
    lattice::{CHOICES, MULTIPLIER, SHIFT},
    prepare::{Nest, Rounding},
    settings::RenderSettings,
};
use facets::Facets;
use std::fmt::Write;

/// `intersect` by ray queries on the device's own hierarchy. A shader with it begins with [`ENABLE_RAY_QUERY`].
pub const INTERSECT_RAY_QUERY: &str =
    concat!(include_str!("kernel/candidate.wgsl"), include_str!("kernel/intersect_ray_query.wgsl"));
/// What a shader with [`INTERSECT_RAY_QUERY`] begins with.
pub const ENABLE_RAY_QUERY: &str = "enable wgpu_ray_query;\n";
/// `intersect` by a ray-tracing pipeline; for [`Form::trace_pipeline`].
const INTERSECT_PIPELINE: &str =
    concat!(include_str!("kernel/candidate.wgsl"), include_str!("kernel/intersect_pipeline.wgsl"));

/// Fresnel's equations; needs the constants only.
pub const FRESNEL: &str = include_str!("kernel/fresnel.wgsl");
/// Stokes rows and their frames; needs [`FRESNEL`].
pub const STOKES: &str = include_str!("kernel/stokes.wgsl");
/// The set of stones that a ray is in; needs the constants only.
pub const NEST: &str = include_str!("kernel/nest.wgsl");
/// The directions in which a ray goes on from a surface; needs nothing.
pub const DIRECTION: &str = include_str!("kernel/direction.wgsl");
/// Surfaces, and the contract of `intersect`, which it needs, with [`SCENE`], [`NEST`] and [`DIRECTION`].
pub const SURFACE: &str = concat!(include_str!("kernel/plane.wgsl"), include_str!("kernel/surface.wgsl"));
/// The block that is the same for every ray.
pub const SCENE: &str = include_str!("kernel/scene.wgsl");
/// Wavelengths and the light at each; needs [`SCENE`].
pub const LINE: &str = concat!(include_str!("kernel/line.wgsl"), include_str!("kernel/basis.wgsl"));
/// The environment; needs [`SCENE`] and [`LINE`].
pub const LIGHT: &str = include_str!("kernel/light.wgsl");

const PLANE: &str = include_str!("kernel/plane.wgsl");
const BATCH: &str = include_str!("kernel/batch.wgsl");
/// The optics of materials; needs [`LINE`], [`FRESNEL`] and `medium::declarations`.
const MEDIUM: &str = include_str!("kernel/medium.wgsl");
const CHAIN: &str = concat!(include_str!("kernel/results_chain.wgsl"), include_str!("kernel/chain.wgsl"));
const WALK: &str = concat!(include_str!("kernel/walk.wgsl"), include_str!("kernel/results_walk.wgsl"));
/// Waves in crystals, and what their surfaces do to them; needs the constants, [`LINE`], [`FRESNEL`], [`STOKES`] and
/// [`medium::crystal_declarations`].
pub const CRYSTAL: &str = concat!(
    include_str!("kernel/crystal/wave.wgsl"),
    include_str!("kernel/crystal/uniaxial.wgsl"),
    include_str!("kernel/crystal/biaxial.wgsl"),
    include_str!("kernel/crystal/crystal.wgsl"),
    include_str!("kernel/crystal/boundary.wgsl"),
    include_str!("kernel/crystal/weight.wgsl")
);
const EVENT_CRYSTAL: &str = include_str!("kernel/crystal/event.wgsl");
const EVENT_ISOTROPIC: &str = include_str!("kernel/event_isotropic.wgsl");
const TREE: &str = concat!(include_str!("kernel/tree.wgsl"), include_str!("kernel/main_trace.wgsl"));
const MAIN_PRIME: &str = include_str!("kernel/main_prime.wgsl");
const MAIN_COMPUTE: &str = include_str!("kernel/main_compute.wgsl");
const MAIN_PIPELINE: &str = include_str!("kernel/main_pipeline.wgsl");
const MAIN_GATHER: &str = include_str!("kernel/main_gather.wgsl");

/// Invocations a workgroup: a multiple of every subgroup size in use.
pub const WORKGROUP: u32 = 64;

/// The choices that are made when a shader is assembled, each a constant in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Form {
    /// Carry a Stokes row (true) or the mean of s and p.
    pub polarized: bool,
    /// Whether stones come near each other, so that contacts must be looked for.
    pub contacts: bool,
    /// Whether there are doubly refracting crystals. Without, the shader has no part of them.
    pub crystals: bool,
    /// Rays that may wait in a work item; see [`stack_places`].
    pub stack: u32,
}

/// The stack that no path overflows under these settings, up to 32 places.
///
/// A walk goes on with the weaker child, which has at most half of its parent's throughput, so a ray that is
/// stacked while n others wait has at most 2⁻ⁿ. Inside a stone rays below the threshold are spent; outside one
/// they may be weaker still, but then split no more. With a threshold under 2⁻³⁰ a ray may be dropped, which is
/// counted; it carries less than 2⁻³⁰ of the light.
///
/// With `crystals` an event has up to four children w₁ ≤ w₂ ≤ w₃ ≤ w₄. The walk goes on with w₁ and stacks the others, the
/// strongest lowest. A ray with m others below it has at most 2^(−2m/3): of a parent with m below, w₁ has at most a quarter
/// and three more below it, w₂ a third and two more, w₃ a half and one more. So half as many places again do, and three
/// for the last event.
///
/// ```
/// use spectral_core::{kernel::stack_places, settings::RenderSettings};
/// let settings = RenderSettings { threshold: 1e-4, ..RenderSettings::default() };
/// assert_eq!(stack_places(&settings, false), 16);
/// assert_eq!(stack_places(&settings, true), 24);
/// assert_eq!(stack_places(&RenderSettings { max_depth: 3, ..settings }, false), 8);
/// ```
pub fn stack_places(settings: &RenderSettings, crystals: bool) -> u32 {
    let halvings = if settings.threshold > 0.0 { -settings.threshold.log2() } else { f64::INFINITY };
    let most = settings.max_depth + 1;
    let places = if crystals {
        ((1.5 * halvings).ceil() + 3.0).min(48.0).min(3.0 * f64::from(most)) as u32
    } else {
        ((halvings.ceil() + 2.0).min(32.0) as u32).min(most)
    };
    // Rounded up, so that scenes share compiled shaders.
    places.next_multiple_of(8)
}

impl Form {
    /// The WGSL text of these choices and of every constant that Rust owns.
    pub fn constants(&self) -> String {
        let mut text = String::from("// Generated from the Rust constants of the same meaning.\n");
        let Form { contacts, crystals, stack, .. } = *self;
        let mut add = |name: &str, kind: &str, value: String| {
            writeln!(text, "const {name}: {kind} = {value};").expect("a string takes any text");
        };
        add("EPSILON", "f32", wgsl(f32::EPSILON));
        add("LARGEST", "f32", wgsl(f32::MAX));
        add("NEST_CAPACITY", "u32", Nest::CAPACITY.to_string());
        add("MOST_CROSSINGS", "u32", Rounding::MOST_CROSSINGS.to_string());
        add("PARALLEL", "f32", wgsl(Rounding::PARALLEL));
        add("GRAZING", "f32", wgsl(Rounding::GRAZING));
        add("RESCUES", "u32", (6 * Rounding::RESCUE.len()).to_string());
        add("RESCUE_NEAR", "f32", wgsl(Rounding::RESCUE[0]));
        add("RESCUE_FAR", "f32", wgsl(Rounding::RESCUE[1]));
        add("BASIS_VECTORS", "u32", pack::BASIS_VECTORS.to_string());
        add("MEDIUM_VECTORS", "u32", medium::vectors(crystals).to_string());
        add("CONTACTS", "bool", contacts.to_string());
        add("STACK", "u32", stack.to_string());
        add("WORKGROUP", "u32", WORKGROUP.to_string());
        text
    }

    /// Whether rays carry a Stokes row; in a scene with crystals it has room for a mode.
    pub fn rows(&self) -> bool {
        self.polarized || self.crystals
    }

    fn throughput(&self) -> &'static str {
        if self.rows() {
            include_str!("kernel/throughput_polarized.wgsl")
        } else {
            include_str!("kernel/throughput_scalar.wgsl")
        }
    }

    /// The shader with the entry point `prime`.
    pub fn prime(&self) -> String {
        [&self.constants(), SCENE, BATCH, LINE, LIGHT, DIRECTION, PLANE, MAIN_PRIME].join("\n")
    }

    /// The shader with the entry point `trace`. `intersect` is the text of the form of intersection, with the
    /// constants it needs.
    pub fn trace(&self, intersect: &str) -> String {
        self.traced(&[intersect, WALK, TREE, &self.event(), MAIN_COMPUTE])
    }

    /// The shader with the entry point `trace` for one convex stone, or none.
    pub fn trace_facets(&self, facets: &Facets) -> String {
        self.traced(&[&facets.intersect(), CHAIN, facets.main()])
    }

    /// The shader of a ray-tracing pipeline: the entry points `trace` (ray generation), `consider` (any-hit) and
    /// `pass_by` (miss).
    ///
    /// WGSL cannot say that an any-hit shader ignores a candidate: `consider` does where it returns before its end,
    /// and the backend has to see to it.
    pub fn trace_pipeline(&self) -> String {
        "enable wgpu_ray_tracing_pipeline;\nenable primitive_index;\n".to_owned()
            + &self.traced(&[INTERSECT_PIPELINE, WALK, TREE, &self.event(), MAIN_PIPELINE])
    }

    /// What a tree's surface events are.
    fn event(&self) -> String {
        if !self.crystals {
            return EVENT_ISOTROPIC.to_owned();
        }
        let constants = format!(
            "const POLARIZED: bool = {};\nconst CHOICES: u32 = {CHOICES}u;\nconst MULTIPLIER: u32 = {MULTIPLIER}u;\n\
             const SHIFT: u32 = {SHIFT}u;",
            self.polarized
        );
        [&constants, &medium::crystal_declarations(), CRYSTAL, EVENT_CRYSTAL].join("\n")
    }

    fn traced(&self, transport: &[&str]) -> String {
        let optics = [SCENE, BATCH, LINE, LIGHT, NEST, FRESNEL, STOKES, self.throughput()];
        let surfaces = [DIRECTION, SURFACE, &medium::declarations(), MEDIUM];
        [&[self.constants().as_str()], &optics[..], &surfaces, transport].concat().join("\n")
    }

    /// The shader with the entry point `gather`, after chains or after trees.
    pub fn gather(&self, chain: bool) -> String {
        let results = if chain { include_str!("kernel/results_chain.wgsl") } else { WALK };
        let optics = [SCENE, BATCH, LINE, NEST, FRESNEL, STOKES, self.throughput()];
        [&[self.constants().as_str()], &optics[..], &[results, MAIN_GATHER]].concat().join("\n")
    }
}

/// A single-precision number as a WGSL literal that is read back as the same number.
pub fn wgsl(value: f32) -> String {
    format!("{:?}", f64::from(value))
}
