// The two directions in which a ray goes on from a surface.
//
// Sums are fused in the order of the CPU backend's `Triple`, so that both round alike: where a ray meets an edge, it is
// rounding that decides.

// The inner product.
fn inner(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return fma(a.z, b.z, fma(a.y, b.y, a.x * b.x));
}

// One Newton step towards length 1: keeps the rounding of a hundred reflections from adding up.
fn renormalized(v: vec3<f32>) -> vec3<f32> {
    return v * fma(-0.5, inner(v, v), 1.5);
}

// Mirrored at a surface of unit normal, either way round.
fn reflected(direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return renormalized(fma(normal, vec3(-2.0 * inner(normal, direction)), direction));
}

// Refracted by Snell's law. The normal points to the side the ray comes from; `eta` is the index on that side
// over the one beyond; the cosines are both positive.
fn refracted(direction: vec3<f32>, normal: vec3<f32>, cos_i: f32, cos_t: f32, eta: f32) -> vec3<f32> {
    return renormalized(fma(normal, vec3(fma(eta, cos_i, -cos_t)), direction * eta));
}
