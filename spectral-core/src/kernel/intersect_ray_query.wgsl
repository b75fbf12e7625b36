// `intersect` by ray queries: `candidate.wgsl` says how.

fn intersect(query: Query) -> Hit {
    var best = hit_none(query);
    let origin = query.origin + query.direction * query.t_min;
    let reach = query.t_max - query.t_min;
    var search: ray_query;
    rayQueryInitialize(
        &search,
        hierarchy,
        RayDesc(RAY_FLAG_FORCE_NO_OPAQUE, 0xffu, 0.0, reach, origin, query.direction),
    );
    while rayQueryProceed(&search) {
        let candidate = rayQueryGetCandidateIntersection(&search);
        let face = faces[candidate.primitive_index];
        if query_accepts(query, face.y) {
            rayQueryConfirmIntersection(&search);
            best = candidate_offer(query, face, candidate.t, best);
        }
    }
    return best;
}
