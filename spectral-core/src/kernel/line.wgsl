// One spectral line of a sample's wavelength grid: all that transport asks of it.

// By line: the light's basis (`basis.wgsl`), the line's weights in X, Y and Z, then the optics of each material.
@group(0) @binding(2) var<storage, read> optics: array<vec4<f32>>;

struct Line {
    // Where the line begins in `optics`.
    first: u32,
    basis: Basis,
}

// Where a line begins in `optics`, by its place in the flat list of all tables' lines.
fn line_first(place: u32) -> u32 {
    return place * (BASIS_VECTORS + 1u + scene.materials * MEDIUM_VECTORS);
}

fn line_at(place: u32) -> Line {
    let first = line_first(place);
    return Line(first, basis_at(first));
}

// Weight of the line at a place in X, Y and Z.
fn line_xyz(place: u32) -> vec3<f32> {
    return optics[line_first(place) + BASIS_VECTORS].xyz;
}
