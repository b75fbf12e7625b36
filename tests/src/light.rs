//! Lights that show where rays went. All of them except the studio use illuminant E, so that a texel of 1 is a spectral
//! radiance of exactly 1 at every wavelength.

use glam::DVec3;
use spectral_core::{
    cie::Illuminant,
    environment::{Environment, LatLong},
};
use std::f64::consts::{PI, TAU};

/// The built-in studio.
pub fn studio() -> Environment {
    Environment::image(LatLong::studio())
}

/// Radiance 1 from everywhere.
pub fn furnace() -> Environment {
    Environment { illuminant: Illuminant::E, ..Environment::uniform([1.0; 3]) }
}

/// A grey image of 2·`height` × `height` texels, each with the value of `paint` in the direction of its centre.
pub fn painted(height: u32, paint: impl Fn(DVec3) -> f64) -> Environment {
    let width = 2 * height;
    let texel = |k: u32| {
        let u = (f64::from(k % width) + 0.5) / f64::from(width);
        let v = (f64::from(k / width) + 0.5) / f64::from(height);
        [paint(direction(u, v)) as f32; 3]
    };
    let (image, _) =
        LatLong::new(width, height, (0..width * height).map(texel).collect()).expect("a valid image");
    Environment { illuminant: Illuminant::E, ..Environment::image(image) }
}

/// Radiance 1 from the half sphere about `axis`, 0 from the other, with a smooth rim of one degree.
pub fn half(axis: DVec3) -> Environment {
    painted(180, |d| if d.dot(axis) > 0.0 { 1.0 } else { 0.0 })
}

/// A disc lamp of radiance 1 and angular radius `radius` degrees about a unit direction.
pub fn lamp(towards: DVec3, radius: f64) -> Environment {
    let edge = radius.to_radians().cos();
    painted(180, |d| if d.dot(towards) > edge { 1.0 } else { 0.0 })
}

/// Radiance θ/π by polar angle θ from +z, on the side y > 0 only.
///
/// Bilinear interpolation reproduces a linear function exactly, so this light measures the elevation of a ray in the yz
/// plane.
pub fn protractor() -> Environment {
    painted(180, |d| if d.y > 0.0 { d.z.acos() / PI } else { 0.0 })
}

/// Radiance 1 on the side y > 0: the divisor of [`protractor`].
pub fn protractor_white() -> Environment {
    painted(180, |d| if d.y > 0.0 { 1.0 } else { 0.0 })
}

/// The unit direction of image coordinates (u, v).
pub fn direction(u: f64, v: f64) -> DVec3 {
    let (sin_polar, cos_polar) = (PI * v).sin_cos();
    let (sin, cos) = (TAU * u).sin_cos();
    DVec3::new(sin_polar * sin, sin_polar * cos, cos_polar)
}
