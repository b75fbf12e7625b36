//! Crystals, sixteen wavelengths at a time: the single-precision twin of `spectral_core::crystal`.
//!
//! Lanes compute with real fields, which is what nearly all events have. A lane in which a wave is evanescent, or so close to
//! grazing that single precision would lose it, is left to the core in double precision (`exact`), and so are metals and
//! other crystals beyond the surface. Which lanes these are depends on each lane alone.

mod biaxial;
mod boundary;
mod exact;
mod turning;
mod uniaxial;

use crate::{medium::Medium, throughput::Polarized};
use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, put};
use biaxial::Biaxial;
pub(crate) use boundary::{Beam, Scattered};
use exact::Beyond;
use spectral_core::crystal as core;
use spectral_core::prepare;
use uniaxial::Uniaxial;

/// A crystal, a wavelength a lane.
#[derive(Debug, Clone)]
pub(crate) struct Crystal {
    frame: Frame,
    figures: Vec<Row>,
    /// The same in double precision.
    exact: [core::Crystal; WIDTH],
}

/// What a crystal has at every wavelength.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    form: Form,
    /// The axes.
    axes: [[f32; 3]; 3],
    /// Whether anything is absorbed.
    absorbs: bool,
}

#[derive(Debug, Clone)]
enum Form {
    Uniaxial(Uniaxial),
    Biaxial(Biaxial),
}

/// What lanes compute with: figures of the wavelengths, a row each, of the form first, then of absorption.
#[derive(Clone, Copy)]
pub(crate) struct Optics<'a> {
    frame: &'a Frame,
    figures: &'a [Row],
}

/// The most figures of a wavelength.
pub(crate) const FIGURES: usize = Biaxial::FIGURES + ABSORPTION;
/// n_k² along each axis, and n_k α_k to base 2, 1/mm.
const ABSORPTION: usize = 6;

/// A crystal at one wavelength with its absorption coefficients along its axes, as [`prepare::Medium`] has it.
type Line = (core::Crystal, [f64; 3]);

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

impl Frame {
    /// Of a crystal at some wavelengths.
    pub fn new<'a>(lines: impl Iterator<Item = &'a Line> + Clone) -> Option<Self> {
        let axes = lines.clone().next()?.0.axes();
        let mut axis = None;
        // Where indices cross, a crystal is uniaxial at single wavelengths; its axis is then no longer one for all.
        let same = lines.clone().all(|(crystal, _)| match crystal.form() {
            core::Form::Uniaxial(uniaxial) => *axis.get_or_insert(uniaxial.axis) == uniaxial.axis,
            core::Form::Biaxial(_) => false,
        });
        let form = match axis.filter(|_| same) {
            Some(axis) => Form::Uniaxial(Uniaxial::new(axis)),
            None => Form::Biaxial(Biaxial::new(axes)),
        };
        let absorbs = lines.flat_map(|(_, absorption)| absorption).any(|a| *a > 0.0);
        Some(Frame { form, axes: axes.map(single), absorbs })
    }

    /// How many figures lanes compute with.
    pub fn count(&self) -> usize {
        self.of_form() + if self.absorbs { ABSORPTION } else { 0 }
    }

    fn of_form(&self) -> usize {
        match self.form {
            Form::Uniaxial(_) => Uniaxial::FIGURES,
            Form::Biaxial(_) => Biaxial::FIGURES,
        }
    }

    /// The figures of one wavelength.
    pub fn figures(&self, (crystal, absorption): &Line) -> Vec<f32> {
        let mut figures = match (&self.form, crystal.form()) {
            (Form::Uniaxial(_), core::Form::Uniaxial(uniaxial)) => Uniaxial::figures(uniaxial).to_vec(),
            _ => Biaxial::figures(crystal).to_vec(),
        };
        let indices = crystal.indices();
        figures.extend(indices.map(|n| (n * n) as f32));
        let lost = |(n, a)| (n * a * std::f64::consts::LOG2_E) as f32;
        figures.extend(indices.into_iter().zip(absorption).map(lost));
        figures
    }

    /// With the figures of sixteen wavelengths.
    #[inline(always)]
    pub fn at<'a>(&'a self, figures: &'a [Row]) -> Optics<'a> {
        Optics { frame: self, figures }
    }
}

impl<'a> Optics<'a> {
    /// Both waves with the tangential wave vector q and energy on one side of a surface, and the lanes in which both are
    /// well away from grazing.
    #[inline(always)]
    fn waves<V: Lanes>(&self, q: Triple<V>, normal: Triple<V>, side: f32) -> ([Wave<V>; 2], V::Mask) {
        match &self.frame.form {
            Form::Uniaxial(uniaxial) => uniaxial.waves(self.rows(0), q, normal, side),
            Form::Biaxial(biaxial) => biaxial.waves(self.rows(0), q, normal, side),
        }
    }

