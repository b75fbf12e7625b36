//! A level, diffuse ground that reaches to the horizon.
//!
//! A Lambertian plane of reflectance ρ and irradiance E shows the radiance ρE/π in every direction. So what a ray sees
//! depends only on where it lands, and the ground is a picture of its radiance. The caller makes that picture; here it
//! is only looked up.

use super::LatLong;
use crate::Error;
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// A diffuse ground with its light on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    /// mm.
    pub height: f64,
    /// Where the first texel lies, in x and y, mm.
    low: DVec2,
    /// From texel to texel, mm.
    step: f64,
    edge: u32,
    texels: Arc<[[f32; 3]]>,
}

/// Where the ground's picture lies, in single precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundFrame {
    /// mm.
    pub height: f32,
    /// x and y of the first texel, mm.
    pub low: [f32; 2],
    /// Texels per mm.
    pub per_mm: f32,
    /// The last texel of a row, or row, that has a next one.
    pub last: f32,
}

impl Ground {
    /// The most texels along an edge.
    pub const MOST_TEXELS: u32 = 4096;

    /// A ground at z = `height` (mm) that shows `texels`: linear sRGB radiances before the environment's scale, `edge`
    /// rows of as many texels with x growing along a row and y from row to row, of which the first lies at `low` and
    /// the next `step` mm further on. Between texels it is bilinear; beyond, it is as at the border.
    ///
    /// # Errors
    /// [`Error::Value`] for figures that are not finite, fewer than two or too many texels an edge, or negative light.
    pub fn new(
        height: f64,
        low: [f64; 2],
        step: f64,
        edge: u32,
        texels: Vec<[f32; 3]>,
    ) -> Result<Self, Error> {
        let low = DVec2::from(low);
        let near = |v: f64| v.is_finite() && v.abs() <= 1e9;
        if ![height, low.x, low.y].into_iter().all(near) {
            let found = format!("{height} at {low}");
            return Err(Error::value("ground.height", found, "figures in mm, at most 1e9 in size"));
        }
        if !(step.is_finite() && step > 0.0) {
            return Err(Error::value("ground step", step, "a length in mm, above 0"));
        }
        if !(2..=Self::MOST_TEXELS).contains(&edge) || texels.len() != edge as usize * edge as usize {
            let found = format!("{} texels, {edge} an edge", texels.len());
            return Err(Error::value("ground texels", found, "2 to 4096 an edge, in a square"));
        }
        if let Some(texel) = texels.iter().find(|t| !t.iter().all(|c| c.is_finite() && *c >= 0.0)) {
            return Err(Error::value("ground texel", format!("{texel:?}"), "finite radiances, none below 0"));
        }
        Ok(Ground { height, low, step, edge, texels: texels.into() })
    }

    /// Linear sRGB that a ray sees which goes down from `origin` (mm) in a unit `direction`.
    pub fn rgb(&self, origin: DVec3, direction: DVec3) -> [f64; 3] {
        let along = (origin.z - self.height) / (-direction.z).max(Self::GRAZING);
        let place = (origin.truncate() + direction.truncate() * along - self.low) / self.step;
        let place = place.clamp(DVec2::ZERO, DVec2::splat(f64::from(self.edge - 1)));
        let corner = place.floor().min(DVec2::splat(f64::from(self.edge - 2)));
        let share = place - corner;
        let (i, j, edge) = (corner.x as usize, corner.y as usize, self.edge as usize);
        let texel = |i: usize, j: usize, c: usize| f64::from(self.texels[j * edge + i][c]);
        std::array::from_fn(|c| {
            let near = texel(i, j, c) + (texel(i + 1, j, c) - texel(i, j, c)) * share.x;
            let far = texel(i, j + 1, c) + (texel(i + 1, j + 1, c) - texel(i, j + 1, c)) * share.x;
            near + (far - near) * share.y
        })
    }

    /// Rays go down at least as steeply as this: flatter ones end beyond the picture anyway.
    pub const GRAZING: f64 = 1e-9;

    /// What a backend needs to find a ray's place in the ground's picture.
    pub fn frame(&self) -> GroundFrame {
        GroundFrame {
            height: self.height as f32,
            low: self.low.to_array().map(|v| v as f32),
            per_mm: (1.0 / self.step) as f32,
            last: (self.edge - 2) as f32,
        }
    }

