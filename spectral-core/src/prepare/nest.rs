//! Which stones a ray is in: the interface priorities of nested and touching stones.
//!
//! After Schmidt & Budge (2002), "Simple nested dielectrics in ray traced images": stones may overlap, and
//! the one of highest rank fills the common space. Crossing a surface that lies inside a stone of higher
//! rank is no event. Keeping the set also makes intersection robust: a ray can only enter a stone it is
//! outside of and leave one it is inside of, so the surface it starts on never hides the next one.

/// A stone's place in the order of priority; unique in a scene, higher fills the common space.
pub type Rank = u32;

/// The stones that a point lies in, by [`Rank`]; at most [`Nest::CAPACITY`].
///
/// ```
/// use spectral_core::prepare::Nest;
/// let nest = Nest::default().toggled(3).toggled(7);
/// assert_eq!(nest.top(), Some(7));
/// assert_eq!(nest.toggled(7).top(), Some(3));
/// assert!(nest.toggled(7).toggled(3).is_empty());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Nest {
    /// Ranks in descending order, the first `len` of them.
    ranks: [Rank; Nest::CAPACITY],
    len: u8,
}

impl Nest {
    /// The most stones that may overlap at one point; a scene with more is refused. Where rounding adds another, those of
    /// the lowest ranks are ignored.
    pub const CAPACITY: usize = 6;

    /// The ranks in descending order.
    pub(crate) fn ranks(&self) -> &[Rank] {
        &self.ranks[..self.len as usize]
    }

    /// Whether the point lies in no stone.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The stone that fills the space here; `None` is air.
    pub fn top(&self) -> Option<Rank> {
        (self.len > 0).then(|| self.ranks[0])
    }

    /// Whether the point lies in the stone of this rank.
    pub fn contains(&self, rank: Rank) -> bool {
        self.ranks[..self.len as usize].contains(&rank)
    }

    /// The set after crossing the surface of the stone of this rank: entered if outside, left if inside.
    #[must_use]
    pub fn toggled(mut self, rank: Rank) -> Self {
        let len = self.len as usize;
        let place = self.ranks[..len].partition_point(|r| *r > rank);
        if place < len && self.ranks[place] == rank {
            self.ranks.copy_within(place + 1..len, place);
            self.len -= 1;
        } else if place < Self::CAPACITY {
            let kept = len.min(Self::CAPACITY - 1);
            self.ranks.copy_within(place..kept.max(place), place + 1);
            self.ranks[place] = rank;
            self.len = kept as u8 + 1;
        }
        // Unused places hold 0, so that equal sets compare equal.
        self.ranks[self.len as usize..].fill(0);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_rank_is_forgotten_when_full() {
        let full = [5, 1, 9, 3, 7, 11].into_iter().fold(Nest::default(), Nest::toggled);
        assert_eq!(full.ranks, [11, 9, 7, 5, 3, 1]);
        assert_eq!(full.toggled(0), full);
        let more = full.toggled(8);
        assert_eq!(more.ranks, [11, 9, 8, 7, 5, 3]);
        assert!(more.contains(8) && !more.contains(1));
    }

    #[test]
    fn order_of_crossing_does_not_matter() {
        let a = Nest::default().toggled(2).toggled(9).toggled(4).toggled(2);
        let b = Nest::default().toggled(4).toggled(9);
        assert_eq!(a, b);
    }
}
