//! A pixel, looked at closely: its spectrum, its colour, and the way of its main ray.

use super::lists::{hex, spoken};
use super::sight::Sight;
use super::solid::{Solid, shown};
use crate::{Error, Session};
use backend_cpu::{Chain, Kind};
use glam::{DVec2, DVec3};
use serde_json::{Value, json};
use spectral_core::camera::{Camera, CameraRay, Projection};
use spectral_core::color::{RgbSpace, ViewTransform, matrix};
use spectral_core::environment::Source;
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Scene;
use spectral_core::settings::{Coverage, RenderSettings};
use spectral_core::wavelength::WavelengthGrid;
use std::sync::Arc;

/// The wavelength of the main ray, nm: the middle of what the eye sees.
const MIDDLE: f64 = 555.0;
/// Samples of the pixel's spectrum.
const SAMPLES: u32 = 81;

/// The ray through a place of the picture, pixels from its top left corner, to a pixel of a frame.
pub fn ray(sight: &Sight, [x, y]: [f64; 2]) -> CameraRay {
    let (scene, whole) = (&sight.prepared, &sight.loaded.scene);
    let x = x * f64::from(scene.width) / f64::from(whole.width);
    let y = y * f64::from(scene.height) / f64::from(whole.height);
    scene.view.ray(x, y)
}

/// Points as the page draws them.
pub fn points(points: &[DVec3]) -> Value {
    json!(points.iter().map(|point| shown(*point)).collect::<Vec<_>>())
}

/// The message `pixel`, but for its id.
///
/// # Errors
/// [`Error::Core`] for what cannot be rendered.
pub fn inspect(
    sight: &Sight,
    solid: &Solid,
    gear: Option<i32>,
    at: [f64; 2],
    session: &mut Session,
) -> Result<Value, Error> {
    // In the middle of the pixel, so that the same pixel has one answer.
    let [x, y] = at.map(|v| v.floor() + 0.5);
    let scene = at_middle(sight)?;
    let ray = scene.view.ray(x, y);
    let mut message = spectrum(sight, &scene, [x, y], session)?;
    let chain = backend_cpu::heaviest(&scene, &ray, 0);
    let place = chain.events.first().and_then(|event| solid.place(event.facet));
    let local = |point: DVec3| solid.unposed(point + sight.prepared.geometry.origin);
    let spots: Vec<DVec3> = chain.events.iter().map(|event| local(event.point)).collect();
    let exit = chain.exit.map(|exit| solid.unturned(exit));
    let from = solid.unturned(-ray.direction);
    message["type"] = "pixel".into();
    message["x"] = at[0].floor().into();
    message["y"] = at[1].floor().into();
    message["facet"] = place.and_then(|place| solid.facet(place, gear)).into();
    message["outline"] = place.map(|place| points(&solid.outline(place))).into();
    message["source"] = source(sight, &chain).into();
    message["path"] = json!({
        "length": chain.events.iter().filter(|event| event.inside).map(|event| event.length).sum::<f64>(),
        "events": events(&chain, &spots, solid, gear), "from": shown(from), "exit": exit.map(shown),
    });
    message["section"] = section(solid, &spots, from, exit);
    Ok(message)
}

/// The scene in the picture's size, at the wavelength of main rays.
fn at_middle(sight: &Sight) -> Result<Arc<PreparedScene>, Error> {
    let settings = RenderSettings {
        wavelengths: WavelengthGrid::list(vec![MIDDLE])?,
        jitter: false,
        spectral: false,
        ..sight.loaded.settings.with_samples(1)
    };
    Ok(Arc::new(sight.prepared.update(&sight.loaded.scene, &settings)?))
}

fn events(chain: &Chain, spots: &[DVec3], solid: &Solid, gear: Option<i32>) -> Value {
    let name = |facet: usize| {
        let facet = solid.place(facet).and_then(|place| solid.facet(place, gear));
        facet.map_or_else(|| "ground".into(), |facet| facet["name"].clone())
    };
    let event = |(event, spot): (&backend_cpu::Event, &DVec3)| {
        let kind = match event.kind {
            Kind::In => "in",
            Kind::Out => "out",
            Kind::Reflection => "part",
            Kind::TotalReflection => "total",
            Kind::End => "end",
        };
        json!({ "facet": name(event.facet), "event": kind, "angle": event.angle, "left": event.left,
                "length": event.length, "point": shown(*spot) })
    };
    Value::Array(chain.events.iter().zip(spots).map(event).collect())
}

/// Where the light of a chain came from, in words.
fn source(sight: &Sight, chain: &Chain) -> String {
    let Some(exit) = chain.exit else {
        return "it ends inside the stone: what is left is too weak to be followed".to_owned();
    };
    let up = exit.z.clamp(-1.0, 1.0).asin().to_degrees();
    let round = exit.x.atan2(exit.y).to_degrees().rem_euclid(360.0);
    let environment = &sight.loaded.scene.environment;
    let section = sight.setup.section("environment");
    let name = |key: &str| section.and_then(|section| section.get(key)?.as_str());
    let light = match &environment.source {
        _ if up < 0.0 && environment.ground.is_some() => return "from the ground".to_owned(),
        Source::Uniform(_) => "even light".to_owned(),
        Source::Image(_) => name("image")
            .map(|path| {
                std::path::Path::new(path).file_stem().unwrap_or_default().to_string_lossy().into_owned()
            })
            .or_else(|| name("model").map(|model| format!("the light model {}", spoken(model))))
            .unwrap_or_else(|| "the studio".to_owned()),
    };
    let seen = if chain.events.is_empty() { ", seen directly" } else { "" };
    let side = if up < 0.0 { "under" } else { "above" };
    format!("{light}, {:.0}° {side} the horizon, {round:.0}° round{seen}", up.abs())
}

