//! A rendered picture with all that its files need.

#[cfg(feature = "formats")]
use super::exr;
use super::{Depth, Format, Provenance, Target, file, png};
use crate::Error;
use crate::scene_file::LoadedScene;
use rayon::prelude::*;
use spectral_core::color::{RgbSpace, Tone, ViewTransform, matrix};
use spectral_core::film::Film;
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Background;
use spectral_core::tracer::{DeviceInfo, TraceReport};
use std::fs::File;
use std::path::PathBuf;

/// How a picture is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The colour space of the EXR's RGB, and of the PNG where PNG has a name for it (see [`png_space`]).
    ///
    /// [`png_space`]: super::png_space
    pub space: RgbSpace,
    /// Bits a channel of the PNG.
    pub depth: Depth,
    /// Stops (powers of two) that the PNG is brightened by. The EXR keeps the scene's own values.
    pub exposure: f64,
    /// How the PNG shows colours that a screen cannot show; `None`: as the scene says.
    pub tone: Option<Tone>,
}

impl Default for Options {
    /// sRGB, 8 bits, as bright as the scene, in the scene's tone.
    fn default() -> Self {
        Options { space: RgbSpace::Srgb, depth: Depth::Eight, exposure: 0.0, tone: None }
    }
}

/// A film, and how it is to be written.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The samples.
    pub film: Film,
    /// The wavelengths of the film's spectral planes, nm; none unless the film is spectral.
    pub wavelengths: Vec<f64>,
    /// Whether alpha is coverage (else 1).
    pub transparent: bool,
    /// A colour to put behind what is transparent, linear sRGB as it is shown: the exposure leaves it alone.
    pub backdrop: Option<[f64; 3]>,
    /// Colour space, bits, exposure, tone.
    pub options: Options,
    /// What goes into the headers.
    pub provenance: Provenance,
}

impl Picture {
    /// The picture of a scene, from the film that `devices` have filled as `report` says.
    pub fn new(
        film: Film,
        scene: &PreparedScene,
        loaded: &LoadedScene,
        devices: &[DeviceInfo],
        report: &TraceReport,
        options: Options,
    ) -> Self {
        let tone = options.tone.unwrap_or(loaded.tone);
        let options = Options { exposure: options.exposure + loaded.exposure, tone: Some(tone), ..options };
        let provenance = Provenance::new(&loaded.name, &loaded.hash, scene, devices, report)
            .with("space", options.space.name().into())
            .with("exposure", options.exposure.into())
            .with("tone", tone.name().into());
        let spectral = film.wavelength_count() > 0;
        Picture {
            wavelengths: if spectral { scene.settings.wavelengths.nm().to_vec() } else { Vec::new() },
            transparent: scene.background == Background::Transparent,
            backdrop: loaded.backdrop,
            film,
            options,
            provenance,
        }
    }

    /// Writes it in another way from now on. `exposure` is all of it, the scene file's included; `tone`, where none is given, stays
    /// as it is.
    pub fn set_options(&mut self, options: Options) {
        let tone = options.tone.or(self.options.tone).unwrap_or_default();
        self.options = Options { tone: Some(tone), ..options };
        let provenance = self.provenance.clone().with("space", options.space.name().into());
        self.provenance =
            provenance.with("exposure", options.exposure.into()).with("tone", tone.name().into());
    }

    /// Writes a PNG or an EXR, as the extension of the name says. Returns its size in bytes.
    ///
    /// # Errors
    /// [`Error::Output`] for another extension and for a file that cannot be written; then nothing is left behind.
    pub fn save(&self, path: impl Into<PathBuf>) -> Result<u64, Error> {
        self.write(&Target::new(path)?)
    }

    /// The same for a target that has been checked.
    ///
    /// # Errors
    /// [`Error::Output`] if it cannot be written; then nothing is left behind.
    pub fn write(&self, target: &Target) -> Result<u64, Error> {
        file::write(target.path(), |file| self.encode(target.format(), file))
    }

