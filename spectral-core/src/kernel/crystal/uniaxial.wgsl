// Waves in a uniaxial crystal in closed form: the twin of `crystal/uniaxial.rs`, which has the equations and sources.

// ε⁻¹v.
fn uniaxial_impermittivity(crystal: Crystal, v: vec3<f32>) -> vec3<f32> {
    let e = crystal.middle + crystal.difference;
    let share = dot(v, crystal.first) * (crystal.difference / (crystal.middle * e));
    return v / crystal.middle - crystal.first * share;
}

// The ordinary and the extraordinary wave with energy on the side σ.
fn uniaxial_waves(crystal: Crystal, at: Incidence, side: f32) -> array<Wave, 2> {
    let ordinary = crystal.middle;
    let difference = crystal.difference;
    let q2 = at.tangential * at.tangential;
    let cn = dot(crystal.first, at.normal);
    let cq = dot(crystal.first, at.u) * at.tangential;
    let a = ordinary + difference * cn * cn;
    let b = difference * cn * cq;
    let cos2_o = incidence_square(at, sqrt(ordinary));
    let disc = ordinary * ((ordinary + difference) * a - ordinary * q2 - difference * (cq * cq + cn * cn * q2));
    let root_e = sqrt(abs(disc)) * side;
    let zeta_o = sqrt(abs(cos2_o)) * side;
    let q = at.u * at.tangential;
    if cos2_o > 0.0 && disc > 0.0 {
        let normal_o = q + at.normal * zeta_o;
        return uniaxial_propagating(crystal, at, normal_o, uniaxial_apart(crystal, normal_o, a * zeta_o + b, root_e, a, side));
    }
    var normal_o = Field(q + at.normal * zeta_o, vec3(0.0));
    if cos2_o <= 0.0 {
        normal_o = Field(q, at.normal * zeta_o);
    }
    var normal_e = Field(q + at.normal * ((root_e - b) / a), vec3(0.0));
    if disc <= 0.0 {
        normal_e = Field(q - at.normal * (b / a), at.normal * (root_e / a));
    }
    return array(
        uniaxial_ordinary(crystal, at, normal_o, cos2_o > 0.0),
        uniaxial_extraordinary(crystal, at, normal_e, disc > 0.0),
    );
}

// ζ_e − ζ_o, exact where both waves nearly coincide.
fn uniaxial_apart(crystal: Crystal, normal_o: vec3<f32>, at_ordinary: f32, root: f32, a: f32, side: f32) -> f32 {
    let w = cross(crystal.first, normal_o);
    if at_ordinary * side > 0.0 {
        return crystal.difference * dot(w, w) / (at_ordinary + root);
    }
    return (root - at_ordinary) / a;
}

// Both waves of one w: near the axis c × N is rounding error alone, and two of them would not share power exactly.
fn uniaxial_propagating(crystal: Crystal, at: Incidence, normal_o: vec3<f32>, apart: f32) -> array<Wave, 2> {
    let normal_e = normal_o + at.normal * apart;
    var w = cross(crystal.first, normal_o);
    let size = length(w);
    var step = 0.0;
    if size > 1e-6 {
        w /= size;
        step = apart / size;
    } else {
        w = any_axis(crystal.first);
    }
    w = normalize(w - normal_o * (dot(w, normal_o) / crystal.middle));
    let w_e = w + cross(crystal.first, at.normal) * step;
    let electric = uniaxial_impermittivity(crystal, cross(normal_e, w_e));
    return array(wave_by_field(at, normal_o, w), wave_propagating(at, normal_e, electric, -w_e));
}

// w/|w|, or any vector across the axis where there is no w.
fn uniaxial_across(crystal: Crystal, normal: Field) -> Field {
    let w = Field(cross(crystal.first, normal.re), cross(crystal.first, normal.im));
    let size = sqrt(dot(w.re, w.re) + dot(w.im, w.im));
    if size > 1e-6 {
        return Field(w.re / size, w.im / size);
    }
    return Field(any_axis(crystal.first), vec3(0.0));
}

// The ordinary wave by itself.
fn uniaxial_ordinary(crystal: Crystal, at: Incidence, normal: Field, propagates: bool) -> Wave {
    let w = uniaxial_across(crystal, normal);
    if propagates {
        return wave_by_field(at, normal.re, w.re);
    }
    return wave_evanescent(at, w, field_cross(normal, w));
}

// The extraordinary wave by itself.
fn uniaxial_extraordinary(crystal: Crystal, at: Incidence, normal: Field, propagates: bool) -> Wave {
    let w = uniaxial_across(crystal, normal);
    let d = field_cross(normal, w);
    let electric = Field(uniaxial_impermittivity(crystal, d.re), uniaxial_impermittivity(crystal, d.im));
    if propagates {
        return wave_propagating(at, normal.re, electric.re, -w.re);
    }
    return wave_evanescent(at, electric, Field(-w.re, -w.im));
}
