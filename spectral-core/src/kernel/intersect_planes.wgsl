// `intersect` for one convex stone: the half-spaces of its facets, no hierarchy. The twin of `planes.rs` of the CPU
// backend.
//
// **Search** compares all planes. From inside, the ray leaves through the nearest plane that it runs towards. No
// epsilon: it never runs towards the facet that it has just been reflected by, and a start that rounding put beyond a
// plane leaves through it at distance 0. From outside, it enters through the last plane that it meets from without, if
// that comes before the first it meets from within.
//
// **Verify** takes one facet and believes it only where the ray meets its plane inside its polygon, by a margin that
// covers the rounding of both ways. Then the search would find the same, so a picture cannot show who guessed, or how.
// What is guessed is the business of `facets_guess`, which each form of guessing gives. `facets_nearest` is a search
// that is good enough for a guess, and takes a third of the instructions.

// For each facet where its list begins, then where the last ends; then the lists: the facets around each
// (`prepare/outline.rs`).
@group(0) @binding(5) var<storage, read> outlines: array<u32>;

// What is known of a ray without a search.
struct Answer {
    known: bool,
    hit: Hit,
}

// Whether a point on a facet's plane is well inside its polygon. Of a facet with fewer than three sides none is.
fn facet_holds(facet: u32, point: vec3<f32>) -> bool {
    let begin = facet_word(facet);
    let end = facet_word(facet + 1u);
    let inset = GUESS_MARGINS * scene.margin;
    var holds = end >= begin + 3u;
    for (var place = begin; place < end; place++) {
        let side = facet_plane(facet_word(place));
        holds = holds & (inner(side.xyz, point) < side.w - inset);
    }
    return holds;
}

// What a search would find, as far as one facet tells: the ray leaves the stone by it; or enters by it; or starts on
// it, outside, and runs away, so that it meets nothing. Any number may be given as the facet.
fn facet_verify(query: Query, facet: u32) -> Answer {
    var answer = Answer(false, hit_none(query));
    if facet >= scene.facets {
        return answer;
    }
    let inside = !nest_is_empty(query.nest);
    let plane = facet_plane(facet);
    let towards = inner(plane.xyz, query.direction);
    let gap = plane.w - inner(plane.xyz, query.origin);
    let away = !inside && towards > 0.0;
    let t = select(gap / towards, 0.0, away);
    let holds = facet_holds(facet, query.direction * t + query.origin);
    if away {
        // Inside all planes around by more than a surface may lie behind a ray's start: none of them counts.
        answer.known = holds && abs(gap) <= scene.margin;
        return answer;
    }
    answer.known = holds && (towards > 0.0) == inside && towards != 0.0;
    answer.hit = Hit(t, facet, facet, inside || query_accepts(query, facet));
    return answer;
}

// The facet that a ray from inside leaves by, nearly: of every `step`-th plane from `first` on, the one with the largest
// inverse of the distance. It shares a word with the facet's number, so that a maximum finds both, and loses its last
// bits for that. A start beyond a plane, by rounding, leaves through it at once.
fn facets_nearest(origin: vec3<f32>, direction: vec3<f32>, first: u32, step: u32) -> i32 {
    var nearest = 0i;
    for (var facet = first; facet < scene.facets; facet += step) {
        let plane = facet_plane(facet);
        let gap = max(plane.w - inner(plane.xyz, origin), 1e-30);
        let inverse = bitcast<u32>(inner(plane.xyz, direction) / gap);
        nearest = max(nearest, bitcast<i32>((inverse & ~FACET_BITS) | facet));
    }
    return nearest;
}

// The guess of a ray from inside by itself.
fn facets_own(query: Query) -> Answer {
    let nearest = facets_nearest(query.origin, query.direction, 0u, 1u);
    return facet_verify(query, u32(nearest) & FACET_BITS);
}

// The first surface of all planes.
fn facets_search(query: Query) -> Hit {
    var enter = Hit(-LARGEST, 0u, 0xffffffffu, false);
    var leave = hit_none(query);
    for (var facet = 0u; facet < scene.facets; facet++) {
        let plane = facet_plane(facet);
        let towards = inner(plane.xyz, query.direction);
        let gap = plane.w - inner(plane.xyz, query.origin);
        let t = gap / towards;
        if towards > 0.0 && hit_precedes(t, facet, leave) {
            leave = Hit(t, facet, facet, true);
        } else if towards < 0.0 && t > enter.t {
            enter = Hit(t, facet, facet, true);
        } else if towards == 0.0 && gap < 0.0 {
            // Beside the stone, along one of its facets.
            enter.t = LARGEST;
        }
    }
    if !nest_is_empty(query.nest) {
        return leave;
    }
    enter.found = enter.found && enter.t < leave.t && query_accepts(query, enter.facet);
    return enter;
}

fn intersect(query: Query) -> Hit {
    let answer = facets_guess(query);
    if answer.known {
        return answer.hit;
    }
    return facets_search(query);
}
