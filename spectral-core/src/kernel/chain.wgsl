// One convex stone: what leaves it never comes back, so a path is a chain of internal reflections, and light is looked
// up where a ray leaves. The twin of `chain` of the CPU backend. The rules are those of `tree.wgsl`.

@group(1) @binding(2) var<storage, read> primaries: array<Primary>;

// What stays in the stone, or is about to enter it.
struct Chain {
    origin: vec3<f32>,
    // Surface events so far.
    depth: u32,
    direction: vec3<f32>,
    // The facet that the ray starts on, or that a camera ray comes to first.
    facet: u32,
    throughput: Throughput,
    // Whether there is anything to follow.
    alive: bool,
}

// The nest of a ray inside the only stone.
const INSIDE = Nest(1u, 0u, 0u);

// The next surface. An invocation without a ray helps its subgroup to search.
fn chain_hit(chain: Chain) -> Hit {
    let nest = select(Nest(0u), INSIDE, chain.depth > 0u && chain.alive);
    let start = select(0xffffffffu, chain.facet, chain.alive);
    let query =
        Query(chain.origin, start, chain.direction, -scene.behind, LARGEST, nest, false, vec3(0.0), Nest(0u));
    let answer = facets_guess(query);
    if answer.known || !chain.alive {
        return answer.hit;
    }
    return facets_search(query);
}

// What is seen past the stone.
fn chain_past(result: ptr<function, Result>, line: Line, background: vec3<f32>) {
    if scene.transparent == 0u {
        (*result).rays = 1u;
        (*result).radiance = basis_expand(line.basis, background);
    }
}

// Light that leaves.
fn chain_leave(result: ptr<function, Result>, line: Line, origin: vec3<f32>, direction: vec3<f32>, weight: f32) {
    if weight > 0.0 {
        (*result).radiance += basis_expand(line.basis, light_rgb(origin, direction)) * weight;
    }
}

// A surface event: fades the ray, sends out what leaves, and goes on with what stays.
fn chain_arrive(chain: ptr<function, Chain>, result: ptr<function, Result>, line: Line, stone: Medium, hit: Hit) {
    let inside = (*chain).depth > 0u;
    let distance = max(hit.t, 0.0);
    let direction = (*chain).direction;
    let origin = direction * distance + (*chain).origin;
    let outward = facet_plane(hit.facet).xyz;
    let normal = select(outward, -outward, inside);
    var throughput = (*chain).throughput;
    if inside {
        throughput = throughput_scaled(throughput, medium_transmittance(stone, distance));
    }
    let at_limit = (*chain).depth == scene.max_depth;
    (*chain).alive = false;
    if at_limit && scene.leave_at_limit == 0u {
        (*result).dropped_depth += throughput_intensity(throughput);
        return;
    }
    var here = AIR;
    var beyond = stone;
    if inside {
        here = stone;
    }
    if inside || at_limit {
        beyond = AIR;
    }
    let cos_i = -inner(normal, direction);
    let event = medium_interface(here, beyond, cos_i);
    let shares = throughput_split(throughput, direction, normal, event);
    let mirrored = reflected(direction, normal);
    let onward = refracted(direction, normal, cos_i, event.cos_t, here.n / beyond.n);
    // Under total reflection the refracted share is 0.
    var leaves = throughput_intensity(shares.back);
    var out = mirrored;
    (*chain).throughput = shares.on;
    (*chain).direction = onward;
    if inside {
        leaves = throughput_intensity(shares.on);
        out = onward;
        (*chain).throughput = shares.back;
        (*chain).direction = mirrored;
    }
    (*chain).origin = origin;
    (*chain).facet = hit.facet;
    if at_limit {
        leaves = throughput_intensity(throughput);
        out = select(onward, direction, event.tir || !inside);
        (*result).left_at_limit += leaves;
    } else {
        let stays = throughput_intensity((*chain).throughput);
        (*result).rays += select(0u, 1u, leaves > 0.0);
        (*result).dropped_threshold += select(0.0, stays, stays < scene.threshold);
        (*chain).alive = stays > 0.0 && stays >= scene.threshold;
    }
    chain_leave(result, line, origin, out, leaves);
}

fn chain_follow(primary: Primary, line: Line, exists: bool) -> Result {
    var result = Result();
    var stone = AIR;
    if scene.materials > 0u {
        stone = line_medium(line, material_of_rank[0]);
    }
    let throughput = throughput_eye(primary.direction);
    let near = exists && primary.near != 0u;
    var chain = Chain(primary.origin, 0u, primary.direction, max(primary.near, 1u) - 1u, throughput, near);
    if !near {
        chain_past(&result, line, primary.background);
    }
    while guess_again(chain.alive) {
        let hit = chain_hit(chain);
        if chain.alive {
            result.rays++;
            if hit.found {
                result.covered = 1u;
                chain_arrive(&chain, &result, line, stone, hit);
                chain.depth++;
            } else if chain.depth == 0u {
                chain.alive = false;
                chain_past(&result, line, primary.background);
                result.rays = select(1u, 0u, scene.transparent != 0u);
            } else {
                // A ray inside leaves, whatever rounding does: straight on, and counted.
                chain.alive = false;
                let weight = throughput_intensity(chain.throughput);
                result.lost += weight;
                chain_leave(&result, line, chain.origin, chain.direction, weight);
            }
        }
    }
    return result;
}

// The chain of a work item.
fn trace_item(item: u32) {
    let exists = item < batch.pixels * batch.count * scene.lines;
    // Those beyond the last follow nothing, but help to search. Their camera ray may never have been written.
    let place = select(0u, item, exists);
    let primary = primaries[place / scene.lines];
    let line = line_at(select(0u, primary.first_line + place % scene.lines, exists));
    let result = chain_follow(primary, line, exists);
    if exists {
        results[item] = result;
    }
}
