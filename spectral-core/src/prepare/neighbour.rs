//! Stones that come near each other.

use super::Geometry;

impl Geometry {
    /// Pairs of indices into [`stones`](Geometry::stones), each pair once: those whose boxes come within `gap`, mm, of each
    /// other along every axis.
    ///
    /// The boxes are swept along the axis on which they are spread the farthest, so that a hundred thousand stones side by
    /// side are not compared with each other.
    pub fn near_pairs(&self, gap: f64) -> impl Iterator<Item = (usize, usize)> {
        let stones = &self.stones;
        let spread = |axis: &usize| {
            let lows = stones.iter().map(|stone| stone.low[*axis]);
            lows.clone().fold(f64::NEG_INFINITY, f64::max) - lows.fold(f64::INFINITY, f64::min)
        };
        let axis = (0..3).max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or_default();
        let mut order: Vec<usize> = (0..stones.len()).collect();
        order.sort_by(|&a, &b| stones[a].low[axis].total_cmp(&stones[b].low[axis]));
        (0..order.len()).flat_map(move |place| {
            let a = order[place];
            let reach = stones[a].high[axis] + gap;
            let reached = order[place + 1..].iter().take_while(|&&b| stones[b].low[axis] <= reach);
            let near: Vec<usize> = reached.copied().filter(|&b| self.are_near(a, b, gap)).collect();
            near.into_iter().map(move |b| (a, b))
        })
    }

    fn are_near(&self, a: usize, b: usize, gap: f64) -> bool {
        let (a, b) = (&self.stones[a], &self.stones[b]);
        (a.low - b.high).max_element() <= gap && (b.low - a.high).max_element() <= gap
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::PreparedStone;
    use glam::DVec3;
    use std::collections::BTreeSet;

    /// Boxes of edge 1 at pseudo-random places, some of them large.
    fn boxes(count: u32) -> Geometry {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 16) / 65_536.0
        };
        let stone = |number: u32| {
            let low = DVec3::new(20.0 * next(), 5.0 * next(), next());
            let size = if number.is_multiple_of(17) { 6.0 } else { 1.0 };
            PreparedStone {
                name: String::new(),
                facets: 0..0,
                triangles: 0..0,
                material: 0,
                rank: number,
                convex: true,
                conductor: false,
                crystal: false,
                low,
                high: low + size,
            }
        };
        let mut geometry = Geometry::default();
        geometry.stones.extend((0..count).map(stone));
        geometry
    }

    #[test]
    fn the_sweep_finds_what_comparing_all_does() {
        for gap in [0.0, 0.3] {
            let geometry = boxes(120);
            let swept: Vec<_> = geometry.near_pairs(gap).map(|(a, b)| (a.min(b), a.max(b))).collect();
            let pairs = (0..120).flat_map(|b| (0..b).map(move |a| (a, b)));
            let all: BTreeSet<_> = pairs.filter(|&(a, b)| geometry.are_near(a, b, gap)).collect();
            assert!(!all.is_empty() && all.len() == swept.len());
            assert_eq!(swept.into_iter().collect::<BTreeSet<_>>(), all);
        }
    }
}
