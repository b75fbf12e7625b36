//! One picture by many machines: each renders a share of its rows into a file, and the files are joined.
//!
//! A film adds the samples of a pixel in their order, and no pixel depends on another. So the joined picture has the bits
//! that a single machine would have computed, if the devices compute alike.

mod file;
mod joint;

use crate::output::{self, Picture, Target, is_plain_name};
use crate::shard::Shard;
use crate::{Error, import};
pub use file::Contribution;
use file::{Header, PictureHeader};
pub use joint::Joint;
use serde_json::Value;
use spectral_core::film::{BLOCK, Film, PixelSums};
use spectral_core::shown_lines;
use std::path::{Path, PathBuf};

/// The rows of a picture that a shard renders. Of n shards, each takes every n-th band of rows, so that the stone, which
/// costs most, is spread over all machines.
///
/// ```
/// use gemtrace::{part::Bands, shard::Shard};
/// let parts = (0..3).map(|index| Bands::new(Shard::new(index, 3).unwrap(), 50).unwrap());
/// let mut rows: Vec<u32> = parts.flat_map(|part| part.rows()).collect();
/// rows.sort();
/// assert_eq!(rows, (0..50).collect::<Vec<u32>>());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bands {
    shard: Shard,
    height: u32,
    /// Rows of a band.
    band: u32,
}

/// Rows of a band at most: what a tile has.
///
/// Bands are whole multiples of [`BLOCK`]: pixels that are judged together stay together.
const BAND: u32 = 16;

impl Bands {
    /// The bands of a shard in a picture of this many rows.
    ///
    /// # Errors
    /// [`Error::Usage`] where there are more shards than blocks of four rows.
    pub fn new(shard: Shard, height: u32) -> Result<Self, Error> {
        let blocks = height.div_ceil(BLOCK);
        if shard.count() > blocks {
            let message = format!(
                "a picture of {height} rows, {blocks} blocks of {BLOCK}, cannot be shared out among {}",
                shard.count()
            );
            return Err(Error::Usage(message));
        }
        // Four bands for each shard, if that leaves any blocks.
        let band = BLOCK * (blocks / shard.count().saturating_mul(4)).clamp(1, BAND / BLOCK);
        Ok(Bands { shard, height, band })
    }

    /// The rows, from the top.
    pub fn rows(self) -> Vec<u32> {
        (0..self.height).filter(|row| self.shard.has((row / self.band) as usize)).collect()
    }

    /// Marks all other rows of a film as having their samples, so that only these are traced.
    ///
    /// # Errors
    /// [`Error::Core`] for a film of another height.
    pub fn reserve(self, film: &mut Film, samples: u32) -> Result<(), Error> {
        let rows = self.rows();
        let none = vec![0.0; film.wavelength_count()];
        for y in (0..film.height()).filter(|y| rows.binary_search(y).is_err()) {
            for x in 0..film.width() {
                film.set_sums(x, y, PixelSums { samples, ..PixelSums::default() }, &none)?;
            }
        }
        Ok(())
    }
}

/// The file for a shard of a picture: beside it, `hall.part-3-of-8.exr`.
pub fn part_path(picture: &Path, shard: Shard) -> PathBuf {
    let stem = picture.file_stem().unwrap_or_default().to_string_lossy();
    picture.with_file_name(format!("{stem}.part-{}-of-{}.exr", shard.index() + 1, shard.count()))
}

/// The picture's name without extension, and the shard, from the name of a part's file.
fn parse_name(name: &str) -> Option<(&str, Shard)> {
    let (stem, numbers) = name.strip_suffix(".exr")?.rsplit_once(".part-")?;
    let (index, count) = numbers.split_once("-of-")?;
    let shard = Shard::new(index.parse::<u32>().ok()?.checked_sub(1)?, count.parse().ok()?)?;
    // No picture has more blocks of rows.
    (shard.count() <= Film::MAX_EDGE / BLOCK).then_some((stem, shard))
}

/// Whether these pictures can be rendered in shares, to be asked before any work is done.
///
/// # Errors
/// [`Error::Usage`] unless all have plain names and are in one folder: parts name them, and may be joined elsewhere.
pub fn check(targets: &[Target]) -> Result<(), Error> {
    names(targets).map(drop)
}

fn names(targets: &[Target]) -> Result<Vec<String>, Error> {
    let name = |target: &Target| {
        let name = target.path().file_name()?.to_str().filter(|name| is_plain_name(name))?;
        (target.path().parent() == targets[0].path().parent()).then(|| name.to_owned())
    };
    let refuse = |target: &Target| {
        let path = shown_lines(&target.path().display().to_string());
        Error::Usage(format!(
            "the outputs of a share are files of one folder with plain names; {path} is none"
        ))
    };
    targets.iter().map(|target| name(target).ok_or_else(|| refuse(target))).collect()
}

