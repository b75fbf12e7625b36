// Polarised light: the twin of `stokes.rs`. A row (I, Q, U, V) is carried backwards from the eye.

fn row_rotated(row: vec4<f32>, cos2: f32, sin2: f32) -> vec4<f32> {
    return vec4(row.x, row.y * cos2 + row.z * sin2, row.z * cos2 - row.y * sin2, row.w);
}

// Row · matrix of an event with the powers s and p and the product of amplitudes `cross`.
fn row_through(row: vec4<f32>, s: f32, p: f32, cross: vec2<f32>) -> vec4<f32> {
    let mean = (s + p) * 0.5;
    let half = (s - p) * 0.5;
    return vec4(
        row.x * mean + row.y * half,
        row.x * half + row.y * mean,
        row.z * cross.x + row.w * cross.y,
        row.w * cross.x - row.z * cross.y,
    );
}

fn row_reflected(row: vec4<f32>, event: Fresnel) -> vec4<f32> {
    return row_through(row, event.reflectance_s, event.reflectance_p, event.reflected_cross);
}

fn row_refracted(row: vec4<f32>, event: Fresnel) -> vec4<f32> {
    return row_through(row, event.transmittance_s, event.transmittance_p, vec2(event.refracted_cross, 0.0));
}

struct Alignment {
    axis: vec3<f32>,
    cos2: f32,
    sin2: f32,
}

// Turns the frame of a ray that was traced backwards into the plane of incidence.
fn aligned(direction: vec3<f32>, axis: vec3<f32>, normal: vec3<f32>) -> Alignment {
    let s = cross(direction, normal);
    let sin2_incidence = dot(s, s);
    if sin2_incidence <= EPSILON {
        return Alignment(axis, 1.0, 0.0);
    }
    let e_s = s / sqrt(sin2_incidence);
    let c = dot(e_s, axis);
    let d = dot(e_s, cross(axis, direction));
    let norm = c * c + d * d;
    if norm <= EPSILON {
        return Alignment(e_s, 1.0, 0.0);
    }
    let inverse = 1.0 / norm;
    return Alignment(e_s, (c * c - d * d) * inverse, (c + c) * d * inverse);
}

// A unit vector perpendicular to a unit direction (Duff et al. 2017).
fn any_axis(direction: vec3<f32>) -> vec3<f32> {
    let sign = select(1.0, -1.0, direction.z < 0.0);
    let a = -1.0 / (sign + direction.z);
    return vec3(1.0 + sign * direction.x * direction.x * a, sign * direction.x * direction.y * a, -sign * direction.x);
}
