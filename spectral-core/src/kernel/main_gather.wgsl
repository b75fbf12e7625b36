// The compute entry point that sums a pixel sample's wavelengths, in ascending order, into what the film takes.

// One pixel sample.
struct Seen {
    xyz: vec3<f32>,
    coverage: f32,
    // Depth, threshold, left at the limit, lost: the fields of `Energy`.
    energies: vec4<f32>,
    rays: u32,
    // Walks that are not over.
    going: u32,
}

struct Gathering {
    samples: u32,
    // 1 writes every radiance out.
    spectral: u32,
}

@group(1) @binding(0) var<uniform> gathering: Gathering;
@group(1) @binding(1) var<storage, read> primaries: array<Primary>;
@group(1) @binding(2) var<storage, read> walks: array<Walk>;
@group(1) @binding(3) var<storage, read_write> seen: array<Seen>;
@group(1) @binding(4) var<storage, read_write> radiances: array<f32>;

@compute @workgroup_size(WORKGROUP)
fn gather(@builtin(global_invocation_id) id: vec3<u32>) {
    let sample = id.x;
    if sample >= gathering.samples {
        return;
    }
    var sum = Seen(vec3(0.0), 0.0, vec4(0.0), 0u, 0u);
    for (var i = 0u; i < scene.lines; i++) {
        let item = sample * scene.lines + i;
        let radiance = walks[item].sum;
        let account = walks[item].account;
        sum.xyz += line_xyz(primaries[sample].first_line + i) * radiance;
        sum.energies +=
            vec4(account.dropped_depth, account.dropped_threshold, account.left_at_limit, account.lost);
        sum.rays += account.rays;
        sum.going += select(1u, 0u, walks[item].state == WALK_OVER);
        if gathering.spectral != 0u {
            radiances[item] = radiance;
        }
    }
    sum.coverage = f32(walks[sample * scene.lines].covered);
    seen[sample] = sum;
}
