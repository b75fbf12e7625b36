// Scenes with crystals: the twin of `reference/crystal.rs` of the CPU backend.
//
// Outside crystals a ray's throughput is a row. In one it is a mode: the row is its weight W and its E, of any length, the
// axis its N. An event at a crystal sends on up to four rays.

// What a step leads to: see `event_isotropic.wgsl`.
struct Outcome {
    weight: f32,
    origin: vec3<f32>,
    direction: vec3<f32>,
    goes_on: bool,
    // The weakest.
    ray: Ray,
    waits: bool,
    // The strongest, for the stack before the others, which become weaker.
    waiting: Ray,
    more: u32,
    others: array<Ray, 2>,
}

fn outcome_of(ray: Ray) -> Outcome {
    return Outcome(0.0, ray.origin, ray.direction, false, ray, false, ray, 0u, array(ray, ray));
}

// The rays that an event sends on, the strongest first.
struct Children {
    count: u32,
    rays: array<Ray, 4>,
}

fn line_crystal(line: Line, material: u32) -> Crystal {
    return crystal_at(line.first + BASIS_VECTORS + 1u + material * MEDIUM_VECTORS + CRYSTAL_OFFSET);
}

// The crystal that fills the space; of kind 0 where there is none.
fn tree_crystal(nest: Nest, line: Line) -> Crystal {
    if nest_is_empty(nest) {
        return Crystal();
    }
    return line_crystal(line, material_of_rank[nest_top(nest) - 1u]);
}

// A mode as the throughput of a ray.
fn throughput_of_mode(weight: f32, wave: Wave) -> Throughput {
    return Throughput(vec4(weight, wave.electric), wave.normal);
}

// A row in the plane of incidence; without polarisation only its intensity.
fn throughput_of_row(row: vec4<f32>, at: Incidence) -> Throughput {
    if POLARIZED {
        return Throughput(row, at.s);
    }
    return Throughput(vec4(row.x, 0.0, 0.0, 0.0), at.s);
}

// The number of the pixel's sample, by which rays are chosen.
var<private> sample_number: u32;

// By what the sample chooses at an event: the twin of `lattice::choice`.
fn choice(event: u32) -> f32 {
    var turned = 0u;
    var place = CHOICES;
    for (var rest = sample_number % CHOICES; rest > 0u; rest /= 3u) {
        place /= 3u;
        turned += rest % 3u * place;
    }
    var power = MULTIPLIER;
    for (var left = event; left > 0u; left >>= 1u) {
        if (left & 1u) == 1u {
            turned = turned * power % CHOICES;
        }
        power = power * power % CHOICES;
    }
    return f32((2u * (turned + SHIFT) + CHOICES) % (2u * CHOICES)) / f32(2u * CHOICES);
}

// The weights of two modes that are followed. If one is lighter than `split` only one of them is, with the weight of both.
fn modes_followed(weights: vec2<f32>, event: u32) -> vec2<f32> {
    if min(weights.x, weights.y) >= scene.split {
        return weights;
    }
    let sum = weights.x + weights.y;
    return select(vec2(0.0, sum), vec2(sum, 0.0), choice(event) * sum < weights.x);
}

fn children_add(walk: ptr<function, Walk>, children: ptr<function, Children>, ray: Ray) {
    if !walk_worthwhile(walk, ray) {
        return;
    }
    let intensity = throughput_intensity(ray.throughput);
    var place = (*children).count;
    while place > 0u && throughput_intensity((*children).rays[place - 1u].throughput) < intensity {
        (*children).rays[place] = (*children).rays[place - 1u];
        place--;
    }
    (*children).rays[place] = ray;
    (*children).count++;
}

// Two modes on one side of a surface; the rest of their rays is that of `start`.
fn children_add_modes(
    walk: ptr<function, Walk>,
    children: ptr<function, Children>,
    start: Ray,
    weights: vec2<f32>,
    waves: array<Wave, 2>,
) {
    let followed = modes_followed(weights, start.depth - 1u);
    var ray = start;
    ray.throughput = throughput_of_mode(followed.x, waves[0]);
    ray.direction = wave_ray(waves[0].normal, waves[0].electric);
    children_add(walk, children, ray);
    ray.throughput = throughput_of_mode(followed.y, waves[1]);
    ray.direction = wave_ray(waves[1].normal, waves[1].electric);
    children_add(walk, children, ray);
}

