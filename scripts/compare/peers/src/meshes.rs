//! Large meshes: building and tracing gemtrace's hierarchy.

use crate::{
    Failure, record,
    scene::{self, Studio},
    store::{self, Packet, WIDTH},
};
use accel::testing::{self, Mesh};
use accel::{BuildOptions, Bvh, Ray};
use cpu_time::ProcessTime;
use glam::Vec3;
use serde_json::{Value, json};
use spectral_core::prepare::PreparedScene;
use std::path::Path;

/// Packets of incoherent rays.
const RANDOM: usize = 1 << 15;
/// Stones along each edge of the heap; with about 250 triangles each, the heap has a million.
const EDGE: usize = 16;
/// Stones of the heap.
pub const STONES: usize = EDGE.pow(3);
/// Packets of internal rays in one stone before the next one.
pub const STAY: usize = 32;

/// Writes a torus and a heap of brilliants of a million triangles each, with rays for them.
pub fn write(folder: &Path) -> Result<Value, Failure> {
    let torus = testing::torus(0.4, 1000, 500);
    store::write_mesh(&folder.join("torus.mesh"), &torus)?;
    store::write_packets(&folder.join("torus.rays"), &incoherent())?;
    let scene = scene::prepared(Studio::Coloured, &scene::shallow("scalar")?)?;
    let (heap, middles) = heap(&record::mesh(&scene));
    store::write_mesh(&folder.join("heap.mesh"), &heap)?;
    let mut packets = internal(&scene);
    for (group, packets) in packets.chunks_mut(STAY).enumerate() {
        let middle = middles[stone(group)];
        for packet in packets {
            for axis in 0..3 {
                packet.origin[axis].iter_mut().for_each(|x| *x += middle[axis]);
            }
        }
    }
    store::write_packets(&folder.join("heap.rays"), &packets)?;
    Ok(json!({ "torus": torus.triangles.len(), "heap": heap.triangles.len() }))
}

/// The heap's rays, each in the coordinates of its own stone.
pub fn internal(scene: &PreparedScene) -> Vec<Packet> {
    let mut packets = record::packets(scene);
    packets.truncate(RANDOM);
    packets
}

/// The stone of a group of packets: the step is coprime to their number, so all stones are visited, out of order.
pub fn stone(group: usize) -> usize {
    group * 2_654_435_761 % STONES
}

/// Random rays around the torus.
fn incoherent() -> Vec<Packet> {
    let mut random = testing::Random(7);
    let packet = |_| {
        let mut packet = Packet::default();
        for lane in 0..WIDTH {
            packet.put(lane, (random.point() - Vec3::splat(0.5)) * 2.8, random.direction());
        }
        packet
    };
    (0..RANDOM).map(packet).collect()
}

fn heap(stone: &Mesh) -> (Mesh, Vec<Vec3>) {
    let step = 7.0;
    let mut heap = Mesh::default();
    let mut middles = Vec::new();
    for number in 0..STONES {
        let cell = [number % EDGE, number / EDGE % EDGE, number / EDGE / EDGE];
        let middle = Vec3::from(cell.map(|i| (i as f32 - EDGE as f32 / 2.0) * step));
        let first = heap.positions.len() as u32;
        heap.positions.extend(stone.positions.iter().map(|p| *p + middle));
        heap.triangles.extend(stone.triangles.iter().map(|t| t.map(|i| i + first)));
        middles.push(middle);
    }
    (heap, middles)
}

/// Builds the hierarchy.
pub fn build(mesh: &Path) -> Result<Value, Failure> {
    let mesh = store::read_mesh(mesh)?;
    let time = ProcessTime::now();
    let bvh = Bvh::build(&mesh.positions, &mesh.triangles, &BuildOptions::default())?;
    let cpu = time.elapsed().as_secs_f64();
    let references = bvh.stats().references as f64 / mesh.triangles.len() as f64;
    Ok(json!({ "cpu": cpu, "references": references }))
}

/// Traces rays, one at a time. Rays start at a small distance, like those of the peers.
pub fn trace(mesh: &Path, rays: &Path) -> Result<Value, Failure> {
    const NEAR: f32 = 1e-4;
    let mesh = store::read_mesh(mesh)?;
    let bvh = mesh.bvh();
    let packets = store::read_packets(rays)?;
    let (mut rays, mut hits, mut sum) = (0, 0, 0.0);
    let time = ProcessTime::now();
    for packet in &packets {
        for lane in packet.lanes() {
            let (origin, direction) = packet.ray(lane);
            let ray = Ray { t_min: NEAR, ..Ray::new(origin, direction) };
            rays += 1;
            if let Some(hit) = bvh.closest(&ray, |_| true) {
                hits += 1;
                sum += f64::from(hit.t);
            }
        }
    }
    let cpu = time.elapsed().as_secs_f64();
    Ok(json!({ "cpu": cpu, "rays": rays, "hits": hits, "mean": sum / f64::from(hits) }))
}
