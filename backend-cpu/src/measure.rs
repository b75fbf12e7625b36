//! Kernels by themselves, for measurements against other intersectors (feature `measure`).

use crate::{
    chain::Chain,
    instructions::{Instructions, Task},
    lanes::{Lanes, Row, Triple, WIDTH},
    planes::Planes,
};
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
#[derive(Debug)]
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
