// Weights between Stokes rows and modes of paths that are followed backwards: the twin of `crystal/weight.rs`.

// The Stokes column of the field (a_s, a_p).
fn stokes_column(a: array<vec2<f32>, 2>) -> vec4<f32> {
    let s = dot(a[0], a[0]);
    let p = dot(a[1], a[1]);
    let cross = complex_product(a[0], vec2(a[1].x, -a[1].y));
    return vec4(s + p, s - p, 2.0 * cross.x, 2.0 * cross.y);
}

// From a row to a mode, with the amplitudes into this mode for incident s and p.
fn weight_into_mode(row: vec4<f32>, amplitudes: array<vec2<f32>, 2>) -> f32 {
    return 0.5 * dot(row, stokes_column(amplitudes));
}

// From a mode to a row, for each unit of the mode's weight, with the amplitudes into s and p.
fn weight_from_mode(amplitudes: array<vec2<f32>, 2>) -> vec4<f32> {
    return stokes_column(amplitudes) * vec4(1.0, 1.0, 1.0, -1.0);
}

// Ωv of the form of a row (I, Q, U, V): Ω = ((I + Q, U + iV), (U − iV, I − Q)).
fn row_form(row: vec4<f32>, v: array<vec2<f32>, 2>) -> array<vec2<f32>, 2> {
    return array(
        v[0] * (row.x + row.y) + complex_product(row.zw, v[1]),
        complex_product(vec2(row.z, -row.w), v[0]) + v[1] * (row.x - row.y),
    );
}

// a†b.
fn pair_product(a: array<vec2<f32>, 2>, b: array<vec2<f32>, 2>) -> vec2<f32> {
    return complex_product(vec2(a[0].x, -a[0].y), b[0]) + complex_product(vec2(a[1].x, -a[1].y), b[1]);
}

// From a row to a row, with what is reflected of incident s and p: J†ΩJ.
fn weight_reflected(row: vec4<f32>, s: array<vec2<f32>, 2>, p: array<vec2<f32>, 2>) -> vec4<f32> {
    let into_s = array(s[0], p[0]);
    let into_p = array(s[1], p[1]);
    let along_s = pair_product(into_s, row_form(row, into_s)).x;
    let along_p = pair_product(into_p, row_form(row, into_p)).x;
    let cross = pair_product(into_s, row_form(row, into_p));
    return vec4(0.5 * (along_s + along_p), 0.5 * (along_s - along_p), cross);
}
