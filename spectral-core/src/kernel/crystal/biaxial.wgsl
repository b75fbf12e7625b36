// Waves in a biaxial crystal: the twin of `crystal/biaxial.rs`. Of the axes x has the smallest index and z the largest.
//
// Where a sheet of the index surface is not met, Booker's quartic serves. In single precision its coefficients would lose
// what little tells the sheets apart. So it is written in the differences from ε_y: with F = N² − ε_y and δ_k = ε_k − ε_y
//
//     ε_y F² + F(Σδ_k N_k² − ε_y(δ_x + δ_z) − δ_x δ_z) + δ_x δ_z N_y² = 0

// The sheets: that of the smaller index and that of the larger.
const FAST: f32 = 1.0;
const SLOW: f32 = -1.0;
// More steps than Newton's method has been seen to take; what takes more is left to the quartic.
const NEWTON_STEPS: u32 = 12u;
const ABERTH_STEPS: u32 = 40u;

// G − 1 and dG/dζ on a sheet at N.
fn sheet_at(crystal: Crystal, sheet: f32, normal: vec3<f32>, n: vec3<f32>) -> vec2<f32> {
    let along = vec2(dot(crystal.first, normal), dot(crystal.second, normal));
    let slope = vec2(dot(crystal.first, n), dot(crystal.second, n));
    let first = cross(crystal.first, normal);
    let second = cross(crystal.second, normal);
    let across = vec2(length(first), length(second));
    // On the axis itself the surface has a corner, and any slope of its cone serves.
    let widening = vec2(dot(first, cross(crystal.first, n)), dot(second, cross(crystal.second, n)));
    let widens = widening / max(across, vec2(1e-12));
    let value = crystal.mean * dot(normal, normal)
        + crystal.half * (along.x * along.y + sheet * across.x * across.y);
    let growth = slope.x * along.y + along.x * slope.y + sheet * (widens.x * across.y + across.x * widens.y);
    return vec2(value - 1.0, 2.0 * crystal.mean * dot(normal, n) + crystal.half * growth);
}

// A point where a line N = q + ζn meets a sheet.
struct Meeting {
    zeta: f32,
    // dG/dζ: its sign is that of the energy.
    slope: f32,
    found: bool,
}

fn sheet_meet(crystal: Crystal, sheet: f32, at: Incidence, start: f32) -> Meeting {
    var zeta = start;
    var value = vec2(1.0);
    for (var i = 0u; i < NEWTON_STEPS && abs(value.x) > 1e-7; i++) {
        value = sheet_at(crystal, sheet, at.u * at.tangential + at.normal * zeta, at.normal);
        let step = value.x / value.y;
        zeta -= step;
        if abs(step) <= 1e-6 {
            break;
        }
    }
    // Where the line grazes the sheet, G is exact to rounding before ζ settles.
    return Meeting(zeta, value.y, abs(value.x) <= 2e-6);
}

// The wave of a sheet: D ∥ u₁ ± u₂ with u = a × N/|a × N|, E = ε⁻¹D, H = N × E.
fn sheet_wave(crystal: Crystal, sheet: f32, at: Incidence, zeta: f32) -> Wave {
    let normal = at.u * at.tangential + at.normal * zeta;
    let first = sheet_across(crystal.first, normal);
    let second = sheet_across(crystal.second, normal) * sheet;
    let same = first + second;
    let other = first - second;
    // The two are perpendicular; the shorter one has lost digits, or vanished.
    var displacement = same;
    if dot(same, same) < dot(other, other) {
        displacement = cross(normal, other);
    }
    displacement = normalize(displacement - normal * (dot(displacement, normal) / dot(normal, normal)));
    let along = vec3(dot(displacement, crystal.x), dot(displacement, crystal.y), dot(displacement, crystal.z));
    let share = along / (crystal.index * crystal.index);
    return wave_by_field(at, normal, crystal.x * share.x + crystal.y * share.y + crystal.z * share.z);
}

fn sheet_across(axis: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let across = cross(axis, normal);
    let size = length(across);
    if size > 1e-6 {
        return across / size;
    }
    return any_axis(axis);
}

