//! Where beams begin: the parts of a tile's pixels, and the light that needs no beam.

use super::line::Line;
use crate::{
    account::Account,
    block::Block,
    environment::{Light, Lookup},
    sums::Sums,
    throughput::first_axis,
};
use accel::lanes::{Lanes, Row, Triple, WIDTH, put};
use glam::DVec3;
use spectral_core::{
    beam::{Piece, Polygon, Silhouette, Uncovered},
    film::Tile,
    prepare::PreparedScene,
    scene::Background,
};

/// A part of a pixel that enters by one facet, at its centroid.
#[derive(Debug, Clone, Copy)]
struct Entry {
    facet: usize,
    /// The pixel's number in the tile.
    pixel: u32,
    /// Share of the pixel.
    area: f32,
    polygon: Polygon,
    /// Origin and direction, and their derivatives by u and v.
    ray: [[f32; 3]; 2],
    by: [[[f32; 3]; 2]; 2],
    /// Unit normal into the stone.
    ahead: [f32; 3],
    /// e_s of the plane of incidence.
    axis: [f32; 3],
    /// Of the angle of incidence, and its derivatives.
    cosine: f32,
    cosine_by: [f32; 2],
    /// The colour that the surface mirrors.
    colour: [f32; 3],
}

/// The part of a pixel beside the stone.
#[derive(Debug, Clone, Copy, Default)]
struct Beside {
    /// Share of the pixel.
    area: f32,
    colour: [f32; 3],
}

/// All that is seen in a tile.
pub(crate) struct Entries {
    /// By facet.
    entries: Vec<Entry>,
    /// By pixel.
    beside: Vec<Beside>,
    transparent: bool,
}

fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

impl Entry {
    fn new(scene: &PreparedScene, pixel: u32, piece: &Piece) -> Self {
        let ahead = -scene.geometry.facets_of(&scene.geometry.stones[0])[piece.facet].normal;
        let pencil = &piece.pencil;
        let direction = single(pencil.direction);
        Entry {
            facet: piece.facet,
            pixel,
            area: piece.area as f32,
            polygon: piece.polygon,
            ray: [single(pencil.origin), direction],
            by: [pencil.origin_by.map(single), pencil.direction_by.map(single)],
            ahead: single(ahead),
            axis: first_axis(direction, single(-ahead)),
            cosine: ahead.dot(pencil.direction) as f32,
            cosine_by: pencil.direction_by.map(|by| ahead.dot(by) as f32),
            colour: [0.0; 3],
        }
    }
}

impl Entries {
    pub fn new(silhouette: &Silhouette, scene: &PreparedScene, tile: Tile) -> Self {
        let (mut entries, mut beside, mut pieces) = (Vec::new(), Vec::new(), Vec::new());
        let rows = tile.y..tile.y + tile.height;
        let pixels = rows.flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| [x, y]));
        for (pixel, [x, y]) in (0..).zip(pixels) {
            let uncovered = silhouette.pieces(x, y, &mut pieces);
            entries.extend(pieces.iter().map(|piece| Entry::new(scene, pixel, piece)));
            beside.push(uncovered.map_or_else(Beside::default, |Uncovered { area, centroid: [u, v] }| {
                let ray = scene.view.ray(f64::from(x) + 0.5 + u, f64::from(y) + 0.5 + v);
                Beside { area: area as f32, colour: scene.background_of(&ray) }
            }));
        }
        // Beams that enter by the same facet stay together for longer.
        entries.sort_by_key(|entry| entry.facet);
        Entries { entries, beside, transparent: scene.background == Background::Transparent }
    }

    pub fn pixels(&self) -> usize {
        self.beside.len()
    }

    /// The coverage of each pixel, for each of its samples.
    pub fn coverage(&self, samples: usize) -> Vec<f32> {
        self.beside.iter().flat_map(|pixel| std::iter::repeat_n(1.0 - pixel.area, samples)).collect()
    }

    /// Looks up what the first surface mirrors.
    #[inline(always)]
    pub fn mirror<V: Lanes>(&mut self, light: &Light) {
        for group in self.entries.chunks_mut(WIDTH) {
            let mut rows = [[Row::default(); 3]; 3];
            let (mut cosine, lanes) = (Row::default(), (1u32 << group.len()) - 1);
            for (lane, entry) in group.iter().enumerate() {
                put(&mut rows[0], lane, entry.ray[0]);
                put(&mut rows[1], lane, entry.ray[1]);
                put(&mut rows[2], lane, entry.ahead);
                cosine.0[lane] = 2.0 * entry.cosine;
            }
            let mirrored = Triple::<V>::load(&rows[2]).fnma(V::load(&cosine), Triple::load(&rows[1]));
            let lookup = Lookup::new(light, Triple::load(&rows[0]), mirrored.renormalized());
            let colours = lookup.colours(light, lanes as u16).stored();
            for (lane, entry) in group.iter_mut().enumerate() {
                entry.colour = [colours[0].0[lane], colours[1].0[lane], colours[2].0[lane]];
            }
        }
    }

    /// Adds the light beside the stone.
    #[inline(always)]
    pub fn behind<V: Lanes>(&self, blocks: &[Block], lines: usize, sums: &mut Sums, account: &mut Account) {
        if self.transparent {
            return;
        }
        for (pixel, beside) in self.beside.iter().enumerate() {
            if beside.area == 0.0 {
                continue;
            }
            account.count(lines as u64);
            for block in blocks {
                let seen = block.basis.expand(Triple::<V>::splat(beside.colour)) * V::splat(beside.area);
                let seen = seen.stored();
                for lane in 0..block.lanes.count_ones() as usize {
                    sums.add(pixel * lines + block.place(lane) as usize, seen.0[lane]);
                }
            }
        }
    }
}

