// The compute entry point that traces one convex stone, for subgroups that guess together.

@compute @workgroup_size(WORKGROUP)
fn trace(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
    @builtin(subgroup_invocation_id) number: u32,
) {
    subgroup_lane = number;
    facets_load(lane);
    trace_item(invocation(group, groups, lane));
}
