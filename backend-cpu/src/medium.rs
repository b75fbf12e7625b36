//! The optics of materials, and the surfaces between them, for sixteen wavelengths at a time: the twin of
//! `spectral_core::prepare::Medium`.

use crate::{
    crystal::Crystal,
    incidence::{Incidence, Reflection},
    throughput::Throughput,
};
use accel::lanes::{Lanes, Row, WIDTH, exp2};
use spectral_core::prepare;

/// The optics of a material, a wavelength a lane.
#[derive(Debug, Clone)]
pub(crate) struct Medium {
    /// Index of refraction n, n² and 1 − n².
    index: [Row; 3],
    /// The same of 1/n, and the rounding errors of the latter two.
    inverse: [Row; 5],
    /// Extinction coefficient.
    k: Row,
    /// Absorption coefficient to base 2, 1/mm.
    absorption: Row,
    /// Whether anything is absorbed.
    absorbs: bool,
    /// Whether light ends at its surface or is reflected there.
    pub opaque: bool,
    /// Of a crystal its modes; the rest is then that of its first axis.
    pub crystal: Option<Box<Crystal>>,
}

impl Medium {
    /// From the optics on each lane.
    pub fn new<'a>(lane: impl Fn(usize) -> &'a prepare::Medium) -> Self {
        let row = |value: &dyn Fn(&prepare::Medium) -> f64| {
            Row(std::array::from_fn(|place| value(lane(place)) as f32))
        };
        // n as single precision has it, so that all that is made of it fits together.
        let n = |medium: &prepare::Medium| f64::from(medium.n as f32);
        let inverse = |medium: &prepare::Medium| f64::from((1.0 / n(medium)) as f32);
        let square = |medium: &prepare::Medium| inverse(medium) * inverse(medium);
        let one_less = |medium: &prepare::Medium| 1.0 - square(medium);
        let rest = |value: f64| value - f64::from(value as f32);
        let absorption = row(&|medium| medium.absorption * std::f64::consts::LOG2_E);
        let k = row(&|medium| medium.k);
        Medium {
            index: [row(&n), row(&|m| n(m) * n(m)), row(&|m| 1.0 - n(m) * n(m))],
            inverse: [
                row(&inverse),
                row(&square),
                row(&one_less),
                row(&|m| rest(square(m))),
                row(&|m| rest(one_less(m))),
            ],
            absorbs: absorption.0.iter().any(|a| *a > 0.0),
            opaque: k.0.iter().any(|k| *k > 0.0),
            k,
            absorption,
            crystal: Crystal::new(lane),
        }
    }

    /// The index of refraction.
    pub fn refractive(&self) -> &Row {
        &self.index[0]
    }

    /// Of a lane n, n² and 1 − n², and the absorption coefficient to base 2.
    pub fn outward(&self, lane: usize) -> [f32; 4] {
        let [n, n2, one_less_n2] = &self.index;
        [n, n2, one_less_n2, &self.absorption].map(|row| row.0[lane])
    }

    /// Of a lane what [`entered`](Self::entered) needs.
    pub fn inward(&self, lane: usize) -> [f32; 5] {
        self.inverse.map(|row| row.0[lane])
    }

    /// n and k of a lane.
    pub fn complex(&self, lane: usize) -> [f64; 2] {
        [&self.index[0], &self.k].map(|row| f64::from(row.0[lane]))
    }

    /// Leaves of a throughput what is not absorbed over `distance`, mm.
    #[inline(always)]
    pub fn fade<V: Lanes, T: Throughput<V>>(&self, throughput: &mut T, distance: V) {
        if self.absorbs {
            *throughput = throughput.scaled(exp2(-(V::load(&self.absorption) * distance)));
        }
    }

    /// Rays that come from air.
    #[inline(always)]
    pub fn entered<V: Lanes>(&self, cosine: V) -> Incidence<V> {
        Incidence::entering(cosine, &self.inverse)
    }

    /// Rays that go into air.
    #[inline(always)]
    pub fn left<V: Lanes>(&self, cosine: V) -> Incidence<V> {
        let [n, n2, one_less_n2] = &self.index;
        Incidence::new(cosine, V::load(n), V::load(n2), V::load(one_less_n2))
    }
}

/// The two media of a surface event, `None` for air.
pub(crate) struct Interface<'a> {
    /// On the side that rays come from.
    pub here: Option<&'a Medium>,
    /// On the other side.
    pub beyond: Option<&'a Medium>,
}

impl Interface<'_> {
    /// Whether nothing goes through.
    #[inline(always)]
    pub fn is_opaque(&self) -> bool {
        self.beyond.is_some_and(|beyond| beyond.opaque)
    }

    /// For transparent media.
    #[inline(always)]
    pub fn incidence<V: Lanes>(&self, cosine: V) -> Incidence<V> {
        let one = V::splat(1.0);
        match (self.here, self.beyond) {
            (Some(here), None) => here.left(cosine),
            (None, Some(beyond)) => beyond.entered(cosine),
            (Some(here), Some(beyond)) => {
                Incidence::between(cosine, V::load(&here.index[0]), V::load(&beyond.index[0]))
            }
            (None, None) => Incidence::between(cosine, one, one),
        }
    }

    /// What the metal beyond reflects.
    #[inline(always)]
    pub fn metal<V: Lanes>(&self, cosine: V) -> Reflection<V> {
        let air = Row([1.0; WIDTH]);
        let here = self.here.map_or(&air, |here| &here.index[0]);
        let [n, k] = self.beyond.map_or([&air, &air], |beyond| [&beyond.index[0], &beyond.k]);
        Reflection::load(&Reflection::<V>::metal(&cosine.stored(), here, n, k))
    }
}
