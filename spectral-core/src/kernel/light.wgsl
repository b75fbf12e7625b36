// The environment: where a direction falls on the image, and its colour there. The twin of `environment.rs`.

@group(0) @binding(1) var environment: texture_2d<f32>;

// atan2(y, x) in turns, in (−1/2, 1/2].
//
// The built-in function may be off by 4096 units in the last place, hence a polynomial of our own: on
// |s| ≤ tan(π/8) its relative error is 6e-10 before rounding (Chebyshev interpolation of atan(s)/(2πs) in s²).
fn turns(y: f32, x: f32) -> f32 {
    let larger = max(abs(x), abs(y));
    let smaller = min(abs(x), abs(y));
    if larger == 0.0 {
        return 0.0;
    }
    let steep = smaller > 0.41421356 * larger;
    let s = select(smaller / larger, (smaller - larger) / (smaller + larger), steep);
    let q = s * s;
    var p = -0.009602202288362165;
    p = p * q + 0.016827156809618694;
    p = p * q - 0.02266363670131922;
    p = p * q + 0.031828141013539896;
    p = p * q - 0.05305160657179266;
    p = p * q + 0.1591549429951449;
    var angle = select(0.0, 0.125, steep) + s * p;
    angle = select(angle, 0.25 - angle, abs(y) > abs(x));
    angle = select(angle, 0.5 - angle, x < 0.0);
    return select(angle, -angle, y < 0.0);
}

fn texel(x: u32, y: u32) -> vec3<f32> {
    return textureLoad(environment, vec2(x, y), 0).rgb;
}

// Between four texels, of which `a` is the first.
fn between(a: vec2<u32>, b: vec2<u32>, share: vec2<f32>) -> vec3<f32> {
    let first = texel(a.x, a.y);
    let left = texel(a.x, b.y);
    let top = first + (texel(b.x, a.y) - first) * share.x;
    let bottom = left + (texel(b.x, b.y) - left) * share.x;
    return top + (bottom - top) * share.y;
}

// The lights at image coordinates `u` (periodic) and `v` (clamped).
fn sky_rgb(u: f32, v: f32) -> vec3<f32> {
    let size = scene.sky;
    let x = (u - floor(u)) * f32(size.x) - 0.5;
    let y = clamp(v * f32(size.y) - 0.5, 0.0, f32(size.y - 1u));
    let x0 = floor(x);
    let y0 = floor(y);
    // x0 runs from −1 to width − 1 (to width where u rounds up to 1).
    let i = u32(i32(x0) + i32(size.x)) % size.x;
    let i1 = select(i + 1u, 0u, i + 1u == size.x);
    let j = u32(y0);
    let j1 = min(j + 1u, size.y - 1u);
    return between(vec2(i, j), vec2(i1, j1), vec2(x - x0, y - y0));
}

// What a ray sees of the ground that goes down: the twin of `environment/ground.rs`.
fn ground_rgb(origin: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let along = (origin.z - scene.ground_height) / max(-direction.z, scene.grazing);
    let place = (origin.xy + direction.xy * along - scene.ground_low) * scene.ground_per_mm;
    let at = clamp(place, vec2(0.0), vec2(scene.ground_last + 1.0));
    let corner = min(floor(at), vec2(scene.ground_last));
    let first = vec2<u32>(corner) + vec2(0u, scene.sky.y);
    return between(first, first + 1u, at - corner);
}

// Linear sRGB seen from a point in a unit direction.
fn light_rgb(origin: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    if scene.image == 0u {
        return scene.light;
    }
    if scene.ground_per_mm > 0.0 && direction.z < 0.0 {
        return ground_rgb(origin, direction) * scene.gain;
    }
    let u = turns(direction.x, direction.y) + scene.turn;
    // acos(z), without its loss of digits near the poles.
    let v = 2.0 * turns(length(direction.xy), direction.z);
    return sky_rgb(u, v) * scene.gain;
}
