//! Intersections of the recorded internal rays by gemtrace's planes, without any shading.

use crate::{
    Failure, meshes,
    scene::{self, Studio},
    store::{self, Packet},
};
use accel::lanes::Row;
use backend_cpu::{
    Instructions,
    measure::{Beam, Exits},
};
use cpu_time::ProcessTime;
use serde_json::{Value, json};
use std::path::Path;

/// Packets that are traced repeatedly before the next ones. In a render, packets are in the second cache; reading them from
/// memory would take longer than intersecting them. The peer does the same.
const TOGETHER: usize = 512;
const REPEATS: usize = 20;

/// Traces the rays of `heap.rays` as in a render: a ray knows which stone it is in, so each group of packets is tested
/// against the planes of its stone, each in its own memory.
pub fn heap(instructions: Instructions) -> Result<Value, Failure> {
    let scene = scene::prepared(Studio::Coloured, &scene::shallow("scalar")?)?;
    let exits = Exits::new(&scene, instructions).ok_or("the scene is one convex stone")?;
    let stones = vec![exits; meshes::STONES];
    let rays = meshes::internal(&scene);
    let packets: Vec<Beam> = rays.iter().map(packet).collect();
    let mut distances = vec![[0.0; store::WIDTH]; packets.len()];
    let time = ProcessTime::now();
    for (group, (packets, distances)) in
        packets.chunks(meshes::STAY).zip(distances.chunks_mut(meshes::STAY)).enumerate()
    {
        stones[meshes::stone(group)].distances(packets, distances);
    }
    Ok(report(time.elapsed().as_secs_f64(), &rays, &distances))
}

fn packet(p: &Packet) -> Beam {
    Beam { origin: p.origin.map(Row), direction: p.direction.map(Row), alive: p.alive as u16 }
}

fn report(cpu: f64, rays: &[Packet], distances: &[[f32; store::WIDTH]]) -> Value {
    let sum: f64 = rays
        .iter()
        .zip(distances)
        .flat_map(|(packet, distances)| packet.lanes().map(|lane| f64::from(distances[lane])))
        .sum();
    let count: u32 = rays.iter().map(|packet| packet.alive.count_ones()).sum();
    json!({ "cpu": cpu, "rays": count, "mean": sum / f64::from(count) })
}

/// Traces `internal.rays`.
pub fn measure(instructions: Instructions, folder: &Path) -> Result<Value, Failure> {
    let scene = scene::prepared(Studio::Coloured, &scene::shallow("scalar")?)?;
    let exits = Exits::new(&scene, instructions).ok_or("the scene is one convex stone")?;
    let rays = store::read_packets(&folder.join("internal.rays"))?;
    let packets: Vec<Beam> = rays.iter().map(packet).collect();
    let mut distances = vec![[0.0; store::WIDTH]; packets.len()];
    let time = ProcessTime::now();
    for (packets, distances) in packets.chunks(TOGETHER).zip(distances.chunks_mut(TOGETHER)) {
        for _ in 0..REPEATS {
            exits.distances(packets, distances);
        }
    }
    Ok(report(time.elapsed().as_secs_f64() / REPEATS as f64, &rays, &distances))
}
