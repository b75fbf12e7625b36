//! The internal rays of the picture of the first line of the table, as packets of wavelengths in the order of a packet
//! renderer: a group of pixels makes each reflection together.

use crate::{
    Failure,
    baseline::{Stone, Wavelength, reflected, refracted},
    scene::{self, Studio},
    store::{self, Packet, WIDTH},
};
use accel::testing::Mesh;
use glam::Vec3A;
use serde_json::{Value, json};
use spectral_core::{fresnel::dielectric, prepare::PreparedScene};
use std::path::Path;

/// Pixels in a group.
const GROUP: usize = 16;
/// Edge of a tile, pixels.
const TILE: u32 = 16;
/// One tile of this many is recorded.
const EVERY: usize = 4;

/// A ray inside the stone.
struct Inside {
    origin: Vec3A,
    direction: Vec3A,
    facet: u32,
    /// Unpolarised: polarisation hardly affects which rays are followed.
    throughput: f32,
}

/// Writes `brilliant.mesh` and `internal.rays`.
pub fn write(folder: &Path) -> Result<Value, Failure> {
    let scene = scene::prepared(Studio::Coloured, &scene::shallow("scalar")?)?;
    let packets = packets(&scene);
    store::write_packets(&folder.join("internal.rays"), &packets)?;
    store::write_mesh(&folder.join("brilliant.mesh"), &mesh(&scene))?;
    let rays: u32 = packets.iter().map(|packet| packet.alive.count_ones()).sum();
    Ok(json!({ "packets": packets.len(), "rays": rays }))
}

/// The stone's triangles.
pub fn mesh(scene: &PreparedScene) -> Mesh {
    Mesh {
        positions: scene.geometry.positions.iter().map(|p| p.as_vec3()).collect(),
        triangles: scene.geometry.triangles.clone(),
    }
}

/// All packets.
pub fn packets(scene: &PreparedScene) -> Vec<Packet> {
    let (stone, lines) = (Stone::new(scene), Wavelength::all(scene));
    let mut packets = Vec::new();
    let tiles = (0..scene.height)
        .step_by(TILE as usize)
        .flat_map(|y| (0..scene.width).step_by(TILE as usize).map(move |x| (x, y)));
    for (x0, y0) in tiles.step_by(EVERY) {
        let pixels: Vec<(u32, u32)> =
            (y0..y0 + TILE).flat_map(|y| (x0..x0 + TILE).map(move |x| (x, y))).collect();
        for group in pixels.chunks(GROUP) {
            let mut rays: Vec<Vec<Option<Inside>>> = group
                .iter()
                .filter_map(|&(x, y)| entering(scene, &stone, &lines, x, y))
                .flat_map(|rays| {
                    let mut rays = rays.into_iter();
                    (0..lines.len() / WIDTH)
                        .map(move |_| rays.by_ref().take(WIDTH).collect())
                        .collect::<Vec<_>>()
                })
                .collect();
            for _ in 0..scene.settings.max_depth {
                packets.extend(rays.iter().map(|rays| packet(rays)).filter(|packet| packet.alive != 0));
                step(scene, &stone, &lines, &mut rays);
            }
        }
    }
    packets
}

fn packet(rays: &[Option<Inside>]) -> Packet {
    let mut packet = Packet::default();
    for (lane, ray) in rays.iter().enumerate() {
        if let Some(ray) = ray {
            packet.put(lane, ray.origin.into(), ray.direction.into());
        }
    }
    packet
}

fn entering(
    scene: &PreparedScene,
    stone: &Stone,
    lines: &[Wavelength],
    x: u32,
    y: u32,
) -> Option<Vec<Option<Inside>>> {
    let ray = scene.view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let direction = ray.direction.as_vec3a();
    let (distance, facet) = stone.hit(ray.origin.as_vec3a(), direction, u32::MAX)?;
    let origin = (ray.origin + ray.direction * f64::from(distance)).as_vec3a();
    let normal = stone.normals[facet as usize];
    let cosine = -normal.dot(direction);
    let inside = |line: &Wavelength| {
        let event = dielectric(cosine, 1.0 / line.n);
        let direction = refracted(direction, normal, cosine, event.cos_t, 1.0 / line.n);
        Some(Inside { origin, direction, facet, throughput: event.transmittance() })
    };
    Some(lines.iter().map(inside).collect())
}

/// One reflection of all rays.
fn step(scene: &PreparedScene, stone: &Stone, lines: &[Wavelength], packets: &mut [Vec<Option<Inside>>]) {
    let blocks = lines.len() / WIDTH;
    for (number, rays) in packets.iter_mut().enumerate() {
        for (lane, slot) in rays.iter_mut().enumerate() {
            let Some(ray) = slot.take() else { continue };
            let line = &lines[number % blocks * WIDTH + lane];
            let Some((distance, facet)) = stone.hit(ray.origin, ray.direction, ray.facet) else { continue };
            let normal = stone.normals[facet as usize];
            let throughput = ray.throughput * dielectric(normal.dot(ray.direction), line.n).reflectance();
            *slot = (throughput >= scene.settings.threshold as f32).then(|| Inside {
                origin: ray.origin + ray.direction * distance,
                direction: reflected(ray.direction, normal),
                facet,
                throughput,
            });
        }
    }
}
