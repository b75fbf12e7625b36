// The entry point that adds a batch to the film: one invocation a pixel. All sums run in the order of samples, and of
// wavelengths within a sample, as the host's do.

// A pixel after the batch.
struct Seen {
    // Sums over all samples so far.
    xyz: vec3<f32>,
    coverage: f32,
    // Of this batch: depth, threshold, left at the limit, lost: the fields of `Energy`.
    energies: vec4<f32>,
    // Of this batch: segments traced, low and high word.
    rays: vec2<u32>,
    // Work items that are not over.
    going: u32,
}

@group(1) @binding(2) var<storage, read> primaries: array<Primary>;
// XYZ and coverage before the batch.
@group(1) @binding(5) var<storage, read> sums: array<vec4<f32>>;
@group(1) @binding(6) var<storage, read_write> seen: array<Seen>;
// By pixel, then wavelength; before the batch, and after.
@group(1) @binding(7) var<storage, read_write> radiances: array<f32>;

// A sample's wavelengths.
fn gather_sample(pixel: u32, number: u32, sum: ptr<function, Seen>) {
    var xyz = vec3(0.0);
    var energies = vec4(0.0);
    for (var i = 0u; i < scene.lines; i++) {
        let result = result_of(number * scene.lines + i);
        xyz += line_xyz(primaries[number].first_line + i) * result.radiance;
        energies += vec4(result.dropped_depth, result.dropped_threshold, result.left_at_limit, result.lost);
        (*sum).rays.x += result.rays;
        (*sum).rays.y += select(0u, 1u, (*sum).rays.x < result.rays);
        (*sum).going += result.going;
        if batch.spectral != 0u {
            let place = pixel * scene.lines + i;
            let before = select(radiances[place], 0.0, batch.fresh != 0u && number == pixel * batch.count);
            radiances[place] = before + result.radiance;
        }
    }
    (*sum).xyz += xyz;
    (*sum).energies += energies;
    (*sum).coverage += f32(result_of(number * scene.lines).covered);
}

@compute @workgroup_size(WORKGROUP)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let pixel = invocation(group, groups, lane);
    if pixel >= batch.pixels {
        return;
    }
    var sum = Seen(vec3(0.0), 0.0, vec4(0.0), vec2(0u), 0u);
    if batch.fresh == 0u {
        sum.xyz = sums[pixel].xyz;
        sum.coverage = sums[pixel].w;
    }
    for (var sample = 0u; sample < batch.count; sample++) {
        gather_sample(pixel, pixel * batch.count + sample, &sum);
    }
    seen[pixel] = sum;
}
