//! The maths alone in ten lines: how much light passes a tilted window, polarised and by the scalar shortcut.

use spectral_core::{fresnel::dielectric, material::Catalogue};

fn main() -> Result<(), spectral_core::Error> {
    let n = Catalogue::builtin().get("n-bk7")?.index(587.56);
    let face = dielectric(75_f64.to_radians().cos(), 1.0 / n);
    // Summed over all inner reflections, a slab passes (1 − R)/(1 + R) of each polarisation.
    let slab = |r: f64| (1.0 - r) / (1.0 + r);
    let polarised = (slab(face.reflectance_s) + slab(face.reflectance_p)) / 2.0;
    println!("N-BK7 at 75°: {polarised:.3} in truth, {:.3} by averaging s and p", slab(face.reflectance()));
    Ok(())
}
