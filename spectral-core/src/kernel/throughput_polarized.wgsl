// What a path carries from event to event, polarised: a Stokes row and the first axis of its frame.

struct Throughput {
    row: vec4<f32>,
    axis: vec3<f32>,
}

// After a surface: the reflected and the refracted share.
struct Shares {
    back: Throughput,
    on: Throughput,
}

fn throughput_eye(direction: vec3<f32>) -> Throughput {
    return Throughput(vec4(1.0, 0.0, 0.0, 0.0), any_axis(direction));
}

fn throughput_intensity(throughput: Throughput) -> f32 {
    return throughput.row.x;
}

fn throughput_scaled(throughput: Throughput, factor: f32) -> Throughput {
    return Throughput(throughput.row * factor, throughput.axis);
}

fn throughput_split(throughput: Throughput, direction: vec3<f32>, normal: vec3<f32>, event: Fresnel) -> Shares {
    let frame = aligned(direction, throughput.axis, normal);
    let row = row_rotated(throughput.row, frame.cos2, frame.sin2);
    let back = Throughput(row_reflected(row, event), frame.axis);
    let on = Throughput(row_refracted(row, event), frame.axis);
    return Shares(back, on);
}
