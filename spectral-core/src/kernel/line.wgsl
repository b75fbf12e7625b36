// One spectral line of a sample's wavelength grid: all that transport asks of it.

// By line: three vectors of light (Smits's bases white, cyan, magenta, yellow; red, green, blue, –; X, Y, Z, –),
// then one a material (n, k, absorption, –).
@group(0) @binding(2) var<storage, read> optics: array<vec4<f32>>;

// The optics of a material at one wavelength.
struct Medium {
    n: f32,
    // Above 0 for metals only.
    k: f32,
    // Napierian, 1/mm.
    absorption: f32,
}

struct Line {
    // Where the line begins in `optics`.
    first: u32,
    // Radiance of white, cyan, magenta and yellow, light and scale included.
    mixed: vec4<f32>,
    // Radiance of red, green and blue.
    pure: vec3<f32>,
}

// The line at a place in the flat list of all tables' lines.
fn line_at(place: u32) -> Line {
    let first = place * (LINE_VECTORS + scene.materials);
    return Line(first, optics[first], optics[first + 1u].xyz);
}

// Weight of the line at a place in X, Y and Z.
fn line_xyz(place: u32) -> vec3<f32> {
    return optics[place * (LINE_VECTORS + scene.materials) + 2u].xyz;
}

fn line_medium(line: Line, material: u32) -> Medium {
    let medium = optics[line.first + LINE_VECTORS + material];
    return Medium(medium.x, medium.y, medium.z);
}

fn mix_bases(line: Line, least: f32, mid: f32, most: f32, secondary: f32, primary: f32) -> f32 {
    return least * line.mixed.x + (mid - least) * secondary + (most - mid) * primary;
}

// Smits's expansion of a non-negative linear sRGB colour.
fn line_expand(line: Line, rgb: vec3<f32>) -> f32 {
    let r = rgb.x;
    let g = rgb.y;
    let b = rgb.z;
    let cyan = line.mixed.y;
    let magenta = line.mixed.z;
    let yellow = line.mixed.w;
    if r <= g && r <= b {
        if g <= b {
            return mix_bases(line, r, g, b, cyan, line.pure.z);
        }
        return mix_bases(line, r, b, g, cyan, line.pure.y);
    }
    if g <= b {
        if r <= b {
            return mix_bases(line, g, r, b, magenta, line.pure.z);
        }
        return mix_bases(line, g, b, r, magenta, line.pure.x);
    }
    if r <= g {
        return mix_bases(line, b, r, g, yellow, line.pure.y);
    }
    return mix_bases(line, b, g, r, yellow, line.pure.x);
}