// The rays after an event, all from its place and one event deeper.
fn ray_after(ray: Ray, crossing: Crossing, nest: Nest) -> Ray {
    let origin = ray.direction * crossing.distance + ray.origin;
    return Ray(origin, ray.depth + 1u, ray.direction, ray.throughput, nest, crossing.facet);
}

// A row that meets a crystal: one row is reflected, two modes enter.
fn walk_enter(
    walk: ptr<function, Walk>,
    ray: Ray,
    crossing: Crossing,
    here: Medium,
    beyond: Crystal,
    children: ptr<function, Children>,
) {
    let normal = -crossing.normal;
    let frame = aligned(ray.direction, ray.throughput.axis, normal);
    let row = row_rotated(ray.throughput.row, frame.cos2, frame.sin2);
    let at = incidence_aligned(ray.direction * here.n, normal, frame.axis);
    let on = crystal_waves(beyond, at, 1.0);
    let z = max(here.n * inner(normal, ray.direction), 1e-12);
    let out = boundary_enter(at, here.n, z, on);
    let back = weight_reflected(row, out[0].back, out[1].back);
    let into_first = weight_into_mode(row, array(out[0].on[0], out[1].on[0]));
    let into_second = weight_into_mode(row, array(out[0].on[1], out[1].on[1]));
    // Nothing is lost to rounding.
    let scale = row.x / (back.x + into_first + into_second);
    var mirrored = ray_after(ray, crossing, crossing.before);
    mirrored.direction = reflected(ray.direction, normal);
    mirrored.throughput = throughput_of_row(back * scale, at);
    children_add(walk, children, mirrored);
    let weights = vec2(into_first, into_second) * scale;
    children_add_modes(walk, children, ray_after(ray, crossing, crossing.after), weights, on);
}

// A mode that meets a surface: two modes are reflected, and a row or two modes go through.
fn walk_leave(
    walk: ptr<function, Walk>,
    ray: Ray,
    crossing: Crossing,
    here: Crystal,
    crystal_beyond: Crystal,
    beyond: Medium,
    children: ptr<function, Children>,
) {
    let normal = -crossing.normal;
    let weight = ray.throughput.row.x;
    let at = incidence_of(ray.throughput.axis, normal);
    let incident = wave_by_field(at, ray.throughput.axis, ray.throughput.row.yzw);
    let back = crystal_waves(here, at, -1.0);
    let inside = ray_after(ray, crossing, crossing.before);
    var through = ray_after(ray, crossing, crossing.after);
    var out: Scattered;
    if crystal_beyond.kind > 0.0 {
        let on = crystal_waves(crystal_beyond, at, 1.0);
        out = boundary_between(incident, back, on);
        let weights = vec2(dot(out.on[0], out.on[0]), dot(out.on[1], out.on[1]));
        children_add_modes(walk, children, through, weights * (weight / scattered_power(out)), on);
    } else {
        out = boundary_leave(at, incident, back, beyond.n, beyond.k);
        let cos2 = incidence_square(at, beyond.n);
        if !medium_is_opaque(beyond) && cos2 > 0.0 {
            through.direction = normalize(at.u * at.tangential + normal * sqrt(cos2));
            let row = weight_from_mode(out.on) * (weight / scattered_power(out));
            through.throughput = throughput_of_row(row, at);
            children_add(walk, children, through);
        }
    }
    // A metal takes what is not reflected; elsewhere nothing is lost to rounding.
    let power = select(scattered_power(out), abs(incident.flux), medium_is_opaque(beyond));
    let weights = vec2(dot(out.back[0], out.back[0]), dot(out.back[1], out.back[1]));
    children_add_modes(walk, children, inside, weights * (weight / power), back);
}