/// The number of entries with so many lines each that fill packets.
fn together(lines: usize) -> usize {
    (1..WIDTH).find(|entries| (entries * lines).is_multiple_of(WIDTH)).unwrap_or(WIDTH)
}

/// Sixteen spectral lines of entries, a lane each.
pub(crate) struct Arrivals<'a> {
    entries: &'a [Entry],
    lines: &'a [Line],
    /// Entries that share packets.
    group: usize,
    /// The first entry of the group at hand, and how many of its beams have been gathered.
    first: usize,
    gathered: usize,
    /// The lanes in use: the first ones.
    pub lanes: u16,
    pub origin: [Row; 3],
    pub direction: [Row; 3],
    pub origin_by: [[Row; 3]; 2],
    pub direction_by: [[Row; 3]; 2],
    pub ahead: [Row; 3],
    pub axis: [Row; 3],
    pub cosine: Row,
    pub cosine_by: [Row; 2],
    pub colour: [Row; 3],
    pub area: Row,
    pub inverse: [Row; 5],
    pub line: [u16; WIDTH],
    pub polygon: [Polygon; WIDTH],
    pub place: [u32; WIDTH],
}

impl<'a> Arrivals<'a> {
    pub fn new(entries: &'a Entries, lines: &'a [Line]) -> Self {
        let (row, rows) = (Row::default(), [Row::default(); 3]);
        Arrivals {
            entries: &entries.entries,
            lines,
            group: together(lines.len()),
            first: 0,
            gathered: 0,
            lanes: 0,
            origin: rows,
            direction: rows,
            origin_by: [rows; 2],
            direction_by: [rows; 2],
            ahead: rows,
            axis: rows,
            cosine: row,
            cosine_by: [row; 2],
            colour: rows,
            area: row,
            inverse: [row; 5],
            line: [0; WIDTH],
            polygon: [Polygon::square(0.5); WIDTH],
            place: [0; WIDTH],
        }
    }

    /// The next beams; false if there are none.
    pub fn gather(&mut self) -> bool {
        let group = &self.entries[self.first..self.entries.len().min(self.first + self.group)];
        let rest = (group.len() * self.lines.len()).saturating_sub(self.gathered);
        if rest == 0 {
            return false;
        }
        let count = rest.min(WIDTH);
        for lane in 0..WIDTH {
            // What is not in use repeats the last.
            let number = self.gathered + lane.min(count - 1);
            self.put(lane, &group[number % group.len()], number / group.len());
        }
        self.lanes = ((1u32 << count) - 1) as u16;
        self.gathered += count;
        if count == rest {
            (self.first, self.gathered) = (self.first + group.len(), 0);
        }
        true
    }

    fn put(&mut self, lane: usize, entry: &Entry, line: usize) {
        put(&mut self.origin, lane, entry.ray[0]);
        put(&mut self.direction, lane, entry.ray[1]);
        for axis in 0..2 {
            put(&mut self.origin_by[axis], lane, entry.by[0][axis]);
            put(&mut self.direction_by[axis], lane, entry.by[1][axis]);
            self.cosine_by[axis].0[lane] = entry.cosine_by[axis];
        }
        put(&mut self.ahead, lane, entry.ahead);
        put(&mut self.axis, lane, entry.axis);
        put(&mut self.colour, lane, entry.colour);
        (self.cosine.0[lane], self.area.0[lane]) = (entry.cosine, entry.area);
        for (row, value) in self.inverse.iter_mut().zip(self.lines[line].inverse) {
            row.0[lane] = value;
        }
        (self.line[lane], self.polygon[lane]) = (line as u16, entry.polygon);
        self.place[lane] = entry.pixel * self.lines.len() as u32 + self.lines[line].place;
    }
}
