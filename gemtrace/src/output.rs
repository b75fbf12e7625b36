//! Pictures on disk: PNG for showing, OpenEXR for measuring.
//!
//! | | PNG | EXR |
//! |---|---|---|
//! | values | 8 or 16 bits, sRGB transfer, in 0–1 by the `tone` after `exposure` | 32-bit float, linear, unclamped: negative values are real colours outside the space |
//! | spaces | sRGB, P3 and Rec. 2020 (labelled by a cICP chunk) | all, by `chromaticities` |
//! | alpha | straight | premultiplied |
//! | spectra | none | with `spectral = true`, one channel a wavelength |
//!
//! Alpha is the stones' coverage where the scene's background is transparent, else 1; a pixel that an
//! interrupted render never reached has alpha 0. There is no dithering: the same film gives the
//! same bytes.
//!
//! A file appears under its name only when it is complete: it is written beside it under a temporary
//! name, flushed to the disk and renamed. An interrupted render leaves the asked-for name alone and
//! writes `NAME.partial.png` instead. Temporary names are random, and the file is created by whoever writes it: a link
//! that waits under such a name is never followed.

#[cfg(feature = "batch")]
pub mod animation;
#[cfg(feature = "formats")]
pub(crate) mod exr;
mod file;
mod picture;
mod png;
mod provenance;
mod temporary;

#[cfg(feature = "formats")]
pub use exr::write_light;
pub use file::{check, prepare, refuse_overlap, remove_leftovers};
#[cfg(feature = "batch")]
pub(crate) use file::{is_plain_name, write as write_file};
#[cfg(feature = "view")]
pub(crate) use picture::pixels;
pub use picture::{Options, Picture};
pub use provenance::{Provenance, device, energy, settings};
pub use temporary::{abandon, is_writing};

use crate::Error;
use ::png::Compression;
use rayon::prelude::*;
use spectral_core::{color::RgbSpace, film::Film, memory, mesh::Mesh, prepare::PreparedScene};
use std::path::{Path, PathBuf};

/// A kind of picture file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics.
    Png,
    /// OpenEXR.
    Exr,
}

impl Format {
    /// The file name extension, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Png => "png",
            Format::Exr => "exr",
        }
    }
}

/// Bits a channel of a PNG.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Depth {
    /// 8 bits.
    #[default]
    Eight,
    /// 16 bits.
    Sixteen,
}

impl Depth {
    /// Both of them.
    pub const ALL: [Depth; 2] = [Depth::Eight, Depth::Sixteen];

    /// The number of bits, as a name on a command line.
    pub fn name(self) -> &'static str {
        match self {
            Depth::Eight => "8",
            Depth::Sixteen => "16",
        }
    }

    /// The number of bits.
    pub fn bits(self) -> u32 {
        match self {
            Depth::Eight => 8,
            Depth::Sixteen => 16,
        }
    }

    /// The depth of 8 or 16 bits.
    pub fn of_bits(bits: u32) -> Option<Self> {
        Depth::ALL.into_iter().find(|depth| depth.bits() == bits)
    }
}

/// A picture file to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    path: PathBuf,
    format: Format,
}

impl Target {
    /// A target whose format is what its extension says.
    ///
    /// ```
    /// use gemtrace::output::{Format, Target};
    /// assert_eq!(Target::new("stone.EXR")?.format(), Format::Exr);
    /// assert!(Target::new("stone.jpg").unwrap_err().to_string().contains("'.png' or '.exr'"));
    /// # Ok::<(), gemtrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Usage`] for any other extension, or none.
    pub fn new(path: impl Into<PathBuf>) -> Result<Self, Error> {
        let path = path.into();
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let format = match extension.as_deref() {
            Some("png") => Format::Png,
            Some("exr") => Format::Exr,
            _ => {
                let name = path.display();
                let message = "pictures are written as PNG or EXR; end the name in '.png' or '.exr'";
                return Err(Error::Usage(format!("{name}: {message}")));
            }
        };
        Ok(Target { path, format })
    }

    /// Where the picture goes.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What kind of file it is.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Whether the picture can be written there, tried before any work is done.
    ///
    /// # Errors
    /// [`Error::Output`] where the folder is missing or not writable, or the name is a folder's.
    pub fn check(&self) -> Result<(), Error> {
        file::check(&self.path)
    }

    /// The name for a picture that is not finished: `stone.png` becomes `stone.partial.png`.
    #[must_use]
    pub fn partial(&self) -> Target {
        let path = self.path.with_extension(format!("partial.{}", self.format.extension()));
        Target { path, format: self.format }
    }
}

/// The space that a PNG is written in when `space` is asked for: sRGB where PNG has no name for it.
pub fn png_space(space: RgbSpace) -> RgbSpace {
    match space {
        RgbSpace::P3 | RgbSpace::Rec2020 => space,
        _ => RgbSpace::Srgb,
    }
}

