//! Pictures by Mitsuba 3 of the scenes in `scripts/verify/scenes`: see `tests/data/mitsuba/README.md`.

use crate::compare::Difference;
use exr::prelude::{ReadChannels, ReadLayers};
use gemtrace::scene_file::{LoadedScene, load};
use spectral_core::{film::Film, settings::RenderSettings, wavelength::WavelengthGrid};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The scenes that there is a reference for.
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
/// At most this share of the stone's pixels is off by more than 1 %: the edges of facets.
pub const OFF: f64 = 5e-3;

/// A scene with the settings that its reference was rendered with, but for polarisation.
///
/// # Panics
/// If the scene cannot be loaded.
pub fn scene(name: &str, polarized: bool) -> LoadedScene {
    let path = root().join("scripts/verify/scenes").join(name).with_extension("toml");
    let mut loaded = load(&path).unwrap_or_else(|e| panic!("{e}"));
    loaded.settings.polarized = polarized;
    loaded
}

/// The settings with one wavelength instead.
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
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(root().join("tests/data/mitsuba").join(scene).with_extension("exr"))
            .unwrap_or_else(|e| panic!("the reference of {scene}: {e}"));
        // Readers take what stands before a name's last point for the name of a layer.
        let layer = image.layer_data.attributes.layer_name.map(|name| format!("{name}.")).unwrap_or_default();
        let channels = image
            .layer_data
            .channel_data
            .list
            .into_iter()
            .map(|c| (format!("{layer}{}", c.name), c.sample_data.values_as_f32().map(f64::from).collect()))
            .collect();
        Reference { channels, prefix: if polarized { "polarized" } else { "scalar" } }
    }

    /// How far a film is from it at each of the film's wavelengths, over the stone.
    ///
    /// # Panics
    /// If the reference lacks one of the wavelengths `nm`, or is of another size.
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

/// Whether pictures are the same but for rounding.
pub fn agree(differences: &[Difference]) -> bool {
    !differences.is_empty() && differences.iter().all(|d| d.median < MEDIAN && d.over_1_percent <= OFF)
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
