// A path on its way, as it is kept between dispatches.

// A camera ray, moved near the stones by the host in double precision.
struct Primary {
    origin: vec3<f32>,
    // The first line of the sample's table.
    first_line: u32,
    direction: vec3<f32>,
    // 0 where the ray passes the stones by; else one more than the facet that it may come to first.
    near: u32,
    // Linear sRGB seen where the ray meets no stone: looked up in double precision, since beside a lamp one texel
    // may be a thousand times the next.
    background: vec3<f32>,
}

// A ray on its way.
struct Ray {
    origin: vec3<f32>,
    // Surface events so far.
    depth: u32,
    direction: vec3<f32>,
    throughput: Throughput,
    // The stones it is in.
    nest: Nest,
    // The facet that it starts on, or that a camera ray comes to first. Nothing is taken from it unverified.
    start: u32,
}

// Rays and energy of one work item.
struct Account {
    rays: u32,
    dropped_depth: f32,
    dropped_threshold: f32,
    left_at_limit: f32,
    lost: f32,
}

// States of a walk: its ray may meet surfaces; its ray passes all of them by; nothing is left to follow.
const WALK_GOING: u32 = 0u;
const WALK_PASSING: u32 = 1u;
const WALK_OVER: u32 = 2u;

// One work item: a pixel sample at one wavelength.
struct Walk {
    // The ray to follow next, unless the walk is over.
    ray: Ray,
    // Radiance gathered so far.
    sum: f32,
    account: Account,
    // Rays waiting on the stack.
    waiting: u32,
    state: u32,
    // Whether the primary ray meets a stone.
    covered: u32,
}
