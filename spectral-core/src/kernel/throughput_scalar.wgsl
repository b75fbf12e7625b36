// What a path carries from event to event in the scalar mode: one number, the mean of s and p at each event.

struct Throughput {
    intensity: f32,
}

// After a surface: the reflected and the refracted share.
struct Shares {
    back: Throughput,
    on: Throughput,
}

fn throughput_eye(_direction: vec3<f32>) -> Throughput {
    return Throughput(1.0);
}

fn throughput_intensity(throughput: Throughput) -> f32 {
    return throughput.intensity;
}

fn throughput_scaled(throughput: Throughput, factor: f32) -> Throughput {
    return Throughput(throughput.intensity * factor);
}

fn throughput_split(throughput: Throughput, _direction: vec3<f32>, _normal: vec3<f32>, event: Fresnel) -> Shares {
    let reflectance = (event.reflectance_s + event.reflectance_p) * 0.5;
    let transmittance = (event.transmittance_s + event.transmittance_p) * 0.5;
    return Shares(Throughput(throughput.intensity * reflectance), Throughput(throughput.intensity * transmittance));
}
