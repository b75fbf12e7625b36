//! The environment in single precision, for sixteen rays at a time: the twin of `spectral_core::environment`.

use accel::lanes::{Lanes, Mask, Row, Triple, WIDTH, turns};
use spectral_core::environment::{Environment, Ground, GroundFrame, LatLong, Source};
use std::sync::Arc;

/// The environment; illuminant and scale are in the spectral lines' bases already.
#[derive(Debug, Clone)]
pub(crate) enum Light {
    Uniform([f32; 3]),
    /// An image and its rotation, in turns.
    Image {
        image: Arc<LatLong>,
        turn: f32,
        ground: Option<GroundFrame>,
    },
}

impl Light {
    pub fn new(environment: &Environment) -> Self {
        match &environment.source {
            Source::Uniform(rgb) => Light::Uniform(rgb.map(|c| c as f32)),
            Source::Image(image) => Light::Image {
                image: image.clone(),
                turn: environment.turn(),
                ground: environment.ground.as_ref().map(|ground| ground.frame()),
            },
        }
    }

    /// The largest component that any ray can see.
    pub fn most(&self) -> f32 {
        let most = |colour: &[f32; 3]| colour.iter().copied().fold(0.0, f32::max);
        match self {
            Light::Uniform(rgb) => most(rgb),
            Light::Image { image, .. } => image.texels().iter().map(most).fold(0.0, f32::max),
        }
    }
}

/// Where the texels lie that rays see.
#[derive(Clone, Copy)]
pub(crate) struct Lookup<V> {
    column: V,
    row: V,
    /// Shares of the next column and of the next row.
    across: V,
    down: V,
    /// Lanes whose four texels lie one after the other, two and two.
    inner: u16,
}

impl<V: Lanes> Lookup<V> {
    /// Nowhere in particular.
    #[inline(always)]
    pub fn nowhere() -> Self {
        let zero = V::splat(0.0);
        Lookup { column: zero, row: zero, across: zero, down: zero, inner: 0 }
    }

    /// For rays that leave the stones: their origins and unit directions.
    #[inline(always)]
    pub fn new(light: &Light, origin: Triple<V>, direction: Triple<V>) -> Self {
        let Light::Image { image, turn, ground } = light else { return Self::nowhere() };
        let sky = Self::sky(image, *turn, direction);
        match ground {
            None => sky,
            Some(ground) => sky.or_ground(ground, image.sky()[1] as f32, origin, direction),
        }
    }

    #[inline(always)]
    fn sky(image: &LatLong, turn: f32, direction: Triple<V>) -> Self {
        let (zero, half) = (V::splat(0.0), V::splat(0.5));
        let [width, height] = image.sky().map(|n| n as f32);
        let u = turns(direction.x, direction.y) + V::splat(turn);
        let flat = direction.x.fma(direction.x, direction.y * direction.y).sqrt();
        let v = turns(flat, direction.z) * V::splat(2.0);
        let x = (u - u.floor()).fma(V::splat(width), -half);
        let y = v.fma(V::splat(height), -half).max(zero).min(V::splat(height - 1.0));
        let (column, row) = (x.floor(), y.floor());
        let (across, down) = (x - column, y - row);
        // Eight numbers are read from the first texel on, of which six are wanted.
        let inner = !column.lt(zero) & column.lt(V::splat(width - 2.5)) & row.lt(V::splat(height - 1.5));
        let column = V::select(column.lt(zero), V::splat(width - 1.0), column).min(V::splat(width - 1.0));
        Lookup { column, row, across, down, inner: inner.bits() }
    }

    /// A ray that goes down sees the ground, whose picture begins in the row `first`: the twin of
    /// `environment/ground.rs`.
    #[inline(always)]
    fn or_ground(self, ground: &GroundFrame, first: f32, origin: Triple<V>, direction: Triple<V>) -> Self {
        let zero = V::splat(0.0);
        let falling = direction.z.lt(zero);
        let slope = (-direction.z).max(V::splat(Ground::GRAZING as f32));
        let along = (origin.z - V::splat(ground.height)) / slope;
        let x = Self::place(origin.x, direction.x, along, ground.low[0], ground);
        let y = Self::place(origin.y, direction.y, along, ground.low[1], ground);
        let last = V::splat(ground.last);
        let (column, row) = (x.floor().min(last), y.floor().min(last));
        Lookup {
            column: V::select(falling, column, self.column),
            row: V::select(falling, row + V::splat(first), self.row),
            across: V::select(falling, x - column, self.across),
            down: V::select(falling, y - row, self.down),
            inner: self.inner | falling.bits(),
        }
    }

