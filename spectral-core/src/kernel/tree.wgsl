// The rules of transport: the twin of `tree.rs` of the CPU backend. A path is a tree of reflected and refracted
// rays; an explicit stack holds those still to be followed.
//
// Unlike the CPU's, whose stack grows, a walk goes on with the **weaker** child and stacks the stronger. The
// weaker has at most half of its parent, so a ray stacked while n others wait has at most 2⁻ⁿ, and STACK places
// suffice for any threshold down to 2^(1 − STACK) however deep the path. The same rays are followed, in another
// order.

const AIR = Medium(1.0, 0.0, 0.0);

// A ray that may be absent.
struct Child {
    ray: Ray,
    goes_on: bool,
}

struct Interface {
    event: Fresnel,
    cos_i: f32,
}

fn interface_at(direction: vec3<f32>, normal: vec3<f32>, here: Medium, beyond: Medium) -> Interface {
    let cos_i = -dot(normal, direction);
    if beyond.k > 0.0 {
        return Interface(conductor(cos_i, here.n, beyond.n, beyond.k), cos_i);
    }
    return Interface(dielectric(cos_i, here.n / beyond.n), cos_i);
}

fn tree_medium(nest: Nest, line: Line) -> Medium {
    if nest_is_empty(nest) {
        return AIR;
    }
    return line_medium(line, material_of_rank[nest_top(nest) - 1u]);
}

fn walk_leave(walk: ptr<function, Walk>, throughput: Throughput, direction: vec3<f32>, line: Line) {
    (*walk).sum += light_radiance(direction, line) * throughput_intensity(throughput);
}

// Follows the walk's ray to its next surface.
fn walk_go_on(walk: ptr<function, Walk>, item: u32, line: Line) {
    let ray = (*walk).ray;
    let crossing = surfaces_next(ray.origin, ray.direction, ray.nest);
    if crossing.found {
        (*walk).covered = 1u;
        walk_arrive(walk, item, crossing, line);
    } else if (*walk).covered == 0u {
        walk_pass_by(walk, ray.direction, line);
    } else {
        (*walk).account.rays++;
        if !nest_is_empty(ray.nest) {
            (*walk).account.lost += throughput_intensity(ray.throughput);
        }
        walk_leave(walk, ray.throughput, ray.direction, line);
        walk_pop(walk, item);
    }
}

// What is seen past the stones.
fn walk_pass_by(walk: ptr<function, Walk>, direction: vec3<f32>, line: Line) {
    (*walk).state = WALK_OVER;
    if scene.transparent == 0u {
        (*walk).account.rays = 1u;
        (*walk).sum = light_radiance(direction, line);
    }
}

// A surface event: fades the ray and splits it; the walk goes on with a child or with a ray from the stack.
fn walk_arrive(walk: ptr<function, Walk>, item: u32, crossing: Crossing, line: Line) {
    var ray = (*walk).ray;
    let here = tree_medium(crossing.before, line);
    let beyond = tree_medium(crossing.after, line);
    (*walk).account.rays++;
    if here.absorption > 0.0 {
        ray.throughput = throughput_scaled(ray.throughput, exp(-here.absorption * crossing.distance));
    }
    let intensity = throughput_intensity(ray.throughput);
    let spent = nest_is_empty(crossing.before) && intensity < scene.threshold;
    // Inside a metal nothing travels.
    if here.k > 0.0 {
        walk_pop(walk, item);
    } else if ray.depth == scene.max_depth {
        walk_at_limit(walk, ray, crossing, here, beyond, line);
        walk_pop(walk, item);
    } else if spent {
        (*walk).account.dropped_threshold += intensity;
        walk_pop(walk, item);
    } else {
        walk_split(walk, item, ray, crossing, here, beyond);
    }
}

