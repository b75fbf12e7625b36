// The entry points of a ray-tracing pipeline that traces.

@ray_generation
fn trace(@builtin(ray_invocation_id) id: vec3<u32>) {
    trace_item(id.x);
}

// A triangle that the ray meets. One that does not count is passed over: `return` before the end means that, and the
// backend makes it so, since WGSL has no word for it.
@any_hit @incoming_payload(offered)
fn consider(@builtin(primitive_index) primitive: u32, @builtin(ray_t_current_max) distance: f32) {
    let face = faces[primitive];
    let query = offered.query;
    if !query_accepts(query, face.y) {
        return;
    }
    offered.best = candidate_offer(query, face, distance, offered.best);
}

// Nothing to do: the search began with no hit.
@miss @incoming_payload(offered)
fn pass_by() {}
