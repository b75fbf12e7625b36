//! One spectral line of a sample's wavelength grid, in single precision: all that transport asks of it.

use spectral_core::prepare::SpectralTable;

/// The optics of a material at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Medium {
    /// Index of refraction (real part).
    pub n: f32,
    /// Extinction coefficient; above 0 for metals only.
    pub k: f32,
    /// Napierian absorption, 1/mm.
    pub absorption: f32,
}

/// A wavelength: its optics, its light, and its weight in the picture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    /// By material.
    pub media: Vec<Medium>,
    /// Radiance of Smits's seven bases (white, cyan, magenta, yellow, red, green, blue), light and scale
    /// included.
    basis: [f32; 7],
    /// Weight in X, Y and Z.
    pub xyz: [f32; 3],
}

impl Line {
    /// The lines of a table, in ascending wavelength.
    pub fn all(table: &SpectralTable) -> Vec<Line> {
        (0..table.wavelengths.len())
            .map(|i| Line {
                media: table.media.iter().map(|m| Medium::new(&m[i])).collect(),
                basis: table.basis[i].map(|b| b as f32),
                xyz: table.response[i].map(|w| w as f32),
            })
            .collect()
    }

    /// Radiance of Smits's seven bases: white, cyan, magenta, yellow, red, green, blue.
    pub fn basis(&self) -> &[f32; 7] {
        &self.basis
    }

    /// Smits's expansion of a non-negative linear sRGB colour: the least component is white, what the
    /// middle one has more is the secondary of the two larger, the rest is the primary of the largest.
    #[inline]
    pub fn expand(&self, [r, g, b]: [f32; 3]) -> f32 {
        let [white, cyan, magenta, yellow, red, green, blue] = self.basis;
        let mix = |least: f32, mid: f32, most: f32, secondary: f32, primary: f32| {
            least * white + (mid - least) * secondary + (most - mid) * primary
        };
        if r <= g && r <= b {
            if g <= b { mix(r, g, b, cyan, blue) } else { mix(r, b, g, cyan, green) }
        } else if g <= b {
            // g is least: r > g or r > b, and g <= b.
            if r <= b { mix(g, r, b, magenta, blue) } else { mix(g, b, r, magenta, red) }
        } else if r <= g {
            mix(b, r, g, yellow, green)
        } else {
            mix(b, g, r, yellow, red)
        }
    }
}

impl Medium {
    fn new(medium: &spectral_core::prepare::Medium) -> Self {
        Medium { n: medium.n as f32, k: medium.k as f32, absorption: medium.absorption as f32 }
    }
}
