// `intersect` by our own wide BVH: the counterpart of `traverse.rs` and `triangle.rs`, where the proofs are.
//
// There are two differences, because the kernel has single precision only. If a ray passes an edge too closely for
// rounding to tell the side, both neighbours count as hit (the CPU decides exactly), so no ray leaks. And the
// parameter is that of the facet's plane, clamped to the range of the triangle's corners.

// An eight-way compressed node (Ylitie, Karras & Laine 2017), as `obvhs` lays it out: bytes, four a word.
struct Node {
    corner: vec3<f32>,
    // The exponents of the cell along x, y and z; then a bit for each child that is a node.
    cell_and_inner: u32,
    first_child: u32,
    first_triangle: u32,
    children: vec2<u32>,
    low_x: vec2<u32>,
    high_x: vec2<u32>,
    low_y: vec2<u32>,
    high_y: vec2<u32>,
    low_z: vec2<u32>,
    high_z: vec2<u32>,
}

struct Triangle {
    a: vec3<f32>,
    // In the input.
    number: u32,
    b: vec3<f32>,
    facet: u32,
    c: vec3<f32>,
}

@group(0) @binding(5) var<storage, read> nodes: array<Node>;
@group(0) @binding(6) var<storage, read> triangles: array<Triangle>;

// The ray-dependent part of the triangle test.
struct Shear {
    // The axis of the direction's largest component.
    axis: u32,
    origin: vec3<f32>,
    slope: vec2<f32>,
    // 1 / the direction's largest component.
    inverse: f32,
}

// A ray in the builder's units, the direction scaled to a largest component of 1.
struct Slabs {
    origin: vec3<f32>,
    inverse: vec3<f32>,
    widening: vec3<f32>,
    // Slab distance per ray parameter.
    rate: f32,
}

// Coordinates in cyclic order, with the chosen axis last.
fn permuted(v: vec3<f32>, axis: u32) -> vec3<f32> {
    return select(select(v.xyz, v.zxy, axis == 1u), v.yzx, axis == 0u);
}

fn shear_new(query: Query) -> Shear {
    let size = abs(query.direction);
    let largest = max(size.x, max(size.y, size.z));
    let axis = select(select(2u, 1u, size.y == largest), 0u, size.x == largest);
    let d = permuted(query.direction, axis);
    return Shear(axis, permuted(query.origin, axis), d.xy / d.z, 1.0 / d.z);
}

// A corner relative to the ray, sheared onto the axis: two coordinates of the image, then the height.
fn shear_image(shear: Shear, corner: vec3<f32>) -> vec3<f32> {
    let relative = permuted(corner, shear.axis) - shear.origin;
    return vec3(relative.xy - shear.slope * relative.z, relative.z);
}

// The sign of the area of the origin with an edge. Rounding is monotonic, so rounded products compare like the exact
// ones. They are compared and not subtracted: a subtraction could be contracted, and then round differently for the
// neighbour.
fn edge_sign(a: vec3<f32>, b: vec3<f32>) -> i32 {
    let p = a.x * b.y;
    let q = a.y * b.x;
    return i32(p > q) - i32(p < q);
}

