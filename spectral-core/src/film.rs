//! The accumulating picture: CIE XYZ, coverage and, on request, the radiance at every wavelength.

mod agreement;
mod convergence;
mod sums;

pub use agreement::Agreement;
pub use convergence::BLOCK;
pub use sums::PixelSums;

use crate::{Error, color::RgbSpace, memory};
use std::ops::Range;

/// One finished pixel sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelSample {
    /// CIE XYZ, relative: an environment of (1, 1, 1) under D65 has Y = 1.
    pub xyz: [f32; 3],
    /// 1 if the primary ray meets a stone, else 0; of an area the share that meets one. The mean is the coverage of the pixel.
    pub coverage: f32,
}

/// A rectangle of pixels.
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

/// Samples missing in all pixels of a rectangle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// The rectangle.
    pub tile: Tile,
    /// The samples; never empty.
    pub samples: Range<u32>,
}

impl Missing {
    /// The number of pixel samples.
    pub fn count(&self) -> u64 {
        u64::from(self.tile.width) * u64::from(self.tile.height) * self.samples.len() as u64
    }
}

/// The samples of a tile, row by row: the result of a worker.
#[derive(Debug, Clone, PartialEq)]
pub struct TileSums {
    /// The rectangle.
    pub tile: Tile,
    /// The samples of every pixel of the tile, pixel by pixel in order.
    pub samples: Vec<PixelSample>,
    /// Radiance, if the film keeps it: one value a wavelength for each entry of `samples`.
    pub radiance: Vec<f32>,
}

/// Accumulates pixel samples. Sums are in sample order, so the same samples give the same bits for any division into tiles
/// and calls.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    wavelengths: usize,
    xyz: Vec<[f32; 3]>,
    coverage: Vec<f32>,
    samples: Vec<u32>,
    radiance: Vec<f32>,
    convergence: convergence::Convergence,
}

impl Film {
    /// The longest edge, pixels.
    pub const MAX_EDGE: u32 = 65_536;
    /// The largest memory of a film, bytes (16 GiB).
    pub const MAX_BYTES: u64 = 16 << 30;

    /// An empty film of a size, for example for sums from a file; `wavelengths` is 0 unless it is spectral.
    ///
    /// # Errors
    /// As [`Film::check_size`], and [`Error::Memory`].
    pub fn with_size(width: u32, height: u32, wavelengths: usize) -> Result<Self, Error> {
        Film::check_size(width, height, wavelengths)?;
        Film::empty(width, height, wavelengths)
    }

    pub(crate) fn empty(width: u32, height: u32, wavelengths: usize) -> Result<Self, Error> {
        let bytes = u64::try_from(Film::bytes(width, height, wavelengths)).unwrap_or(u64::MAX);
        memory::check(bytes, || format!("a film of {width} × {height} pixels"))?;
        let pixels = width as usize * height as usize;
        Ok(Film {
            width,
            height,
            wavelengths,
            xyz: vec![[0.0; 3]; pixels],
            coverage: vec![0.0; pixels],
            samples: vec![0; pixels],
            radiance: vec![0.0; pixels * wavelengths],
            convergence: convergence::Convergence::new(width, height, BLOCK),
        })
    }

    /// Refuses a size that is zero or too large, with the memory needed.
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