// The two children of an event; the second is absent under total reflection and at metals.
fn walk_split(
    walk: ptr<function, Walk>,
    item: u32,
    ray: Ray,
    crossing: Crossing,
    here: Medium,
    beyond: Medium,
) {
    let at = interface_at(ray.direction, crossing.normal, here, beyond);
    let shares = throughput_split(ray.throughput, ray.direction, crossing.normal, at.event);
    let origin = ray.origin + ray.direction * crossing.distance;
    let depth = ray.depth + 1u;
    let direction = reflected(ray.direction, crossing.normal);
    let back = walk_worthwhile(walk, Ray(origin, depth, direction, shares.back, crossing.before), true);
    let through = !at.event.tir && beyond.k == 0.0;
    let onward = refracted(ray.direction, crossing.normal, at.cos_i, at.event.cos_t, here.n / beyond.n);
    let on = walk_worthwhile(walk, Ray(origin, depth, onward, shares.on, crossing.after), through);
    if back.goes_on && on.goes_on {
        let back_is_weaker = throughput_intensity(shares.back) < throughput_intensity(shares.on);
        if back_is_weaker {
            walk_push(walk, item, on.ray);
            (*walk).ray = back.ray;
        } else {
            walk_push(walk, item, back.ray);
            (*walk).ray = on.ray;
        }
    } else if back.goes_on {
        (*walk).ray = back.ray;
    } else if on.goes_on {
        (*walk).ray = on.ray;
    } else {
        walk_pop(walk, item);
    }
}

// Whether a ray goes on: inside a stone only above the threshold, and never with nothing.
fn walk_worthwhile(walk: ptr<function, Walk>, ray: Ray, present: bool) -> Child {
    let intensity = throughput_intensity(ray.throughput);
    if !present || intensity <= 0.0 {
        return Child(ray, false);
    }
    if intensity < scene.threshold && !nest_is_empty(ray.nest) {
        (*walk).account.dropped_threshold += intensity;
        return Child(ray, false);
    }
    return Child(ray, true);
}

// What becomes of a ray that would make one event too many.
fn walk_at_limit(
    walk: ptr<function, Walk>,
    ray: Ray,
    crossing: Crossing,
    here: Medium,
    beyond: Medium,
    line: Line,
) {
    let left = throughput_intensity(ray.throughput);
    if scene.leave_at_limit == 0u {
        (*walk).account.dropped_depth += left;
        return;
    }
    let normal = crossing.normal;
    if beyond.k > 0.0 {
        // A metal lets nothing through: the rest leaves as the metal reflects it.
        let at = interface_at(ray.direction, normal, here, beyond);
        let back = throughput_split(ray.throughput, ray.direction, normal, at.event).back;
        (*walk).account.left_at_limit += throughput_intensity(back);
        walk_leave(walk, back, reflected(ray.direction, normal), line);
        return;
    }
    (*walk).account.left_at_limit += left;
    let at = interface_at(ray.direction, normal, here, AIR);
    var direction = ray.direction;
    if !at.event.tir && !nest_is_empty(crossing.before) {
        direction = refracted(ray.direction, normal, at.cos_i, at.event.cos_t, here.n);
    }
    walk_leave(walk, ray.throughput, direction, line);
}

// Stacks a ray. When the stack is full the weakest ray goes, and is counted as dropped.
fn walk_push(walk: ptr<function, Walk>, item: u32, ray: Ray) {
    if (*walk).waiting < STACK {
        stack_store(item, (*walk).waiting, ray);
        (*walk).waiting++;
        return;
    }
    var weakest = throughput_intensity(ray.throughput);
    var place = STACK;
    for (var i = 0u; i < STACK; i++) {
        let intensity = throughput_intensity(stack_load(item, i).throughput);
        if intensity < weakest {
            weakest = intensity;
            place = i;
        }
    }
    (*walk).account.dropped_threshold += weakest;
    if place < STACK {
        stack_store(item, place, ray);
    }
}

// Goes on with the ray stacked last; without one the walk is over.
fn walk_pop(walk: ptr<function, Walk>, item: u32) {
    if (*walk).waiting == 0u {
        (*walk).state = WALK_OVER;
        return;
    }
    (*walk).waiting--;
    (*walk).ray = stack_load(item, (*walk).waiting);
}
