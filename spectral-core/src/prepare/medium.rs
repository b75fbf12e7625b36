//! The optics of a material at one wavelength: the one description that every backend is packed from.
//!
//! The double-precision reference takes a [`Medium`] as it stands. The CPU backend packs sixteen of them into lanes.
//! The kernel's structure, its loader and its constant for air are generated from [`Medium::figures`].

use super::substance::Substance;
use crate::{
    crystal::Crystal,
    fresnel::{Fresnel, conductor, dielectric},
};

/// The optics of a material at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Index of refraction (real part).
    pub n: f64,
    /// Extinction coefficient, the index's imaginary part; above 0 for metals only.
    pub k: f64,
    /// Napierian absorption coefficient, 1/mm; 0 for metals, in which no ray travels.
    pub absorption: f64,
    /// Of a crystal that is traced as one: its permittivity in the scene's frame, and its absorption coefficients along
    /// the three axes. `n` and `absorption` are then those of the first axis.
    pub crystal: Option<(Crystal, [f64; 3])>,
}

impl Medium {
    /// What is between the stones.
    pub const AIR: Medium = Medium { n: 1.0, k: 0.0, absorption: 0.0, crystal: None };
    /// How many [`figures`](Self::figures) there are.
    pub const FIGURES: usize = 3;

    pub(super) fn new(substance: &Substance, nm: f64) -> Self {
        let Substance { material, axes } = substance;
        let absorption = if material.is_conductor() { 0.0 } else { material.absorption(nm) };
        let (n, k) = (material.index(nm), material.extinction(nm));
        let medium = Medium { n, k, absorption, crystal: None };
        if !material.is_crystal() {
            return medium;
        }
        let (indices, absorptions) = (material.indices(nm), material.absorptions(nm));
        match axes {
            Some(axes) => {
                let crystal = Crystal::new(indices, axes.map(|axis| axis.to_array()));
                Medium { crystal: Some((crystal, absorptions)), ..medium }
            }
            // Too weak or too small to split light.
            None => Medium { n: mean(indices), absorption: mean(absorptions), ..medium },
        }
    }

    /// Every figure of an isotropic medium with its name, in the order of the kernel's structure.
    pub fn figures(&self) -> [(&'static str, f64); Self::FIGURES] {
        let Medium { n, k, absorption, .. } = *self;
        [("n", n), ("k", k), ("absorption", absorption)]
    }

    /// Whether light ends at its surface or is reflected there: it is a metal.
    pub fn is_opaque(&self) -> bool {
        self.k > 0.0
    }

    /// The share of light that is left after `distance`, mm (Beer and Lambert's law).
    pub fn transmittance(&self, distance: f64) -> f64 {
        (-self.absorption * distance).exp()
    }

    /// What the surface between this medium and another does to light that arrives in this one; `cos_i` is the cosine
    /// of the angle of incidence.
    pub fn interface(&self, beyond: &Medium, cos_i: f64) -> Fresnel<f64> {
        if beyond.is_opaque() {
            conductor(cos_i, self.n, beyond.n, beyond.k)
        } else {
            dielectric(cos_i, self.n / beyond.n)
        }
    }
}

/// The mean of the three axes; equal figures come out as they are.
fn mean([x, y, z]: [f64; 3]) -> f64 {
    if x == y && y == z { x } else { (x + y + z) / 3.0 }
}