    /// The memory of a film, bytes.
    pub fn bytes(width: u32, height: u32, wavelengths: usize) -> u128 {
        u128::from(width) * u128::from(height) * (32 + 4 * wavelengths as u128)
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Wavelengths kept for each pixel; 0 unless the film is spectral.
    pub fn wavelength_count(&self) -> usize {
        self.wavelengths
    }

    /// The whole film.
    pub fn tile(&self) -> Tile {
        Tile { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// The missing ones of `samples` in a tile, as rectangles of pixels that lack the same samples. A pixel with k samples
    /// lacks those from k on; a [settled](Film::settle) pixel lacks none. Usually all pixels have the same number of samples,
    /// and there is one rectangle. Cancelled calls and settled blocks lead to several. Panics for a tile outside the film.
    pub fn missing(&self, tile: Tile, samples: &Range<u32>) -> Vec<Missing> {
        let mut found: Vec<Missing> = Vec::new();
        // The rectangles that extend to the previous row.
        let mut band = 0..0;
        for y in tile.y..tile.y + tile.height {
            let row = self.missing_in_row(Tile { y, height: 1, ..tile }, samples);
            let alike = |(above, here): (&Missing, &Missing)| {
                let place = |missing: &Missing| (missing.tile.x, missing.tile.width);
                (place(above), &above.samples) == (place(here), &here.samples)
            };
            if band.len() == row.len() && found[band.clone()].iter().zip(&row).all(alike) {
                found[band.clone()].iter_mut().for_each(|missing| missing.tile.height += 1);
            } else {
                band = found.len()..found.len() + row.len();
                found.extend(row);
            }
        }
        found
    }

    fn missing_in_row(&self, row: Tile, samples: &Range<u32>) -> Vec<Missing> {
        let first = self.index(row.x, row.y);
        let mut found: Vec<Missing> = Vec::new();
        let settled = self.convergence.settled_in_row(row);
        for ((x, has), settled) in
            (row.x..).zip(&self.samples[first..first + row.width as usize]).zip(settled)
        {
            let lacking = samples.start.max(*has)..samples.end;
            if settled || lacking.is_empty() {
                continue;
            }
            match found.last_mut() {
                Some(last) if last.tile.x + last.tile.width == x && last.samples == lacking => {
                    last.tile.width += 1;
                }
                _ => found.push(Missing { tile: Tile { x, width: 1, ..row }, samples: lacking }),
            }
        }
        found
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
            let expected = "a tile of this film, with as many wavelengths";
            return Err(Error::value("tile", format!("{t:?}"), expected));
        }
        for (k, samples) in sums.samples.chunks_exact(count.max(1)).enumerate() {
            let (dx, dy) = (k as u32 % t.width, k as u32 / t.width);
            let pixel = self.index(t.x + dx, t.y + dy);
            let first = k * count * self.wavelengths;
            self.add_pixel(pixel, samples, &sums.radiance[first..first + count * self.wavelengths]);
        }
        Ok(())
    }

    // The first samples are stored without reading the sums. Reading a fresh page would map the shared zero page, and the
    // write would then have to replace this mapping in every thread.
    fn add_pixel(&mut self, pixel: usize, samples: &[PixelSample], radiance: &[f32]) {
        let fresh = self.samples[pixel] == 0;
        let (mut xyz, mut coverage) =
            if fresh { ([0.0; 3], 0.0) } else { (self.xyz[pixel], self.coverage[pixel]) };
        for sample in samples {
            xyz.iter_mut().zip(sample.xyz).for_each(|(sum, value)| *sum += value);
            coverage += sample.coverage;
        }
        (self.xyz[pixel], self.coverage[pixel]) = (xyz, coverage);
        if self.wavelengths > 0 {
            let kept = &mut self.radiance[pixel * self.wavelengths..][..self.wavelengths];
            if fresh {
                kept.fill(0.0);
            }
            for new in radiance.chunks_exact(self.wavelengths) {
                kept.iter_mut().zip(new).for_each(|(sum, value)| *sum += value);
            }
        }
        self.samples[pixel] += samples.len() as u32;
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// The number of samples of a pixel; (0, 0) is top left. Panics outside the film.
    pub fn samples(&self, x: u32, y: u32) -> u32 {
        self.samples[self.index(x, y)]
    }

    /// Whether every pixel has at least `samples` samples, or is settled with fewer.
    pub fn is_complete(&self, samples: u32) -> bool {
        self.missing(self.tile(), &(0..samples)).is_empty()
    }

    /// The number of samples of all pixels together.
    pub fn total_samples(&self) -> u64 {
        self.samples.iter().map(|&n| u64::from(n)).sum()
    }

    /// Settles blocks of `block` × `block` pixels that need no more than `samples` samples:
    /// [`missing`](Film::missing) then omits them. Of one film, `block` is always the same
    /// ([`RenderSettings::block`](crate::settings::RenderSettings::block)). A block is settled if the colours of its pixels differ from those at the
    /// last check by at most `tolerance`, ΔE00 in the root mean square; so the first check settles nothing. If each check
    /// has three times the samples of the last, the remaining error is below this difference. The decision depends on the
    /// samples of the block alone, so it does not matter which machine renders its neighbours.
    ///
    /// Must be called when the film has reached `samples`. A film that was checked there or later does not change, so a
    /// continued render decides as before.
    pub fn settle(&mut self, samples: u32, tolerance: f64, block: u32) {
        let Film { width, height, xyz, samples: counts, convergence, .. } = self;
        if convergence.block() != block {
            *convergence = convergence::Convergence::new(*width, *height, block);
        }
        convergence.settle(samples, tolerance, |i| xyz[i].map(|v| v * inverse(counts[i])));
    }

    /// The change of the picture at the last two [checks](Film::settle), ΔE00 in the root mean square over all blocks,
    /// each with its change when it was last looked at; `None` before the second.
    pub fn change(&self) -> Option<f64> {
        self.convergence.mean_change()
    }

    /// Mean CIE XYZ of a pixel; 0 without samples. Panics outside the film.
    pub fn xyz(&self, x: u32, y: u32) -> [f32; 3] {
        let i = self.index(x, y);
        let scale = inverse(self.samples[i]);
        self.xyz[i].map(|v| v * scale)
    }

    /// The share of a pixel's samples, or of its area, that meets a stone. Panics outside the film.
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

    /// [`radiance`](Self::radiance) of all pixels, row by row, one value a wavelength each.
    pub fn spectra(&self) -> Vec<f32> {
        let scales = self.samples.iter().map(|&samples| inverse(samples));
        // No chunks where the film keeps no spectra.
        let pixels = self.radiance.chunks_exact(self.wavelengths.max(1));
        pixels.zip(scales).flat_map(|(sums, scale)| sums.iter().map(move |sum| sum * scale)).collect()
    }

    /// The number of samples of all pixels, row by row.
    pub fn counts(&self) -> &[u32] {
        &self.samples
    }

    /// All pixels in a colour space, row by row: linear, with negative components for colours outside the space, and coverage
    /// as the fourth channel.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn film(width: u32, height: u32) -> Film {
        Film::empty(width, height, 0).expect("a small film")
    }

    fn add(film: &mut Film, [x, y, width, height]: [u32; 4], count: usize) {
        let samples = vec![PixelSample::default(); (width * height) as usize * count];
        let sums = TileSums { tile: Tile { x, y, width, height }, samples, radiance: Vec::new() };
        film.add(&sums).expect("a tile of the film");
    }

    #[test]
    fn a_uniform_film_lacks_one_rectangle() {
        let mut film = film(7, 5);
        assert_eq!(film.missing(film.tile(), &(0..4)), [Missing { tile: film.tile(), samples: 0..4 }]);
        add(&mut film, [0, 0, 7, 5], 3);
        assert_eq!(film.missing(film.tile(), &(0..4)), [Missing { tile: film.tile(), samples: 3..4 }]);
        assert_eq!(film.missing(film.tile(), &(0..3)), []);
        assert_eq!(film.missing(film.tile(), &(2..2)), []);
    }

    #[test]
    fn every_pixel_is_completed_once() {
        let mut film = film(23, 17);
        let tiles = [[0, 0, 23, 4], [3, 2, 9, 9], [20, 10, 3, 7], [0, 16, 1, 1], [5, 5, 1, 1]];
        tiles.into_iter().zip([2, 1, 5, 9, 2]).for_each(|(tile, count)| add(&mut film, tile, count));
        let before = film.samples.clone();
        let tile = Tile { x: 1, y: 1, width: 21, height: 16 };
        let missing = film.missing(tile, &(1..6));
        let total: u64 = missing.iter().map(Missing::count).sum();
        for piece in &missing {
            let t = piece.tile;
            for (x, y) in (t.y..t.y + t.height).flat_map(|y| (t.x..t.x + t.width).map(move |x| (x, y))) {
                assert_eq!(piece.samples, film.samples(x, y).max(1)..6, "{x}, {y}");
            }
            add(&mut film, [t.x, t.y, t.width, t.height], piece.samples.len());
        }
        assert!(total > 0 && film.missing(tile, &(1..6)).iter().all(|piece| piece.samples.start == 5));
        for (i, (&before, &after)) in before.iter().zip(&film.samples).enumerate() {
            let (x, y) = (i as u32 % 23, i as u32 / 23);
            let inside = (1..22).contains(&x) && (1..17).contains(&y);
            // Samples before the requested ones are not added.
            let wanted = if inside && before < 6 { before + 6 - before.max(1) } else { before };
            assert_eq!(after, wanted, "{x}, {y}");
        }
    }
}