// Whether the ray's line passes through the triangle: no two edges disagree. A triangle seen edge-on is not hit.
fn image_is_hit(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> bool {
    let u = edge_sign(c, b);
    let v = edge_sign(a, c);
    let w = edge_sign(b, a);
    let low = min(u, min(v, w));
    let high = max(u, max(v, w));
    return !(low < 0 && high > 0) && (low != 0 || high != 0);
}

// `best`, or the triangle's hit if it lies in the interval, precedes `best` and is accepted.
fn triangle_offer(query: Query, shear: Shear, triangle: Triangle, best: Hit) -> Hit {
    let a = shear_image(shear, triangle.a);
    let b = shear_image(shear, triangle.b);
    let c = shear_image(shear, triangle.c);
    if !image_is_hit(a, b, c) {
        return best;
    }
    let near = min(a.z, min(b.z, c.z)) * shear.inverse;
    let far = max(a.z, max(b.z, c.z)) * shear.inverse;
    let t =
        plane_parameter(triangle.facet, query.origin, query.direction, min(near, far), max(near, far));
    if t >= query.t_min && hit_precedes(t, triangle.number, best) && query_accepts(query, triangle.facet) {
        return Hit(t, triangle.facet, triangle.number, true);
    }
    return best;
}

// Tests the triangles of a leaf: the low five bits of its kind give the first one, the high three their number.
fn leaf_offer(query: Query, shear: Shear, base: u32, kind: u32, so_far: Hit) -> Hit {
    var best = so_far;
    let start = base + (kind & 31u);
    let end = start + countOneBits(kind >> 5u);
    for (var i = start; i < end; i++) {
        best = triangle_offer(query, shear, triangles[i], best);
    }
    return best;
}

fn slabs_new(query: Query) -> Slabs {
    let size = abs(query.direction);
    let largest = max(size.x, max(size.y, size.z));
    let d = query.direction / largest;
    let steep = min(1.0 / max(abs(d), vec3(1e-30)), vec3(STEEPEST));
    let inverse = select(steep, -steep, d < vec3(0.0));
    let origin = query.origin * scene.builder_scale;
    let reach = max(abs(origin.x), max(abs(origin.y), abs(origin.z))) + 1.0;
    return Slabs(origin, inverse, steep * (WIDENING * reach), largest * scene.builder_scale);
}

// Entry and exit distances of four children along one axis, folded into those of the axes before.
struct Span {
    near: vec4<f32>,
    far: vec4<f32>,
}

fn bytes(word: u32) -> vec4<f32> {
    return vec4<f32>((vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(0xffu));
}

fn span_cut(span: Span, low: u32, high: u32, step: f32, start: f32, widening: f32) -> Span {
    let forward = step >= 0.0;
    let enter = bytes(select(high, low, forward));
    let leave = bytes(select(low, high, forward));
    return Span(
        max(span.near, enter * step + (start - widening)),
        min(span.far, leave * step + (start + widening)),
    );
}

// Entry distances to children 4·half to 4·half + 3 of a node, LARGEST if they are missed.
fn node_enter(node: Node, slabs: Slabs, half: u32, first: f32, last: f32) -> vec4<f32> {
    let exponents = (vec3(node.cell_and_inner) >> vec3(0u, 8u, 16u)) & vec3(0xffu);
    let step = bitcast<vec3<f32>>(exponents << vec3(23u)) * slabs.inverse;
    let start = (node.corner - slabs.origin) * slabs.inverse;
    var span = Span(vec4(first), vec4(last));
    span = span_cut(span, node.low_x[half], node.high_x[half], step.x, start.x, slabs.widening.x);
    span = span_cut(span, node.low_y[half], node.high_y[half], step.y, start.y, slabs.widening.y);
    span = span_cut(span, node.low_z[half], node.high_z[half], step.z, start.z, slabs.widening.z);
    return select(vec4(LARGEST), span.near, span.near <= span.far);
}

// A node still to visit.
struct Entry {
    distance: f32,
    node: u32,
}

fn intersect(query: Query) -> Hit {
    let shear = shear_new(query);
    let slabs = slabs_new(query);
    // A margin of a few units in the last place for the product and the division.
    let first = query.t_min * slabs.rate - abs(query.t_min * slabs.rate) * 1e-6;
    var best = hit_none(query);
    var entries: array<Entry, TRAVERSAL_STACK>;
    entries[0] = Entry(-LARGEST, 0u);
    var count = 1u;
    while count > 0u {
        count--;
        let entry = entries[count];
        let reach = min(best.t, 1e30) * slabs.rate;
        let last = reach + abs(reach) * 1e-6;
        if entry.distance > last {
            continue;
        }
        let node = nodes[entry.node];
        let inner = node.cell_and_inner >> 24u;
        let base = count;
        for (var half = 0u; half < 2u; half++) {
            let near = node_enter(node, slabs, half, first, last);
            for (var i = 0u; i < 4u; i++) {
                let child = 4u * half + i;
                let kind = (node.children[half] >> (8u * i)) & 0xffu;
                if kind == 0u || near[i] == LARGEST {
                    continue;
                }
                if (inner & (1u << child)) == 0u {
                    best = leaf_offer(query, shear, node.first_triangle, kind, best);
                    continue;
                }
                // The nearest goes on top.
                var place = count;
                while place > base && entries[place - 1u].distance < near[i] {
                    entries[place] = entries[place - 1u];
                    place--;
                }
                let before = inner & ((1u << ((kind & 31u) - 24u)) - 1u);
                entries[place] = Entry(near[i], node.first_child + countOneBits(before));
                count++;
            }
        }
    }
    return best;
}
