// Work items that end in one dispatch leave nothing but their results.

@group(1) @binding(3) var<storage, read_write> results: array<Result>;

fn result_of(item: u32) -> Result {
    return results[item];
}
