// `intersect` by a ray-tracing pipeline: as by ray queries, but candidates come to an any-hit shader
// (`main_pipeline.wgsl`), which answers through the ray's payload.

// What a ray carries to its candidates, and what they leave.
struct Search {
    query: Query,
    best: Hit,
}

var<ray_payload> search: Search;
var<incoming_ray_payload> offered: Search;

fn intersect(query: Query) -> Hit {
    search = Search(query, hit_none(query));
    let origin = query.origin + query.direction * query.t_min;
    let reach = query.t_max - query.t_min;
    let flags = RAY_FLAG_FORCE_NO_OPAQUE | RAY_FLAG_SKIP_CLOSEST_HIT_SHADER;
    traceRay(hierarchy, RayDesc(flags, 0xffu, 0.0, reach, origin, query.direction), &search);
    return search.best;
}
