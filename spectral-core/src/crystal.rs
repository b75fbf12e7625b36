//! Crystals: double refraction, uniaxial and biaxial, and pleochroism.
//!
//! # Model
//! Outside crystals light is a Stokes vector. In a crystal it is one of two eigenmodes, each with its own index, ray and
//! absorption, and modes are added as intensities: their interference averages out over the wavelengths of a colour,
//! except in plates of a few wavelengths' retardation. So a surface event has up to four rays: two reflected, two
//! transmitted. Not modelled: optical activity, and axes that turn with the wavelength (monoclinic and triclinic
//! crystals).
//!
//! # Steps
//! | what | where |
//! |---|---|
//! | permittivity and orientation | [`Crystal::new`], [`Crystal::uniaxial`] |
//! | the waves on a side of a surface, evanescent ones included | [`Crystal::waves`] |
//! | what the surface sends on, in amplitudes of power | [`Incidence`] |
//! | weights of a path that is followed backwards | [`into_mode`], [`from_mode`], [`reflected`] |
//! | how light fades along its ray | [`Crystal::absorption`] |
//! | how its ray turns with its wave vector | [`Crystal::ray_by`] |
//!
//! Phase matching takes the real permittivity; absorption acts along the ray. It is exact as long as a wavelength absorbs
//! little, as in every gem.
//!
//! # Example
//! A tourmaline through a dichroscope: along the axis both windows show one colour, across it they differ.
//!
//! ```
//! use spectral_core::absorption::{Absorption, Term};
//! use spectral_core::{cie::Illuminant, color::Response, crystal::Crystal, wavelength::WavelengthGrid};
//!
//! let band = |centre, sigma, peak| Term::Gaussian { centre, sigma, peak };
//! let ordinary = Absorption::new(vec![band(425.0, 38.0, 0.55), band(665.0, 60.0, 0.95), Term::Constant(0.12)])?;
//! let extraordinary = Absorption::new(vec![band(420.0, 35.0, 0.16), band(715.0, 70.0, 0.22)])?;
//! let green = Crystal::uniaxial([1.644, 1.624], [0.0, 0.0, 1.0]);
//! let grid = WavelengthGrid::midpoints([380.0, 740.0], 32)?;
//! let response = Response::new(&grid)?;
//! let windows = |along: [f64; 3]| {
//!     green.waves([0.0; 3], along, 1.0).map(|wave| {
//!         let seen = grid.nm().iter().map(|&nm| {
//!             let [o, e] = [&ordinary, &extraordinary].map(|absorption| absorption.coefficient(nm));
//!             Illuminant::D65.at(nm) * (-3.0 * green.absorption(&wave, [o, o, e])).exp() // 3 mm
//!         });
//!         response.to_linear_srgb(&seen.collect::<Vec<_>>())
//!     })
//! };
//! let [a, b] = windows([0.0, 0.0, 1.0]);
//! println!("along the axis {a:.3?} and {b:.3?}");
//! assert!((a[1] - b[1]).abs() < 1e-9);
//! let [o, e] = windows([1.0, 0.0, 0.0]);
//! println!("across it {o:.3?} and {e:.3?}");
//! assert!(e[1] > 1.2 * o[1]);
//! # Ok::<(), spectral_core::Error>(())
//! ```
//!
//! Sources: Born & Wolf, *Principles of Optics*, 7th ed., ch. 15; Yeh, *Optical Waves in Layered Media*, 1988; Lekner,
//! "Reflection and refraction by uniaxial crystals", J. Phys.: Condens. Matter 3 (1991) 6121; Berreman, J. Opt. Soc. Am. 62
//! (1972) 502.

mod biaxial;
mod boundary;
mod polynomial;
mod sheet;
mod uniaxial;
mod vector;
mod wave;
mod weight;

pub use biaxial::Biaxial;
pub use boundary::{Incidence, Scattered};
pub use uniaxial::Uniaxial;
pub use wave::Wave;
pub use weight::{from_mode, into_mode, reflected};

use crate::color::matrix::dot;
use crate::stokes::any_axis;
use vector::{Real3, real};

/// A crystal at one wavelength, as it is oriented: a real permittivity with three perpendicular axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crystal {
    index: [f64; 3],
    axes: [Real3; 3],
    form: Form,
}

/// A crystal by its kind, with what its waves are computed from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Form {
    /// Two indices are equal.
    Uniaxial(Uniaxial),
    /// All three differ.
    Biaxial(Biaxial),
}

impl Crystal {
    /// A crystal by its index of refraction along each of its axes, which are unit vectors perpendicular to each other.
    /// Where two indices are equal it is uniaxial, with its optic axis along the third. Indices are above 0.
    pub fn new(index: [f64; 3], axes: [[f64; 3]; 3]) -> Self {
        let uniaxial = |o: usize, e: usize| Form::Uniaxial(Uniaxial::new([index[o], index[e]], axes[e]));
        let form = match index {
            [x, y, _] if x == y => uniaxial(0, 2),
            [_, y, z] if y == z => uniaxial(1, 0),
            [x, _, z] if x == z => uniaxial(2, 1),
            _ => Form::Biaxial(Biaxial::new(index, axes)),
        };
        Crystal { index, axes, form }
    }

