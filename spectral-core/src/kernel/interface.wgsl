// A surface between two media.

const AIR = Medium(1.0, 0.0, 0.0);

struct Interface {
    event: Fresnel,
    cos_i: f32,
}

fn interface_at(direction: vec3<f32>, normal: vec3<f32>, here: Medium, beyond: Medium) -> Interface {
    let cos_i = -inner(normal, direction);
    if beyond.k > 0.0 {
        return Interface(conductor(cos_i, here.n, beyond.n, beyond.k), cos_i);
    }
    return Interface(dielectric(cos_i, here.n / beyond.n), cos_i);
}
