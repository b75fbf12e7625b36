//! Kernels by themselves, for measurements against other intersectors (feature `measure`).

use crate::chain::Chain;
pub use crate::planes::Beam;
use crate::planes::{BATCH, Exit, Planes};
use accel::lanes::{Lanes, WIDTH};
use accel::{Instructions, Task};
use spectral_core::prepare::PreparedScene;

/// Where rays inside one convex stone leave it.
#[derive(Debug, Clone)]
pub struct Exits {
    chain: Chain,
    instructions: Instructions,
}

impl Exits {
    /// For a scene of one convex stone; `None` for any other.
    pub fn new(scene: &PreparedScene, instructions: Instructions) -> Option<Self> {
        Some(Exits { chain: Chain::new(scene, instructions)?, instructions })
    }

    /// The length of each ray, mm, in the stone's own coordinates; as many packets together as in a render.
    pub fn distances(&self, beams: &[Beam], distances: &mut [[f32; WIDTH]]) {
        self.instructions.run(Distances { planes: self.chain.planes(), beams, distances });
    }
}

struct Distances<'a> {
    planes: &'a Planes,
    beams: &'a [Beam],
    distances: &'a mut [[f32; WIDTH]],
}

impl Task for Distances<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes>(self) {
        let mut exits = vec![Exit::<V>::nowhere(); BATCH];
        for (beams, distances) in self.beams.chunks(BATCH).zip(self.distances.chunks_mut(BATCH)) {
            self.planes.exits(beams, &mut exits);
            for (distances, exit) in distances.iter_mut().zip(&exits) {
                *distances = exit.distance.stored().0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::tests::chain;
    use accel::lanes::Row;

    #[test]
    fn a_ray_from_the_middle_goes_as_far_as_the_nearest_plane_ahead() {
        let (_, scene) = chain("round-brilliant");
        let exits = Exits::new(&scene, Instructions::best()).unwrap();
        let mut direction = [[0.0; WIDTH]; 3];
        direction[0] = std::array::from_fn(|lane| (lane as f32).sin());
        direction[2] = std::array::from_fn(|lane| (lane as f32).cos());
        let mut distances = [[0.0; WIDTH]];
        let beam = Beam { origin: [Row::default(); 3], direction: direction.map(Row), alive: u16::MAX };
        exits.distances(&[beam], &mut distances);
        for lane in 0..WIDTH {
            let towards = glam::DVec3::new(direction[0][lane].into(), 0.0, direction[2][lane].into());
            let ahead = |f: &spectral_core::prepare::FacetPlane| {
                let cosine = f.normal.dot(towards);
                (cosine > 0.0).then(|| f.offset / cosine)
            };
            let exact = scene.geometry.facets.iter().filter_map(ahead).fold(f64::INFINITY, f64::min);
            assert!((f64::from(distances[0][lane]) - exact).abs() < 1e-5, "{lane}: {exact}");
        }
    }
}