/// The outcome of writing one target.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Where the picture is, if it could be written anywhere.
    pub path: Option<PathBuf>,
    /// Bytes written.
    pub bytes: u64,
    /// Why it is not where it should be.
    pub failure: Option<Error>,
}

impl From<Result<PathBuf, Error>> for Written {
    /// The outcome for a file that has no other place to go.
    fn from(result: Result<PathBuf, Error>) -> Self {
        let (path, failure) = match result {
            Ok(path) => (Some(path), None),
            Err(error) => (None, Some(error)),
        };
        let bytes = path.as_ref().and_then(|path| std::fs::metadata(path).ok()).map_or(0, |data| data.len());
        Written { path, bytes, failure }
    }
}

/// Pixels that take more than this, bytes, have memory checked for threads, too.
const LARGE: u128 = 32 << 20;
/// What threads and their allocators reserve, bytes.
const THREADS: u128 = 512 << 20;

/// Whether there is memory for a scene's film and for writing its picture, which is to be known before the work.
///
/// # Errors
/// [`Error::Core`] naming the memory.
pub fn check_memory(scene: &PreparedScene) -> Result<(), Error> {
    let (width, height) = (scene.width, scene.height);
    let kept = if scene.settings.spectral { scene.wavelength_count() } else { 0 };
    // Three numbers a pixel twice to judge it by; for each of PNG and EXR four linear numbers, for EXR all channels again.
    let writing = u128::from(width) * u128::from(height) * (2 * 12 + 3 * 16 + 4 * kept as u128);
    let pixels = Film::bytes(width, height, kept) + writing;
    // The threads that compute and compress large pictures reserve memory of their own.
    let bytes = if pixels > LARGE { pixels + THREADS } else { pixels };
    let what = || format!("a picture of {width} × {height} pixels");
    Ok(memory::check(u64::try_from(bytes).unwrap_or(u64::MAX), what)?)
}

/// Writes every target, side by side, so that one failure costs no other; a picture that fails is saved in the folder
/// for temporary files instead, and its failure says where.
pub fn write_all(targets: &[Target], picture: &Picture) -> Vec<Written> {
    targets.par_iter().map(|target| write_or_rescue(target, picture)).collect()
}

fn write_or_rescue(target: &Target, picture: &Picture) -> Written {
    let error = match picture.write(target) {
        Ok(bytes) => return Written { path: Some(target.path.clone()), bytes, failure: None },
        Err(error) => error,
    };
    let rescued = picture.rescue(target);
    let place = match &rescued {
        Ok((path, _)) => format!("; the picture was saved as {} instead", path.display()),
        Err(_) => "; it could not be saved among the temporary files either".to_owned(),
    };
    let failure = match error {
        Error::Output { path, message } => Error::output(path, message + &place),
        other => other,
    };
    let (path, bytes) = rescued.map_or((None, 0), |(path, bytes)| (Some(path), bytes));
    Written { path, bytes, failure: Some(failure) }
}

/// Writes 8-bit sRGB pixels, row by row, as a PNG: sheets.
///
/// # Errors
/// [`Error::Output`] if it cannot be written.
pub fn write_rgb(path: &Path, width: u32, pixels: &[[u8; 3]]) -> Result<u64, Error> {
    file::write(path, |file| png::encode_pixels(width, pixels, Compression::default(), file))
}

/// 8-bit sRGB pixels, RGB or RGBA, as a PNG in a `data:` address for HTML.
///
/// # Errors
/// Why they cannot be encoded, for people.
#[cfg(feature = "batch")]
pub fn data_url<const N: usize>(width: u32, pixels: &[[u8; N]]) -> Result<String, String> {
    use base64::{Engine as _, engine::general_purpose::STANDARD};
    let mut bytes = Vec::new();
    png::encode_pixels(width, pixels, Compression::Fast, &mut bytes)?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}

/// 8-bit sRGB pixels as the bytes of a PNG that is as small as it gets.
///
/// # Errors
/// Why they cannot be encoded, for people.
#[cfg(feature = "view")]
pub(crate) fn small_png<const N: usize>(width: u32, pixels: &[[u8; N]]) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    png::encode_pixels(width, pixels, Compression::High, &mut bytes)?;
    Ok(bytes)
}

/// Writes a solid as a mesh file (.obj), in its unit of length.
///
/// # Errors
/// [`Error::Output`] if it cannot be written.
pub fn write_mesh(path: &Path, mesh: &Mesh) -> Result<u64, Error> {
    let vertices = mesh.positions().iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = mesh.triangles().iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    write_text(path, &vertices.chain(faces).collect::<String>())
}

/// Writes a text file (a plot, say) as safely as a picture.
///
/// # Errors
/// [`Error::Output`] if it cannot be written.
pub fn write_text(path: &Path, text: &str) -> Result<u64, Error> {
    use std::io::Write as _;
    file::check(path)?;
    file::write(path, |file| file.write_all(text.as_bytes()).map_err(|e| e.to_string()))
}
