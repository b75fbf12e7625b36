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

// The value at image coordinates `u` (periodic) and `v` (clamped).
fn bilinear(u: f32, v: f32) -> vec3<f32> {
    let size = textureDimensions(environment);
    let x = (u - floor(u)) * f32(size.x) - 0.5;
    let y = clamp(v * f32(size.y) - 0.5, 0.0, f32(size.y - 1u));
    let x0 = floor(x);
    let y0 = floor(y);
    let fx = x - x0;
    let fy = y - y0;
    // x0 runs from −1 to width − 1 (to width where u rounds up to 1).
    let i = u32(i32(x0) + i32(size.x)) % size.x;
    let i1 = select(i + 1u, 0u, i + 1u == size.x);
    let j = u32(y0);
    let j1 = min(j + 1u, size.y - 1u);
    let a = texel(i, j);
    let b = texel(i1, j);
    let c = texel(i, j1);
    let d = texel(i1, j1);
    let top = a + (b - a) * fx;
    let bottom = c + (d - c) * fx;
    return top + (bottom - top) * fy;
}

// Linear sRGB from a unit direction.
fn light_rgb(direction: vec3<f32>) -> vec3<f32> {
    if scene.image == 0u {
        return scene.light;
    }
    let u = turns(direction.x, direction.y) + scene.turn;
    // acos(z), without its loss of digits near the poles.
    let v = 2.0 * turns(length(direction.xy), direction.z);
    return bilinear(u, v) * scene.gain;
}
