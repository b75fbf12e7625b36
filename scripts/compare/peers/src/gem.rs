//! indicatrix's spectral path tracer on the same stone, light and camera.
//!
//! Its y axis is up. Exchanging y and z mirrors light, stone and camera together, so the picture is the same.

use crate::{
    Failure,
    scene::{self, Studio},
    store,
};
use cpu_time::ProcessTime;
use glam::{DVec3, Vec3};
use indicatrix::{
    geometry::GpuFacetPlane,
    optics::{
        GemMaterial,
        raytracer::{Camera, EnvironmentSource, build_plane_soa},
    },
    renderer::{cpu_frame::trace_pixels_interleaved, env_map::EnvironmentMap, frame_scene::FrameScene},
};
use serde_json::{Value, json};
use std::path::Path;

/// The depth limit of gemtrace; Russian roulette ends paths sooner.
const BOUNCES: u32 = 64;

/// A picture of `samples` samples a pixel from sample `first` on: the mean of X, Y and Z as floats.
pub fn picture(samples: u32, first: u32, file: &Path) -> Result<Value, Failure> {
    let scene = scene::prepared(Studio::Grey, &scene::deep("polarized", 1, 32)?)?;
    let plane =
        |f: &spectral_core::prepare::FacetPlane| GpuFacetPlane::new(swapped(f.normal), -f.offset as f32);
    let planes: Vec<GpuFacetPlane> = scene.geometry.facets.iter().map(plane).collect();
    let studio = scene::studio(Studio::Grey)?;
    let (width, height) = (studio.width() as usize, studio.height() as usize);
    let map = EnvironmentMap::from_rgb(width, height, studio.texels().to_vec())?;
    let camera = camera(scene.geometry.origin);
    let frame = FrameScene {
        camera: &camera,
        width: scene::SIZE,
        height: scene::SIZE,
        planes: &planes,
        facet_finishes: &[],
        material: &GemMaterial::diamond(),
        max_bounces: BOUNCES,
        environment: EnvironmentSource::HdrMap(&map),
    };
    let soa = build_plane_soa(&planes);
    let time = ProcessTime::now();
    let sums = trace_pixels_interleaved(&frame, &soa, 0, 1, first, samples);
    let cpu = time.elapsed().as_secs_f64();
    let pixels: Vec<f32> = sums.iter().flat_map(|sum| (*sum / samples as f32).to_array()).collect();
    store::write_numbers(file, &pixels)?;
    Ok(json!({ "cpu": cpu }))
}

fn camera(middle: DVec3) -> Camera {
    let view = scene::camera();
    let forward = (view.look_at - view.position).normalize();
    let right = forward.cross(view.up).normalize();
    let up = right.cross(forward);
    let tangent = (scene::FOV.to_radians() / 2.0).tan();
    // Its pixel centres are integers: half a pixel to the right and down.
    let aimed = forward + (right - up) * (tangent / f64::from(scene::SIZE));
    Camera {
        origin: swapped(view.position - middle),
        forward: swapped(aimed),
        right: swapped(right),
        up: swapped(up),
        fov_tan: tangent as f32,
    }
}

fn swapped(v: DVec3) -> Vec3 {
    DVec3::new(v.x, v.z, v.y).as_vec3()
}
