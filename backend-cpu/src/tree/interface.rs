//! The two media of a surface event, a wavelength a lane.

use crate::{
    block::Medium,
    incidence::{Incidence, Reflection},
};
use accel::lanes::{Lanes, Row, WIDTH};

/// Two media, `None` for air.
pub(super) struct Interface<'a> {
    /// On the side that rays come from.
    pub here: Option<&'a Medium>,
    /// On the other side.
    pub beyond: Option<&'a Medium>,
}

impl Interface<'_> {
    /// Whether nothing goes through.
    #[inline(always)]
    pub fn is_opaque(&self) -> bool {
        self.beyond.is_some_and(|beyond| beyond.metal)
    }

    /// For transparent media.
    #[inline(always)]
    pub fn incidence<V: Lanes>(&self, cosine: V) -> Incidence<V> {
        let one = V::splat(1.0);
        match (self.here, self.beyond) {
            (Some(here), None) => {
                let [n, n2, one_less] = &here.index;
                Incidence::new(cosine, V::load(n), V::load(n2), V::load(one_less))
            }
            (None, Some(beyond)) => Incidence::entering(cosine, &beyond.inverse),
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