    /// Where on the ground's picture, in texels, a ray is after the distance `along`. No closure: it would be compiled
    /// without the instruction set, and called.
    #[inline(always)]
    fn place(origin: V, direction: V, along: V, low: f32, ground: &GroundFrame) -> V {
        let place = (direction.fma(along, origin) - V::splat(low)) * V::splat(ground.per_mm);
        place.max(V::splat(0.0)).min(V::splat(ground.last + 1.0))
    }

    /// Colours of the lanes whose bit is set; what the others hold is finite.
    #[inline(always)]
    pub fn colours(&self, light: &Light, lanes: u16) -> Triple<V> {
        let image = match light {
            Light::Uniform(rgb) => return Triple::splat(*rgb),
            Light::Image { image, .. } => image,
        };
        let inner = self.inner & lanes;
        let mut colours = Triple::splat([0.0; 3]);
        let down = self.down.stored();
        if inner != 0 {
            let pitch = 3 * image.width();
            // The other lanes read the image's first texels.
            let offsets = V::offsets(V::Mask::from_bits(inner), self.row, self.column, pitch);
            let texels = image.texels().as_flattened();
            let [x, y, z] = V::bilinear(texels, &offsets, pitch, self.across, &down);
            colours = Triple { x, y, z };
        }
        let outer = lanes & !inner;
        if outer != 0 {
            let [columns, rows, across] = [self.column.stored(), self.row.stored(), self.across.stored()];
            let rest = at_the_edge(image, outer, [&columns, &rows], [&across, &down]);
            colours = Triple::select(V::Mask::from_bits(outer), Triple::load(&rest), colours);
        }
        colours
    }
}

/// Colours of lanes whose next texel is the first of the row, or that are near the image's end: a few in a thousand.
#[cold]
#[inline(never)]
fn at_the_edge(
    image: &LatLong,
    lanes: u16,
    [columns, rows]: [&Row; 2],
    [across, down]: [&Row; 2],
) -> [Row; 3] {
    let [width, height] = image.sky().map(|n| n as usize);
    let mut colours = [Row::default(); 3];
    for lane in (0..WIDTH).filter(|lane| lanes >> lane & 1 == 1) {
        let (column, row) = (columns.0[lane] as usize, rows.0[lane] as usize);
        let texel = |i: usize, j: usize| image.texels()[j * image.width() as usize + i];
        let (next, below) = ((column + 1) % width, (row + 1).min(height - 1));
        let [a, b] = [texel(column, row), texel(next, row)];
        let [c, d] = [texel(column, below), texel(next, below)];
        for k in 0..3 {
            let left = (c[k] - a[k]).mul_add(down.0[lane], a[k]);
            let right = (d[k] - b[k]).mul_add(down.0[lane], b[k]);
            colours[k].0[lane] = (right - left).mul_add(across.0[lane], left);
        }
    }
    colours
}

#[cfg(test)]
mod tests {
    use super::*;
    use accel::{Instructions, Task};
    use glam::DVec3;

    struct Look<'a>(&'a Light, [Row; 3]);

    impl Task for Look<'_> {
        type Output = [Row; 3];

        #[inline(always)]
        fn run<V: Lanes>(self) -> [Row; 3] {
            Lookup::<V>::new(self.0, Triple::splat([0.0; 3]), Triple::load(&self.1))
                .colours(self.0, 0xffff)
                .stored()
        }
    }

    #[test]
    fn single_precision_agrees_with_the_core() {
        let mut environment = Environment::image(LatLong::studio());
        environment.rotation = 33.0;
        let light = Light::new(&environment);
        // A spiral over the sphere, poles included.
        let direction = |k: usize| {
            let (z, angle) = (1.0 - 2.0 * k as f64 / 9_999.0, 2.399_963 * k as f64);
            DVec3::new((1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z)
        };
        for first in (0..10_000).step_by(WIDTH) {
            let mut rows = [Row::default(); 3];
            for lane in 0..WIDTH {
                accel::lanes::put(&mut rows, lane, direction(first + lane).as_vec3().to_array());
            }
            let found = Instructions::best().run(Look(&light, rows));
            for lane in 0..WIDTH {
                let exact = environment.rgb(direction(first + lane));
                for c in 0..3 {
                    let error = (f64::from(found[c].0[lane]) - exact[c]).abs();
                    assert!(error < 2e-3 * exact[c].max(0.1), "{}", direction(first + lane));
                }
            }
        }
    }
}
