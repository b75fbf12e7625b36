//! The wavelengths of a pixel's samples in blocks of sixteen lanes: what they have in common for all pixels.

use crate::{
    lanes::{Lanes, Row, Triple, WIDTH},
    line::Line,
};

/// Sixteen spectral lines. The lines of a pixel's samples follow each other, wavelengths innermost, so that a
/// block may hold the end of one sample and the beginning of the next.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// The lanes that hold a line.
    pub lanes: u16,
    /// Of each lane, its sample counted from the pixel's first; empty lanes repeat the last.
    pub sample: [u32; WIDTH],
    /// The stone's index of refraction n, n² and 1 − n².
    pub index: [Row; 3],
    /// The same of 1/n.
    pub inverse: [Row; 3],
    /// Absorption as a power of two, 1/mm.
    pub fade: Row,
    /// Whether anything is absorbed.
    pub absorbs: bool,
    /// Smits's bases, as in [`Line`].
    basis: [Row; 7],
}

impl Block {
    /// The blocks of samples with these lines each, for a stone of one material.
    pub fn all<'a>(samples: impl Iterator<Item = &'a [Line]>, material: usize) -> Vec<Self> {
        let lines: Vec<(u32, &Line)> =
            (0..).zip(samples).flat_map(|(s, lines)| lines.iter().map(move |line| (s, line))).collect();
        lines.chunks(WIDTH).map(|chunk| Self::new(chunk, material)).collect()
    }

    fn new(lines: &[(u32, &Line)], material: usize) -> Self {
        let place = |lane: usize| lines[lane.min(lines.len() - 1)];
        let row = |value: &dyn Fn(&Line) -> f64| {
            let mut row = Row::default();
            for lane in 0..WIDTH {
                row.0[lane] = value(place(lane).1) as f32;
            }
            row
        };
        let n = |line: &Line| f64::from(line.media[material].n);
        let fade = row(&|line| f64::from(line.media[material].absorption) * std::f64::consts::LOG2_E);
        Block {
            lanes: ((1u32 << lines.len()) - 1) as u16,
            sample: std::array::from_fn(|lane| place(lane).0),
            index: [row(&n), row(&|l| n(l) * n(l)), row(&|l| 1.0 - n(l) * n(l))],
            inverse: [
                row(&|l| 1.0 / n(l)),
                row(&|l| 1.0 / (n(l) * n(l))),
                row(&|l| 1.0 - 1.0 / (n(l) * n(l))),
            ],
            absorbs: fade.0.iter().any(|a| *a > 0.0),
            fade,
            basis: std::array::from_fn(|k| row(&|line| f64::from(line.basis()[k]))),
        }
    }

    /// Radiances of linear sRGB colours: [`Line::expand`] with selections in place of branches. Where two
    /// components are equal, either choice gives the same, since their difference is what it weighs.
    #[inline(always)]
    pub fn expand<V: Lanes>(&self, Triple { x: r, y: g, z: b }: Triple<V>) -> V {
        let [white, cyan, magenta, yellow, red, green, blue] = &self.basis;
        let least = r.min(g).min(b);
        let most = r.max(g).max(b);
        let middle = r.min(g).max(r.max(g).min(b));
        // The secondary lacks the least component; the primary is the greatest.
        let (r_over, g_over) = (least.lt(r), least.lt(g));
        let secondary =
            V::select(r_over, V::select(g_over, V::load(yellow), V::load(magenta)), V::load(cyan));
        let (r_under, g_under) = (r.lt(most), g.lt(most));
        let primary = V::select(r_under, V::select(g_under, V::load(blue), V::load(green)), V::load(red));
        (most - middle).fma(primary, (middle - least).fma(secondary, least * V::load(white)))
    }
}