// A surface event.
fn walk_meet(walk: ptr<function, Walk>, crossing: Crossing, line: Line, outcome: ptr<function, Outcome>) {
    var ray = (*walk).ray;
    let here = tree_crystal(crossing.before, line);
    let crystal_beyond = tree_crystal(crossing.after, line);
    let at_limit = ray.depth == scene.max_depth;
    let medium = tree_medium(crossing.before, line);
    if here.kind == 0.0 {
        if !POLARIZED {
            // The mean of s and p at each event: the rest of the row is dropped.
            (*walk).ray.throughput.row = vec4(ray.throughput.row.x, 0.0, 0.0, 0.0);
        }
        if crystal_beyond.kind == 0.0 || at_limit || medium_is_opaque(medium) {
            walk_arrive(walk, crossing, line, outcome);
            return;
        }
        ray.throughput = throughput_scaled((*walk).ray.throughput, medium_transmittance(medium, crossing.distance));
    } else {
        let row = ray.throughput.row;
        let absorption = crystal_absorption(here, ray.throughput.axis, row.yzw, ray.direction);
        ray.throughput.row.x *= exp(-absorption * crossing.distance);
    }
    let intensity = throughput_intensity(ray.throughput);
    if at_limit {
        mode_at_limit(walk, ray, crossing, line, outcome);
        return;
    }
    if nest_is_empty(crossing.before) && intensity < scene.threshold {
        (*walk).result.dropped_threshold += intensity;
        return;
    }
    var children: Children;
    if here.kind == 0.0 {
        walk_enter(walk, ray, crossing, medium, crystal_beyond, &children);
    } else {
        walk_leave(walk, ray, crossing, here, crystal_beyond, tree_medium(crossing.after, line), &children);
    }
    outcome_follow(outcome, children);
}

// The weakest child goes on, the others wait, the strongest lowest.
fn outcome_follow(outcome: ptr<function, Outcome>, start: Children) {
    var children = start;
    let count = children.count;
    (*outcome).goes_on = count > 0u;
    (*outcome).waits = count > 1u;
    (*outcome).more = max(count, 2u) - 2u;
    (*outcome).ray = children.rays[max(count, 1u) - 1u];
    (*outcome).waiting = children.rays[0];
    (*outcome).others = array(children.rays[1], children.rays[2]);
}

// A mode that would make one event too many leaves straight on, or as from a mirror at a metal.
fn mode_at_limit(
    walk: ptr<function, Walk>,
    ray: Ray,
    crossing: Crossing,
    line: Line,
    outcome: ptr<function, Outcome>,
) {
    let intensity = throughput_intensity(ray.throughput);
    if scene.leave_at_limit == 0u {
        (*walk).result.dropped_depth += intensity;
        return;
    }
    (*outcome).weight = intensity;
    (*outcome).origin = ray.direction * crossing.distance + ray.origin;
    let mirrored = reflected(ray.direction, crossing.normal);
    let opaque = medium_is_opaque(tree_medium(crossing.after, line));
    (*outcome).direction = select(ray.direction, mirrored, opaque);
    (*walk).result.left_at_limit += intensity;
}

fn walk_push_others(walk: ptr<function, Walk>, item: u32, outcome: ptr<function, Outcome>) {
    for (var i = 0u; i < (*outcome).more; i++) {
        walk_push(walk, item, (*outcome).others[i]);
    }
}

// Begins or resumes a walk. An eye in a crystal sees both modes with the wave vector along its ray.
fn walk_ready(walk: ptr<function, Walk>, item: u32, line: Line) {
    sample_number = batch.first + item / scene.lines % batch.count;
    var ray = (*walk).ray;
    let crystal = tree_crystal(ray.nest, line);
    if batch.resume != 0u || crystal.kind == 0.0 {
        return;
    }
    var at = incidence_of(ray.direction, ray.direction);
    at.tangential = 0.0;
    let waves = crystal_waves(crystal, at, 1.0);
    ray.throughput = throughput_of_mode(0.5, waves[0]);
    ray.direction = wave_ray(waves[0].normal, waves[0].electric);
    walk_push(walk, item, ray);
    ray.throughput = throughput_of_mode(0.5, waves[1]);
    ray.direction = wave_ray(waves[1].normal, waves[1].electric);
    (*walk).ray = ray;
}