    /// The wave with the wave vector N of the second mode in some lanes and of the first in the others, and the lanes in which
    /// it is one.
    #[inline(always)]
    fn wave<V: Lanes>(&self, second: V::Mask, normal: Triple<V>) -> (Wave<V>, V::Mask) {
        match &self.frame.form {
            Form::Uniaxial(uniaxial) => {
                (uniaxial.wave(self.rows(0), second, normal), V::Mask::from_bits(u16::MAX))
            }
            Form::Biaxial(biaxial) => biaxial.wave(self.rows(0), second, normal),
        }
    }

    /// Some of the figures.
    #[inline(always)]
    fn rows<const N: usize>(&self, first: usize) -> &'a [Row; N] {
        self.figures[first..].first_chunk().expect("as many figures as the form has")
    }

    /// The exponent, to base 2, of what is left of a mode after `distance`, mm; `None` where nothing is absorbed.
    ///
    /// α = (N·ŝ) Σ n_k α_k E_k²/Σ n_k² E_k²: see `spectral_core::crystal::Crystal::absorption`.
    #[inline(always)]
    pub fn fading<V: Lanes>(
        &self,
        second: V::Mask,
        normal: Triple<V>,
        ray: Triple<V>,
        distance: V,
    ) -> Option<V> {
        if !self.frame.absorbs {
            return None;
        }
        let figures: &[Row; ABSORPTION] = self.rows(self.frame.of_form());
        let (squares, losses) = figures.split_at(3);
        let electric = self.wave(second, normal).0.electric;
        let (mut lost, mut stored) = (V::splat(0.0), V::splat(0.0));
        for (axis, (square, loss)) in self.frame.axes.iter().zip(squares.iter().zip(losses)) {
            let along = Triple::splat(*axis).dot(electric);
            let share = along * along;
            stored = share.fma(V::load(square), stored);
            lost = share.fma(V::load(loss), lost);
        }
        Some(-(normal.dot(ray) * (lost / stored) * distance))
    }
}

impl Crystal {
    /// From the optics on each lane, where these are a crystal's.
    pub fn new<'a>(lane: impl Fn(usize) -> &'a prepare::Medium) -> Option<Box<Self>> {
        let (first, _) = lane(0).crystal?;
        let each: [_; WIDTH] = std::array::from_fn(|place| lane(place).crystal.unwrap_or((first, [0.0; 3])));
        let frame = Frame::new(each.iter())?;
        let lines = each.each_ref().map(|line| frame.figures(line));
        let row = |k: usize| Row(std::array::from_fn(|place| lines[place][k]));
        let figures = (0..frame.count()).map(row).collect();
        Some(Box::new(Crystal { frame, figures, exact: each.map(|(crystal, _)| crystal) }))
    }

    /// In double precision.
    pub fn exact(&self, lane: usize) -> &core::Crystal {
        &self.exact[lane]
    }

    /// What lanes compute with.
    #[inline(always)]
    pub fn optics(&self) -> Optics<'_> {
        self.frame.at(&self.figures)
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
pub(crate) fn leave<'a, V: Lanes>(
    here: Optics<'_>,
    exact: impl Fn(usize) -> &'a core::Crystal,
    second: V::Mask,
    beam: (Triple<V>, V),
    n: Triple<V>,
    beyond: Option<&'a Medium>,
    lanes: u16,
) -> Scattered<V> {
    let crystal = beyond.and_then(|medium| medium.crystal.as_deref());
    let plain = crystal.is_none() && beyond.is_none_or(|medium| !medium.opaque);
    let (scattered, served) = if plain {
        let index = beyond.map_or(V::splat(1.0), |medium| V::load(medium.refractive()));
        let (scattered, served) = boundary::leave(here, second, beam, n, index);
        (scattered, served.bits())
    } else {
        (Scattered::none(), 0)
    };
    let rest = lanes & !served;
    if rest == 0 {
        return scattered;
    }
    let (vectors, weights, normals) = (beam.0.stored(), beam.1.stored(), n.stored());
    let sent = exact::left(rest, exact, (&vectors, &weights), &normals, |lane| match (crystal, beyond) {
        (Some(crystal), _) => Beyond::Crystal(&crystal.exact[lane]),
        (None, Some(medium)) => Beyond::Isotropic(medium.complex(lane)),
        (None, None) => Beyond::Isotropic([1.0, 0.0]),
    });
    scattered.replaced(rest, &sent)
}

/// What a surface of a crystal with the normal n sends on of a row that travels along `direction`; `here` is `None` for air.
#[inline(always)]
pub(crate) fn enter<'a, V: Lanes>(
    beyond: Optics<'_>,
    exact: impl Fn(usize) -> &'a core::Crystal,
    row: Polarized<V>,
    [direction, n]: [Triple<V>; 2],
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
    let sent = exact::entered(rest, exact, (&row, &axis), [&directions, &normals], &index.stored());
    scattered.replaced(rest, &sent)
}
