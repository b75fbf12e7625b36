// Light at one wavelength for a linear sRGB colour: the twin of `upsample/smits.rs`.

// Radiance of Smits's bases, light and scale included.
struct Basis {
    // White, cyan, magenta and yellow.
    mixed: vec4<f32>,
    // Red, green and blue.
    pure: vec3<f32>,
}

// The basis at a place in `optics`.
fn basis_at(first: u32) -> Basis {
    return Basis(optics[first], optics[first + 1u].xyz);
}

fn basis_mix(basis: Basis, least: f32, mid: f32, most: f32, secondary: f32, primary: f32) -> f32 {
    return least * basis.mixed.x + (mid - least) * secondary + (most - mid) * primary;
}

// Smits's expansion of a non-negative linear sRGB colour.
fn basis_expand(basis: Basis, rgb: vec3<f32>) -> f32 {
    let r = rgb.x;
    let g = rgb.y;
    let b = rgb.z;
    let cyan = basis.mixed.y;
    let magenta = basis.mixed.z;
    let yellow = basis.mixed.w;
    if r <= g && r <= b {
        if g <= b {
            return basis_mix(basis, r, g, b, cyan, basis.pure.z);
        }
        return basis_mix(basis, r, b, g, cyan, basis.pure.y);
    }
    if g <= b {
        if r <= b {
            return basis_mix(basis, g, r, b, magenta, basis.pure.z);
        }
        return basis_mix(basis, g, b, r, magenta, basis.pure.x);
    }
    if r <= g {
        return basis_mix(basis, b, r, g, yellow, basis.pure.y);
    }
    return basis_mix(basis, b, g, r, yellow, basis.pure.x);
}
