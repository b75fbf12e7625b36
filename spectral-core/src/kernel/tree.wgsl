// The rules of transport: the twin of `tree.rs` of the CPU backend. A path is a tree of reflected and refracted
// rays; an explicit stack holds those still to be followed.
//
// Unlike the CPU's, whose stack grows, a walk goes on with the **weaker** child and stacks the stronger. The
// weaker has at most half of its parent, so a ray stacked while n others wait has at most 2⁻ⁿ, and STACK places
// suffice for any threshold down to 2^(1 − STACK) however deep the path. The same rays are followed, in another
// order.

fn tree_medium(nest: Nest, line: Line) -> Medium {
    if nest_is_empty(nest) {
        return AIR;
    }
    return line_medium(line, material_of_rank[nest_top(nest) - 1u]);
}

// Follows the walk's ray to its next surface, or out into the light; `background` is what is seen past the stones.
fn walk_go_on(walk: ptr<function, Walk>, item: u32, line: Line, background: vec3<f32>) {
    let ray = (*walk).ray;
    var crossing = Crossing(false, 0.0, 0u, vec3(0.0), ray.nest, ray.nest);
    if (*walk).state == WALK_GOING {
        crossing = surfaces_next(ray.origin, ray.direction, ray.nest, ray.start);
    }
    (*walk).result.rays++;
    var outcome = outcome_of(ray);
    if crossing.found {
        (*walk).result.covered = 1u;
        walk_meet(walk, crossing, line, &outcome);
    } else if (*walk).result.covered == 0u && scene.transparent != 0u {
        (*walk).result.rays = 0u;
    } else {
        outcome.weight = throughput_intensity(ray.throughput);
        if (*walk).result.covered != 0u && !nest_is_empty(ray.nest) {
            (*walk).result.lost += outcome.weight;
        }
    }
    if outcome.weight > 0.0 {
        var rgb = background;
        if (*walk).result.covered != 0u {
            rgb = light_rgb(outcome.origin, outcome.direction);
        }
        (*walk).result.radiance += basis_expand(line.basis, rgb) * outcome.weight;
    }
    if outcome.waits {
        walk_push(walk, item, outcome.waiting);
    }
    walk_push_others(walk, item, &outcome);
    if outcome.goes_on {
        (*walk).ray = outcome.ray;
    } else if (*walk).waiting > 0u {
        (*walk).waiting--;
        (*walk).ray = stack_load(item, (*walk).waiting);
    } else {
        (*walk).state = WALK_OVER;
    }
}

// A surface event outside crystals: fades the ray and splits it.
fn walk_arrive(walk: ptr<function, Walk>, crossing: Crossing, line: Line, outcome: ptr<function, Outcome>) {
    var ray = (*walk).ray;
    let here = tree_medium(crossing.before, line);
    let beyond = tree_medium(crossing.after, line);
    // Inside a metal nothing travels.
    if medium_is_opaque(here) {
        return;
    }
    ray.throughput = throughput_scaled(ray.throughput, medium_transmittance(here, crossing.distance));
    let intensity = throughput_intensity(ray.throughput);
    let at_limit = ray.depth == scene.max_depth;
    if at_limit && scene.leave_at_limit == 0u {
        (*walk).result.dropped_depth += intensity;
        return;
    }
    if !at_limit && nest_is_empty(crossing.before) && intensity < scene.threshold {
        (*walk).result.dropped_threshold += intensity;
        return;
    }
    // At the limit a ray leaves into air, unless a metal lets nothing through.
    var other = beyond;
    if at_limit && !medium_is_opaque(beyond) {
        other = AIR;
    }
    let normal = crossing.normal;
    let cos_i = -inner(normal, ray.direction);
    let event = medium_interface(here, other, cos_i);
    let opaque = medium_is_opaque(other);
    let shares = throughput_split(ray.throughput, ray.direction, normal, event);
    let origin = ray.direction * crossing.distance + ray.origin;
    let depth = ray.depth + 1u;
    let mirrored = reflected(ray.direction, normal);
    let onward = refracted(ray.direction, normal, cos_i, event.cos_t, here.n / other.n);
    if at_limit {
        (*outcome).origin = origin;
        walk_at_limit(walk, ray, crossing, opaque, event.tir, shares.back, mirrored, onward, outcome);
        return;
    }
    // The second child is absent under total reflection and at metals.
    let through = !event.tir && !opaque;
    let back = Ray(origin, depth, mirrored, shares.back, crossing.before, crossing.facet);
    let on = Ray(origin, depth, onward, shares.on, crossing.after, crossing.facet);
    let back_goes_on = walk_worthwhile(walk, back);
    let on_goes_on = through && walk_worthwhile(walk, on);
    let back_is_weaker = throughput_intensity(back.throughput) < throughput_intensity(on.throughput);
    (*outcome).goes_on = back_goes_on || on_goes_on;
    (*outcome).waits = back_goes_on && on_goes_on;
    if back_goes_on && (back_is_weaker || !on_goes_on) {
        (*outcome).ray = back;
        (*outcome).waiting = on;
    } else {
        (*outcome).ray = on;
        (*outcome).waiting = back;
    }
}

// Whether a ray goes on: inside a stone only above the threshold, and never with nothing.
fn walk_worthwhile(walk: ptr<function, Walk>, ray: Ray) -> bool {
    let intensity = throughput_intensity(ray.throughput);
    if intensity > 0.0 && intensity < scene.threshold && !nest_is_empty(ray.nest) {
        (*walk).result.dropped_threshold += intensity;
        return false;
    }
    return intensity > 0.0;
}

// A ray that would make one event too many leaves: along the refracted direction, straight on where reflection is
// total, and as a metal reflects it.
fn walk_at_limit(
    walk: ptr<function, Walk>,
    ray: Ray,
    crossing: Crossing,
    metal: bool,
    tir: bool,
    back: Throughput,
    mirrored: vec3<f32>,
    onward: vec3<f32>,
    outcome: ptr<function, Outcome>,
) {
    if metal {
        (*outcome).weight = throughput_intensity(back);
        (*outcome).direction = mirrored;
    } else {
        (*outcome).weight = throughput_intensity(ray.throughput);
        (*outcome).direction = select(onward, ray.direction, tir || nest_is_empty(crossing.before));
    }
    (*walk).result.left_at_limit += (*outcome).weight;
}

// Stacks a ray. When the stack is full the weakest ray goes, and is counted as dropped.
fn walk_push(walk: ptr<function, Walk>, item: u32, ray: Ray) {
    var place = (*walk).waiting;
    if place == STACK {
        var weakest = throughput_intensity(ray.throughput);
        for (var i = 0u; i < STACK; i++) {
            let intensity = throughput_intensity(stack_load(item, i).throughput);
            if intensity < weakest {
                weakest = intensity;
                place = i;
            }
        }
        (*walk).result.dropped_threshold += weakest;
    } else {
        (*walk).waiting++;
    }
    if place < STACK {
        stack_store(item, place, ray);
    }
}
