//! A picture that is being put together from its parts.

use super::file::{self, Contribution, PictureHeader};
use super::{Bands, OF_WORK, parse_name};
use crate::Error;
use crate::output::{self, Depth, Options, Picture, Provenance, Target, is_plain_name};
use crate::shard::Shard;
use spectral_core::color::RgbSpace;
use spectral_core::film::Film;
use spectral_core::shown;
use std::path::Path;

/// What the parts so far have brought. Nothing in their files is taken on trust: a part may come from anywhere.
#[derive(Default)]
pub struct Joint(Option<(PictureHeader, Contribution, Film)>);

impl Joint {
    /// Adds the part that a file holds, `path` naming it in messages.
    ///
    /// # Errors
    /// [`Error::File`] for a part that is not whole, is of another picture than the first, or names a file of another
    /// folder as its output; [`Error::Core`] where there is not enough memory for the film.
    pub fn add(&mut self, shard: Shard, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        let incomplete = |e: String| Error::file(path, format!("not a complete part of a picture: {e}"));
        let part = file::decode(bytes).map_err(incomplete)?;
        let picture = &part.header.picture;
        outputs(Path::new(""), picture).map_err(|e| Error::file(path, e))?;
        let rows = Bands::new(shard, picture.height).map_err(|e| Error::file(path, e))?.rows();
        part.check(rows.len()).map_err(incomplete)?;
        let (header, work, film) = match &mut self.0 {
            Some(joined) => joined,
            None => {
                let film = Film::with_size(picture.width, picture.height, picture.spectral.len())?;
                self.0.insert((picture.clone(), Contribution::default(), film))
            }
        };
        if header != picture {
            let message =
                format!("this is of another picture than shard 1/{}; render it again", shard.count());
            return Err(Error::file(path, message));
        }
        work.add(&part.header.work);
        part.place(film, &rows).map_err(incomplete)
    }

    /// The picture, and the files of `folder` that it is to be written to.
    ///
    /// # Errors
    /// [`Error::Items`] without any part.
    pub fn finish(self, folder: &Path) -> Result<(Picture, Vec<Target>), Error> {
        let (header, work, film) = self.0.ok_or_else(|| Error::Items("there are no parts".to_owned()))?;
        let targets = outputs(folder, &header).map_err(|e| Error::file(folder, e))?;
        let PictureHeader { spectral, space, bits, exposure, tone, transparent, backdrop, facts, .. } =
            header;
        let all =
            |k: usize| work.devices.iter().map(|d| d[k].as_str()).collect::<Vec<_>>().join(" + ").into();
        let mut provenance = Provenance::from_facts(facts);
        let energy = output::energy(&work.energy());
        for (key, value) in OF_WORK.into_iter().zip([all(0), all(1), all(2), work.rays.into(), energy]) {
            provenance = provenance.with(key, value);
        }
        let depth = Depth::of_bits(bits).unwrap_or_default();
        let space = RgbSpace::by_name(&space).map_err(|e| Error::file(folder, e))?;
        let options = Options { space, depth, exposure, tone: Some(tone) };
        Ok((Picture { film, wavelengths: spectral, transparent, backdrop, options, provenance }, targets))
    }
}

/// The files that a part names, in the folder that it is in.
fn outputs(folder: &Path, header: &PictureHeader) -> Result<Vec<Target>, String> {
    let target = |name: &String| {
        let target = Target::new(folder.join(name)).ok().filter(|_| is_plain_name(name));
        let expected = "the plain name of a PNG or EXR in its own folder";
        target
            .filter(|_| parse_name(name).is_none())
            .ok_or_else(|| format!("its output '{}' is not valid: expected {expected}", shown(name)))
    };
    header.outputs.iter().map(target).collect()
}
