// The scene's surfaces: which one a ray crosses next, and between which media.
//
// Here is what all forms of `intersect` share: the question (`Query`), the answer (`Hit`), the rule by which a
// candidate counts (`query_accepts`), and the order among those that count (`hit_precedes`). A form gives
//
//     fn intersect(query: Query) -> Hit
//
// the first hit, in that order, with a parameter in [query.t_min, query.t_max]. Because a hit may lie a little
// behind the start (t_min < 0), a form on hardware moves the origin back along the ray and asks for t from 0; the
// rule judges by the query's own origin, so the rounding of the moved one does no harm. Candidates must reach the
// rule one by one: triangles are not opaque to ray queries, and an any-hit shader ignores what is not accepted.

// A facet plane.
struct Plane {
    // Unit, outward.
    normal: vec3<f32>,
    offset: f32,
    // Of its stone.
    rank: u32,
}

@group(0) @binding(3) var<storage, read> planes: array<Plane>;
@group(0) @binding(4) var<storage, read> material_of_rank: array<u32>;

struct Query {
    origin: vec3<f32>,
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
    // Unit, on the side the ray comes from.
    normal: vec3<f32>,
    // The stones the ray is in as it arrives, and if it goes through.
    before: Nest,
    after: Nest,
}

// What no hit found looks like: any hit within the interval precedes it.
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
    let leaving = dot(plane.normal, query.direction) > 0.0;
    if leaving != nest_contains(query.nest, plane.rank) {
        return false;
    }
    if query.contact {
        return !nest_contains(query.crossed, plane.rank) && abs(dot(plane.normal, query.normal)) > PARALLEL;
    }
    let gap = plane.offset - dot(plane.normal, query.origin);
    return select(-gap, gap, leaving) >= -scene.margin;
}

// The parameter at which a ray meets a facet's exact plane, within the bounds that its triangle sets.
fn plane_parameter(facet: u32, origin: vec3<f32>, direction: vec3<f32>, low: f32, high: f32) -> f32 {
    let plane = planes[facet];
    let towards = dot(plane.normal, direction);
    if abs(towards) < 1e-20 {
        return low;
    }
    return clamp((plane.offset - dot(plane.normal, origin)) / towards, low, high);
}

// The nearest surface that a ray can cross.
//
// A ray inside a stone always meets one, but one reflected within rounding of an edge can start outside and run
// past the corner: then it is cast again from points a few margins to each side.
fn surfaces_cast(origin: vec3<f32>, direction: vec3<f32>, nest: Nest) -> Hit {
    var query = Query(origin, direction, -scene.behind, LARGEST, nest, false, vec3(0.0), Nest(0u));
    var hit = intersect(query);
    if hit.found || nest_is_empty(nest) {
        return hit;
    }
    for (var attempt = 0u; attempt < 12u && !hit.found; attempt++) {
        var aside = vec3(0.0);
        aside[(attempt % 6u) >> 1u] = select(1.0, -1.0, (attempt & 1u) == 1u);
        query.origin = origin + aside * (select(RESCUE_NEAR, RESCUE_FAR, attempt >= 6u) * scene.margin);
        hit = intersect(query);
    }
    return hit;
}

// Distance to the exact plane; the triangle's own where the ray is too nearly parallel to say.
fn surface_distance(hit: Hit, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let plane = planes[hit.facet];
    let towards = dot(plane.normal, direction);
    let slack = scene.margin / max(abs(towards), GRAZING);
    let gap = plane.offset - dot(plane.normal, origin);
    let exact = select(hit.t, gap / towards, towards != 0.0);
    return max(select(hit.t, exact, abs(exact - hit.t) <= slack), 0.0);
}

// The nest after crossing `first` and every face of another stone that lies on it.
fn surfaces_with_contacts(
    origin: vec3<f32>,
    direction: vec3<f32>,
    distance: f32,
    first: u32,
    nest: Nest,
) -> Nest {
    let plane = planes[first];
    var after = nest_toggled(nest, plane.rank);
    if !CONTACTS {
        return after;
    }
    let window = scene.contact / max(abs(dot(plane.normal, direction)), GRAZING);
    let crossed = nest_toggled(Nest(0u), plane.rank);
    var query =
        Query(origin, direction, distance - window, distance + window, after, true, plane.normal, crossed);
    for (var i = 1u; i < NEST_CAPACITY; i++) {
        let hit = intersect(query);
        if !hit.found {
            break;
        }
        let rank = planes[hit.facet].rank;
        query.crossed = nest_toggled(query.crossed, rank);
        query.nest = nest_toggled(query.nest, rank);
    }
    return query.nest;
}

// The nearest surface that the ray can cross, with all that are in contact with it.
fn surfaces_nearest(origin: vec3<f32>, direction: vec3<f32>, nest: Nest) -> Crossing {
    let hit = surfaces_cast(origin, direction, nest);
    if !hit.found {
        return Crossing(false, 0.0, vec3(0.0), nest, nest);
    }
    let distance = surface_distance(hit, origin, direction);
    let after = surfaces_with_contacts(origin, direction, distance, hit.facet, nest);
    let outward = planes[hit.facet].normal;
    let normal = select(outward, -outward, dot(outward, direction) > 0.0);
    return Crossing(true, distance, normal, nest, after);
}

// What tells two media apart: the material's index plus one, or 0 for air.
fn surfaces_optics(nest: Nest) -> u32 {
    if nest_is_empty(nest) {
        return 0u;
    }
    return material_of_rank[nest_top(nest) - 1u] + 1u;
}

// The next optical interface along a ray.
fn surfaces_next(origin: vec3<f32>, direction: vec3<f32>, start: Nest) -> Crossing {
    var at = origin;
    var travelled = 0.0;
    var nest = start;
    for (var i = 0u; i < MOST_CROSSINGS; i++) {
        var crossing = surfaces_nearest(at, direction, nest);
        if !crossing.found || surfaces_optics(crossing.before) != surfaces_optics(crossing.after) {
            crossing.distance += travelled;
            return crossing;
        }
        travelled += crossing.distance;
        at = origin + direction * travelled;
        nest = crossing.after;
    }
    return Crossing(false, 0.0, vec3(0.0), nest, nest);
}
