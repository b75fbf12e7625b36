//! Crystals, sixteen wavelengths at a time: the single-precision twin of `spectral_core::crystal`.
//!
//! Lanes compute with real fields, which is what nearly all events have. A lane in which a wave is evanescent, or so close to
//! grazing that single precision would lose it, is left to the core in double precision (`exact`), and so are metals and
//! other crystals beyond the surface. Which lanes these are depends on each lane alone.

mod biaxial;
mod boundary;
mod exact;
mod uniaxial;

use crate::{medium::Medium, throughput::Polarized};
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, put};
use biaxial::Biaxial;
pub(crate) use boundary::{Beam, Scattered};
use exact::Beyond;
use spectral_core::crystal::{self as core, Form};
use spectral_core::prepare;
use uniaxial::Uniaxial;

/// A crystal, a wavelength a lane.
#[derive(Debug, Clone)]
pub(crate) struct Crystal {
    form: Kind,
    /// Whether anything is absorbed.
    absorbs: bool,
    /// The axes, n_k² along each, and n_k α_k to base 2, 1/mm.
    axes: [[f32; 3]; 3],
    stored: [Row; 3],
    lost: [Row; 3],
    /// The same in double precision.
    exact: [core::Crystal; WIDTH],
}

#[derive(Debug, Clone)]
enum Kind {
    Uniaxial(Box<Uniaxial>),
    Biaxial(Box<Biaxial>),
}

/// Of a crystal's two waves: the ordinary or faster one, or the other.
pub(crate) type Mode = usize;

/// A propagating wave, its fields up to a common factor.
#[derive(Clone, Copy)]
pub(crate) struct Wave<V> {
    /// N = k/k₀.
    pub normal: Triple<V>,
    pub electric: Triple<V>,
    pub magnetic: Triple<V>,
}

impl<V: Lanes> Wave<V> {
    /// E × H, along the ray.
    #[inline(always)]
    fn poynting(&self) -> Triple<V> {
        self.electric.cross(self.magnetic)
    }
}

/// The vector's direction.
#[inline(always)]
fn unit<V: Lanes>(v: Triple<V>) -> Triple<V> {
    v.scaled(V::splat(1.0) / v.dot(v).sqrt())
}

/// Figures in single precision.
fn single<const N: usize>(figures: [f64; N]) -> [f32; N] {
    figures.map(|figure| figure as f32)
}

impl Crystal {
    /// From the optics on each lane, where these are a crystal's.
    pub fn new<'a>(lane: impl Fn(usize) -> &'a prepare::Medium) -> Option<Box<Self>> {
        let (first, _) = lane(0).crystal?;
        let each: [_; WIDTH] = std::array::from_fn(|place| lane(place).crystal.unwrap_or((first, [0.0; 3])));
        let row = |value: &dyn Fn(&core::Crystal, &[f64; 3]) -> f64| {
            Row(std::array::from_fn(|place| value(&each[place].0, &each[place].1) as f32))
        };
        let exact = each.map(|(crystal, _)| crystal);
        let uniaxial: Vec<core::Uniaxial> = exact
            .iter()
            .filter_map(|crystal| match crystal.form() {
                Form::Uniaxial(uniaxial) => Some(*uniaxial),
                Form::Biaxial(_) => None,
            })
            .collect();
        // Where indices cross, a crystal is uniaxial at single wavelengths; its axis is then no longer one for all.
        let same = uniaxial.len() == WIDTH && uniaxial.iter().all(|other| other.axis == uniaxial[0].axis);
        let form = if same {
            Kind::Uniaxial(Box::new(Uniaxial::new(&uniaxial)))
        } else {
            Kind::Biaxial(Box::new(Biaxial::new(&exact)))
        };
        let axis = |k: usize| row(&|crystal, _| crystal.indices()[k].powi(2));
        let lost = |k: usize| {
            row(&|crystal, absorption| crystal.indices()[k] * absorption[k] * std::f64::consts::LOG2_E)
        };
        Some(Box::new(Crystal {
            form,
            absorbs: each.iter().any(|(_, absorption)| absorption.iter().any(|a| *a > 0.0)),
            axes: first.axes().map(single),
            stored: [0, 1, 2].map(axis),
            lost: [0, 1, 2].map(lost),
            exact,
        }))
    }

    /// Both waves with the tangential wave vector q and energy on one side of a surface, and the lanes in which both are
    /// well away from grazing.
    #[inline(always)]
    fn waves<V: Lanes>(&self, q: Triple<V>, normal: Triple<V>, side: f32) -> ([Wave<V>; 2], V::Mask) {
        match &self.form {
            Kind::Uniaxial(uniaxial) => uniaxial.waves(q, normal, side),
            Kind::Biaxial(biaxial) => biaxial.waves(q, normal, side),
        }
    }

    /// The wave of a mode with the wave vector N, and the lanes in which it is one.
    #[inline(always)]
    fn wave<V: Lanes>(&self, mode: Mode, normal: Triple<V>) -> (Wave<V>, V::Mask) {
        match &self.form {
            Kind::Uniaxial(uniaxial) => (uniaxial.wave(mode, normal), V::Mask::from_bits(u16::MAX)),
            Kind::Biaxial(biaxial) => biaxial.wave(mode, normal),
        }
    }

    /// The exponent, to base 2, of what is left of a mode after `distance`, mm; `None` where nothing is absorbed.
    ///
    /// α = (N·ŝ) Σ n_k α_k E_k²/Σ n_k² E_k²: see `spectral_core::crystal::Crystal::absorption`.
    #[inline(always)]
    pub fn fading<V: Lanes>(&self, mode: Mode, normal: Triple<V>, ray: Triple<V>, distance: V) -> Option<V> {
        if !self.absorbs {
            return None;
        }
        let electric = self.wave(mode, normal).0.electric;
        let (mut lost, mut stored) = (V::splat(0.0), V::splat(0.0));
        for k in 0..3 {
            let along = Triple::splat(self.axes[k]).dot(electric);
            let square = along * along;
            lost = square.fma(V::load(&self.lost[k]), lost);
            stored = square.fma(V::load(&self.stored[k]), stored);
        }
        Some(-(normal.dot(ray) * (lost / stored) * distance))
    }

    /// The two modes of an eye that looks along `direction` from within: N, which has this direction, and the ray.
    pub fn of_eye(&self, directions: &[Row; 3]) -> [[[Row; 3]; 2]; 2] {
        let mut modes = [[[Row::default(); 3]; 2]; 2];
        for lane in 0..WIDTH {
            let direction = [0, 1, 2].map(|i| f64::from(directions[i].0[lane]));
            for ([normal, ray], wave) in
                modes.iter_mut().zip(self.exact[lane].waves([0.0; 3], direction, 1.0))
            {
                put(normal, lane, single(wave.wave_vector()));
                put(ray, lane, single(wave.ray()));
            }
        }
        modes
    }
}