// Both waves with energy on the side σ, the faster first, except where one of them is evanescent.
fn biaxial_waves(crystal: Crystal, at: Incidence, side: f32) -> array<Wave, 2> {
    let square = incidence_square(at, sqrt(crystal.middle));
    if square > 0.0 {
        let start = sqrt(square) * side;
        let fast = sheet_meet(crystal, FAST, at, start);
        let slow = sheet_meet(crystal, SLOW, at, start);
        if fast.found && slow.found && fast.slope * side > 0.0 && slow.slope * side > 0.0 {
            let waves = share_power(
                sheet_wave(crystal, FAST, at, fast.zeta),
                sheet_wave(crystal, SLOW, at, slow.zeta),
            );
            // On an axis whose cone the surface cuts, the two are a wave and its reflection.
            if waves[0].flux * side > 0.0 && waves[1].flux * side > 0.0 {
                return waves;
            }
        }
    }
    return biaxial_by_roots(crystal, at, side);
}

// Two waves of one surface whose powers add up: exact solutions have this, rounded ones near an axis do not.
fn share_power(first: Wave, second: Wave) -> array<Wave, 2> {
    let mixed = 0.5 * (wave_flux(first.along, second.along) + wave_flux(second.along, first.along));
    if abs(first.flux) >= abs(second.flux) {
        return array(first, wave_plus(second, -mixed / first.flux, first));
    }
    return array(wave_plus(first, -mixed / second.flux, second), second);
}

// The coefficients of the quartic.
fn biaxial_quartic(crystal: Crystal, at: Incidence) -> array<f32, 5> {
    let q = at.u * at.tangential;
    let q_by = vec3(dot(q, crystal.x), dot(q, crystal.y), dot(q, crystal.z));
    let n_by = vec3(dot(at.normal, crystal.x), dot(at.normal, crystal.y), dot(at.normal, crystal.z));
    let delta = vec3(crystal.lower, 0.0, crystal.difference);
    let both = crystal.lower * crystal.difference;
    let m = crystal.middle;
    let f = -incidence_square(at, sqrt(m));
    let linear = dot(delta, q_by * q_by) - m * (crystal.lower + crystal.difference) - both;
    let d1 = 2.0 * dot(delta, q_by * n_by);
    let d2 = dot(delta, n_by * n_by);
    return array(
        f * (m * f + linear) + both * q_by.y * q_by.y,
        f * d1 + 2.0 * both * q_by.y * n_by.y,
        2.0 * m * f + linear + f * d2 + both * n_by.y * n_by.y,
        d1,
        m + d2,
    );
}

// The roots of a quartic by Aberth's method: the twin of `crystal/polynomial.rs`.
fn quartic_roots(coefficients: array<f32, 5>) -> array<vec2<f32>, 4> {
    var c = coefficients;
    var bound = 0.0;
    for (var k = 0u; k < 4u; k++) {
        bound = max(bound, abs(c[k] / c[4]));
    }
    let radius = min(sqrt(bound), 1.0 + bound);
    var roots: array<vec2<f32>, 4>;
    for (var k = 0u; k < 4u; k++) {
        let angle = 0.4 + 1.5707964 * f32(k);
        roots[k] = vec2(-0.25 * c[3] / c[4], 0.0) + vec2(cos(angle), sin(angle)) * radius;
    }
    for (var step = 0u; step < ABERTH_STEPS; step++) {
        var largest = 0.0;
        for (var i = 0u; i < 4u; i++) {
            let z = roots[i];
            var value = vec2(c[4], 0.0);
            var slope = vec2(0.0);
            for (var k = 4u; k > 0u; k--) {
                slope = complex_product(slope, z) + value;
                value = complex_product(value, z) + vec2(c[k - 1u], 0.0);
            }
            var others = vec2(0.0);
            for (var k = 0u; k < 4u; k++) {
                others += complex_quotient(vec2(1.0, 0.0), z - roots[k]);
            }
            let change = complex_quotient(value, slope - complex_product(value, others));
            roots[i] = z - change;
            largest = max(largest, length(change));
        }
        if largest <= 2e-7 {
            break;
        }
    }
    return roots;
}

