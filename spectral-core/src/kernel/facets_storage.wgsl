// The facets of one convex stone, where they are too many for workgroup memory: read from where the host puts them.

fn facets_load(lane: u32) {}

// The plane n · x = d of a facet as (n, d).
fn facet_plane(facet: u32) -> vec4<f32> {
    let plane = planes[facet];
    return vec4(plane.normal, plane.offset);
}

// A word of `outlines`.
fn facet_word(place: u32) -> u32 {
    return outlines[place];
}
