//! A closed mesh of any number of triangles, written as it is computed.

use std::f64::consts::{PI, TAU};
use std::io::Write;

/// A sphere of radius 1 in rings of latitude, with hills on it.
pub struct Globe {
    /// Vertices on a ring.
    around: u32,
    /// Rings between the poles.
    rings: u32,
    /// Of the hills, as a share of the radius.
    height: f64,
}

impl Globe {
    /// About `triangles` triangles, `2 · around · rings`, twice as many around as from pole to pole.
    pub fn new(triangles: usize, height: f64) -> Self {
        let rings = (triangles as f64 / 4.0).sqrt().round() as u32;
        Globe { around: 2 * rings, rings, height }
    }

    fn vertex_count(&self) -> u32 {
        self.around * self.rings + 2
    }

    fn triangle_count(&self) -> u32 {
        2 * self.around * self.rings
    }

    /// The north pole, the rings southwards, the south pole.
    fn vertex(&self, index: u32) -> [f32; 3] {
        let (ring, place) = match index {
            0 => (0, 0),
            last if last == self.vertex_count() - 1 => (self.rings + 1, 0),
            other => (1 + (other - 1) / self.around, (other - 1) % self.around),
        };
        let polar = PI * f64::from(ring) / f64::from(self.rings + 1);
        let azimuth = TAU * f64::from(place) / f64::from(self.around);
        let hills = (9.0 * azimuth).sin() * (11.0 * polar).sin() * polar.sin();
        let radius = 1.0 + self.height * hills;
        let across = radius * polar.sin();
        [across * azimuth.cos(), across * azimuth.sin(), radius * polar.cos()].map(|c| c as f32)
    }

    /// Counter-clockwise seen from outside.
    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        let (around, rings, last) = (self.around, self.rings, self.vertex_count() - 1);
        let at = move |ring: u32, place: u32| 1 + ring * around + place % around;
        (0..=rings).flat_map(move |band| {
            (0..around).flat_map(move |place| {
                let cap = |pole: u32, a: u32, b: u32| [Some([pole, a, b]), None];
                let pair = match band {
                    0 => cap(0, at(0, place), at(0, place + 1)),
                    south if south == rings => cap(last, at(rings - 1, place + 1), at(rings - 1, place)),
                    band => {
                        let [a, b] = [at(band - 1, place), at(band - 1, place + 1)];
                        let [c, d] = [at(band, place), at(band, place + 1)];
                        [Some([a, c, d]), Some([a, d, b])]
                    }
                };
                pair.into_iter().flatten()
            })
        })
    }

    pub fn write_ply(&self, mut file: impl Write) -> std::io::Result<()> {
        let (vertices, faces) = (self.vertex_count(), self.triangle_count());
        write!(
            file,
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
             property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )?;
        for index in 0..vertices {
            self.vertex(index).iter().try_for_each(|c| file.write_all(&c.to_le_bytes()))?;
        }
        for triangle in self.triangles() {
            file.write_all(&[3])?;
            triangle.iter().try_for_each(|v| file.write_all(&v.to_le_bytes()))?;
        }
        file.flush()
    }

    pub fn write_stl(&self, mut file: impl Write) -> std::io::Result<()> {
        file.write_all(&[b' '; 80])?;
        file.write_all(&self.triangle_count().to_le_bytes())?;
        for triangle in self.triangles() {
            // Readers compute the normal.
            file.write_all(&[0; 12])?;
            for corner in triangle.map(|v| self.vertex(v)) {
                corner.iter().try_for_each(|c| file.write_all(&c.to_le_bytes()))?;
            }
            file.write_all(&[0; 2])?;
        }
        file.flush()
    }
}
