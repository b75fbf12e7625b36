// The facets of one convex stone, copied into workgroup memory as a kernel starts: every ray asks for them.

var<workgroup> facet_planes: array<vec4<f32>, FACET_ROOM>;
var<workgroup> facet_words: array<u32, WORD_ROOM>;

// Called by all invocations of a workgroup, before anything else.
fn facets_load(lane: u32) {
    for (var facet = lane; facet < scene.facets; facet += WORKGROUP) {
        let plane = planes[facet];
        facet_planes[facet] = vec4(plane.normal, plane.offset);
    }
    // The last word of the table says where the lists end.
    let words = outlines[scene.facets];
    for (var place = lane; place < words; place += WORKGROUP) {
        facet_words[place] = outlines[place];
    }
    workgroupBarrier();
}

// The plane n · x = d of a facet as (n, d).
fn facet_plane(facet: u32) -> vec4<f32> {
    return facet_planes[facet];
}

// A word of `outlines`.
fn facet_word(place: u32) -> u32 {
    return facet_words[place];
}
