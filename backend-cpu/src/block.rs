//! The wavelengths of a pixel's samples in blocks of sixteen lanes: what they have in common for all pixels.

use accel::lanes::{Lanes, Row, Triple, WIDTH};
use spectral_core::prepare::{self, SpectralTable};

/// The optics of a material on each lane.
#[derive(Debug, Clone)]
pub(crate) struct Medium {
    /// Index of refraction n, n² and 1 − n².
    pub index: [Row; 3],
    /// The same of 1/n, and what rounding took from the latter two.
    pub inverse: [Row; 5],
    /// Extinction coefficient; above 0 for metals only.
    pub k: Row,
    /// Absorption as a power of two, 1/mm.
    pub fade: Row,
    /// Whether anything is absorbed.
    pub absorbs: bool,
    /// Whether it is a metal.
    pub metal: bool,
}

/// Sixteen spectral lines of the samples of one pixel, or of a few, neighbours by wavelength: within a pixel it is
/// dispersion that parts rays, not where in the pixel they began, for plane mirrors keep parallel rays parallel. So they
/// meet the same facets for longer than the lines of one sample would.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// The lanes that hold a line: the first ones.
    pub lanes: u16,
    /// Of each lane, its place among the lines of the pixels' samples, pixel by pixel, sample by sample, wavelengths
    /// innermost.
    place: [u32; WIDTH],
    /// Of each lane, its sample counted from the first pixel's first; empty lanes repeat the last.
    pub sample: [u32; WIDTH],
    /// Whether that is one and the same.
    pub together: bool,
    /// By material.
    pub media: Vec<Medium>,
    /// Radiance of Smits's seven bases (white, cyan, magenta, yellow, red, green, blue), light and scale included.
    basis: [Row; 7],
}

/// A spectral line of one sample's wavelength grid.
struct Line<'a> {
    sample: u32,
    table: &'a SpectralTable,
    index: usize,
    place: u32,
}

impl Line<'_> {
    fn wavelength(&self) -> f64 {
        self.table.wavelengths[self.index]
    }

    fn basis(&self) -> &[f64; 7] {
        &self.table.basis[self.index]
    }
}

impl Medium {
    /// From the optics on each lane.
    fn new(lane: impl Fn(usize) -> prepare::Medium) -> Self {
        let row = |value: &dyn Fn(&prepare::Medium) -> f64| {
            Row(std::array::from_fn(|place| value(&lane(place)) as f32))
        };
        // n as single precision has it, so that all that is made of it fits together.
        let n = |medium: &prepare::Medium| f64::from(medium.n as f32);
        let inverse = |medium: &prepare::Medium| f64::from((1.0 / n(medium)) as f32);
        let square = |medium: &prepare::Medium| inverse(medium) * inverse(medium);
        let one_less = |medium: &prepare::Medium| 1.0 - square(medium);
        let rest = |value: f64| value - f64::from(value as f32);
        let fade = row(&|medium| medium.absorption * std::f64::consts::LOG2_E);
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
            absorbs: fade.0.iter().any(|a| *a > 0.0),
            metal: k.0.iter().any(|k| *k > 0.0),
            k,
            fade,
        }
    }
}

impl Block {
    /// How many pixels with so many lines had best share their blocks: lanes that hold nothing cost as much as those
    /// that do, but rays of different pixels meet different facets sooner.
    pub fn pixels(lines: usize) -> usize {
        // What a line costs more, measured on a brilliant.
        const SHARED: [(usize, f64); 3] = [(1, 1.0), (2, 1.1), (4, 1.3)];
        let cost = |&(pixels, cost): &(usize, f64)| {
            cost * (pixels * lines).next_multiple_of(WIDTH) as f64 / (pixels * lines) as f64
        };
        SHARED.iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).map_or(1, |(pixels, _)| *pixels)
    }

    /// The blocks of some pixels' samples with these tables, every pixel's the same.
    pub fn all<'a>(pixels: usize, samples: impl Iterator<Item = &'a SpectralTable> + Clone) -> Vec<Self> {
        let samples = (0..pixels).flat_map(|_| samples.clone());
        let mut lines: Vec<Line<'_>> = (0..)
            .zip(samples)
            .flat_map(|(sample, table)| (0..table.wavelengths.len()).map(move |index| (sample, table, index)))
            .zip(0..)
            .map(|((sample, table, index), place)| Line { sample, table, index, place })
            .collect();
        lines.sort_by(|a, b| a.wavelength().total_cmp(&b.wavelength()));
        lines.chunks(WIDTH).map(Self::new).collect()
    }

    fn new(lines: &[Line<'_>]) -> Self {
        let line = |lane: usize| &lines[lane.min(lines.len() - 1)];
        let basis = |k: usize| Row(std::array::from_fn(|lane| line(lane).basis()[k] as f32));
        let materials = lines.first().map_or(0, |line| line.table.media.len());
        let medium = |m: usize| Medium::new(|lane| line(lane).table.media[m][line(lane).index]);
        Block {
            lanes: ((1u32 << lines.len()) - 1) as u16,
            place: std::array::from_fn(|lane| line(lane).place),
            sample: std::array::from_fn(|lane| line(lane).sample),
            together: lines.iter().all(|line| line.sample == lines[0].sample),
            media: (0..materials).map(medium).collect(),
            basis: std::array::from_fn(basis),
        }
    }

    /// Puts each line's number where it belongs among those of its pixels.
    #[inline(always)]
    pub fn scatter<V: Lanes>(&self, values: V, pixels: &mut [f32]) {
        let values = values.stored().0;
        for lane in 0..self.lanes.count_ones() as usize {
            pixels[self.place[lane] as usize] = values[lane];
        }
    }

    /// Radiances of non-negative linear sRGB colours by Smits's expansion: the least component is white, what the
    /// middle one has more is the secondary of the two larger, the rest is the primary of the largest. Where two
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