/// The spectrum and the colour of a pixel: a picture of this pixel alone.
fn spectrum(
    sight: &Sight,
    seen: &PreparedScene,
    place: [f64; 2],
    session: &mut Session,
) -> Result<Value, Error> {
    let whole = &sight.loaded.scene;
    let camera = close(&whole.camera, seen, place);
    let scene = Scene { camera, width: 1, height: 1, ..whole.clone() };
    let settings = RenderSettings {
        wavelengths: WavelengthGrid::default(),
        jitter: false,
        spectral: true,
        coverage: Coverage::Points,
        ..sight.loaded.settings.with_samples(SAMPLES)
    };
    let scene: Arc<PreparedScene> = session.prepare(&scene, &settings)?;
    let (film, _) = session.film(&scene, &mut ())?;
    let xyz = film.xyz(0, 0).map(f64::from);
    let sum: f64 = xyz.iter().sum();
    let through = 1.0 - f64::from(film.coverage(0, 0));
    let gain = sight.loaded.exposure.exp2();
    let rgb = matrix::apply(&RgbSpace::Srgb.from_xyz(), xyz).map(|c| c * gain);
    let cover = 1.0 - through;
    let view = ViewTransform::new(sight.loaded.tone, RgbSpace::Srgb);
    let rgb = view.shown(rgb.map(|c| c / cover.max(1e-9))).map(|c| c * cover);
    let behind = sight.loaded.backdrop.unwrap_or_default();
    let colour = hex(std::array::from_fn(|c| (rgb[c] + through * behind[c]).clamp(0.0, 1.0)));
    let chromaticity = (sum > 0.0).then(|| [xyz[0] / sum, xyz[1] / sum]);
    Ok(json!({
        "colour": colour, "chromaticity": chromaticity, "luminance": xyz[1],
        "wavelengths": settings.wavelengths.nm(), "radiance": film.radiance(0, 0),
    }))
}

/// The camera for the pixel about a place alone.
fn close(camera: &Camera, seen: &PreparedScene, [x, y]: [f64; 2]) -> Camera {
    let [middle, above, below] = [0.0, -0.5, 0.5].map(|dy| seen.view.ray(x, y + dy));
    let (origin, pixels) = (seen.geometry.origin, f64::from(seen.height));
    match camera.projection {
        Projection::Perspective { .. } => {
            let fov = above.direction.angle_between(below.direction).to_degrees().max(1e-9);
            let position = camera.position;
            Camera {
                look_at: position + middle.direction * camera.position.distance(camera.look_at),
                projection: Projection::Perspective { fov },
                ..camera.clone()
            }
        }
        Projection::Orthographic { height } => {
            let position = middle.origin + origin;
            Camera {
                position,
                look_at: position + middle.direction * camera.position.distance(camera.look_at),
                projection: Projection::Orthographic { height: height / pixels },
                ..camera.clone()
            }
        }
    }
}

/// The stone from the side, with the way through it: seen along the horizontal direction across which the way is widest.
fn section(solid: &Solid, spots: &[DVec3], from: DVec3, exit: Option<DVec3>) -> Value {
    let corners = solid.corners();
    let middle = spots.iter().sum::<DVec3>() / spots.len().max(1) as f64;
    let spread = spots.iter().copied().chain([middle + from]).map(|spot| (spot - middle).truncate());
    let [xx, xy, yy] =
        spread.fold([0.0; 3], |[xx, xy, yy], d| [xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y]);
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let across = DVec3::new(angle.cos(), angle.sin(), 0.0);
    let flat = |point: DVec3| {
        let from = point - solid.middle;
        DVec2::new(from.dot(across), from.z)
    };
    let reach = corners.iter().map(|corner| corner.distance(solid.middle)).fold(0.0, f64::max);
    let list = |points: &[DVec2]| json!(points.iter().map(|p| p.to_array()).collect::<Vec<_>>());
    let flats: Vec<DVec2> = spots.iter().map(|spot| flat(*spot)).collect();
    let before = spots.first().map(|spot| flat(*spot + from * reach).to_array());
    let after = spots.last().zip(exit).map(|(spot, exit)| flat(*spot + exit * reach).to_array());
    let outline = hull(corners.iter().map(|corner| flat(*corner)).collect());
    json!({ "outline": list(&outline), "points": list(&flats), "from": before, "to": after })
}

/// The convex hull, counter-clockwise (Andrew's monotone chain, 1979).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain.as_slice()
                && (*b - *a).perp_dot(point - *a) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_has_the_corners_and_no_more() {
        let grid = (0..25).map(|k| DVec2::new(f64::from(k % 5), f64::from(k / 5))).collect();
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(DVec2::from);
        assert_eq!(hull(grid), corners);
        assert!(hull(Vec::new()).is_empty());
    }
}
