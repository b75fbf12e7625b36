// Scenes without crystals: an event sends on two rays at most.

// What a step leads to: light that reaches the eye, and the ray to go on with. It is collected, so that the long parts
// (the look-up of light, the stack) are in the program once and all invocations run them together.
struct Outcome {
    // Weight of the radiance from a direction; 0 for none.
    weight: f32,
    // Where it leaves the stones, and which way.
    origin: vec3<f32>,
    direction: vec3<f32>,
    goes_on: bool,
    ray: Ray,
    // A ray for the stack.
    waits: bool,
    waiting: Ray,
}

fn outcome_of(ray: Ray) -> Outcome {
    return Outcome(0.0, ray.origin, ray.direction, false, ray, false, ray);
}

fn walk_meet(walk: ptr<function, Walk>, crossing: Crossing, line: Line, outcome: ptr<function, Outcome>) {
    walk_arrive(walk, crossing, line, outcome);
}

fn walk_push_others(_walk: ptr<function, Walk>, _item: u32, _outcome: ptr<function, Outcome>) {}

fn walk_ready(_walk: ptr<function, Walk>, _item: u32, _line: Line) {}
