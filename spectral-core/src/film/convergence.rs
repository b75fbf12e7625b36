//! Adaptive sampling: parts of a picture that the last samples changed need more.

use super::Tile;
use crate::color::{RgbSpace, delta_e_2000, lab};

/// Edge of the blocks that are settled together, pixels, unless samples are areas. All samples of one pixel may miss a small
/// lamp, but those of sixteen pixels rarely do. Rectangles are also efficient in every backend.
pub const BLOCK: u32 = 4;

/// The picture at the last check, and the blocks that need no more samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Convergence {
    width: u32,
    height: u32,
    /// Edge of a block, pixels.
    block: u32,
    /// CIE L*a*b* of every pixel at the last check; empty before the first.
    before: Vec<[f32; 3]>,
    /// For each block, row by row.
    settled: Vec<bool>,
    /// The change of each block when it was last compared, ΔE00; empty before the second check.
    changes: Vec<f32>,
    /// The number of samples at the last check.
    checked: u32,
}

impl Convergence {
    pub fn new(width: u32, height: u32, block: u32) -> Self {
        let blocks = width.div_ceil(block) as usize * height.div_ceil(block) as usize;
        Convergence {
            width,
            height,
            block,
            before: Vec::new(),
            settled: vec![false; blocks],
            changes: Vec::new(),
            checked: 0,
        }
    }

    /// Edge of a block, pixels.
    pub fn block(&self) -> u32 {
        self.block
    }

    /// For each pixel of a row, whether its block is settled.
    pub fn settled_in_row(&self, row: Tile) -> impl Iterator<Item = bool> {
        let first = (row.y / self.block * self.width.div_ceil(self.block)) as usize;
        (row.x..row.x + row.width).map(move |x| self.settled[first + (x / self.block) as usize])
    }

    /// See [`Film::settle`](super::Film::settle); `xyz` is each pixel's mean.
    pub fn settle(&mut self, samples: u32, tolerance: f64, xyz: impl Fn(usize) -> [f32; 3]) {
        if samples <= self.checked {
            return;
        }
        self.checked = samples;
        let white = RgbSpace::Xyz.white_xyz();
        let pixels = self.width as usize * self.height as usize;
        let now: Vec<[f32; 3]> =
            (0..pixels).map(|i| lab(xyz(i).map(f64::from), white).map(|v| v as f32)).collect();
        if !self.before.is_empty() {
            self.changes.resize(self.settled.len(), 0.0);
            for block in 0..self.settled.len() {
                if !self.settled[block] {
                    let change = self.change(block, &now);
                    self.changes[block] = change as f32;
                    self.settled[block] = change <= tolerance;
                }
            }
        }
        self.before = now;
    }

    /// The root mean square of the changes of all blocks.
    pub fn mean_change(&self) -> Option<f64> {
        let squares = self.changes.iter().map(|change| f64::from(*change).powi(2)).sum::<f64>();
        (!self.changes.is_empty()).then(|| (squares / self.changes.len() as f64).sqrt())
    }

    /// The root mean square of the differences of a block's pixels from before, ΔE00.
    fn change(&self, block: usize, now: &[[f32; 3]]) -> f64 {
        let across = self.width.div_ceil(self.block) as usize;
        let edge = self.block as usize;
        let [x, y] = [block % across * edge, block / across * edge];
        let [width, height] = [self.width as usize, self.height as usize];
        let (mut sum, mut pixels) = (0.0, 0.0);
        for y in y..height.min(y + edge) {
            let row = y * width + x..y * width + width.min(x + edge);
            for (before, now) in self.before[row.clone()].iter().zip(&now[row]) {
                sum += delta_e_2000(before.map(f64::from), now.map(f64::from)).powi(2);
                pixels += 1.0;
            }
        }
        (sum / pixels).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GREY: [f32; 3] = [0.2, 0.21, 0.23];

    /// Two blocks. The second is `change` times as bright at each further check.
    fn checked(change: f32, tolerance: f64, samples: &[u32]) -> Convergence {
        let mut it = Convergence::new(2 * BLOCK, BLOCK, BLOCK);
        for (k, &n) in samples.iter().enumerate() {
            let factor = change.powi(k as i32);
            it.settle(n, tolerance, |pixel| {
                let second = pixel as u32 % (2 * BLOCK) >= BLOCK;
                GREY.map(|v| if second { v * factor } else { v })
            });
        }
        it
    }

    #[test]
    fn only_blocks_that_no_longer_change_are_settled() {
        assert_eq!(checked(1.5, 1.0, &[3, 9]).settled, [true, false]);
        assert_eq!(checked(1.001, 1.0, &[3, 9]).settled, [true, true]);
        // The first check has nothing to compare with.
        assert_eq!(checked(1.0, 1.0, &[3]).settled, [false, false]);
    }

    #[test]
    fn the_tolerance_is_a_colour_difference() {
        let white = RgbSpace::Xyz.white_xyz();
        let of = |factor: f32| lab(GREY.map(|v| f64::from(v * factor)), white);
        let difference = delta_e_2000(of(1.0), of(1.1));
        assert_eq!(checked(1.1, difference * 1.0001, &[3, 9]).settled, [true, true]);
        assert_eq!(checked(1.1, difference * 0.9999, &[3, 9]).settled, [true, false]);
    }

    #[test]
    fn a_block_of_one_pixel_is_judged_by_itself() {
        let mut it = Convergence::new(3, 1, 1);
        for (n, change) in [(1, 1.0), (3, 1.5)] {
            it.settle(n, 1.0, |pixel| if pixel == 1 { GREY.map(|v| v * change) } else { GREY });
        }
        let row: Vec<bool> = it.settled_in_row(Tile { x: 0, y: 0, width: 3, height: 1 }).collect();
        assert_eq!(row, [true, false, true]);
    }

    #[test]
    fn a_film_is_checked_once_at_each_number_of_samples() {
        let first = checked(1.5, 1.0, &[3, 9]);
        assert_eq!(checked(1.5, 1.0, &[3, 9, 9]), first);
        assert_eq!(checked(1.5, 1.0, &[3, 9, 3]), first);
        let mut later = checked(1.5, 1.0, &[3, 9]);
        later.settle(27, 1e9, |_| GREY);
        assert_eq!(later.settled, [true, true]);
    }
}
