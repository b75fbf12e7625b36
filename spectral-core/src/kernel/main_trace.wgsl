// What an entry point that traces does: one invocation a work item, which is a pixel sample at one wavelength.
//
// A tree of rays can be vast, and desktop systems end kernels that run for seconds. So an invocation follows at
// most `batch.budget` rays and leaves its walk in memory, to be resumed by the next dispatch.

@group(1) @binding(2) var<storage, read> primaries: array<Primary>;
@group(1) @binding(4) var<storage, read_write> stack: array<Ray>;

fn stack_store(item: u32, place: u32, ray: Ray) {
    stack[item * STACK + place] = ray;
}

fn stack_load(item: u32, place: u32) -> Ray {
    return stack[item * STACK + place];
}

// A walk before its first surface.
fn walk_begin(primary: Primary) -> Walk {
    let throughput = throughput_eye(primary.direction);
    let ray = Ray(primary.origin, 0u, primary.direction, throughput, scene.eye_nest, max(primary.near, 1u) - 1u);
    let state = select(WALK_PASSING, WALK_GOING, primary.near != 0u);
    return Walk(ray, Result(), 0u, state);
}

// Begins or resumes the walk of a work item.
fn trace_item(item: u32) {
    if item >= batch.pixels * batch.count * scene.lines {
        return;
    }
    let primary = primaries[item / scene.lines];
    let line = line_at(primary.first_line + item % scene.lines);
    var walk: Walk;
    if batch.resume == 0u {
        walk = walk_begin(primary);
    } else {
        walk = walks[item];
    }
    walk_ready(&walk, item, line);
    for (var i = 0u; i < batch.budget && walk.state != WALK_OVER; i++) {
        walk_go_on(&walk, item, line, primary.background);
    }
    walk.result.going = select(1u, 0u, walk.state == WALK_OVER);
    walks[item] = walk;
}
