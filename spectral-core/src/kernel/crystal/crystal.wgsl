// A crystal at one wavelength: the twin of `crystal.rs`. The structure `Crystal` and `crystal_at`, which reads one from
// `optics`, are generated from `kernel/medium.rs`.

// The two waves with energy on one side of a surface: along its normal (side 1) or against it (−1).
fn crystal_waves(crystal: Crystal, at: Incidence, side: f32) -> array<Wave, 2> {
    if crystal.kind == BIAXIAL {
        return biaxial_waves(crystal, at, side);
    }
    return uniaxial_waves(crystal, at, side);
}

// The absorption coefficient of a mode along its ray, 1/mm.
fn crystal_absorption(crystal: Crystal, normal: vec3<f32>, electric: vec3<f32>, ray: vec3<f32>) -> f32 {
    let along = vec3(dot(electric, crystal.x), dot(electric, crystal.y), dot(electric, crystal.z));
    let share = crystal.index * along * along;
    return dot(normal, ray) * dot(share, crystal.absorption) / dot(share, crystal.index);
}
