// The entry point that makes the camera rays: one invocation a pixel sample.
//
// The host gives the camera as linear maps about the middle of the stones, made in double precision, so that single
// precision is spent on the stones and not on the way to them: the twin of `Geometry::approach`.

// Where each sample lies in its pixel.
@group(0) @binding(7) var<storage, read> offsets: array<vec2<f32>>;

@group(1) @binding(1) var<storage, read> pixels: array<u32>;
@group(1) @binding(2) var<storage, read_write> primaries: array<Primary>;

// The part of a camera ray that comes near the stones.
struct Approach {
    near: bool,
    origin: vec3<f32>,
    // The facet of one convex stone by which the ray enters.
    facet: u32,
}

// Where a ray enters the stone that its planes bound, from a point outside.
fn prime_enter(origin: vec3<f32>, direction: vec3<f32>) -> Approach {
    var enter = -LARGEST;
    var leave = LARGEST;
    var facet = 0u;
    for (var i = 0u; i < scene.facets; i++) {
        let plane = planes[i];
        let towards = inner(plane.normal, direction);
        let gap = plane.offset - inner(plane.normal, origin);
        let t = gap / towards;
        if towards < 0.0 && t > enter {
            enter = t;
            facet = i;
        } else if towards > 0.0 {
            leave = min(leave, t);
        } else if towards == 0.0 && gap < 0.0 {
            leave = -LARGEST;
        }
    }
    return Approach(enter >= 0.0 && enter <= leave, origin + direction * max(enter, 0.0), facet);
}

// `middle` is a point of the ray beside the stones, and the ray begins at the parameter `begin` from there.
fn prime_approach(middle: vec3<f32>, direction: vec3<f32>, begin: f32) -> Approach {
    let ahead = inner(middle, direction);
    let half2 = ahead * ahead - (inner(middle, middle) - scene.reach * scene.reach);
    let half = sqrt(max(half2, 0.0));
    if half2 < 0.0 || half - ahead < begin || scene.reach == 0.0 {
        return Approach(false, middle, 0u);
    }
    var origin = middle + direction * max(-ahead - half, begin);
    if scene.eye.w > 0.0 && begin >= -ahead - half {
        // Among the stones all rays begin at the same point, which may be very near a surface.
        origin = scene.eye.xyz;
    }
    if scene.facets > 0u {
        return prime_enter(origin, direction);
    }
    return Approach(true, origin, 0u);
}

@compute @workgroup_size(WORKGROUP)
fn prime(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = invocation(group, groups, lane);
    if number >= batch.pixels * batch.count {
        return;
    }
    let pixel = pixels[number / batch.count];
    let sample = batch.first + number % batch.count;
    let x = (f32(pixel % scene.width) - scene.middle.x) + offsets[sample].x;
    let y = (f32(pixel / scene.width) - scene.middle.y) + offsets[sample].y;
    let middle = scene.centre + scene.right * x + scene.down * y;
    let towards = scene.forward + scene.across * x + scene.along * y;
    let length = sqrt(inner(towards, towards));
    let direction = towards / length;
    let begin = -scene.depth * length;
    let approach = prime_approach(middle, direction, begin);
    var background = vec3(0.0);
    if scene.transparent == 0u {
        background = light_rgb(middle + direction * begin, direction);
    }
    let first_line = sample % scene.tables * scene.lines;
    let near = select(0u, approach.facet + 1u, approach.near);
    primaries[number] = Primary(approach.origin, first_line, direction, near, background);
}