/// What a surface sends on of a mode, given by N and its weight; n along the light's way. `beyond` is `None` for air.
#[inline(always)]
pub(crate) fn leave<V: Lanes>(
    here: &Crystal,
    mode: Mode,
    beam: (Triple<V>, V),
    n: Triple<V>,
    beyond: Option<&Medium>,
    lanes: u16,
) -> Scattered<V> {
    let crystal = beyond.and_then(|medium| medium.crystal.as_deref());
    let plain = crystal.is_none() && beyond.is_none_or(|medium| !medium.opaque);
    let (scattered, served) = if plain {
        let index = beyond.map_or(V::splat(1.0), |medium| V::load(medium.refractive()));
        let (scattered, served) = boundary::leave(here, mode, beam, n, index);
        (scattered, served.bits())
    } else {
        (Scattered::none(), 0)
    };
    let rest = lanes & !served;
    if rest == 0 {
        return scattered;
    }
    let (vectors, weights, normals) = (beam.0.stored(), beam.1.stored(), n.stored());
    let sent = exact::left(rest, here, (&vectors, &weights), &normals, |lane| match (crystal, beyond) {
        (Some(crystal), _) => Beyond::Crystal(&crystal.exact[lane]),
        (None, Some(medium)) => Beyond::Isotropic(medium.complex(lane)),
        (None, None) => Beyond::Isotropic([1.0, 0.0]),
    });
    scattered.replaced(rest, &sent)
}

/// What a surface of a crystal sends on of a row that travels along `direction`; `here` is `None` for air.
#[inline(always)]
pub(crate) fn enter<V: Lanes>(
    beyond: &Crystal,
    row: Polarized<V>,
    direction: Triple<V>,
    n: Triple<V>,
    here: Option<&Medium>,
    lanes: u16,
) -> Scattered<V> {
    let index = here.map_or(V::splat(1.0), |medium| V::load(medium.refractive()));
    let (scattered, served) = boundary::enter(beyond, row, direction, n, index);
    let rest = lanes & !served.bits();
    if rest == 0 {
        return scattered;
    }
    let Polarized { row: [i, q, u, v], axis } = row;
    let (row, axis) = ([i.stored(), q.stored(), u.stored(), v.stored()], axis.stored());
    let (directions, normals) = (direction.stored(), n.stored());
    let sent = exact::entered(rest, beyond, (&row, &axis), [&directions, &normals], &index.stored());
    scattered.replaced(rest, &sent)
}
