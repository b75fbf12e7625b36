// The optics of a material at one wavelength: the twin of `prepare/medium.rs`. From there are generated the structure
// `Medium`, the constant `AIR` and `medium_at`, which reads a medium from `optics`.

fn line_medium(line: Line, material: u32) -> Medium {
    return medium_at(line.first + BASIS_VECTORS + 1u + material * MEDIUM_VECTORS);
}

// Whether light ends at its surface or is reflected there: it is a metal.
fn medium_is_opaque(medium: Medium) -> bool {
    return medium.k > 0.0;
}

// The share of light that is left after a distance in mm.
fn medium_transmittance(medium: Medium, distance: f32) -> f32 {
    if medium.absorption > 0.0 {
        return exp(-medium.absorption * distance);
    }
    return 1.0;
}

// What the surface between two media does to light that arrives `here`.
fn medium_interface(here: Medium, beyond: Medium, cos_i: f32) -> Fresnel {
    if medium_is_opaque(beyond) {
        return conductor(cos_i, here.n, beyond.n, beyond.k);
    }
    return dielectric(cos_i, here.n / beyond.n);
}
