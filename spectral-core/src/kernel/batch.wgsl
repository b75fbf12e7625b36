// A batch of work: some samples of some pixels, each at every wavelength.

struct Batch {
    // Pixels.
    pixels: u32,
    // The first sample of each pixel, and how many there are.
    first: u32,
    count: u32,
    // Rays that an invocation of `trace` follows at most.
    budget: u32,
    // 0 begins the walks, 1 resumes them.
    resume: u32,
    // 1 keeps every radiance.
    spectral: u32,
    // 1 where the pixels have no samples yet.
    fresh: u32,
}

@group(1) @binding(0) var<uniform> batch: Batch;

// The number of an invocation of a dispatch whose workgroups are laid out in rows.
fn invocation(group: vec3<u32>, groups: vec3<u32>, lane: u32) -> u32 {
    return (group.y * groups.x + group.x) * WORKGROUP + lane;
}

// A camera ray, moved near the stones.
struct Primary {
    origin: vec3<f32>,
    // The first line of the sample's table.
    first_line: u32,
    direction: vec3<f32>,
    // 0 where the ray passes the stones by; else one more than the facet that it may come to first.
    near: u32,
    // Linear sRGB seen where the ray meets no stone.
    background: vec3<f32>,
}

// What a work item has come to: a pixel sample at one wavelength.
struct Result {
    radiance: f32,
    // Segments traced.
    rays: u32,
    // Whether the primary ray meets a stone.
    covered: u32,
    // Whether the work item is not over.
    going: u32,
    // Throughput: the fields of `Energy`.
    dropped_depth: f32,
    dropped_threshold: f32,
    left_at_limit: f32,
    lost: f32,
}
