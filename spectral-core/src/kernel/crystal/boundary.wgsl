// What a plane surface of a crystal does to a wave: the twin of `crystal/boundary.rs`, which has the equations.

// Amplitudes of what an incident wave sends on, back and through; |amplitude|² is a power, in the unit of the incident
// wave's flux. Of an isotropic side they are s and p.
struct Scattered {
    back: array<vec2<f32>, 2>,
    on: array<vec2<f32>, 2>,
}

fn scattered_power(out: Scattered) -> f32 {
    return dot(out.back[0], out.back[0]) + dot(out.back[1], out.back[1]) + dot(out.on[0], out.on[0]) + dot(out.on[1], out.on[1]);
}

fn fields_scaled(fields: mat4x2<f32>, factor: vec2<f32>) -> mat4x2<f32> {
    return mat4x2(
        complex_product(factor, fields[0]),
        complex_product(factor, fields[1]),
        complex_product(factor, fields[2]),
        complex_product(factor, fields[3]),
    );
}

// α = H_u + σzE_s and β = zH_s − σn²E_u: both 0 for light that goes on (σ = 1) or comes (σ = −1) on an isotropic side.
fn boundary_row(fields: mat4x2<f32>, z: vec2<f32>, permittivity: vec2<f32>, side: f32) -> mat2x2<f32> {
    return mat2x2(
        fields[2] + complex_product(z, fields[1]) * side,
        complex_product(z, fields[3]) - complex_product(permittivity, fields[0]) * side,
    );
}

// x and y of x·one + y·two = right.
fn boundary_solve(one: mat2x2<f32>, two: mat2x2<f32>, right: mat2x2<f32>) -> mat2x2<f32> {
    let determinant = complex_product(one[0], two[1]) - complex_product(two[0], one[1]);
    return mat2x2(
        complex_quotient(complex_product(right[0], two[1]) - complex_product(two[0], right[1]), determinant),
        complex_quotient(complex_product(one[0], right[1]) - complex_product(right[0], one[1]), determinant),
    );
}

// From a crystal into an isotropic medium or onto a metal, of index n + ik.
fn boundary_leave(at: Incidence, incident: Wave, back: array<Wave, 2>, n: f32, k: f32) -> Scattered {
    let permittivity = vec2((n - k) * (n + k), 2.0 * n * k);
    let z = complex_root(vec2(incidence_square(at, n) - k * k, permittivity.y));
    let r = boundary_solve(
        boundary_row(back[0].along, z, permittivity, 1.0),
        boundary_row(back[1].along, z, permittivity, 1.0),
        boundary_row(incident.along, z, permittivity, 1.0) * -1.0,
    );
    let sum = incident.along + fields_scaled(back[0].along, r[0]) + fields_scaled(back[1].along, r[1]);
    var out = Scattered();
    out.back = array(r[0] * sqrt(abs(back[0].flux)), r[1] * sqrt(abs(back[1].flux)));
    if k == 0.0 {
        // √(z n²)/n² = √z/n.
        out.on = array(sum[1] * sqrt(z.x), sum[3] * (sqrt(z.x) / n));
    }
    return out;
}

// From a transparent isotropic medium of index n, with N·n = z, into a crystal: for incident s and p.
fn boundary_enter(at: Incidence, n: f32, z: f32, on: array<Wave, 2>) -> array<Scattered, 2> {
    let permittivity = n * n;
    let one = boundary_row(on[0].along, vec2(z, 0.0), vec2(permittivity, 0.0), -1.0);
    let two = boundary_row(on[1].along, vec2(z, 0.0), vec2(permittivity, 0.0), -1.0);
    var out = array<Scattered, 2>();
    for (var m = 0u; m < 2u; m++) {
        var right = mat2x2<f32>(-2.0 * z, 0.0, 0.0, 0.0);
        var root = sqrt(z);
        if m == 1u {
            right = mat2x2<f32>(0.0, 0.0, 2.0 * z * permittivity, 0.0);
            root = n * root;
        }
        let t = boundary_solve(one, two, right);
        let sum = fields_scaled(on[0].along, t[0]) + fields_scaled(on[1].along, t[1]);
        // Amplitudes of s and p have the flux z and z n².
        out[m].back = array(sum[1], sum[3] / n);
        out[m].back[m] -= vec2(select(1.0, n, m == 1u), 0.0);
        let unit = select(1.0, 1.0 / n, m == 1u);
        out[m].back[0] *= unit;
        out[m].back[1] *= unit;
        out[m].on = array(t[0] * (sqrt(abs(on[0].flux)) / root), t[1] * (sqrt(abs(on[1].flux)) / root));
    }
    return out;
}

// From a crystal into another one in contact with it: four equations for E_u, E_s, H_u and H_s, by Gauss's elimination
// with pivots.
fn boundary_between(incident: Wave, back: array<Wave, 2>, on: array<Wave, 2>) -> Scattered {
    var columns = array(back[0].along, back[1].along, on[0].along * -1.0, on[1].along * -1.0, incident.along * -1.0);
    var rows: array<array<vec2<f32>, 5>, 4>;
    for (var k = 0u; k < 4u; k++) {
        for (var j = 0u; j < 5u; j++) {
            rows[k][j] = columns[j][k];
        }
    }
    for (var k = 0u; k < 4u; k++) {
        var pivot = k;
        for (var i = k + 1u; i < 4u; i++) {
            if dot(rows[i][k], rows[i][k]) > dot(rows[pivot][k], rows[pivot][k]) {
                pivot = i;
            }
        }
        let swapped = rows[k];
        rows[k] = rows[pivot];
        rows[pivot] = swapped;
        let head = rows[k][k];
        for (var j = 0u; j < 5u; j++) {
            rows[k][j] = complex_quotient(rows[k][j], head);
        }
        for (var i = 0u; i < 4u; i++) {
            if i != k {
                let factor = rows[i][k];
                for (var j = 0u; j < 5u; j++) {
                    rows[i][j] -= complex_product(factor, rows[k][j]);
                }
            }
        }
    }
    let back_power = array(rows[0][4] * sqrt(abs(back[0].flux)), rows[1][4] * sqrt(abs(back[1].flux)));
    return Scattered(back_power, array(rows[2][4] * sqrt(abs(on[0].flux)), rows[3][4] * sqrt(abs(on[1].flux))));
}
