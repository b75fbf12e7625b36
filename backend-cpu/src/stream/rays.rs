//! Rays in one convex crystal, without gaps: a column for each of their numbers.

use crate::planes::Beam;
use accel::lanes::{Lanes, Row, Triple, WIDTH};

/// Rays of a lane each.
#[derive(Clone, Copy)]
pub(super) struct Ray<V> {
    pub origin: Triple<V>,
    /// Unit.
    pub direction: Triple<V>,
    /// N.
    pub wave: Triple<V>,
    /// The throughput.
    pub weight: V,
    /// What has been seen on the way here.
    pub radiance: V,
    /// Surface events so far; below 0 in the second mode.
    pub depth: V,
    /// The place of the next choice of a mode among `lattice::CHOICES`.
    pub choice: V,
    /// The bits of an integer: the place of its sum. Of a second one: its spectral line.
    pub place: V,
    pub line: V,
}

const COLUMNS: usize = 15;

/// A stack of rays.
pub(super) struct Rays {
    columns: [Vec<f32>; COLUMNS],
    count: usize,
}

/// Sixteen rays in memory.
pub(super) type Packet = [Row; COLUMNS];

impl Rays {
    pub fn new() -> Self {
        Rays { columns: [const { Vec::new() }; COLUMNS], count: 0 }
    }

    pub fn count(&self) -> usize {
        self.count
    }

    /// Adds the rays of some lanes.
    #[inline(always)]
    pub fn push<V: Lanes>(&mut self, ray: &Ray<V>, lanes: u16) {
        let Ray { origin, direction, wave, weight, radiance, depth, choice, place, line } = *ray;
        let values = [
            origin.x,
            origin.y,
            origin.z,
            direction.x,
            direction.y,
            direction.z,
            wave.x,
            wave.y,
            wave.z,
            weight,
            radiance,
            depth,
            choice,
            place,
            line,
        ];
        // Whole packets are written, and read from any ray on.
        let end = self.count + 2 * WIDTH;
        if self.columns[0].len() < end {
            self.grow(end);
        }
        for (value, column) in values.iter().zip(&mut self.columns) {
            if let Some(to) = column[self.count..].first_chunk_mut() {
                value.pack(lanes, to);
            }
        }
        self.count += lanes.count_ones() as usize;
    }

    #[cold]
    fn grow(&mut self, end: usize) {
        for column in &mut self.columns {
            column.resize(2 * end, 0.0);
        }
    }

    /// Takes the last rays away into packets, of which the last may have lanes left; returns how many.
    #[inline(always)]
    pub fn take(&mut self, packets: &mut [Packet]) -> usize {
        let taken = self.count.min(packets.len() * WIDTH);
        let first = self.count - taken;
        for (p, packet) in packets[..taken.div_ceil(WIDTH)].iter_mut().enumerate() {
            for (row, column) in packet.iter_mut().zip(&self.columns) {
                if let Some(numbers) = column[first + p * WIDTH..].first_chunk() {
                    row.0 = *numbers;
                }
            }
        }
        self.count = first;
        taken
    }
}

impl<V: Lanes> Ray<V> {
    #[inline(always)]
    pub fn load(packet: &Packet) -> Self {
        let [ox, oy, oz, dx, dy, dz, nx, ny, nz, weight, radiance, depth, choice, place, line] = packet;
        Ray {
            origin: Triple { x: V::load(ox), y: V::load(oy), z: V::load(oz) },
            direction: Triple { x: V::load(dx), y: V::load(dy), z: V::load(dz) },
            wave: Triple { x: V::load(nx), y: V::load(ny), z: V::load(nz) },
            weight: V::load(weight),
            radiance: V::load(radiance),
            depth: V::load(depth),
            choice: V::load(choice),
            place: V::load(place),
            line: V::load(line),
        }
    }
}

/// A vector from three rows.
#[inline(always)]
pub(super) fn triple<V: Lanes>(rows: &[Row]) -> Triple<V> {
    Triple { x: V::load(&rows[0]), y: V::load(&rows[1]), z: V::load(&rows[2]) }
}

/// The way of the rays of a packet, for the search of what they meet.
pub(super) fn beam(packet: &Packet, alive: u16) -> Beam {
    let [ox, oy, oz, dx, dy, dz, ..] = *packet;
    Beam { origin: [ox, oy, oz], direction: [dx, dy, dz], alive }
}

/// Where the place of a ray's sum is in a packet, and its line.
pub(super) const PLACE: usize = 13;
pub(super) const LINE: usize = 14;
