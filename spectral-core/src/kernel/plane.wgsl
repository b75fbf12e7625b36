// The facet planes of all stones.

// A facet plane.
struct Plane {
    // Unit, outward.
    normal: vec3<f32>,
    offset: f32,
    // Of its stone.
    rank: u32,
}

@group(0) @binding(3) var<storage, read> planes: array<Plane>;
