//! From the light of a scene to the colours of a screen.

use super::{Oklab, RgbSpace};
use crate::Error;
use serde::{Deserialize, Serialize};

/// How colours are shown that a screen cannot show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Each component is cut off at 0 and at 1 by itself: bright colours change their hue.
    Clip,
    /// Hue is kept, and what a screen can show is shown as it is, to the bit.
    #[default]
    Hue,
    /// The Khronos PBR Neutral tone mapper: a filmic curve that darkens all colours a little and rolls highlights off.
    Neutral,
}

impl Tone {
    /// Every tone.
    pub const ALL: [Tone; 3] = [Tone::Clip, Tone::Hue, Tone::Neutral];

    /// The name in scenes and on a command line.
    pub fn name(self) -> &'static str {
        match self {
            Tone::Clip => "clip",
            Tone::Hue => "hue",
            Tone::Neutral => "neutral",
        }
    }

    /// The tone of a name.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing the names.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|tone| tone.name() == name);
        found.ok_or_else(|| Error::unknown("tone", name, Self::ALL.map(Self::name)))
    }
}

/// How fast colours brighter than the screen become white: with it, half of the way is gone 5 stops above it.
const WHITENING: f64 = 0.03;

/// A [`Tone`] for the colours of one linear RGB space.
///
/// ```
/// use spectral_core::color::{RgbSpace, Tone, ViewTransform};
/// let view = ViewTransform::new(Tone::Hue, RgbSpace::Srgb);
/// assert_eq!(view.shown([0.2, 1.0, 0.0]), [0.2, 1.0, 0.0]); // a screen shows it
/// let [r, g, b] = view.shown([4.0, 2.0, 0.4]); // an orange flash stays orange, where a clip makes it yellow
/// assert!(r > 0.99 && (0.5..0.6).contains(&g) && b < 0.3);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ViewTransform {
    tone: Tone,
    oklab: Oklab,
}

impl ViewTransform {
    /// For colours of `space`.
    pub fn new(tone: Tone, space: RgbSpace) -> Self {
        ViewTransform { tone, oklab: Oklab::of(space) }
    }

    /// The colour that is shown for a linear one, linear itself. It is within 0–1, but for [`Tone::Clip`] and what is not
    /// finite, which stay as they are.
    pub fn shown(&self, rgb: [f64; 3]) -> [f64; 3] {
        if !rgb.iter().all(|c| c.is_finite()) {
            return rgb;
        }
        match self.tone {
            Tone::Clip => rgb,
            Tone::Hue => self.dimmed(self.oklab.without_negatives(rgb)),
            Tone::Neutral => neutral(self.oklab.without_negatives(rgb)),
        }
    }

    /// What is brighter than the screen is dimmed with its chromaticity kept until the screen can show it. From there it goes
    /// towards white along its hue, the farther the brighter it is, so that a brighter place is always the lighter one.
    fn dimmed(&self, rgb: [f64; 3]) -> [f64; 3] {
        let peak = rgb.into_iter().fold(0.0, f64::max);
        if peak <= 1.0 {
            return rgb;
        }
        let [l, a, b] = self.oklab.of_rgb(rgb.map(|c| c / peak));
        let whiteness = 1.0 - 1.0 / (1.0 + WHITENING * (peak - 1.0));
        self.oklab.inside([l + whiteness * (1.0 - l), a, b], 1.0)
    }
}

