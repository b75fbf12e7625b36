//! Pictures by Mitsuba 3 of the scenes in `scripts/verify/scenes`: see `tests/data/mitsuba/README.md`.

use crate::{compare::Difference, image::read_channels};
use gemtrace::scene_file::{LoadedScene, load};
use spectral_core::{film::Film, settings::RenderSettings, wavelength::WavelengthGrid};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The scenes with a reference.
pub const SCENES: [&str; 11] = [
    "brilliant-diamond",
    "step-sapphire",
    "step-ruby",
    "brilliant-moissanite",
    "portuguese-quartz",
    "drilled-bead",
    "two-stones",
    "metal-plate",
    "slab-grazing",
    "diamond-grazing",
    "furnace",
];

/// The median relative difference over the stone stays below this at every wavelength.
pub const MEDIAN: f64 = 1e-4;
/// At most this share of the stone's pixels, at edges of facets, is off by more than 1 %.
pub const OFF: f64 = 5e-3;

/// A scene with the settings of its reference and the given polarisation.
///
/// # Panics
/// If the scene cannot be loaded.
pub fn scene(name: &str, polarized: bool) -> LoadedScene {
    let path = root().join("scripts/verify/scenes").join(name).with_extension("toml");
    let mut loaded = load(&path).unwrap_or_else(|e| panic!("{e}"));
    loaded.settings.polarized = polarized;
    loaded
}

/// The settings with a single wavelength.
///
/// # Panics
/// If `nm` is no wavelength.
pub fn at(nm: f64, settings: RenderSettings) -> RenderSettings {
    RenderSettings { wavelengths: WavelengthGrid::list(vec![nm]).expect("a wavelength"), ..settings }
}

/// An independent renderer's picture.
pub struct Reference {
    channels: HashMap<String, Vec<f64>>,
    prefix: &'static str,
}

impl Reference {
    /// The picture of a scene, with or without polarisation.
    ///
    /// # Panics
    /// If the reference is not there.
    pub fn of(scene: &str, polarized: bool) -> Self {
        let (_, channels) =
            read_channels(&root().join("tests/data/mitsuba").join(scene).with_extension("exr"));
        Reference { channels, prefix: if polarized { "polarized" } else { "scalar" } }
    }

    /// The differences of a film from it at each of the film's wavelengths, over the stone.
    ///
    /// # Panics
    /// If the reference lacks one of the wavelengths `nm`, or has another size.
    pub fn differences(&self, film: &Film, nm: &[f64]) -> Vec<Difference> {
        let width = film.width() as usize;
        let stone = self.plane("stone");
        assert_eq!(stone.len(), width * film.height() as usize, "pixels");
        let pixels: Vec<usize> = (0..stone.len()).filter(|&i| stone[i] > 0.5).collect();
        let found = |i: usize| film.radiance((i % width) as u32, (i / width) as u32);
        nm.iter()
            .enumerate()
            .map(|(line, nm)| {
                let plane = self.plane(&format!("{}.S0.{nm}nm", self.prefix));
                Difference::of(pixels.iter().map(|&i| (plane[i], f64::from(found(i)[line]))))
            })
            .collect()
    }

    fn plane(&self, name: &str) -> &[f64] {
        let known: Vec<&String> = self.channels.keys().collect();
        self.channels.get(name).unwrap_or_else(|| panic!("no channel {name} among {known:?}"))
    }
}

/// Whether pictures are the same except for rounding.
pub fn agree(differences: &[Difference]) -> bool {
    !differences.is_empty() && differences.iter().all(|d| d.median < MEDIAN && d.over_1_percent <= OFF)
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