    /// A uniaxial crystal by n_o and n_e and its optic axis, of any length above 0; the axis is the crystal's third.
    ///
    /// ```
    /// use spectral_core::crystal::Crystal;
    /// let calcite = Crystal::uniaxial([1.65835, 1.48640], [0.0, 3.0, 0.0]);
    /// let [o, e] = calcite.waves([0.0; 3], [0.0, 0.0, 1.0], 1.0); // across the axis
    /// assert!((o.index() - 1.65835).abs() < 1e-15 && (e.index() - 1.48640).abs() < 1e-15);
    /// ```
    pub fn uniaxial([o, e]: [f64; 2], optic_axis: [f64; 3]) -> Self {
        let z = vector::unit(optic_axis);
        let x = any_axis(z);
        Crystal::new([o, o, e], [x, crate::color::matrix::cross(z, x), z])
    }

    /// The index along each axis.
    pub fn indices(&self) -> [f64; 3] {
        self.index
    }

    /// Uniaxial or biaxial.
    pub fn form(&self) -> &Form {
        &self.form
    }

    /// The axes.
    pub fn axes(&self) -> [[f64; 3]; 3] {
        self.axes
    }

    /// 2V_z: the angle between the optic axes about the axis of the largest index, radians; 0 for a uniaxial positive and π for
    /// a negative crystal.
    pub fn optic_angle(&self) -> f64 {
        match self.form {
            Form::Uniaxial(Uniaxial { difference, .. }) if difference < 0.0 => std::f64::consts::PI,
            Form::Uniaxial(_) => 0.0,
            Form::Biaxial(biaxial) => 2.0 * biaxial.half_angle(),
        }
    }

    /// The two waves with the tangential wave vector `q` whose energy goes to one side of a surface with unit normal n:
    /// along n for `side` 1, against it for −1. Of evanescent waves, those that decay towards that side.
    ///
    /// A uniaxial crystal's are the ordinary and the extraordinary wave; a biaxial one's those of the smaller and the
    /// larger index, except where one of them is evanescent. With `q` = 0 they are the waves that travel along n.
    pub fn waves(&self, q: [f64; 3], normal: [f64; 3], side: f64) -> [Wave; 2] {
        match &self.form {
            Form::Uniaxial(uniaxial) => uniaxial.waves(q, normal, side),
            Form::Biaxial(biaxial) => biaxial.waves(q, normal, side),
        }
    }

    /// The indices of the two waves whose wave vector has this unit direction: the ordinary and the extraordinary, or the smaller
    /// and the larger.
    ///
    /// ```
    /// use spectral_core::crystal::Crystal;
    /// let topaz = Crystal::new([1.609, 1.611, 1.618], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    /// let [fast, slow] = topaz.indices_along([0.0, 1.0, 0.0]);
    /// assert!((fast - 1.609).abs() < 1e-12 && (slow - 1.618).abs() < 1e-12);
    /// ```
    pub fn indices_along(&self, direction: [f64; 3]) -> [f64; 2] {
        match &self.form {
            Form::Uniaxial(uniaxial) => uniaxial.indices_along(direction),
            Form::Biaxial(biaxial) => biaxial.indices_along(direction),
        }
    }

    /// The wave that comes to a surface with a wave vector that is known in single precision; its part in the surface is exact.
    /// `None` if there is no such wave.
    pub fn incident(&self, vector: [f64; 3], at: &Incidence) -> Option<Wave> {
        let (known, q) = (dot(vector, at.normal), at.q());
        let near = match &self.form {
            Form::Uniaxial(_) => None,
            Form::Biaxial(biaxial) => biaxial.near(known, q, at.normal),
        };
        let far = |wave: &Wave| (dot(wave.wave_vector(), at.normal) - known).abs();
        let waves = || self.waves(q, at.normal, 1.0).into_iter().filter(Wave::propagates);
        near.or_else(|| waves().min_by(|one, two| far(one).total_cmp(&far(two))))
    }

    /// The two waves that may be reflected where `incident`, a wave of this crystal, meets a surface.
    ///
    /// They are those of [`waves`](Self::waves) on the side that it comes from, but on an optic axis of a biaxial crystal,
    /// where the incident wave decides which they are.
    pub fn reflections(&self, incident: &Wave, at: &Incidence) -> [Wave; 2] {
        match &self.form {
            Form::Uniaxial(uniaxial) => uniaxial.waves(at.q(), at.normal, -1.0),
            Form::Biaxial(biaxial) => biaxial.reflections(incident, at.q(), at.normal),
        }
    }

    /// The Napierian absorption coefficient of a wave along its ray, in the unit of the three coefficients α_k, which
    /// light polarised along each axis of the crystal meets:
    ///
    /// ```text
    /// α = (N·ŝ) Σ n_k α_k E_k²/Σ n_k² E_k²
    /// ```
    ///
    /// from E·ε″E/|S| with ε″_k = n_k α_k/k₀. An ordinary wave has exactly its own α.
    pub fn absorption(&self, wave: &Wave, coefficients: [f64; 3]) -> f64 {
        let electric = real(&wave.electric);
        let (mut lost, mut stored) = (0.0, 0.0);
        for ((index, axis), coefficient) in self.index.iter().zip(self.axes).zip(coefficients) {
            let share = index * dot(electric, axis).powi(2);
            lost += share * coefficient;
            stored += share * index;
        }
        dot(wave.wave_vector(), wave.ray()) * lost / stored
    }
}
