//! How much work pictures are worth, in place of what their scenes say.

use spectral_core::settings::{Quality, RenderSettings};

/// Arguments of every command that renders.
///
/// ```
/// use gemtrace::effort::Effort;
/// use spectral_core::settings::{Quality, RenderSettings};
/// let effort = Effort { quality: Some(Quality::Draft), samples: Some(4), tolerance: None };
/// let settings = effort.over(&RenderSettings::default());
/// assert_eq!((settings.samples, settings.wavelengths.len()), (4, 16));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, clap::Args)]
pub struct Effort {
    /// Samples, wavelengths, depth and thresholds chosen together, in place of the scene's: draft, normal or final.
    #[arg(long, value_name = "NAME", value_parser = parse_quality)]
    pub quality: Option<Quality>,
    /// Samples for every pixel, or with --tolerance the most, in place of the scene's.
    #[arg(long, value_name = "N")]
    pub samples: Option<u32>,
    /// Spend samples where they change the picture by more than this colour difference, ΔE00; 0: everywhere alike.
    #[arg(long, value_name = "DELTA_E")]
    pub tolerance: Option<f64>,
}

impl Effort {
    /// Whether anything was asked for.
    pub fn is_given(&self) -> bool {
        *self != Effort::default()
    }

    /// A scene's settings with what was asked for: the numbers of the quality, then each by itself.
    #[must_use]
    pub fn over(&self, settings: &RenderSettings) -> RenderSettings {
        let settings = self.quality.map_or_else(|| settings.clone(), |quality| settings.at(quality));
        let settings =
            self.samples.map_or_else(|| settings.clone(), |samples| settings.with_samples(samples));
        RenderSettings { tolerance: self.tolerance.unwrap_or(settings.tolerance), ..settings }
    }

    /// The same in the `[render]` table of a scene's document.
    pub fn write(&self, render: &mut toml::Table) {
        if let Some(quality) = self.quality {
            for key in ["samples", "tolerance", "max_depth", "threshold"] {
                render.remove(key);
            }
            let spectral = render.get("spectral").and_then(toml::Value::as_bool) == Some(true);
            let grid = render.get_mut("wavelengths").and_then(toml::Value::as_table_mut);
            if let Some(grid) = grid.filter(|_| !spectral) {
                grid.remove("count");
            }
            render.insert("quality".into(), quality.name().into());
        }
        if let Some(samples) = self.samples {
            render.remove("tolerance");
            render.insert("samples".into(), i64::from(samples).into());
        }
        if let Some(tolerance) = self.tolerance {
            render.insert("tolerance".into(), tolerance.into());
        }
    }
}

fn parse_quality(name: &str) -> Result<Quality, String> {
    Quality::by_name(name).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file;
    use std::path::Path;

    #[test]
    fn a_document_is_changed_as_its_settings_are() {
        let renders = [
            "",
            "samples = 9",
            "samples = 9\ntolerance = 2.0\nmax_depth = 7\nthreshold = 0.1\npolarized = false",
            "wavelengths = { count = 16, range = [400.0, 700.0], jitter = false }",
            "wavelengths = { count = 16 }\nspectral = true",
            "wavelengths = [450.0, 550.0]",
            "quality = 'final'\nleftover = 'drop'",
        ];
        let efforts = [
            Effort::default(),
            Effort { quality: Some(Quality::Draft), ..Effort::default() },
            Effort { quality: Some(Quality::Final), samples: Some(5), tolerance: None },
            Effort { samples: Some(5), ..Effort::default() },
            Effort { tolerance: Some(0.25), ..Effort::default() },
            Effort { quality: Some(Quality::Normal), samples: Some(5), tolerance: Some(3.0) },
        ];
        let settings = |render: &toml::Table| {
            let camera = "format = 1\n[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n";
            let mut scene: toml::Table = camera.parse().expect("a table");
            scene.insert("render".into(), render.clone().into());
            let text = scene.to_string();
            scene_file::parse(&text, Path::new("a.toml"), Path::new("")).expect("a valid scene").settings
        };
        for (render, effort) in renders.iter().flat_map(|render| efforts.map(|effort| (render, effort))) {
            let plain: toml::Table = render.parse().expect("a table");
            let mut changed = plain.clone();
            effort.write(&mut changed);
            assert_eq!(settings(&changed), effort.over(&settings(&plain)), "{render}, {effort:?}");
        }
    }
}
