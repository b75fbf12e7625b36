//! The environment for sixteen directions at a time: the twin of `spectral_core::environment`.

use crate::{
    lanes::{Lanes, Row, Triple, WIDTH, planar_place, turns},
    light::Light,
};
use spectral_core::environment::LatLong;

/// Where directions fall on the image.
#[derive(Clone, Copy)]
pub(crate) struct Aim {
    column: [i32; WIDTH],
    row: [i32; WIDTH],
    across: Row,
    down: Row,
}

impl Aim {
    /// Nowhere yet.
    pub const NOWHERE: Self =
        Aim { column: [0; WIDTH], row: [0; WIDTH], across: Row([0.0; WIDTH]), down: Row([0.0; WIDTH]) };

    /// For unit directions.
    #[inline(always)]
    pub fn new<V: Lanes>(light: &Light, direction: Triple<V>) -> Self {
        let Light::Image { image, turn } = light else { return Self::NOWHERE };
        let (zero, half, one) = (V::splat(0.0), V::splat(0.5), V::splat(1.0));
        let (width, height) = (image.width() as f32, image.height() as f32);
        let u = turns(direction.x, direction.y) + V::splat(*turn);
        let flat = direction.x.fma(direction.x, direction.y * direction.y).sqrt();
        let v = turns(flat, direction.z) * V::splat(2.0);
        let x = (u - u.floor()).fma(V::splat(width), -half);
        let y = v.fma(V::splat(height), -half).max(zero).min(V::splat(height - 1.0));
        let (x0, y0) = (x.floor(), y.floor());
        let column = V::select(x0.lt(zero), V::splat(width) - one, x0);
        let mut aim = Self::NOWHERE;
        aim.column = column.min(V::splat(width) - one).truncated();
        aim.row = y0.truncated();
        (x - x0).store(&mut aim.across);
        (y - y0).store(&mut aim.down);
        aim
    }

    /// Colours of the lanes whose bit is set.
    #[inline(always)]
    pub fn colours<V: Lanes>(&self, light: &Light, lanes: u16) -> Triple<V> {
        let image = match light {
            Light::Uniform(rgb) => return Triple::splat(*rgb),
            Light::Image { image, .. } => image,
        };
        let mut colours = [[0.0; 4]; WIDTH];
        let texels = image.texels().as_flattened();
        let pitch = 3 * image.width() as usize;
        let mut left = lanes;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let (column, row) = (self.column[lane] as usize, self.row[lane] as usize);
            let colour = &mut colours[planar_place(lane)];
            let (fx, fy) = (self.across.0[lane], self.down.0[lane]);
            let top = row * pitch + 3 * column;
            let bottom = if row + 1 < image.height() as usize { top + pitch } else { top };
            let inner = column + 1 < image.width() as usize;
            match (pair(texels, top), pair(texels, bottom)) {
                (Some(top), Some(bottom)) if inner => V::bilinear(top, bottom, fx, fy, colour),
                _ => {
                    let [top, bottom] = wrapped(image, column, row);
                    V::bilinear(&top, &bottom, fx, fy, colour);
                }
            }
        }
        let [x, y, z] = V::planar(&colours);
        Triple { x, y, z }
    }
}

/// A texel, the next one, and two numbers more; `None` at the very end of the image.
#[inline(always)]
fn pair(texels: &[f32], at: usize) -> Option<&[f32; 8]> {
    texels.get(at..).and_then(|rest| rest.first_chunk())
}

/// The same where it has to be put together: the next texel is the row's first, or the image's end is near.
#[cold]
fn wrapped(image: &LatLong, column: usize, row: usize) -> [[f32; 8]; 2] {
    let (width, height) = (image.width() as usize, image.height() as usize);
    [row, (row + 1).min(height - 1)].map(|row| {
        let [a, b] = [column, (column + 1) % width].map(|i| image.texels()[row * width + i]);
        [a[0], a[1], a[2], b[0], b[1], b[2], 0.0, 0.0]
    })
}
