//! Writes the scenes that `scripts/memory.sh` measures: a closed mesh of many triangles, a large environment, and both.
//!
//!     cargo run --release -p gemtrace --example large_scene -- FOLDER [TRIANGLES [WIDTH]]
//!
//! The mesh is a globe of `TRIANGLES` triangles, round (`round.ply`) and with hills (`hills.ply`, and `hills.stl`, where
//! each corner is written out); the environment is a sky of `WIDTH × WIDTH/2` texels with lamps in it (`sky.exr` in half
//! floats, `sky.hdr`). Everything is written as it is computed, so that the files may be larger than the memory.

use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage, f16};
use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, rest @ ..] = arguments.as_slice() else {
        return Err("give a folder, and optionally the numbers of triangles and of texels across".into());
    };
    let number = |at: usize, otherwise| rest.get(at).map_or(Ok(otherwise), |text| text.parse::<usize>());
    let (triangles, width) = (number(0, 10_000_000)?.max(64), number(1, 16_384)?.max(8));
    let folder = Path::new(folder);
    std::fs::create_dir_all(folder)?;
    for (name, height) in [("round", 0.0), ("hills", 0.08)] {
        Globe::new(triangles, height).write_ply(create(folder, &format!("{name}.ply"))?)?;
    }
    Globe::new(triangles, 0.08).write_stl(create(folder, "hills.stl")?)?;
    let sky = Sky { width, height: width / 2 };
    sky.write_exr(&folder.join("sky.exr"))?;
    sky.write_hdr(create(folder, "sky.hdr")?)?;
    let small = "uniform = [0.6, 0.7, 0.8]";
    let glass = "[[stone]]\nshape = \"round-brilliant\"\nwidth = 2.0\nmaterial = \"diamond\"\n";
    let stone = |file: &str| format!("[[stone]]\nmesh = \"{file}\"\nmaterial = \"diamond\"\n");
    for (name, light, stone) in [
        ("round", small, stone("round.ply")),
        ("hills", small, stone("hills.ply")),
        ("stl", small, stone("hills.stl")),
        ("exr", "image = \"sky.exr\"", glass.into()),
        ("hdr", "image = \"sky.hdr\"", glass.into()),
        ("both", "image = \"sky.exr\"", stone("hills.ply")),
        ("both-stl", "image = \"sky.hdr\"", stone("hills.stl")),
    ] {
        let scene = format!(
            "format = 1\n[camera]\nposition = [0.0, -8.0, 3.0]\nlook_at = [0.0, 0.0, 0.0]\nfov = 20.0\n\
             [film]\nwidth = 64\nheight = 64\n[environment]\n{light}\n{stone}\
             [render]\nsamples = 1\nwavelengths = {{ count = 4 }}\nmax_depth = 8\n"
        );
        std::fs::write(folder.join(format!("{name}.toml")), scene)?;
    }
    Ok(())
}

fn create(folder: &Path, name: &str) -> std::io::Result<BufWriter<File>> {
    File::create(folder.join(name)).map(BufWriter::new)
}

/// A sphere of radius 1 in rings of latitude, with hills on it.
struct Globe {
    /// Vertices on a ring.
    around: u32,
    /// Rings between the poles.
    rings: u32,
    /// Of the hills, as a share of the radius.
    height: f64,
}

impl Globe {
    /// About `triangles` triangles, `2 · around · rings`, twice as many around as from pole to pole.
    fn new(triangles: usize, height: f64) -> Self {
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

    fn write_ply(&self, mut file: impl Write) -> std::io::Result<()> {
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

    fn write_stl(&self, mut file: impl Write) -> std::io::Result<()> {
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

/// A smooth sky with square lamps.
struct Sky {
    width: usize,
    height: usize,
}

impl Sky {
    fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        let (u, v) = (x as f32 / self.width as f32, y as f32 / self.height as f32);
        let lamp = (u * 8.0).fract() < 0.125 && (v * 6.0).fract() < 0.125;
        if lamp { [40.0, 36.0, 30.0] } else { [0.3 + 0.3 * v, 0.4 + 0.2 * v, 0.6 - 0.2 * (u - 0.5).abs()] }
    }

    fn write_exr(&self, path: &Path) -> exr::error::UnitResult {
        let channels = SpecificChannels::rgb(|Vec2(x, y)| {
            let [r, g, b] = self.texel(x, y).map(f16::from_f32);
            (r, g, b)
        });
        let attributes = LayerAttributes::default();
        let layer =
            Layer::new((self.width, self.height), attributes, Encoding::SMALL_FAST_LOSSLESS, channels);
        Image::from_layer(layer).write().non_parallel().to_file(path)
    }

    /// Scan lines of literal runs: the largest that the format makes them.
    fn write_hdr(&self, mut file: impl Write) -> std::io::Result<()> {
        write!(file, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", self.height, self.width)?;
        let mut line = vec![[0_u8; 4]; self.width];
        for y in 0..self.height {
            for (x, slot) in line.iter_mut().enumerate() {
                *slot = rgbe(self.texel(x, y));
            }
            file.write_all(&[2, 2, (self.width >> 8) as u8, self.width as u8])?;
            for component in 0..4 {
                for run in line.chunks(128) {
                    file.write_all(&[run.len() as u8])?;
                    run.iter().try_for_each(|texel| file.write_all(&[texel[component]]))?;
                }
            }
        }
        file.flush()
    }
}

/// Three mantissas and their common exponent (Ward, "Real pixels", Graphics Gems II).
fn rgbe(texel: [f32; 3]) -> [u8; 4] {
    let exponent = texel.iter().fold(0.0, |most: f32, c| most.max(*c)).log2().floor() + 1.0;
    let [r, g, b] = texel.map(|c| (c / exponent.exp2() * 256.0) as u8);
    [r, g, b, (exponent + 128.0) as u8]
}
