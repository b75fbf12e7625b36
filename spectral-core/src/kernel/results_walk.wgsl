// Work items that may be resumed keep their results with what is left to follow.

@group(1) @binding(3) var<storage, read_write> walks: array<Walk>;

fn result_of(item: u32) -> Result {
    return walks[item].result;
}
