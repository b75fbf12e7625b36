//! The environment in single precision: where a direction falls on the image, and its radiance at one
//! wavelength. The twin of `spectral_core::environment`.

use crate::line::Line;
use glam::Vec3;
use spectral_core::environment::{Environment, LatLong, Source};
use std::f32::consts::{FRAC_1_PI, TAU};
use std::sync::Arc;

/// The environment; illuminant and scale are in the [`Line`]s' bases already.
#[derive(Debug, Clone)]
pub(crate) enum Light {
    Uniform([f32; 3]),
    Image { image: Arc<LatLong>, turn: f32 },
}

impl Light {
    pub fn new(environment: &Environment) -> Self {
        match &environment.source {
            Source::Uniform(rgb) => Light::Uniform(rgb.map(|c| c as f32)),
            Source::Image(image) => {
                let turn = (environment.rotation / 360.0).rem_euclid(1.0) as f32;
                Light::Image { image: image.clone(), turn }
            }
        }
    }

    /// Spectral radiance from a unit direction.
    #[inline]
    pub fn radiance(&self, direction: Vec3, line: &Line) -> f32 {
        line.expand(self.rgb(direction))
    }

    #[inline]
    fn rgb(&self, direction: Vec3) -> [f32; 3] {
        match self {
            Light::Uniform(rgb) => *rgb,
            Light::Image { image, turn } => {
                let u = direction.x.atan2(direction.y) * (1.0 / TAU) + turn;
                bilinear(image, u, polar_angle(direction) * FRAC_1_PI)
            }
        }
    }
}

/// acos(z), without its loss of digits near the poles.
#[inline]
fn polar_angle(direction: Vec3) -> f32 {
    direction.x.hypot(direction.y).atan2(direction.z)
}

#[inline]
fn bilinear(image: &LatLong, u: f32, v: f32) -> [f32; 3] {
    let (w, h) = (image.width() as usize, image.height() as usize);
    let x = (u - u.floor()) * w as f32 - 0.5;
    let y = (v * h as f32 - 0.5).clamp(0.0, (h - 1) as f32);
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = (x - x0, y - y0);
    // x0 runs from −1 to w − 1 (w where u rounds up to 1).
    let i = if x0 < 0.0 { w - 1 } else { x0 as usize % w };
    let i1 = if i + 1 == w { 0 } else { i + 1 };
    let j = y0 as usize;
    let j1 = (j + 1).min(h - 1);
    let texels = image.texels();
    let (a, b) = (&texels[j * w + i], &texels[j * w + i1]);
    let (c, d) = (&texels[j1 * w + i], &texels[j1 * w + i1]);
    std::array::from_fn(|k| {
        let top = a[k] + (b[k] - a[k]) * fx;
        let bottom = c[k] + (d[k] - c[k]) * fx;
        top + (bottom - top) * fy
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn single_precision_agrees_with_the_core() {
        let mut environment = Environment::image(LatLong::studio());
        environment.rotation = 33.0;
        let light = Light::new(&environment);
        for k in 0..10_000 {
            // A spiral over the sphere, poles included.
            let z = 1.0 - 2.0 * f64::from(k) / 9_999.0;
            let angle = 2.399_963 * f64::from(k);
            let direction =
                DVec3::new((1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z);
            let exact = environment.rgb(direction);
            let found = light.rgb(direction.as_vec3());
            for c in 0..3 {
                assert!((f64::from(found[c]) - exact[c]).abs() < 2e-3 * exact[c].max(0.1), "{direction}");
            }
        }
    }
}
