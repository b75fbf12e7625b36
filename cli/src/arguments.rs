//! Arguments that several commands have.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use gemtrace::scene_file::Override;
use gemtrace::{Error, Session, registry};
use spectral_core::settings::{Coverage, Quality};
use spectral_core::tracer::OpenOptions;

/// What renders, and what is rendered in place of what the scene says.
#[derive(Debug, Clone, clap::Args)]
pub struct Rendering {
    /// What renders: auto, or a name that `gemtrace devices` lists.
    #[arg(long, value_name = "NAME", default_value = registry::AUTO)]
    pub backend: String,
    /// Which of the backend's devices, counted from 0.
    #[arg(long, value_name = "N")]
    pub device: Option<usize>,
    /// Samples, wavelengths, depth and thresholds chosen together, in place of the scene's.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = one_of(&Quality::ALL, Quality::name))]
    pub quality: Option<Quality>,
    /// What a pixel's samples are: rays through points, its whole area, or whichever suits.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = one_of(&Coverage::ALL, Coverage::name))]
    pub coverage: Option<Coverage>,
    /// Samples for every pixel, or with --tolerance the most, in place of the scene's.
    #[arg(long, value_name = "N")]
    pub samples: Option<u32>,
    /// Spend samples where they change the picture by more than this colour difference, ΔE00; 0: everywhere alike.
    #[arg(long, value_name = "DELTA_E")]
    pub tolerance: Option<f64>,
    /// Picture size in pixels, in place of the scene's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Worker threads [default: one a core]; the picture is the same for any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
}

impl Rendering {
    /// What is asked for in place of what a scene says.
    pub fn overrides(&self) -> Override {
        let &Rendering { size, quality, coverage, samples, tolerance, .. } = self;
        Override { size, quality, coverage, samples, tolerance }
    }

    /// How the device is opened.
    pub fn open_options(&self) -> OpenOptions {
        open_options(self.threads)
    }

    /// A session with the device that is asked for.
    ///
    /// # Errors
    /// As [`registry::choose`].
    pub fn session(&self) -> Result<Session, Error> {
        Ok(Session::new(registry::choose(&self.backend, self.device)?, self.open_options()))
    }
}

/// How a device is opened for this many worker threads.
pub fn open_options(threads: Option<u32>) -> OpenOptions {
    OpenOptions { threads: threads.map(|n| n as usize), ..OpenOptions::default() }
}

/// A parser for values that have names: help, errors and completions list them.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let value = move |text: String| {
        let found = all.iter().find(|value| name(**value).eq_ignore_ascii_case(&text));
        found.copied().ok_or("this value has no such name")
    };
    PossibleValuesParser::new(all.iter().map(|value| name(*value))).try_map(value)
}

/// A picture's size from "800x600".
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parts: Vec<_> = text.split(['x', 'X', '×']).map(|part| part.trim().parse::<u32>()).collect();
    match parts.as_slice() {
        [Ok(width), Ok(height)] if *width > 0 && *height > 0 => Ok([*width, *height]),
        _ => Err("give width and height in pixels, such as 800x600".to_owned()),
    }
}

/// The edge of a square raster from "300" or "300x300".
pub fn parse_square(text: &str) -> Result<u32, String> {
    let size = text.trim().parse().map(|edge| [edge, edge]).or_else(|_| parse_size(text));
    match size {
        Ok([width, height]) if width == height && (1..=8192).contains(&width) => Ok(width),
        _ => Err("the raster is square, at most 8192 rays an edge: give 300x300, or 300".to_owned()),
    }
}

/// Stops of exposure.
pub fn parse_stops(text: &str) -> Result<f64, String> {
    let stops = text.parse::<f64>().ok().filter(|stops| stops.abs() <= 64.0);
    stops.ok_or_else(|| "give a number of stops from -64 to 64".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_raster_is_square() {
        assert_eq!(["300x300", "300", " 1 × 1 "].map(parse_square), [Ok(300), Ok(300), Ok(1)]);
        for bad in ["300x200", "0", "8193", "8193x8193", "-1", "x"] {
            assert!(parse_square(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_are_width_times_height() {
        assert_eq!(parse_size("800x600"), Ok([800, 600]));
        assert_eq!(parse_size("8 × 6"), Ok([8, 6]));
        for bad in ["800", "0x600", "x", "800x600x2", "-1x5", "99999999999x1"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }
}
