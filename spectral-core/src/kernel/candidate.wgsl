// A device's own hierarchy finds candidates, the rule of `surface.wgsl` judges them: what ray queries and ray-tracing
// pipelines share.
//
// No triangle is opaque, so each candidate comes to us. One that counts is confirmed, which ends the search beyond
// it; of those that were, the first in our own order is kept, since the device's distances are rounded in a way of
// its own. Devices search from 0 on, so the origin is moved to where the interval begins, which for a hit behind
// the start is back along the ray.

@group(0) @binding(5) var hierarchy: acceleration_structure;
// By the device's number of the triangle: its number in the input, its facet.
@group(0) @binding(6) var<storage, read> faces: array<vec2<u32>>;

// The candidate in place of `best` if it precedes it. Its parameter is that of the facet's plane, as near the
// device's as rounding lets the two be.
fn candidate_offer(query: Query, face: vec2<u32>, distance: f32, best: Hit) -> Hit {
    let t = query.t_min + distance;
    let slack = scene.margin / max(abs(dot(planes[face.y].normal, query.direction)), GRAZING);
    let exact = plane_parameter(face.y, query.origin, query.direction, t - slack, t + slack);
    if hit_precedes(exact, face.x, best) {
        return Hit(exact, face.y, face.x, true);
    }
    return best;
}
