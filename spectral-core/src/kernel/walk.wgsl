// A path on its way, as it is kept between dispatches.

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

// States of a walk: its ray may meet surfaces; its ray passes all of them by; nothing is left to follow.
const WALK_GOING: u32 = 0u;
const WALK_PASSING: u32 = 1u;
const WALK_OVER: u32 = 2u;

// One work item: a pixel sample at one wavelength.
struct Walk {
    // The ray to follow next, unless the walk is over.
    ray: Ray,
    // What it has come to so far.
    result: Result,
    // Rays waiting on the stack.
    waiting: u32,
    state: u32,
}
