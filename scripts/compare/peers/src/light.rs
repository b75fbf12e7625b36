//! The environment for one direction and one wavelength at a time, with the functions of the C library.

use glam::Vec3A;
use spectral_core::{
    environment::{LatLong, Source},
    prepare::PreparedScene,
};
use std::f32::consts::{FRAC_1_PI, TAU};

/// The environment image in single precision.
pub struct Light<'a> {
    image: &'a LatLong,
}

impl<'a> Light<'a> {
    /// Of a scene lit by an image.
    pub fn new(scene: &'a PreparedScene) -> Option<Self> {
        match &scene.environment.source {
            Source::Image(image) => Some(Light { image }),
            Source::Uniform(_) => None,
        }
    }

    /// Bilinear colour from a unit direction.
    pub fn rgb(&self, direction: Vec3A) -> [f32; 3] {
        let (w, h) = (self.image.width() as usize, self.image.height() as usize);
        let u = direction.x.atan2(direction.y) * (1.0 / TAU);
        let v = direction.x.hypot(direction.y).atan2(direction.z) * FRAC_1_PI;
        let x = (u - u.floor()) * w as f32 - 0.5;
        let y = (v * h as f32 - 0.5).clamp(0.0, (h - 1) as f32);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let i = if x0 < 0.0 { w - 1 } else { x0 as usize % w };
        let i1 = if i + 1 == w { 0 } else { i + 1 };
        let (j, j1) = (y0 as usize, (y0 as usize + 1).min(h - 1));
        let texels = self.image.texels();
        let (a, b) = (&texels[j * w + i], &texels[j * w + i1]);
        let (c, d) = (&texels[j1 * w + i], &texels[j1 * w + i1]);
        std::array::from_fn(|k| {
            let top = a[k] + (b[k] - a[k]) * fx;
            let bottom = c[k] + (d[k] - c[k]) * fx;
            top + (bottom - top) * fy
        })
    }
}

/// Smits's expansion of a colour over seven bases.
pub fn expand(basis: &[f32; 7], [r, g, b]: [f32; 3]) -> f32 {
    let [white, cyan, magenta, yellow, red, green, blue] = *basis;
    let mix = |least: f32, middle: f32, most: f32, secondary: f32, primary: f32| {
        least * white + (middle - least) * secondary + (most - middle) * primary
    };
    if r <= g && r <= b {
        if g <= b { mix(r, g, b, cyan, blue) } else { mix(r, b, g, cyan, green) }
    } else if g <= b {
        if r <= b { mix(g, r, b, magenta, blue) } else { mix(g, b, r, magenta, red) }
    } else if r <= g {
        mix(b, r, g, yellow, green)
    } else {
        mix(b, g, r, yellow, red)
    }
}
