//! What is chosen in place of what a scene file says.

use super::LoadedScene;
use serde::Serialize;
use spectral_core::settings::{Coverage, Quality};

/// Size and settings in place of a scene's own; `None` keeps the scene's.
///
/// ```
/// use gemtrace::scene_file::{self, Override};
/// use spectral_core::settings::Quality;
/// let text = "format = 1\ncamera = { position = [0, -20, 20], look_at = [0, 0, 0] }";
/// let mut loaded = scene_file::parse(text, "a.toml".as_ref(), ".".as_ref())?;
/// let change = Override { quality: Some(Quality::Draft), samples: Some(4), ..Override::default() };
/// change.apply(&mut loaded);
/// assert_eq!((loaded.settings.samples, loaded.settings.wavelengths.len()), (4, 16));
/// # Ok::<(), gemtrace::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Override {
    /// Width and height of the film, pixels.
    pub size: Option<[u32; 2]>,
    /// Samples, wavelengths, depth and thresholds together.
    #[serde(serialize_with = "quality_name")]
    pub quality: Option<Quality>,
    /// What samples are.
    #[serde(serialize_with = "coverage_name", skip_serializing_if = "Option::is_none")]
    pub coverage: Option<Coverage>,
    /// Samples for every pixel; with a tolerance the most that a pixel gets.
    pub samples: Option<u32>,
    /// Samples are taken where they change the picture by more than this colour difference, ΔE00; 0: everywhere alike.
    pub tolerance: Option<f64>,
}

impl Override {
    /// Whether anything is overridden.
    pub fn is_given(&self) -> bool {
        *self != Override::default()
    }

    /// Changes a scene: first all that belongs to the quality, then each value by itself.
    pub fn apply(&self, loaded: &mut LoadedScene) {
        if let Some([width, height]) = self.size {
            (loaded.scene.width, loaded.scene.height) = (width, height);
        }
        let settings = &mut loaded.settings;
        if let Some(quality) = self.quality {
            *settings = settings.at(quality);
        }
        settings.coverage = self.coverage.unwrap_or(settings.coverage);
        if let Some(samples) = self.samples {
            *settings = settings.with_samples(samples);
        }
        if let Some(tolerance) = self.tolerance {
            *settings = settings.with_tolerance(tolerance);
        }
    }
}

fn coverage_name<S: serde::Serializer>(
    coverage: &Option<Coverage>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    coverage.map(Coverage::name).serialize(serializer)
}

fn quality_name<S: serde::Serializer>(quality: &Option<Quality>, serializer: S) -> Result<S::Ok, S::Error> {
    quality.map(Quality::name).serialize(serializer)
}