/// The Khronos PBR Neutral tone mapper of a colour without negative components (Khronos Group, "PBR Neutral Specification",
/// 2024, <https://github.com/KhronosGroup/ToneMapping>). It is defined for sRGB's primaries; other spaces take it as it is.
fn neutral(rgb: [f64; 3]) -> [f64; 3] {
    /// The Fresnel reflection of an index of 1.5 at normal incidence.
    const F90: f64 = 0.04;
    /// Where highlights begin to be compressed.
    const START: f64 = 0.8 - F90;
    /// How fast they lose their colour.
    const DESATURATION: f64 = 0.15;
    let least = rgb.into_iter().fold(f64::INFINITY, f64::min);
    let offset = if least <= 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let rgb = rgb.map(|c| c - offset);
    let peak = rgb.into_iter().fold(0.0, f64::max);
    if peak <= START {
        return rgb;
    }
    let shown = 1.0 - (1.0 - START).powi(2) / (peak + 1.0 - 2.0 * START);
    let kept = 1.0 / (DESATURATION * (peak - shown) + 1.0);
    rgb.map(|c| c * (shown / peak) * kept + shown * (1.0 - kept))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hue_between(a: [f64; 3], b: [f64; 3]) -> f64 {
        (a[1] * b[2] - a[2] * b[1]).atan2(a[1] * b[1] + a[2] * b[2]).to_degrees().abs()
    }

    #[test]
    fn hue_stays_and_brighter_is_lighter_at_every_exposure() {
        let view = ViewTransform::new(Tone::Hue, RgbSpace::Srgb);
        let oklab = Oklab::of(RgbSpace::Srgb);
        for degrees in (0..360).step_by(5) {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            for chroma in [0.03, 0.1, 0.3] {
                let rgb = oklab.to_rgb([0.7, chroma * cos, chroma * sin]);
                let mut before = 0.0;
                for step in -60..=160 {
                    let gain = (0.05 * f64::from(step)).exp2();
                    let seen = rgb.map(|c| c * gain);
                    let shown = view.shown(seen);
                    assert!(shown.iter().all(|c| (0.0..=1.0).contains(c)), "{shown:?}");
                    let (given, found) = (oklab.of_rgb(seen), oklab.of_rgb(shown));
                    let left = found[1].hypot(found[2]);
                    assert!(left < 1e-3 || hue_between(given, found) < 0.01, "{degrees} {chroma} {step}");
                    // Continuous, too: a step of a twentieth of a stop is never a jump.
                    assert!((-1e-6..0.03).contains(&(found[0] - before)) || step == -60, "{degrees} {step}");
                    before = found[0];
                }
            }
        }
    }

    #[test]
    fn what_a_screen_shows_stays_to_the_bit_and_whites_stay_white() {
        let view = ViewTransform::new(Tone::Hue, RgbSpace::Rec2020);
        for rgb in [[0.0; 3], [1.0; 3], [0.1, 1.0, 0.0], [0.999, 0.5, 1.0]] {
            assert_eq!(view.shown(rgb), rgb);
        }
        assert!(view.shown([60.0; 3]).iter().all(|c| (c - 1.0).abs() < 1e-6));
        assert!(view.shown([f64::NAN, 1.0, 2.0])[0].is_nan());
        let clip = ViewTransform::new(Tone::Clip, RgbSpace::Srgb);
        assert_eq!(clip.shown([-1.0, 2.0, 0.5]), [-1.0, 2.0, 0.5]);
    }

    #[test]
    fn neutral_is_the_published_curve() {
        // Between 0.08 and 0.8 every colour is 0.04 darker, and no more (the specification's first note).
        assert!(neutral([0.1, 0.8, 0.3]).iter().zip([0.06, 0.76, 0.26]).all(|(a, b)| (a - b).abs() < 1e-12));
        // Its equations by hand: x = 0 gives f = 0, p = 2, p_n = 1 - 0.0576/1.48, g = 1/(0.15 (2 - p_n) + 1).
        let [r, g, b] = neutral([2.0, 1.0, 0.0]);
        let (p_n, kept) = (0.961_081_081_081, 0.865_173_268_484);
        assert!((r - p_n).abs() < 1e-9, "{r}");
        assert!(
            (g - (0.5 * p_n * kept + p_n * (1.0 - kept))).abs() < 1e-9
                && (b - p_n * (1.0 - kept)).abs() < 1e-9
        );
        assert!(neutral([1e6; 3]).iter().all(|c| *c <= 1.0 && *c > 0.999));
    }

    #[test]
    fn tones_have_names() {
        assert!(Tone::ALL.iter().all(|tone| Tone::by_name(tone.name()) == Ok(*tone)));
        let message = Tone::by_name("Hues").unwrap_err().to_string();
        assert!(message.contains("did you mean 'hue'?"), "{message}");
    }
}
