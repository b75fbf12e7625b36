//! The light that stones leave on a diffuse ground.
//!
//! At a point of the ground the irradiance is ∫ L cos θ dω over the upper hemisphere less what the stones hide; they
//! count as opaque, so their shadow is there and their caustics are not. The hemisphere is cut into directions of equal
//! weight by the map of Shirley & Chiu (A low distortion map between disk and square, JGT 2(3), 1997), whose disc is
//! the hemisphere projected onto the ground: equal areas of it are equal shares of cos θ dω. The light of each
//! direction is the mean over its cell. Nothing is drawn at random.

use crate::Error;
use accel::{BuildOptions, Bvh, Ray};
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use spectral_core::environment::{Environment, Ground, Source};
use spectral_core::scene::Stone;
use std::f64::consts::FRAC_PI_4;

/// Cells along each edge of the square: a power of two, so that a light of 1 sums to 1 exactly. Fine, and coarse.
const CELLS: [usize; 2] = [32, 8];
/// Texels along an edge of the ground's picture.
const TEXELS: [usize; 2] = [161, 41];
/// The most points of a cell along an edge at which the environment is looked up.
const POINTS: [usize; 2] = [64, 16];
/// Its width, in extents of what stands there.
const EXTENTS: f64 = 5.0;
/// The share of its half width from which the shadow fades towards the border.
const FADING: f64 = 0.7;

/// A ground at `height` (mm) with the linear sRGB reflectance `albedo`, on which the environment shines past stones. A coarse one
/// takes a hundredth of the time, and its shadows have steps.
///
/// # Errors
/// [`Error::Core`] for stones that cannot be placed or figures that make no ground.
pub fn ground(
    albedo: [f64; 3],
    height: f64,
    stones: &[Stone],
    environment: &Environment,
    coarse: bool,
) -> Result<Ground, Error> {
    let [cells, texels, points] = [CELLS, TEXELS, POINTS].map(|sizes| sizes[usize::from(coarse)]);
    let sky = Sky::new(environment, cells, points);
    let shown = |light: [f64; 3]| std::array::from_fn(|c| (albedo[c] * light[c].max(0.0)) as f32);
    let Some(scenery) = Scenery::new(stones)? else {
        return Ok(Ground::new(height, [0.0; 2], 1.0, 2, vec![shown(sky.irradiance); 4])?);
    };
    let width = EXTENTS * scenery.extent;
    let step = width / (texels - 1) as f64;
    let low = scenery.middle.truncate() - width / 2.0;
    let texel = |i: usize, j: usize| {
        let place = low + DVec2::new(i as f64, j as f64) * step;
        let aside = (place - scenery.middle.truncate()).abs().max_element() / (width / 2.0);
        let hidden = sky.hidden(place.extend(height), &scenery);
        let share = 1.0 - smooth((aside - FADING) / (1.0 - FADING));
        shown(std::array::from_fn(|c| sky.irradiance[c] - share * hidden[c]))
    };
    let all = (0..texels * texels).into_par_iter().map(|k| texel(k % texels, k / texels)).collect();
    Ok(Ground::new(height, low.to_array(), step, texels as u32, all)?)
}

/// From 0 at 0 to 1 at 1, level at both.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// The box around all stones, mm.
pub(crate) fn bounds(stones: &[Stone]) -> Result<(DVec3, DVec3), spectral_core::Error> {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    stones.iter().try_fold(empty, |(low, high), stone| {
        let (l, h) = stone.bounds()?;
        Ok((low.min(l), high.max(h)))
    })
}

/// The upper hemisphere in directions of equal weight.
struct Sky {
    /// Unit directions with their shares of the irradiance over π.
    lights: Vec<(DVec3, [f64; 3])>,
    /// The sum of all shares.
    irradiance: [f64; 3],
}

