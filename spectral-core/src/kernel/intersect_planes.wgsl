// `intersect` for one convex stone: the half-spaces of its facets, no hierarchy. The twin of `planes.rs` of the CPU
// backend.
//
// From inside, the ray leaves through the nearest plane that it runs towards. No epsilon: it never runs towards the
// facet that it has just been reflected by, and a start that rounding put beyond a plane leaves through it at
// distance 0. From outside, it enters through the last plane that it meets from without, if that comes before the
// first it meets from within.

fn intersect(query: Query) -> Hit {
    let inside = !nest_is_empty(query.nest);
    let count = arrayLength(&planes);
    var enter = Hit(-LARGEST, 0u, 0xffffffffu, false);
    var leave = hit_none(query);
    for (var facet = 0u; facet < count; facet++) {
        let plane = planes[facet];
        let towards = inner(plane.normal, query.direction);
        let gap = plane.offset - inner(plane.normal, query.origin);
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
    if inside {
        return leave;
    }
    enter.found = enter.found && enter.t < leave.t && query_accepts(query, enter.facet);
    return enter;
}
