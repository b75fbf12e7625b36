//! Intersections of the recorded internal rays by gemtrace's planes, without any shading.

use crate::{
    Failure,
    scene::{self, Studio},
    store::{self, Packet},
};
use backend_cpu::{
    Instructions,
    measure::{Exits, RayPacket},
};
use cpu_time::ProcessTime;
use serde_json::{Value, json};
use std::path::Path;

/// Times that all rays are traced in one measurement.
const REPEATS: usize = 20;

/// Traces `internal.rays`.
pub fn measure(instructions: Instructions, folder: &Path) -> Result<Value, Failure> {
    let scene = scene::prepared(Studio::Coloured, &scene::shallow("scalar")?)?;
    let exits = Exits::new(&scene, instructions).ok_or("the scene is one convex stone")?;
    let rays = store::read_packets(&folder.join("internal.rays"))?;
    let packet = |p: &Packet| RayPacket::new(p.origin, p.direction, p.alive as u16);
    let packets: Vec<RayPacket> = rays.iter().map(packet).collect();
    let mut distances = vec![[0.0; store::WIDTH]; packets.len()];
    let time = ProcessTime::now();
    for _ in 0..REPEATS {
        exits.distances(&packets, &mut distances);
    }
    let cpu = time.elapsed().as_secs_f64() / REPEATS as f64;
    let sum: f64 = rays
        .iter()
        .zip(&distances)
        .flat_map(|(packet, distances)| packet.lanes().map(|lane| f64::from(distances[lane])))
        .sum();
    let count: u32 = rays.iter().map(|packet| packet.alive.count_ones()).sum();
    Ok(json!({ "cpu": cpu, "rays": count, "mean": sum / f64::from(count) }))
}
