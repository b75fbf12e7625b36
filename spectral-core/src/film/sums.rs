//! The sums of a film, pixel by pixel, for the exchange between machines.

use super::Film;
use crate::Error;

/// The sums of a pixel's samples, without radiance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelSums {
    /// CIE XYZ, the sum over all samples.
    pub xyz: [f32; 3],
    /// The number of samples that meet a stone; of areas, the sum of their shares.
    pub coverage: f32,
    /// The number of samples.
    pub samples: u32,
}

impl Film {
    /// The sums of a pixel. Panics outside the film.
    ///
    /// ```
    /// use spectral_core::film::{Film, PixelSums};
    /// let mut film = Film::with_size(2, 1, 0)?;
    /// let sums = PixelSums { xyz: [0.5, 1.0, 0.25], coverage: 1.0, samples: 2 };
    /// film.set_sums(1, 0, sums, &[])?;
    /// assert_eq!((film.sums(1, 0), film.sums(0, 0)), (sums, PixelSums::default()));
    /// assert_eq!(film.xyz(1, 0), [0.25, 0.5, 0.125]);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    pub fn sums(&self, x: u32, y: u32) -> PixelSums {
        let i = self.index(x, y);
        PixelSums { xyz: self.xyz[i], coverage: self.coverage[i], samples: self.samples[i] }
    }

    /// The sums of a pixel's radiance, one a wavelength; empty unless the film is spectral. Panics outside the film.
    pub fn radiance_sums(&self, x: u32, y: u32) -> &[f32] {
        let i = self.index(x, y);
        &self.radiance[i * self.wavelengths..(i + 1) * self.wavelengths]
    }

    /// Replaces the sums of a pixel. [`Tracer::trace`](crate::tracer::Tracer::trace) skips a pixel whose sums claim all
    /// samples; so a machine can render a part of a picture. Panics outside the film.
    ///
    /// # Errors
    /// [`Error::Value`] for radiance of another number of wavelengths than the film keeps.
    pub fn set_sums(&mut self, x: u32, y: u32, sums: PixelSums, radiance: &[f32]) -> Result<(), Error> {
        if radiance.len() != self.wavelengths {
            let expected = format!("{} wavelengths", self.wavelengths);
            return Err(Error::value("radiance", radiance.len(), expected));
        }
        let i = self.index(x, y);
        (self.xyz[i], self.coverage[i], self.samples[i]) = (sums.xyz, sums.coverage, sums.samples);
        self.radiance[i * self.wavelengths..(i + 1) * self.wavelengths].copy_from_slice(radiance);
        Ok(())
    }

    /// The sums of pixels, numbered row by row: XYZ and coverage, and their radiances, wavelengths innermost. Panics
    /// outside the film.
    pub fn carried(&self, pixels: &[u32]) -> (Vec<[f32; 4]>, Vec<f32>) {
        let sums = pixels.iter().map(|&i| {
            let ([x, y, z], coverage) = (self.xyz[i as usize], self.coverage[i as usize]);
            [x, y, z, coverage]
        });
        let radiances =
            pixels.iter().flat_map(|&i| &self.radiance[i as usize * self.wavelengths..][..self.wavelengths]);
        (sums.collect(), radiances.copied().collect())
    }

    /// Puts sums in place of those of pixels, each with `count` samples more; shapes as those of
    /// [`carried`](Self::carried). Panics outside the film.
    ///
    /// ```
    /// use spectral_core::film::Film;
    /// let mut film = Film::with_size(2, 1, 0)?;
    /// film.carry(&[1], 2, &[[0.5, 1.0, 0.25, 1.0]], &[])?;
    /// assert_eq!((film.xyz(1, 0), film.samples(1, 0), film.samples(0, 0)), ([0.25, 0.5, 0.125], 2, 0));
    /// assert_eq!(film.carried(&[1]).0, [[0.5, 1.0, 0.25, 1.0]]);
    /// # Ok::<(), spectral_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Value`] for sums of another shape.
    pub fn carry(
        &mut self,
        pixels: &[u32],
        count: u32,
        sums: &[[f32; 4]],
        radiances: &[f32],
    ) -> Result<(), Error> {
        if sums.len() != pixels.len() || radiances.len() != pixels.len() * self.wavelengths {
            let expected = format!("those of {} pixels with {} wavelengths", pixels.len(), self.wavelengths);
            return Err(Error::value("sums", format!("{} and {}", sums.len(), radiances.len()), expected));
        }
        for (&i, &[x, y, z, coverage]) in pixels.iter().zip(sums) {
            let i = i as usize;
            (self.xyz[i], self.coverage[i]) = ([x, y, z], coverage);
            self.samples[i] += count;
        }
        if self.wavelengths > 0 {
            for (&i, radiances) in pixels.iter().zip(radiances.chunks_exact(self.wavelengths)) {
                self.radiance[i as usize * self.wavelengths..][..self.wavelengths].copy_from_slice(radiances);
            }
        }
        Ok(())
    }
}
