// The two directions in which a ray goes on from a surface.
//
// Computed in the order of the CPU backend's `Triple`, which fuses nothing here, so that both round alike: at the edge of
// a facet rounding decides which way a ray goes.

// The inner product.
fn inner(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// One Newton step towards length 1: keeps the rounding of a hundred reflections from adding up.
fn renormalized(v: vec3<f32>) -> vec3<f32> {
    return v * (1.5 - 0.5 * inner(v, v));
}

// Mirrored at a surface of unit normal, either way round.
fn reflected(direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return renormalized(direction - normal * (2.0 * inner(normal, direction)));
}

// Refracted by Snell's law. The normal points to the side the ray comes from; `eta` is the index on that side
// over the one beyond; the cosines are both positive.
fn refracted(direction: vec3<f32>, normal: vec3<f32>, cos_i: f32, cos_t: f32, eta: f32) -> vec3<f32> {
    return renormalized(direction * eta + normal * (eta * cos_i - cos_t));
}
