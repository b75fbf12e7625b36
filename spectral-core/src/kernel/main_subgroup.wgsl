// The compute entry point that traces one convex stone, for subgroups that guess together.

@compute @workgroup_size(WORKGROUP)
fn trace(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
    @builtin(subgroup_invocation_id) number: u32,
) {
    subgroup_lane = number;
    facets_load(lane);
    trace_item(id.x);
}
