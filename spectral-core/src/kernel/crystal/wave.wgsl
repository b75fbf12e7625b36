// A plane wave at a surface of a crystal: the twin of `crystal/wave.rs`, with the plane of incidence of
// `crystal/boundary.rs`.

// A complex vector.
struct Field {
    re: vec3<f32>,
    im: vec3<f32>,
}

// a × b, without conjugation.
fn field_cross(a: Field, b: Field) -> Field {
    return Field(cross(a.re, b.re) - cross(a.im, b.im), cross(a.re, b.im) + cross(a.im, b.re));
}

// a · b, without conjugation.
fn field_along(a: Field, b: vec3<f32>) -> vec2<f32> {
    return vec2(dot(a.re, b), dot(a.im, b));
}

// The plane of incidence at a surface, and the tangential wave vector, which all waves there share.
struct Incidence {
    // n: unit, along the way of the incident light.
    normal: vec3<f32>,
    // e_s: unit, perpendicular to the plane of incidence.
    s: vec3<f32>,
    // u: unit, in the surface and the plane of incidence; e_s = n × u.
    u: vec3<f32>,
    // The component of N along u, at least 0.
    tangential: f32,
}

fn incidence_of(wave_vector: vec3<f32>, normal: vec3<f32>) -> Incidence {
    let across = cross(normal, wave_vector);
    let size2 = dot(across, across);
    // At normal incidence each plane through the normal is one of incidence.
    var s = any_axis(normal);
    if size2 > 1e-12 {
        s = across / sqrt(size2);
    }
    return incidence_aligned(wave_vector, normal, s);
}

// The same with e_s given: the first axis of a ray's frame in the plane of incidence.
fn incidence_aligned(wave_vector: vec3<f32>, normal: vec3<f32>, axis: vec3<f32>) -> Incidence {
    let s = normalize(axis - normal * dot(axis, normal));
    let u = cross(s, normal);
    let tangential = dot(wave_vector, u);
    let sign = select(1.0, -1.0, tangential < 0.0);
    return Incidence(normal, s * sign, u * sign, abs(tangential));
}

// N² − q² of a medium of index n, as a product: near 0 the difference of rounded squares would have lost digits.
fn incidence_square(at: Incidence, n: f32) -> f32 {
    return (n - at.tangential) * (n + at.tangential);
}

// A wave with its fields along the surface.
struct Wave {
    // N = k/k₀ and E of a wave that propagates.
    normal: vec3<f32>,
    electric: vec3<f32>,
    // (E × H)·n: 0 for an evanescent wave, which carries nothing.
    flux: f32,
    // E_u, E_s, H_u and H_s, complex.
    along: mat4x2<f32>,
}

// (E × H)·n of the real fields E of one wave and H of another.
fn wave_flux(electric: mat4x2<f32>, magnetic: mat4x2<f32>) -> f32 {
    return electric[0].x * magnetic[3].x - electric[1].x * magnetic[2].x;
}

// This wave with `factor` times another's fields added; both propagate.
fn wave_plus(wave: Wave, factor: f32, other: Wave) -> Wave {
    let along = wave.along + other.along * factor;
    return Wave(wave.normal, wave.electric + other.electric * factor, wave_flux(along, along), along);
}

fn wave_propagating(at: Incidence, normal: vec3<f32>, electric: vec3<f32>, magnetic: vec3<f32>) -> Wave {
    let along = mat4x2(
        vec2(dot(electric, at.u), 0.0),
        vec2(dot(electric, at.s), 0.0),
        vec2(dot(magnetic, at.u), 0.0),
        vec2(dot(magnetic, at.s), 0.0),
    );
    return Wave(normal, electric, wave_flux(along, along), along);
}

fn wave_evanescent(at: Incidence, electric: Field, magnetic: Field) -> Wave {
    let along = mat4x2(
        field_along(electric, at.u),
        field_along(electric, at.s),
        field_along(magnetic, at.u),
        field_along(magnetic, at.s),
    );
    return Wave(vec3(0.0), vec3(0.0), 0.0, along);
}

// A wave by its N and E.
fn wave_by_field(at: Incidence, normal: vec3<f32>, electric: vec3<f32>) -> Wave {
    return wave_propagating(at, normal, electric, cross(normal, electric));
}

// The unit vector along which a wave carries its power, that of E × (N × E).
fn wave_ray(normal: vec3<f32>, electric: vec3<f32>) -> vec3<f32> {
    return normalize(normal * dot(electric, electric) - electric * dot(electric, normal));
}