    /// The same with the world's origin moved to `origin`.
    pub(crate) fn seen_from(&self, origin: DVec3) -> Ground {
        Ground { height: self.height - origin.z, low: self.low - origin.truncate(), ..self.clone() }
    }
}

impl LatLong {
    /// The same image with the ground's picture beneath its rows, so that a backend has one image to look into.
    pub(super) fn with_ground(&self, ground: &Ground) -> LatLong {
        let edge = ground.edge as usize;
        let [wide, high] = self.sky.map(|n| n as usize);
        // One texel to spare: wide reads go past the last.
        let pitch = wide.max(edge + 1);
        let mut texels = Vec::with_capacity(pitch * (high + edge));
        let rows = self.texels.chunks(self.width as usize).take(high).map(|row| &row[..wide]);
        for row in rows.chain(ground.texels.chunks(edge)) {
            texels.extend(row);
            texels.resize(texels.len().next_multiple_of(pitch), [0.0; 3]);
        }
        LatLong { width: pitch as u32, height: (high + edge) as u32, sky: self.sky, texels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slope() -> Ground {
        let texels = (0..9).map(|k| [(k % 3) as f32, (k / 3) as f32, 1.0]).collect();
        Ground::new(-1.0, [-2.0, -2.0], 2.0, 3, texels).unwrap()
    }

    #[test]
    fn a_ray_sees_where_it_lands() {
        let ground = slope();
        assert_eq!(ground.rgb(DVec3::new(0.0, 0.0, 5.0), -DVec3::Z), [1.0, 1.0, 1.0]);
        assert_eq!(ground.rgb(DVec3::new(1.0, -1.0, 5.0), -DVec3::Z), [1.5, 0.5, 1.0]);
        // From 2 mm above, at 45° towards +x: 2 mm on.
        let slanting = DVec3::new(1.0, 0.0, -1.0).normalize();
        let [r, g, _] = ground.rgb(DVec3::new(-1.0, 1.0, 1.0), slanting);
        assert!((r - 1.5).abs() < 1e-12 && (g - 1.5).abs() < 1e-12, "{r} {g}");
        // Beyond the picture, and at the horizon.
        assert_eq!(ground.rgb(DVec3::new(99.0, -99.0, 0.0), -DVec3::Z), [2.0, 0.0, 1.0]);
        assert_eq!(ground.rgb(DVec3::ZERO, DVec3::new(1.0, 0.0, -1e-300)), [2.0, 1.0, 1.0]);
        let moved = ground.seen_from(DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(moved.rgb(DVec3::new(0.0, -3.0, 2.0), -DVec3::Z), [1.5, 0.5, 1.0]);
    }

    #[test]
    fn an_image_with_a_ground_shows_the_same_sky() {
        let texels = (0..8).map(|k| [k as f32, 1.0, 0.5]).collect();
        let (sky, _) = LatLong::new(4, 2, texels).unwrap();
        for edge in [2, 3, 9] {
            let ground =
                Ground::new(0.0, [0.0; 2], 1.0, edge, vec![[7.0; 3]; (edge * edge) as usize]).unwrap();
            let both = sky.with_ground(&ground);
            assert_eq!((both.width(), both.height(), both.sky()), (4.max(edge + 1), 2 + edge, [4, 2]));
            for k in 0..50 {
                let (u, v) = (f64::from(k) / 50.0, f64::from(k * 7 % 50) / 50.0);
                assert_eq!(both.bilinear(u, v), sky.bilinear(u, v));
            }
            assert_eq!(both.texels()[(2 * both.width()) as usize], [7.0; 3]);
        }
    }

    #[test]
    fn what_is_no_ground_is_refused() {
        assert!(Ground::new(f64::NAN, [0.0; 2], 1.0, 2, vec![[0.0; 3]; 4]).is_err());
        assert!(Ground::new(0.0, [0.0; 2], 0.0, 2, vec![[0.0; 3]; 4]).is_err());
        assert!(Ground::new(0.0, [0.0; 2], 1.0, 2, vec![[0.0; 3]; 3]).is_err());
        assert!(Ground::new(0.0, [0.0; 2], 1.0, 1, vec![[0.0; 3]; 1]).is_err());
        assert!(Ground::new(0.0, [0.0; 2], 1.0, 2, vec![[-1.0; 3]; 4]).is_err());
    }
}
