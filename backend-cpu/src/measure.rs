//! Kernels by themselves, for measurements against other intersectors (feature `measure`).

use crate::{chain::Chain, planes::Planes};
use accel::lanes::{Lanes, Row, Triple, WIDTH};
use accel::{Instructions, Task};
use spectral_core::prepare::PreparedScene;

/// Sixteen rays inside a stone.
#[derive(Debug, Clone)]
pub struct RayPacket {
    origin: [Row; 3],
    direction: [Row; 3],
    alive: u16,
}

impl RayPacket {
    /// From coordinates (x, y, z, mm) and unit directions, a ray a lane; `alive`: as bits, the rays there are.
    /// The other lanes must be finite.
    pub fn new(origin: [[f32; WIDTH]; 3], direction: [[f32; WIDTH]; 3], alive: u16) -> Self {
        RayPacket { origin: origin.map(Row), direction: direction.map(Row), alive }
    }
}

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

    /// The length of each ray, mm, in the stone's own coordinates; packet after packet, as a render asks for them.
    pub fn distances(&self, packets: &[RayPacket], distances: &mut [[f32; WIDTH]]) {
        self.instructions.run(Distances { planes: self.chain.planes(), packets, distances });
    }
}

struct Distances<'a> {
    planes: &'a Planes,
    packets: &'a [RayPacket],
    distances: &'a mut [[f32; WIDTH]],
}

impl Task for Distances<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes>(self) {
        let mut guess = 0;
        for (packet, distances) in self.packets.iter().zip(self.distances) {
            let (origin, direction) = (Triple::<V>::load(&packet.origin), Triple::load(&packet.direction));
            *distances = self.planes.exits(origin, direction, packet.alive, &mut guess).distance.stored().0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spectral_core::{
        camera::{Camera, Projection},
        environment::Environment,
        material::Catalogue,
        scene::{Background, Scene, Stone},
        settings::RenderSettings,
        shape::ShapeSpec,
    };
    use std::sync::Arc;

    #[test]
    fn a_ray_from_the_middle_goes_as_far_as_the_nearest_plane_ahead() {
        let (mesh, _) = ShapeSpec::by_name("round-brilliant").unwrap().cut().unwrap().solid().unwrap();
        let diamond = Arc::new(Catalogue::builtin().get("diamond").unwrap().clone());
        let scene = Scene {
            camera: Camera {
                position: [0.0, 0.0, 30.0].into(),
                look_at: [0.0; 3].into(),
                up: [0.0, 1.0, 0.0].into(),
                projection: Projection::Perspective { fov: 14.0 },
            },
            width: 1,
            height: 1,
            background: Background::Transparent,
            environment: Environment::uniform([1.0; 3]),
            stones: vec![Stone { width: Some(6.5), ..Stone::new("stone", Arc::new(mesh), diamond) }],
        };
        let scene = PreparedScene::new(&scene, &RenderSettings::default()).unwrap();
        let exits = Exits::new(&scene, Instructions::best()).unwrap();
        let mut direction = [[0.0; WIDTH]; 3];
        direction[0] = std::array::from_fn(|lane| (lane as f32).sin());
        direction[2] = std::array::from_fn(|lane| (lane as f32).cos());
        let mut distances = [[0.0; WIDTH]];
        exits.distances(&[RayPacket::new([[0.0; WIDTH]; 3], direction, u16::MAX)], &mut distances);
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