/// Writes a shard's rows beside the picture that they belong to, with what this machine contributed. Returns the file.
///
/// # Errors
/// [`Error::Output`] if it cannot be written, [`Error::Usage`] where there are more shards than blocks of rows, and as
/// [`check`].
pub fn write(
    shard: Shard,
    targets: &[Target],
    picture: &Picture,
    work: Contribution,
) -> Result<PathBuf, Error> {
    let first = targets.first().map_or(Path::new("picture"), Target::path);
    let path = part_path(first, shard);
    let Value::Object(facts) = picture.provenance.to_json() else {
        return Err(Error::output(path, "the picture's provenance is no object"));
    };
    let film = &picture.film;
    let header = Header {
        shard: shard.to_string(),
        picture: PictureHeader {
            width: film.width(),
            height: film.height(),
            spectral: picture.wavelengths.clone(),
            space: picture.options.space.name().to_owned(),
            bits: picture.options.depth.bits(),
            exposure: picture.options.exposure,
            tone: picture.options.tone.unwrap_or_default(),
            transparent: picture.transparent,
            backdrop: picture.backdrop,
            outputs: names(targets)?,
            facts: facts.into_iter().map(blank).collect(),
        },
        work,
    };
    file::write(&path, &header, film, &Bands::new(shard, film.height())?.rows())?;
    Ok(path)
}

/// Facts of a picture's provenance that depend on who rendered it.
const OF_WORK: [&str; 5] = ["backend", "device", "driver", "rays", "energy"];

/// What depends on the work is left open, but keeps its place.
fn blank((key, value): (String, Value)) -> (String, Value) {
    let value = if OF_WORK.contains(&key.as_str()) { Value::Null } else { value };
    (key, value)
}

/// The pictures of which a folder has parts: for each the stem of its name and the number of its shards.
///
/// # Errors
/// [`Error::File`] if the folder cannot be read.
pub fn pictures(folder: &Path) -> Result<Vec<(String, u32)>, Error> {
    let refuse = |e: std::io::Error| Error::file(folder, format!("cannot be read: {e}"));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(refuse)? {
        let name = entry.map_err(refuse)?.file_name();
        if let Some((stem, shard)) = name.to_str().and_then(parse_name) {
            found.push((stem.to_owned(), shard.count()));
        }
    }
    found.sort();
    found.dedup();
    Ok(found)
}

/// How many missing shards a complaint names.
const NAMED: usize = 16;

/// Joins the parts of a picture and writes it where each of them would have. Returns the files.
///
/// # Errors
/// [`Error::Items`] naming the shards that are missing; [`Error::File`] for a part that is not whole or is of another
/// picture; [`Error::Output`] for a file that cannot be written.
pub fn merge(folder: &Path, stem: &str, count: u32) -> Result<Vec<PathBuf>, Error> {
    let shards: Vec<Shard> = (0..count).filter_map(|index| Shard::new(index, count)).collect();
    let path = |shard: Shard| part_path(&folder.join(format!("{stem}.exr")), shard);
    let missing: Vec<Shard> = shards.iter().copied().filter(|shard| !path(*shard).exists()).collect();
    if let Some(first) = missing.first() {
        let names: Vec<String> = missing.iter().take(NAMED).map(ToString::to_string).collect();
        let more = missing.len().saturating_sub(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let (names, file) = (names.join(", "), path(*first));
        let message = format!("of '{stem}' these shards are missing: {names}{more} (no {})", file.display());
        return Err(Error::Items(message));
    }
    let mut joint = Joint::default();
    for shard in shards {
        let path = path(shard);
        joint.add(shard, &path, &import::read_file(&path)?)?;
    }
    let (picture, targets) = joint.finish(folder)?;
    output::remove_leftovers(&targets.iter().map(|target| target.path().to_owned()).collect::<Vec<_>>());
    let write = |target: Target| picture.replace(&target).map(|_| target.path().to_owned());
    targets.into_iter().map(write).collect()
}

/// The picture that a part's file belongs to: its folder, the stem of its name, and the number of shards.
///
/// # Errors
/// [`Error::File`] for any other name.
pub fn picture_of(part: &Path) -> Result<(PathBuf, String, u32), Error> {
    let name = part.file_name().and_then(|name| name.to_str()).and_then(parse_name);
    let expected = "neither a folder nor a part of a picture, such as hall.part-3-of-8.exr";
    let (stem, shard) = name.ok_or_else(|| Error::file(part, expected))?;
    if !part.exists() {
        import::read_file(part)?;
    }
    Ok((part.parent().unwrap_or(Path::new("")).to_owned(), stem.to_owned(), shard.count()))
}
