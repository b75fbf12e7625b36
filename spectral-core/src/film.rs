//! The picture as it grows: CIE XYZ, coverage and, if asked for, the radiance of every wavelength.

mod agreement;

pub use agreement::Agreement;

use crate::{Error, color::RgbSpace, prepare::PreparedScene};

/// One finished pixel sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelSample {
    /// CIE XYZ, relative: an environment of (1, 1, 1) under D65 has Y = 1.
    pub xyz: [f32; 3],
    /// 1 where the primary ray meets a stone, else 0; the film's mean is the pixel's coverage.
    pub coverage: f32,
}

/// A rectangle of pixels, for handing out work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tile {
    /// Left column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// The sums of some samples over a tile, row by row; what a worker hands back.
#[derive(Debug, Clone, PartialEq)]
pub struct TileSums {
    /// Where in the film.
    pub tile: Tile,
    /// Samples of every pixel of the tile, pixel by pixel, each pixel's samples in order.
    pub samples: Vec<PixelSample>,
    /// Radiance, if the film keeps it: for each entry of `samples`, one value a wavelength.
    pub radiance: Vec<f32>,
}

/// Accumulates pixel samples. Sums run in sample order, so the same samples give the same bits however
/// they were split into tiles and calls.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    wavelengths: usize,
    xyz: Vec<[f32; 3]>,
    coverage: Vec<f32>,
    samples: Vec<u32>,
    radiance: Vec<f32>,
}

impl Film {
    /// The longest edge accepted, pixels.
    pub const MAX_EDGE: u32 = 65_536;
    /// The most memory that a film may take, bytes (16 GiB).
    pub const MAX_BYTES: u64 = 16 << 30;

    /// An empty film for a prepared scene.
    pub fn new(scene: &PreparedScene) -> Self {
        let wavelengths = if scene.settings.spectral { scene.wavelength_count() } else { 0 };
        let pixels = scene.width as usize * scene.height as usize;
        Film {
            width: scene.width,
            height: scene.height,
            wavelengths,
            xyz: vec![[0.0; 3]; pixels],
            coverage: vec![0.0; pixels],
            samples: vec![0; pixels],
            radiance: vec![0.0; pixels * wavelengths],
        }
    }

    /// Refuses a size that is zero or absurd, naming the memory it would need.
    ///
    /// # Errors
    /// [`Error::Value`].
    pub fn check_size(width: u32, height: u32, wavelengths: usize) -> Result<(), Error> {
        let size = format!("{width} × {height}");
        if width == 0 || height == 0 {
            return Err(Error::value("film size", size, "at least 1 × 1 pixels"));
        }
        let bytes = Self::bytes(width, height, wavelengths);
        if width > Self::MAX_EDGE || height > Self::MAX_EDGE || bytes > u128::from(Self::MAX_BYTES) {
            let need = bytes as f64 / f64::from(1 << 30);
            let expected = format!(
                "it would need {need:.1} GiB; at most {} pixels an edge and {} GiB are accepted",
                Self::MAX_EDGE,
                Self::MAX_BYTES >> 30
            );
            return Err(Error::value("film size", size, expected));
        }
        Ok(())
    }

    /// The memory that a film takes, bytes.
    pub fn bytes(width: u32, height: u32, wavelengths: usize) -> u128 {
        u128::from(width) * u128::from(height) * (20 + 4 * wavelengths as u128)
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Wavelengths kept a pixel; 0 unless the render is spectral.
    pub fn wavelength_count(&self) -> usize {
        self.wavelengths
    }

    /// Adds a tile's samples.
    ///
    /// # Errors
    /// [`Error::Value`] for a tile outside the film or sums of another shape.
    pub fn add(&mut self, sums: &TileSums) -> Result<(), Error> {
        let t = sums.tile;
        let pixels = t.width as usize * t.height as usize;
        let inside = u64::from(t.x) + u64::from(t.width) <= u64::from(self.width)
            && u64::from(t.y) + u64::from(t.height) <= u64::from(self.height);
        let count = sums.samples.len().checked_div(pixels).unwrap_or(0);
        if !inside
            || count * pixels != sums.samples.len()
            || sums.radiance.len() != sums.samples.len() * self.wavelengths
        {
            return Err(Error::value(
                "tile",
                format!("{t:?}"),
                "a tile of this film, with as many wavelengths",
            ));
        }
        for (k, samples) in sums.samples.chunks_exact(count.max(1)).enumerate() {
            let (dx, dy) = (k as u32 % t.width, k as u32 / t.width);
            let pixel = self.index(t.x + dx, t.y + dy);
            let first = k * count * self.wavelengths;
            self.add_pixel(pixel, samples, &sums.radiance[first..first + count * self.wavelengths]);
        }
        Ok(())
    }

    fn add_pixel(&mut self, pixel: usize, samples: &[PixelSample], radiance: &[f32]) {
        for (s, sample) in samples.iter().enumerate() {
            for c in 0..3 {
                self.xyz[pixel][c] += sample.xyz[c];
            }
            self.coverage[pixel] += sample.coverage;
            let kept = &mut self.radiance[pixel * self.wavelengths..(pixel + 1) * self.wavelengths];
            let new = &radiance[s * self.wavelengths..(s + 1) * self.wavelengths];
            kept.iter_mut().zip(new).for_each(|(sum, value)| *sum += value);
        }
        self.samples[pixel] += samples.len() as u32;
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// Samples that a pixel has; (0, 0) is top left. Panics outside the film.
    pub fn samples(&self, x: u32, y: u32) -> u32 {
        self.samples[self.index(x, y)]
    }

    /// Whether every pixel has at least `samples` samples.
    pub fn is_complete(&self, samples: u32) -> bool {
        self.samples.iter().all(|&n| n >= samples)
    }

    /// Mean CIE XYZ of a pixel; 0 where it has no sample. Panics outside the film.
    pub fn xyz(&self, x: u32, y: u32) -> [f32; 3] {
        let i = self.index(x, y);
        let scale = inverse(self.samples[i]);
        self.xyz[i].map(|v| v * scale)
    }

    /// The share of a pixel's samples that met a stone. Panics outside the film.
    pub fn coverage(&self, x: u32, y: u32) -> f32 {
        let i = self.index(x, y);
        self.coverage[i] * inverse(self.samples[i])
    }

    /// Mean spectral radiance of a pixel, one value a wavelength; empty unless the film is spectral.
    /// Panics outside the film.
    pub fn radiance(&self, x: u32, y: u32) -> Vec<f32> {
        let i = self.index(x, y);
        let scale = inverse(self.samples[i]);
        self.radiance[i * self.wavelengths..(i + 1) * self.wavelengths].iter().map(|v| v * scale).collect()
    }

    /// All pixels in a colour space, row by row: linear, unclamped (negative values are real colours
    /// outside the space), coverage as the fourth channel.
    pub fn to_space(&self, space: RgbSpace) -> Vec<[f32; 4]> {
        let matrix = space.from_xyz();
        (0..self.xyz.len())
            .map(|i| {
                let scale = f64::from(inverse(self.samples[i]));
                let xyz = self.xyz[i].map(|v| f64::from(v) * scale);
                let [r, g, b] =
                    matrix.map(|row| (row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2]) as f32);
                [r, g, b, self.coverage[i] * scale as f32]
            })
            .collect()
    }
}

fn inverse(samples: u32) -> f32 {
    if samples == 0 { 0.0 } else { 1.0 / samples as f32 }
}
