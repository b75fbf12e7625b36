//! A light model drawn as an image.

use super::{LatLong, LightModel};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Columns of an image whose rows are uniform: enough for the wide reads of a backend.
const COLUMNS: u32 = 8;
const WIDTH: u32 = 2048;
const HEIGHT: u32 = 1024;
/// Points along the edge of a texel in which the light changes.
const FINE: u32 = 12;
/// Texels whose corners and centre differ by more than this are sampled again, finely.
const CHANGE: f64 = 0.02;

/// Rows of uniform texels, each with the mean over its ring.
pub(super) fn zones(model: &LightModel) -> LatLong {
    let rows = LightModel::ROWS;
    let mut edges: Vec<f64> = model.edges().map(f64::to_radians).collect();
    edges.sort_by(f64::total_cmp);
    let step = PI / f64::from(rows);
    let texels = (0..rows)
        .flat_map(|row| {
            let (top, bottom) = (f64::from(row) * step, f64::from(row + 1) * step);
            [zone(model, top, bottom, &edges).map(|c| c as f32); COLUMNS as usize]
        })
        .collect();
    LatLong { width: COLUMNS, height: rows, sky: [COLUMNS, rows], texels }
}

/// The mean over a ring between two angles from +z, piece by piece between the edges in it: Gauss's rule of two points
/// in cos θ, in which equal steps are equal areas.
fn zone(model: &LightModel, top: f64, bottom: f64, edges: &[f64]) -> [f64; 3] {
    let inner = edges.iter().copied().filter(|edge| *edge > top && *edge < bottom);
    let bounds: Vec<f64> = [top].into_iter().chain(inner).chain([bottom]).map(f64::cos).collect();
    let whole = bounds[0] - bounds[bounds.len() - 1];
    let mut mean = [0.0; 3];
    for pair in bounds.windows(2) {
        let (middle, half) = ((pair[0] + pair[1]) / 2.0, (pair[0] - pair[1]) / 2.0);
        for point in [-1.0, 1.0] {
            let z = middle + point * half / 3.0_f64.sqrt();
            let rgb = model.rgb(DVec3::new((1.0 - z * z).max(0.0).sqrt(), 0.0, z));
            mean.iter_mut().zip(rgb).for_each(|(sum, c)| *sum += c * half / whole);
        }
    }
    mean
}

/// An image of texels, each with the mean over its area where the light changes in it, else with its centre's colour.
pub(super) fn texels(model: &LightModel) -> LatLong {
    let spots = model.pattern.spots();
    let at = |x: f64, y: f64| {
        let (sin, cos) = (PI * y / f64::from(HEIGHT)).sin_cos();
        let (across, along) = (TAU * x / f64::from(WIDTH)).sin_cos();
        model.rgb_among(DVec3::new(sin * across, sin * along, cos), &spots)
    };
    let corners = |row: u32| -> Vec<[f64; 3]> {
        (0..=WIDTH).map(|column| at(f64::from(column), f64::from(row))).collect()
    };
    let mut above = corners(0);
    let mut texels = Vec::with_capacity((WIDTH * HEIGHT) as usize);
    for row in 0..HEIGHT {
        let below = corners(row + 1);
        for column in 0..WIDTH {
            let [x, y] = [f64::from(column), f64::from(row)];
            let centre = at(x + 0.5, y + 0.5);
            let i = column as usize;
            let differs = |corner: &[f64; 3]| (0..3).any(|c| (corner[c] - centre[c]).abs() > CHANGE);
            let changes = above[i..i + 2].iter().chain(&below[i..i + 2]).any(differs);
            let rgb = if changes { mean(x, y, &at) } else { centre };
            texels.push(rgb.map(|c| c as f32));
        }
        above = below;
    }
    LatLong { width: WIDTH, height: HEIGHT, sky: [WIDTH, HEIGHT], texels }
}

/// The mean over the texel whose top left corner is (x, y), each of its points with the area that it stands for.
fn mean(x: f64, y: f64, at: &impl Fn(f64, f64) -> [f64; 3]) -> [f64; 3] {
    let place = |k: u32| (f64::from(k) + 0.5) / f64::from(FINE);
    let (mut sum, mut whole) = ([0.0; 3], 0.0);
    for j in 0..FINE {
        let area = (PI * (y + place(j)) / f64::from(HEIGHT)).sin();
        for i in 0..FINE {
            let rgb = at(x + place(i), y + place(j));
            sum.iter_mut().zip(rgb).for_each(|(s, c)| *s += area * c);
            whole += area;
        }
    }
    sum.map(|s| s / whole)
}
