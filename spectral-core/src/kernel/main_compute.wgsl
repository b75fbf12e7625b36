// The compute entry point that traces.

@compute @workgroup_size(WORKGROUP)
fn trace(@builtin(global_invocation_id) id: vec3<u32>) {
    trace_item(id.x);
}
