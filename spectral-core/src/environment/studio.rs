//! The built-in studio, drawn rather than photographed.

use super::LatLong;
use std::f64::consts::{PI, TAU};

const WIDTH: u32 = 512;
const HEIGHT: u32 = 256;

/// A soft box: centre and half-extents in degrees of azimuth and elevation, with a smooth border.
struct SoftBox {
    azimuth: f64,
    elevation: f64,
    half: [f64; 2],
    /// Linear sRGB; the boxes differ a little in colour temperature, as real ones do.
    radiance: [f64; 3],
}

const BORDER: f64 = 2.5;

const BOXES: [SoftBox; 7] = [
    SoftBox { azimuth: 20.0, elevation: 52.0, half: [22.0, 14.0], radiance: [7.0, 7.0, 7.0] },
    SoftBox { azimuth: 140.0, elevation: 38.0, half: [9.0, 22.0], radiance: [5.6, 5.2, 4.6] },
    SoftBox { azimuth: 205.0, elevation: 60.0, half: [14.0, 10.0], radiance: [4.6, 5.0, 5.6] },
    SoftBox { azimuth: 275.0, elevation: 30.0, half: [8.0, 24.0], radiance: [6.0, 6.0, 6.2] },
    SoftBox { azimuth: 85.0, elevation: 22.0, half: [5.0, 12.0], radiance: [9.0, 8.6, 8.0] },
    SoftBox { azimuth: 325.0, elevation: 12.0, half: [16.0, 4.0], radiance: [3.0, 3.0, 3.2] },
    SoftBox { azimuth: 180.0, elevation: 8.0, half: [24.0, 3.0], radiance: [2.4, 2.4, 2.4] },
];

pub(super) fn image() -> LatLong {
    let mut texels = Vec::with_capacity((WIDTH * HEIGHT) as usize);
    for j in 0..HEIGHT {
        let elevation = 90.0 - 180.0 * (f64::from(j) + 0.5) / f64::from(HEIGHT);
        for i in 0..WIDTH {
            let azimuth = 360.0 * (f64::from(i) + 0.5) / f64::from(WIDTH);
            texels.push(radiance(azimuth, elevation).map(|c| c as f32));
        }
    }
    LatLong { width: WIDTH, height: HEIGHT, sky: [WIDTH, HEIGHT], texels }
}

fn radiance(azimuth: f64, elevation: f64) -> [f64; 3] {
    // Walls brighten towards the ceiling; the floor is a dark table top.
    let wall = if elevation >= 0.0 { 0.10 + 0.35 * (elevation / 180.0 * PI).sin() } else { 0.06 };
    let mut sum = [wall; 3];
    let overhead = smooth(18.0 - (90.0 - elevation)) * 3.0;
    for (c, value) in sum.iter_mut().enumerate() {
        *value +=
            overhead + BOXES.iter().map(|b| b.coverage(azimuth, elevation) * b.radiance[c]).sum::<f64>();
    }
    sum
}

impl SoftBox {
    fn coverage(&self, azimuth: f64, elevation: f64) -> f64 {
        let turn = (azimuth - self.azimuth).to_radians().rem_euclid(TAU);
        let across = turn.min(TAU - turn).to_degrees();
        smooth(self.half[0] - across) * smooth(self.half[1] - (elevation - self.elevation).abs())
    }
}

/// 0 outside, 1 inside, cubic over the border; `inside` in degrees from the edge.
fn smooth(inside: f64) -> f64 {
    let t = (inside / BORDER + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
