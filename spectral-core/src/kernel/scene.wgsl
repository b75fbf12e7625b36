// What is the same for every ray: the twin of the parts of `PreparedScene` that transport asks for.

struct Scene {
    // Linear sRGB from everywhere, where the light is no image.
    light: vec3<f32>,
    // Rotation of the image in turns.
    turn: f32,
    // `Rounding`: see `prepare/rounding.rs`.
    margin: f32,
    behind: f32,
    contact: f32,
    threshold: f32,
    // The stones that the eye is in.
    eye_nest: vec3<u32>,
    max_depth: u32,
    // Wavelengths a pixel sample.
    lines: u32,
    // Distinct materials.
    materials: u32,
    // Flags: 0 or 1.
    image: u32,
    leave_at_limit: u32,
    transparent: u32,
    // Units of the hierarchy's builder per mm, where `intersect` has one.
    builder_scale: f32,
    // What a texel of the image is to be multiplied by.
    gain: f32,
    // z of the diffuse ground.
    ground_height: f32,
    // Columns and rows of the image that are lights; the ground's picture begins in the row after.
    sky: vec2<u32>,
    // Where the ground's first texel lies.
    ground_low: vec2<f32>,
    // The ground's texels a mm; 0 where there is no ground.
    ground_per_mm: f32,
    // The last of the ground's texels that has a next.
    ground_last: f32,
    // The least slope of rays that see the ground.
    grazing: f32,
    // Facet planes, where one convex stone is met by them.
    facets: u32,
    // Columns of the picture.
    width: u32,
    // Tables of optics; samples take them in turn.
    tables: u32,
    // Radius of the sphere about the origin that holds the stones; 0 where there are none.
    reach: f32,
    // The camera (`View::frame`): the picture's middle, pixels; the point seen there on the plane that is `depth` from
    // the eye, and its change a pixel to the right and down; the direction there, and its change.
    depth: f32,
    middle: vec2<f32>,
    // The weight below which a mode of a crystal is not followed for itself.
    split: f32,
    centre: vec3<f32>,
    right: vec3<f32>,
    down: vec3<f32>,
    forward: vec3<f32>,
    across: vec3<f32>,
    along: vec3<f32>,
    // The eye, and 1, or 2 of a close-up; 0 in the last place where rays are parallel.
    eye: vec4<f32>,
}

@group(0) @binding(0) var<uniform> scene: Scene;