impl Sky {
    /// In `cells` × `cells` directions, each looked up at up to `most` × `most` points.
    fn new(environment: &Environment, cells: usize, most: usize) -> Self {
        // As fine as the image's texels, within reason.
        let fine = match &environment.source {
            Source::Image(image) => (image.width() as usize / cells).clamp(8, most).next_power_of_two(),
            Source::Uniform(_) => 1,
        };
        let weight = 1.0 / (cells * cells) as f64;
        let light = |cell: usize| {
            let (i, j) = (cell % cells, cell / cells);
            let mut sum = [0.0; 3];
            for point in 0..fine * fine {
                let at = |cell: usize, point: usize| cell as f64 + (point as f64 + 0.5) / fine as f64;
                let rgb = environment.rgb(direction(at(i, point % fine), at(j, point / fine), cells));
                sum = std::array::from_fn(|c| sum[c] + rgb[c]);
            }
            let towards = direction(i as f64 + 0.5, j as f64 + 0.5, cells);
            (towards, sum.map(|s| s / (fine * fine) as f64 * weight))
        };
        let lights: Vec<_> = (0..cells * cells).into_par_iter().map(light).collect();
        let sum = |sum: [f64; 3], (_, light): &(DVec3, [f64; 3])| std::array::from_fn(|c| sum[c] + light[c]);
        let irradiance = lights.iter().fold([0.0; 3], sum);
        Sky { lights, irradiance }
    }

    /// What the stones keep from a point of the ground.
    fn hidden(&self, place: DVec3, scenery: &Scenery) -> [f64; 3] {
        let from = place - scenery.middle;
        let hidden = self.lights.iter().filter(|(direction, _)| scenery.blocks(from, *direction));
        hidden.fold([0.0; 3], |sum, (_, light)| std::array::from_fn(|c| sum[c] + light[c]))
    }
}

/// The direction of a point of a square of `cells` × `cells`.
fn direction(x: f64, y: f64, cells: usize) -> DVec3 {
    let [a, b] = [x, y].map(|v| 2.0 * v / cells as f64 - 1.0);
    let (radius, angle) = if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else if b != 0.0 {
        (b, FRAC_PI_4 * (2.0 - a / b))
    } else {
        (0.0, 0.0)
    };
    DVec3::new(radius * angle.cos(), radius * angle.sin(), (1.0 - radius * radius).max(0.0).sqrt())
}

/// The stones as something in the way.
struct Scenery {
    /// The middle of the box around them, mm.
    middle: DVec3,
    /// The longest edge of the box, mm.
    extent: f64,
    /// Of a sphere about the middle that holds them, squared.
    radius2: f64,
    /// About the middle.
    tree: Bvh,
}

impl Scenery {
    fn new(stones: &[Stone]) -> Result<Option<Self>, Error> {
        if stones.is_empty() {
            return Ok(None);
        }
        let (low, high) = bounds(stones)?;
        let middle = (low + high) / 2.0;
        let (mut positions, mut triangles): (Vec<Vec3>, Vec<[u32; 3]>) = (Vec::new(), Vec::new());
        for stone in stones {
            let mesh = stone.placed()?;
            let first = positions.len() as u32;
            positions.extend(mesh.positions().iter().map(|p| (*p - middle).as_vec3()));
            triangles.extend(mesh.triangles().iter().map(|t| t.map(|corner| corner + first)));
        }
        let tree = Bvh::build(&positions, &triangles, &BuildOptions::default());
        let tree = tree.map_err(|e| spectral_core::Error::value("ground", "shadows", e.to_string()))?;
        let radius2 = (high - middle).length_squared();
        Ok(Some(Scenery { middle, extent: (high - low).max_element(), radius2, tree }))
    }

