// The entry point that adds a batch to the film: one invocation a pixel. All sums run in the order of samples, and of
// wavelengths within a sample, as the host's do.

// What the pixels of a workgroup add to the account.
struct Tally {
    // Depth, threshold, left at the limit, lost: the fields of `Energy`.
    energies: vec4<f32>,
    // Segments traced, low and high word.
    rays: vec2<u32>,
    // Work items that are not over.
    going: u32,
}

@group(1) @binding(2) var<storage, read> primaries: array<Primary>;
// XYZ and coverage of each pixel, before the batch and after.
@group(1) @binding(5) var<storage, read_write> sums: array<vec4<f32>>;
@group(1) @binding(6) var<storage, read_write> tallies: array<Tally>;
// By pixel, then wavelength; before the batch, and after.
@group(1) @binding(7) var<storage, read_write> radiances: array<f32>;

var<workgroup> counted: array<Tally, WORKGROUP>;

fn tally_add(tally: ptr<function, Tally>, other: Tally) {
    (*tally).energies += other.energies;
    let low = (*tally).rays.x + other.rays.x;
    (*tally).rays.y += other.rays.y + select(0u, 1u, low < other.rays.x);
    (*tally).rays.x = low;
    (*tally).going += other.going;
}

// A sample's wavelengths: its XYZ and coverage.
fn gather_sample(pixel: u32, number: u32, tally: ptr<function, Tally>) -> vec4<f32> {
    var xyz = vec3(0.0);
    var own = Tally(vec4(0.0), vec2(0u), 0u);
    for (var i = 0u; i < scene.lines; i++) {
        let result = result_of(number * scene.lines + i);
        xyz += line_xyz(primaries[number].first_line + i) * result.radiance;
        let energies =
            vec4(result.dropped_depth, result.dropped_threshold, result.left_at_limit, result.lost);
        tally_add(&own, Tally(energies, vec2(result.rays, 0u), result.going));
        if batch.spectral != 0u {
            let place = pixel * scene.lines + i;
            let before = select(radiances[place], 0.0, batch.fresh != 0u && number == pixel * batch.count);
            radiances[place] = before + result.radiance;
        }
    }
    tally_add(tally, own);
    return vec4(xyz, f32(result_of(number * scene.lines).covered));
}

@compute @workgroup_size(WORKGROUP)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let pixel = invocation(group, groups, lane);
    var tally = Tally(vec4(0.0), vec2(0u), 0u);
    if pixel < batch.pixels {
        var sum = vec4(0.0);
        if batch.fresh == 0u {
            sum = sums[pixel];
        }
        for (var sample = 0u; sample < batch.count; sample++) {
            sum += gather_sample(pixel, pixel * batch.count + sample, &tally);
        }
        sums[pixel] = sum;
    }
    counted[lane] = tally;
    workgroupBarrier();
    if lane == 0u && pixel < batch.pixels {
        for (var other = 1u; other < WORKGROUP; other++) {
            tally_add(&tally, counted[other]);
        }
        tallies[pixel / WORKGROUP] = tally;
    }
}
