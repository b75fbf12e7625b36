//! What passes between host and device: the Rust twins of the kernel's structures, byte for byte.

use bytemuck::{Pod, Zeroable};

/// The block that is the same for every ray (`scene.wgsl`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct Scene {
    /// Linear sRGB from everywhere, where the light is no image.
    pub light: [f32; 3],
    /// Rotation of the image in turns, in [0, 1).
    pub turn: f32,
    /// [`Rounding::margin`](crate::prepare::Rounding::margin), mm.
    pub margin: f32,
    /// [`Rounding::behind`](crate::prepare::Rounding::behind), mm.
    pub behind: f32,
    /// [`Rounding::contact`](crate::prepare::Rounding::contact), mm.
    pub contact: f32,
    /// Throughput below which a ray inside a stone is spent.
    pub threshold: f32,
    /// The stones that the eye is in: [`Nest::marks`](crate::prepare::Nest::marks).
    pub eye_nest: [u32; 3],
    /// Surface events on a path.
    pub max_depth: u32,
    /// Wavelengths a pixel sample.
    pub lines: u32,
    /// Distinct materials.
    pub materials: u32,
    /// 1 where the light is an image.
    pub image: u32,
    /// 1 where rays leave at the depth limit, 0 where they are dropped.
    pub leave_at_limit: u32,
    /// 1 where nothing is seen past the stones.
    pub transparent: u32,
    /// Units of the hierarchy's builder per mm, where `intersect` has one.
    pub builder_scale: f32,
    /// What a texel of the image is to be multiplied by.
    pub gain: f32,
    /// z of the diffuse ground, mm, local.
    pub ground_height: f32,
    /// Columns and rows of the image that are lights; the ground's picture begins in the row after.
    pub sky: [u32; 2],
    /// Where the ground's first texel lies, mm, local.
    pub ground_low: [f32; 2],
    /// The ground's texels a mm; 0 where there is no ground.
    pub ground_per_mm: f32,
    /// The last of the ground's texels that has a next, as a number.
    pub ground_last: f32,
    /// The least slope of rays that see the ground.
    pub grazing: f32,
    /// Facet planes, where one convex stone is met by them.
    pub facets: u32,
    /// Columns of the picture.
    pub width: u32,
    /// Tables of optics; samples take them in turn.
    pub tables: u32,
    /// Radius of the sphere about the origin that holds the stones, mm; 0 where there are none.
    pub reach: f32,
    /// How far before the plane of `centre` the eye is; this and what follows: [`Frame`](crate::camera::Frame).
    pub depth: f32,
    /// The picture's middle, pixels.
    pub middle: [f32; 2],
    /// The weight below which a mode of a crystal is not followed for itself.
    pub split: f32,
    /// Nothing.
    pub padding: u32,
    /// mm, local.
    pub centre: [f32; 4],
    /// mm a pixel.
    pub right: [f32; 4],
    /// mm a pixel.
    pub down: [f32; 4],
    /// Unit.
    pub forward: [f32; 4],
    /// A pixel.
    pub across: [f32; 4],
    /// A pixel.
    pub along: [f32; 4],
    /// The eye, mm, local, and 1, or 2 of a [close-up](crate::prepare::PreparedScene::close_up); 0 in the last place where rays
    /// are parallel.
    pub eye: [f32; 4],
}

/// A facet plane (`surface.wgsl`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct Plane {
    /// Unit, outward.
    pub normal: [f32; 3],
    /// mm from the local origin along the normal.
    pub offset: f32,
    /// Of its stone.
    pub rank: u32,
    /// Nothing.
    pub padding: [u32; 3],
}

/// A camera ray near the stones (`batch.wgsl`), which never leaves the device.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct Primary {
    /// mm, local.
    pub origin: [f32; 3],
    /// The first line of the sample's table in the optics.
    pub first_line: u32,
    /// Unit.
    pub direction: [f32; 3],
    /// 0 where the ray passes the stones by; else one more than the facet that it may come to first.
    pub near: u32,
    /// Linear sRGB seen where the ray meets no stone.
    pub background: [f32; 3],
    /// Nothing.
    pub padding: u32,
}

/// A batch (`batch.wgsl`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct Batch {
    /// Pixels.
    pub pixels: u32,
    /// The first sample of each pixel.
    pub first: u32,
    /// Samples of each pixel.
    pub count: u32,
    /// Rays that an invocation follows at most.
    pub budget: u32,
    /// 0 begins the walks, 1 resumes them.
    pub resume: u32,
    /// 1 keeps every radiance.
    pub spectral: u32,
    /// 1 where the pixels have no samples yet.
    pub fresh: u32,
    /// Nothing.
    pub padding: u32,
}

/// What the pixels of a workgroup add to the account (`main_gather.wgsl`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub struct Tally {
    /// Throughput dropped at the depth limit, dropped below the threshold, let out at the limit, and lost.
    pub energies: [f32; 4],
    /// Segments traced: low and high word.
    pub rays: [u32; 2],
    /// Work items that are not over.
    pub going: u32,
    /// Nothing.
    pub padding: u32,
}

/// Bytes of a work item's result (`Result` in `batch.wgsl`), which never leaves the device.
pub const RESULT_BYTES: u64 = 32;

/// Bytes of a waiting ray (`Ray` in `walk.wgsl`), which never leaves the device; `rows` is [`Form::rows`](super::Form::rows).
pub const fn ray_bytes(rows: bool) -> u64 {
    if rows { 80 } else { 48 }
}

/// Bytes of a work item's state (`Walk` in `walk.wgsl`), which never leaves the device; `rows` as for [`ray_bytes`].
pub const fn walk_bytes(rows: bool) -> u64 {
    if rows { 128 } else { 96 }
}
