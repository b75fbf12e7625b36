// Fresnel's equations: the twin of `fresnel.rs`, which has the formulas, frames and sources.

struct Fresnel {
    reflectance_s: f32,
    reflectance_p: f32,
    transmittance_s: f32,
    transmittance_p: f32,
    // r_s · conj(r_p), real and imaginary part.
    reflected_cross: vec2<f32>,
    refracted_cross: f32,
    // 0 under total internal reflection and for a conductor.
    cos_t: f32,
    tir: bool,
}

// sin²θ₁ and cos²θ₂, the latter negative under total internal reflection.
struct Squares {
    sin2_i: f32,
    cos2_t: f32,
}

// The leading 12 bits of a number: products of two heads are exact in single precision.
fn head(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) & 0xfffff000u);
}

// The number without its last bit. Shader compilers may reassociate sums and contract products, but not across this, so
// what it guards is computed as written.
fn guarded(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) & 0xfffffffeu);
}

// 1 − η²(1 − c²) in pairs of singles.
//
// The Rust twin takes this difference in double precision: near the critical angle an error of 1e-7 in it
// becomes 3e-4 in cos θ₂. WGSL has no portable doubles, so η² and 1 − c² are each split into a head of 12 bits
// and a rest (Dekker 1971). The product of the heads and its distance from 1 are exact where the two are close,
// and the rests are 2⁻¹² smaller, so the whole is good to about 2⁻³³: less than the step between two neighbouring values of
// the cosine that goes in makes.
fn squares(c: f32, eta: f32) -> Squares {
    let c_head = head(c);
    let c_rest = c - c_head;
    let sin2_head = head(1.0 - c * c);
    let sin2_rest = guarded(guarded(1.0 - sin2_head) - c_head * c_head)
        - guarded(2.0 * c_head * c_rest + c_rest * c_rest);
    let eta_head = head(eta);
    let eta_rest = eta - eta_head;
    let eta2_head = head(eta * eta);
    let eta2_rest = guarded(eta_head * eta_head - eta2_head)
        + guarded(2.0 * eta_head * eta_rest + eta_rest * eta_rest);
    let sin2 = sin2_head + sin2_rest;
    let cos2_t = guarded(1.0 - eta2_head * sin2_head) - guarded(eta2_head * sin2_rest + eta2_rest * sin2);
    return Squares(sin2, cos2_t);
}

fn dielectric(cos_i: f32, eta: f32) -> Fresnel {
    let c = clamp(cos_i, 0.0, 1.0);
    if eta == 1.0 {
        return Fresnel(0.0, 0.0, 1.0, 1.0, vec2(0.0), 1.0, c, false);
    }
    let s = squares(c, eta);
    if s.cos2_t <= 0.0 {
        return total(c, eta, s);
    }
    let cos_t = sqrt(s.cos2_t);
    let s_sum = eta * c + cos_t;
    let p_sum = c + eta * cos_t;
    // One division serves both; with η ≠ 1 the two cosines are never both zero.
    let inverse = 1.0 / (s_sum * p_sum);
    let r_s = (eta * c - cos_t) * (inverse * p_sum);
    let r_p = (c - eta * cos_t) * (inverse * s_sum);
    let reflectance_s = min(r_s * r_s, 1.0);
    let reflectance_p = min(r_p * r_p, 1.0);
    let transmittance_s = 1.0 - reflectance_s;
    let transmittance_p = 1.0 - reflectance_p;
    let refracted_cross = sqrt(transmittance_s * transmittance_p);
    let reflected_cross = vec2(r_s * r_p, 0.0);
    return Fresnel(
        reflectance_s,
        reflectance_p,
        transmittance_s,
        transmittance_p,
        reflected_cross,
        refracted_cross,
        cos_t,
        false,
    );
}

// Total internal reflection: both amplitudes are phases, tan(δ/2) = κ cos θ/(η sin²θ).
fn total(c: f32, eta: f32, s: Squares) -> Fresnel {
    let a = eta * s.sin2_i;
    let b = sqrt(-s.cos2_t) * c;
    let inverse = 1.0 / (a * a + b * b);
    let reflected_cross = vec2((a * a - b * b) * inverse, 2.0 * a * b * inverse);
    return Fresnel(1.0, 1.0, 0.0, 0.0, reflected_cross, 0.0, 0.0, true);
}

fn complex_product(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

// 0 where both parts vanish: no surface, no reflection.
fn complex_quotient(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    let norm2 = dot(b, b);
    if norm2 == 0.0 {
        return vec2(0.0);
    }
    return complex_product(a, vec2(b.x, -b.y)) / norm2;
}

// The principal root of a number with a non-negative imaginary part: both parts of it are non-negative, and
// the smaller one is taken from the larger, so that nothing cancels.
fn complex_root(z: vec2<f32>) -> vec2<f32> {
    let larger = sqrt(0.5 * (length(z) + abs(z.x)));
    if larger == 0.0 {
        return vec2(0.0);
    }
    let smaller = 0.5 * z.y / larger;
    return select(vec2(smaller, larger), vec2(larger, smaller), z.x >= 0.0);
}

fn conductor(cos_i: f32, n1: f32, n: f32, k: f32) -> Fresnel {
    let c = clamp(cos_i, 0.0, 1.0);
    let index2 = vec2((n - k) * (n + k), 2.0 * n * k);
    // n₂² − n₁² sin²θ, arranged so that nothing cancels where the indices are close.
    let real = (n - n1) * (n + n1) + (n1 * c) * (n1 * c) - k * k;
    let w = complex_root(vec2(real, index2.y));
    let incident = vec2(n1 * c, 0.0);
    let r_s = complex_quotient(incident - w, incident + w);
    let r_p = complex_quotient(index2 * c - w * n1, index2 * c + w * n1);
    let reflected_cross = complex_product(r_s, vec2(r_p.x, -r_p.y));
    let reflectance_s = min(dot(r_s, r_s), 1.0);
    let reflectance_p = min(dot(r_p, r_p), 1.0);
    return Fresnel(reflectance_s, reflectance_p, 0.0, 0.0, reflected_cross, 0.0, 0.0, false);
}