    /// Whether a ray from a point, about the middle, meets a stone.
    fn blocks(&self, from: DVec3, direction: DVec3) -> bool {
        let along = -from.dot(direction);
        if along < 0.0 || (from + direction * along).length_squared() > self.radius2 {
            return false;
        }
        self.tree.closest(&Ray::new(from.as_vec3(), direction.as_vec3()), |_| true).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spectral_core::environment::LatLong;
    use spectral_core::material::Catalogue;
    use spectral_core::mesh::{Mesh, MeshOptions};
    use std::sync::Arc;

    /// A box from −`half` to `half` in x and y, from `low` to `high` in z.
    fn block(half: f64, low: f64, high: f64) -> Stone {
        let corner = |i: usize| {
            let side = |bit: usize| if i >> bit & 1 == 1 { half } else { -half };
            DVec3::new(side(0), side(1), if i >> 2 & 1 == 1 { high } else { low })
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let (mesh, _) =
            Mesh::from_triangles((0..8).map(corner).collect(), triangles, &MeshOptions::default()).unwrap();
        let gold = Catalogue::builtin().get("gold").unwrap().clone();
        Stone::new("block", Arc::new(mesh), Arc::new(gold))
    }

    fn below(ground: &Ground, x: f64, y: f64) -> [f64; 3] {
        ground.rgb(DVec3::new(x, y, ground.height + 1.0), -DVec3::Z)
    }

    #[test]
    fn without_stones_uniform_light_is_reflected_exactly() {
        let light = Environment::uniform([0.7, 0.3, 2.0]);
        let ground = ground([1.0, 0.5, 0.25], -2.0, &[], &light, false).unwrap();
        assert_eq!(below(&ground, 3.0, -4.0), [0.7_f32, 0.15, 0.5].map(f64::from));
    }

    #[test]
    fn a_cosine_lobe_has_its_exact_irradiance() {
        // L = z above the horizon: ∫ cos²θ dω / π = 2/3. L = 1 towards +x only: 1/2.
        let painted = |paint: fn(DVec3) -> f32| {
            let direction = |i: u32, j: u32| {
                let (turn, from_top) = (
                    std::f64::consts::TAU * (f64::from(i) + 0.5) / 256.0,
                    std::f64::consts::PI * (f64::from(j) + 0.5) / 128.0,
                );
                DVec3::new(turn.sin() * from_top.sin(), turn.cos() * from_top.sin(), from_top.cos())
            };
            let texels = (0..256 * 128).map(|k| [paint(direction(k % 256, k / 256)); 3]).collect();
            Environment::image(LatLong::new(256, 128, texels).unwrap().0)
        };
        for (light, exact) in [
            (painted(|d| d.z.max(0.0) as f32), 2.0 / 3.0),
            (painted(|d| f32::from(u8::from(d.x > 0.0))), 0.5),
        ] {
            let ground = ground([1.0; 3], 0.0, &[], &light, false).unwrap();
            let [found, ..] = below(&ground, 0.0, 0.0);
            assert!((found - exact).abs() < 1e-3, "{found} {exact}");
        }
    }

    #[test]
    fn a_lid_hides_its_view_factor() {
        // A square lid of half width a at height h above the point beneath its middle hides the share
        // 4 · (2/(2π)) · (a/√(a² + h²)) · atan(a/√(a² + h²)) of the irradiance (configuration factor of a rectangle
        // parallel to the element at its corner, four times; Howell, A Catalog of Radiation Heat Transfer
        // Configuration Factors, B-3).
        let (a, h) = (1.0_f64, 0.8_f64);
        let scenery = Scenery::new(&[block(a, h, h + 0.05)]).unwrap().unwrap();
        let slant = a / (a * a + h * h).sqrt();
        let exact = 4.0 / std::f64::consts::PI * slant * slant.atan();
        // Cells that its outline crosses are in it or not: the finer they are, the nearer.
        for (cells, tolerance) in [(CELLS[0], 0.02), (128, 1e-3)] {
            let sky = Sky::new(&Environment::uniform([1.0; 3]), cells, POINTS[0]);
            let [found, ..] = sky.hidden(DVec3::ZERO, &scenery);
            assert!((found - exact).abs() < tolerance, "{cells} cells: {found} {exact}");
        }
    }

    #[test]
    fn far_from_the_stones_there_is_no_shadow() {
        for coarse in [false, true] {
            let light = Environment::uniform([1.0; 3]);
            let ground = ground([0.5; 3], 0.0, &[block(1.0, 0.0, 1.0)], &light, coarse).unwrap();
            assert_eq!(below(&ground, 5.0, 0.0), [0.5; 3]);
            assert_eq!(below(&ground, 50.0, -70.0), [0.5; 3]);
            // Beneath the block it is dark, and beside it lighter the further away.
            let across: Vec<f64> = [0.0, 1.2, 1.6, 2.4, 4.0].map(|x| below(&ground, x, 0.0)[0]).into();
            assert!(across[0] < 0.01 && across.windows(2).all(|pair| pair[0] < pair[1]), "{across:?}");
        }
    }

    #[test]
    fn directions_are_unit_and_each_weighs_as_much() {
        let (mut mean, [cells, _]) = (DVec3::ZERO, CELLS);
        for k in 0..cells * cells {
            let d = direction((k % cells) as f64 + 0.5, (k / cells) as f64 + 0.5, cells);
            assert!((d.length() - 1.0).abs() < 1e-12 && d.z > 0.0);
            mean += d / (cells * cells) as f64;
        }
        // The mean of cos θ with weight cos θ is 2/3. It ends upright at the rim, where the midpoint rule is good to
        // the power 3/2 of a cell's width.
        let width = 1.0 / cells as f64;
        assert!(mean.truncate().length() < 1e-12 && (mean.z - 2.0 / 3.0).abs() < width.powf(1.5), "{mean}");
    }
}
