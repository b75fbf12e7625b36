// The scene's surfaces: which one a ray crosses next, and between which media.
//
// Here is what all forms of `intersect` share: the question (`Query`), the answer (`Hit`), the rule by which a
// candidate counts (`query_accepts`), and the order among those that count (`hit_precedes`). A form gives
//
//     fn intersect(query: Query) -> Hit
//
// the first hit, in that order, with a parameter in [query.t_min, query.t_max]. A hit may lie a little behind the start
// (t_min < 0). A form on hardware therefore moves the origin back along the ray and searches from t = 0; the rule uses
// the query's own origin, so the rounding of the moved one does no harm. Candidates must reach the rule one by one:
// triangles are not opaque to ray queries, and an any-hit shader ignores what is not accepted.

@group(0) @binding(4) var<storage, read> material_of_rank: array<u32>;

struct Query {
    origin: vec3<f32>,
    // The facet that the ray may start on: see `Ray`. A guess.
    start: u32,
    direction: vec3<f32>,
    t_min: f32,
    t_max: f32,
    // The stones the ray is in.
    nest: Nest,
    // Whether only faces in contact with a first one are asked for: parallel to its normal, of other stones
    // than those crossed.
    contact: bool,
    normal: vec3<f32>,
    crossed: Nest,
}

struct Hit {
    t: f32,
    facet: u32,
    // The triangle's number, or the facet's where planes are met.
    primitive: u32,
    found: bool,
}

// The next optical surface on a ray.
struct Crossing {
    found: bool,
    // mm along the ray; never negative.
    distance: f32,
    facet: u32,
    // Unit, on the side the ray comes from.
    normal: vec3<f32>,
    // The stones the ray is in as it arrives, and if it goes through.
    before: Nest,
    after: Nest,
}

// No hit: any hit within the interval precedes it.
fn hit_none(query: Query) -> Hit {
    return Hit(query.t_max, 0u, 0xffffffffu, false);
}

// The order of hits: by parameter, then by primitive, so that the outcome does not depend on the way to it.
fn hit_precedes(t: f32, primitive: u32, best: Hit) -> bool {
    return t < best.t || (t == best.t && primitive < best.primitive);
}

// Whether a ray can cross a facet: it enters stones it is outside of and leaves those it is inside of, and its
// start is no further beyond the plane than rounding puts it.
fn query_accepts(query: Query, facet: u32) -> bool {
    let plane = planes[facet];
    let leaving = inner(plane.normal, query.direction) > 0.0;
    if leaving != nest_contains(query.nest, plane.rank) {
        return false;
    }
    if query.contact {
        return !nest_contains(query.crossed, plane.rank) && abs(inner(plane.normal, query.normal)) > PARALLEL;
    }
    let gap = plane.offset - inner(plane.normal, query.origin);
    // Beside an edge, a ray that runs away from the facet that it starts on is behind the other facet, and meets it no more.
    // Elsewhere than in a close-up this does not show.
    let begin = planes[query.start];
    let away = scene.eye.w > 1.0 && !leaving && begin.rank == plane.rank
        && inner(begin.normal, query.direction) > 0.0;
    return select(-gap, gap, leaving) >= select(-scene.margin, 0.0, away);
}

// The parameter at which a ray meets a facet's exact plane, within the bounds that its triangle sets.
fn plane_parameter(facet: u32, origin: vec3<f32>, direction: vec3<f32>, low: f32, high: f32) -> f32 {
    let plane = planes[facet];
    let towards = inner(plane.normal, direction);
    if abs(towards) < 1e-20 {
        return low;
    }
    return clamp((plane.offset - inner(plane.normal, origin)) / towards, low, high);
}

// Distance to the exact plane; the triangle's own where the ray is too nearly parallel to say.
fn surface_distance(hit: Hit, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let plane = planes[hit.facet];
    let towards = inner(plane.normal, direction);
    let slack = scene.margin / max(abs(towards), GRAZING);
    let gap = plane.offset - inner(plane.normal, origin);
    let exact = select(hit.t, gap / towards, towards != 0.0);
    return max(select(hit.t, exact, abs(exact - hit.t) <= slack), 0.0);
}

// Where a ray that misses a stone it is in is cast from, at its n-th attempt: a few margins to each side.
//
// A ray inside a stone always meets a surface, but one reflected within rounding of an edge can start outside and
// run past the corner. From beside it does meet the face it should leave by.
fn rescue_origin(origin: vec3<f32>, attempt: u32) -> vec3<f32> {
    var aside = vec3(0.0);
    aside[(attempt % 6u) >> 1u] = select(1.0, -1.0, (attempt & 1u) == 1u);
    return origin + aside * (select(RESCUE_NEAR, RESCUE_FAR, attempt >= 6u) * scene.margin);
}

// The nearest surface that a ray can cross, with every face of another stone that lies on it.
//
// One loop does all queries, so that `intersect`, which is long, is in the program once: first for the surface, again from
// beside where the surface must exist but is missed, then for contacts until there are no more.
fn surfaces_nearest(origin: vec3<f32>, direction: vec3<f32>, nest: Nest, start: u32) -> Crossing {
    var query = Query(origin, start, direction, -scene.behind, LARGEST, nest, false, vec3(0.0), Nest(0u));
    var crossing = Crossing(false, 0.0, start, vec3(0.0), nest, nest);
    var crossed = 0u;
    for (var asked = 0u; asked < RESCUES + NEST_CAPACITY; asked++) {
        let hit = intersect(query);
        if hit.found {
            let plane = planes[hit.facet];
            if !crossing.found {
                crossing.found = true;
                crossing.distance = surface_distance(hit, origin, direction);
                crossing.facet = hit.facet;
                crossing.normal = select(plane.normal, -plane.normal, inner(plane.normal, direction) > 0.0);
                let window = scene.contact / max(abs(inner(plane.normal, direction)), GRAZING);
                query.origin = origin;
                query.t_min = crossing.distance - window;
                query.t_max = crossing.distance + window;
                query.contact = true;
                query.normal = plane.normal;
            }
            query.nest = nest_toggled(query.nest, plane.rank);
            query.crossed = nest_toggled(query.crossed, plane.rank);
            crossed++;
            if !CONTACTS || crossed == NEST_CAPACITY {
                break;
            }
        } else if crossing.found || nest_is_empty(nest) || asked >= RESCUES {
            break;
        } else {
            query.origin = rescue_origin(origin, asked);
        }
    }
    crossing.after = query.nest;
    return crossing;
}

// The material that fills the space: its index plus one, or 0 for air.
fn surfaces_optics(nest: Nest) -> u32 {
    if nest_is_empty(nest) {
        return 0u;
    }
    return material_of_rank[nest_top(nest) - 1u] + 1u;
}

// The next optical interface along a ray that may start on a facet.
fn surfaces_next(origin: vec3<f32>, direction: vec3<f32>, begin: Nest, start: u32) -> Crossing {
    var at = origin;
    var travelled = 0.0;
    var nest = begin;
    var facet = start;
    for (var i = 0u; i < MOST_CROSSINGS; i++) {
        var crossing = surfaces_nearest(at, direction, nest, facet);
        if !crossing.found || surfaces_optics(crossing.before) != surfaces_optics(crossing.after) {
            crossing.distance += travelled;
            return crossing;
        }
        travelled += crossing.distance;
        at = origin + direction * travelled;
        nest = crossing.after;
        facet = crossing.facet;
    }
    return Crossing(false, 0.0, facet, vec3(0.0), nest, nest);
}