    /// The same for a target that a file names: see [`file::replace`].
    #[cfg(feature = "batch")]
    pub(crate) fn replace(&self, target: &Target) -> Result<u64, Error> {
        file::replace(target.path(), |file| self.encode(target.format(), file))
    }

    /// Writes into the folder for temporary files: see [`file::rescue`].
    pub(super) fn rescue(&self, target: &Target) -> Result<(PathBuf, u64), Error> {
        file::rescue(target.path(), |file| self.encode(target.format(), file))
    }

    fn encode(&self, format: Format, file: &mut File) -> Result<(), String> {
        match format {
            Format::Png => png::encode(self, file),
            #[cfg(feature = "formats")]
            Format::Exr => exr::encode(self, file),
            #[cfg(not(feature = "formats"))]
            Format::Exr => Err("EXR needs the feature 'formats'".to_owned()),
        }
    }

    /// The bytes of its PNG file.
    ///
    /// # Errors
    /// [`Error::Output`] if it cannot be encoded.
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        png::encode(self, &mut bytes).map_err(|e| Error::output("the picture", e))?;
        Ok(bytes)
    }

    /// What an 8-bit PNG in sRGB would show: encoded, straight alpha, row by row.
    pub fn rgba(&self) -> Vec<[u8; 4]> {
        let pixels = self.shown(RgbSpace::Srgb);
        pixels.into_iter().map(|p| png::displayed(p).map(|v| (v * 255.0).round() as u8)).collect()
    }

    /// All pixels in `space`, row by row: linear, premultiplied by the alpha that follows, as the scene has them. They are those
    /// of the EXR.
    pub fn linear(&self, space: RgbSpace) -> Vec<[f32; 4]> {
        pixels(&self.film, self.transparent, self.backdrop, space, None)
    }

    /// The same as a screen shows them.
    pub(super) fn shown(&self, space: RgbSpace) -> Vec<[f32; 4]> {
        let look = (self.options.exposure, self.options.tone.unwrap_or_default());
        pixels(&self.film, self.transparent, self.backdrop, space, Some(look))
    }
}

/// Pixels that one thread takes at a time.
const SHARE: usize = 1 << 14;

/// All pixels of a film, as [`Picture`] says, with the exposure (stops) and the tone that they are shown with.
pub(crate) fn pixels(
    film: &Film,
    transparent: bool,
    backdrop: Option<[f64; 3]>,
    space: RgbSpace,
    look: Option<(f64, Tone)>,
) -> Vec<[f32; 4]> {
    let mut pixels = film.to_space(space);
    let width = film.width() as usize;
    let (gain, tone) = look.map_or((1.0, Tone::Clip), |(stops, tone)| (stops.exp2(), tone));
    let view = ViewTransform::new(tone, space);
    let backdrop = backdrop.filter(|_| transparent);
    let backdrop = backdrop.map(|rgb| matrix::apply(&space.from_linear_srgb(), rgb));
    let show = |(i, pixel): (usize, &mut [f32; 4])| {
        let sampled = || film.samples((i % width) as u32, (i / width) as u32) > 0;
        let [colour @ .., alpha] = pixel;
        colour.iter_mut().for_each(|c| *c = (f64::from(*c) * gain) as f32);
        // A tone is of the stones' own colour, before it is mixed with what is behind them.
        let cover = if transparent { f64::from(*alpha) } else { 1.0 };
        if tone != Tone::Clip && cover > 0.0 {
            let own: [f64; 3] = std::array::from_fn(|c| f64::from(colour[c]) / cover);
            let toned = view.shown(own);
            if toned != own {
                *colour = toned.map(|c| (c * cover) as f32);
            }
        }
        if let Some(behind) = backdrop.filter(|_| sampled()) {
            let through = 1.0 - f64::from(*alpha);
            colour.iter_mut().zip(behind).for_each(|(c, b)| *c = (f64::from(*c) + through * b) as f32);
            *alpha = 1.0;
        } else if !transparent {
            *alpha = f32::from(u8::from(sampled()));
        }
    };
    pixels.par_iter_mut().enumerate().with_min_len(SHARE).for_each(show);
    pixels
}