// The two waves on the side σ by the quartic: those of the roots whose energy, or where they are evanescent whose decay, is
// on that side.
fn biaxial_by_roots(crystal: Crystal, at: Incidence, side: f32) -> array<Wave, 2> {
    var roots = quartic_roots(biaxial_quartic(crystal, at));
    var waves: array<Wave, 2>;
    var towards = vec2(-LARGEST);
    for (var i = 0u; i < 4u; i++) {
        let wave = biaxial_by_root(crystal, at, roots[i]);
        let side_of_it = side * select(roots[i].y, wave.flux, wave.flux != 0.0);
        if side_of_it > towards.x {
            waves[1] = waves[0];
            towards.y = towards.x;
            waves[0] = wave;
            towards.x = side_of_it;
        } else if side_of_it > towards.y {
            waves[1] = wave;
            towards.y = side_of_it;
        }
    }
    if waves[0].flux != 0.0 && waves[1].flux != 0.0 {
        return share_power(waves[0], waves[1]);
    }
    return waves;
}

// The wave of a root. A real root is that of a sheet; a double one comes out as a pair that rounding has moved off the real
// axis.
fn biaxial_by_root(crystal: Crystal, at: Incidence, root: vec2<f32>) -> Wave {
    if abs(root.y) < 1e-2 {
        let normal = at.u * at.tangential + at.normal * root.x;
        let fast = abs(sheet_at(crystal, FAST, normal, at.normal).x);
        let slow = abs(sheet_at(crystal, SLOW, normal, at.normal).x);
        var sheet = select(SLOW, FAST, fast < slow);
        for (var i = 0u; i < 2u; i++) {
            let met = sheet_meet(crystal, sheet, at, root.x);
            if met.found && abs(met.zeta - root.x) < 3e-2 {
                return sheet_wave(crystal, sheet, at, met.zeta);
            }
            sheet = -sheet;
        }
    }
    return biaxial_evanescent(crystal, at, root);
}

// An evanescent wave: E is in the null space of δ − F + NNᵀ, which its adjugate's longest column spans.
fn biaxial_evanescent(crystal: Crystal, at: Incidence, zeta: vec2<f32>) -> Wave {
    let normal = Field(at.u * at.tangential + at.normal * zeta.x, at.normal * zeta.y);
    let f = complex_product(zeta, zeta) - vec2(incidence_square(at, sqrt(crystal.middle)), 0.0);
    let along = array(field_along(normal, crystal.x), field_along(normal, crystal.y), field_along(normal, crystal.z));
    var n = along;
    var a = array(vec2(crystal.lower, 0.0) - f, -f, vec2(crystal.difference, 0.0) - f);
    var longest = array<vec2<f32>, 3>();
    var size2 = 0.0;
    for (var i = 0u; i < 3u; i++) {
        let j = (i + 1u) % 3u;
        let k = (i + 2u) % 3u;
        var column: array<vec2<f32>, 3>;
        column[i] = complex_product(a[j], a[k] + complex_product(n[k], n[k]))
            + complex_product(complex_product(n[j], n[j]), a[k]);
        column[j] = -complex_product(complex_product(n[i], n[j]), a[k]);
        column[k] = -complex_product(complex_product(n[i], n[k]), a[j]);
        let own = dot(column[0], column[0]) + dot(column[1], column[1]) + dot(column[2], column[2]);
        if own > size2 {
            size2 = own;
            longest = column;
        }
    }
    let scale = inverseSqrt(max(size2, 1e-30));
    let re = vec3(longest[0].x, longest[1].x, longest[2].x) * scale;
    let im = vec3(longest[0].y, longest[1].y, longest[2].y) * scale;
    let electric = Field(
        crystal.x * re.x + crystal.y * re.y + crystal.z * re.z,
        crystal.x * im.x + crystal.y * im.y + crystal.z * im.z,
    );
    return wave_evanescent(at, electric, field_cross(normal, electric));
}
