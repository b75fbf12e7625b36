//! What a mesh file says beside its triangles: how its materials look, its camera, and what else is in it.

use super::mesh::{self, Format, Open};
use super::{guarded, utf8};
use crate::Error;
use glam::{DMat4, DVec3};
use spectral_core::camera::{Camera, Projection};
use std::path::Path;

/// A material as a mesh file describes it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Look {
    pub name: String,
    pub kind: Kind,
    /// 0 for a mirror, 1 for chalk.
    pub roughness: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kind {
    /// With its colour at normal incidence, linear sRGB.
    Metal([f64; 3]),
    Transparent {
        index: f64,
        /// V, (n_d − 1)/(n_F − n_C).
        abbe: Option<f64>,
        /// The colour, linear sRGB, that is left after a distance in the file's units.
        colour: Option<([f64; 3], f64)>,
    },
    /// Opaque and no metal.
    Opaque([f64; 3]),
}

/// One object of a file, or several of one name.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Object {
    /// What `object = …` calls it; `None`: the whole file.
    pub name: Option<String>,
    pub material: Option<String>,
    pub triangles: usize,
    pub low: DVec3,
    pub high: DVec3,
}

/// All of a file.
#[derive(Debug, Clone, Default)]
pub(crate) struct Inventory {
    pub objects: Vec<Object>,
    pub looks: Vec<Look>,
    pub camera: Option<Camera>,
    /// What has no counterpart in a scene, for people.
    pub rest: Vec<String>,
}

/// Reads what a mesh file holds.
///
/// # Errors
/// As [`mesh::read`].
pub(crate) fn inventory(path: &Path, bytes: &[u8]) -> Result<Inventory, Error> {
    let open = mesh::beside(path);
    let objects = mesh::objects(path, bytes, &open)?;
    let middle = |object: &Object| 0.5 * (object.low + object.high);
    let focus = objects.iter().map(middle).sum::<DVec3>() / objects.len().max(1) as f64;
    let described = guarded(|| match Format::of(path) {
        Some(Format::Gltf) => gltf_looks(bytes, focus),
        Some(Format::Obj) => Ok(Inventory { looks: obj_looks(bytes, &open), ..Inventory::default() }),
        _ => Ok(Inventory::default()),
    });
    let described = described.map_err(|message| Error::file(path, message))?;
    Ok(Inventory { objects, ..described })
}

fn gltf_looks(bytes: &[u8], focus: DVec3) -> Result<Inventory, String> {
    let file = super::gltf::File::parse(bytes)?;
    let document = &file.document;
    let looks = document.materials().filter_map(|material| gltf_look(&material)).collect();
    let mut camera = None;
    super::gltf::visit(document, &mut |node, transform, _| {
        camera = camera.take().or_else(|| node.camera().map(|camera| gltf_camera(&camera, transform, focus)));
        Ok(())
    })?;
    let textured = document.textures().len();
    let counts = [
        (document.animations().len(), "animation"),
        (document.skins().len(), "skin"),
        (textured, "texture"),
        (document.cameras().len().saturating_sub(1), "more camera"),
    ];
    let named =
        |(count, what): &(usize, &str)| format!("{count} {what}{}", if *count == 1 { "" } else { "s" });
    let mut rest: Vec<String> = counts.iter().filter(|(count, _)| *count > 0).map(named).collect();
    let read = [
        "KHR_materials_ior",
        "KHR_materials_transmission",
        "KHR_materials_volume",
        "KHR_materials_dispersion",
        "KHR_mesh_quantization",
    ];
    rest.extend(document.extensions_used().filter(|name| !read.contains(name)).map(spectral_core::shown));
    Ok(Inventory { looks, camera, rest, ..Inventory::default() })
}

fn gltf_look(material: &gltf::Material) -> Option<Look> {
    let plain = material.pbr_metallic_roughness();
    let [r, g, b, alpha] = plain.base_color_factor().map(f64::from);
    let transmission = material.transmission().map_or(0.0, |t| f64::from(t.transmission_factor()));
    let kind = if transmission > 0.0 || alpha < 0.95 {
        let volume = material.volume();
        let colour =
            volume.map(|v| (v.attenuation_color().map(f64::from), f64::from(v.attenuation_distance())));
        // KHR_materials_dispersion: 20/V.
        let dispersion =
            material.extension_value("KHR_materials_dispersion").and_then(|d| d.get("dispersion")?.as_f64());
        Kind::Transparent {
            index: material.ior().map_or(1.5, f64::from),
            abbe: dispersion.filter(|d| *d > 0.0).map(|d| 20.0 / d),
            colour: colour.filter(|(rgb, at)| at.is_finite() && *at > 0.0 && rgb.iter().any(|c| *c < 1.0)),
        }
    } else if plain.metallic_factor() >= 0.5 {
        Kind::Metal([r, g, b])
    } else {
        Kind::Opaque([r, g, b])
    };
    Some(Look { name: material.name()?.to_owned(), kind, roughness: plain.roughness_factor().into() })
}

/// A camera looks along −z of its node, with +y upright.
fn gltf_camera(camera: &gltf::Camera, transform: DMat4, focus: DVec3) -> Camera {
    use gltf::camera::Projection as P;
    let turn = super::gltf::to_z_up;
    let position = turn(transform.transform_point3(DVec3::ZERO));
    let direction = |v: DVec3| turn(transform.transform_vector3(v)).normalize_or(DVec3::Z);
    let (ahead, up) = (direction(DVec3::NEG_Z), direction(DVec3::Y));
    let projection = match camera.projection() {
        P::Perspective(p) => Projection::Perspective { fov: f64::from(p.yfov()).to_degrees() },
        P::Orthographic(o) => Projection::Orthographic { height: 2.0 * f64::from(o.ymag()) },
    };
    let distance = (focus - position).dot(ahead);
    let look_at = position + ahead * if distance > 0.0 { distance } else { 1.0 };
    Camera { position, look_at, up, projection }
}

/// The materials of an OBJ's `mtllib`; a library that cannot be read has none.
fn obj_looks(bytes: &[u8], open: Open) -> Vec<Look> {
    let bytes = utf8(bytes);
    let text = String::from_utf8_lossy(&bytes);
    let libraries = text.lines().filter_map(|line| line.trim().strip_prefix("mtllib "));
    let mut looks = Vec::new();
    for library in libraries.take(16) {
        let name = library.trim();
        let plain = |part: &str| !matches!(part, "" | "..") && !part.contains(['\\', ':']);
        if let Some(bytes) =
            Some(name).filter(|name| name.split('/').all(plain)).and_then(|name| open(name).ok())
        {
            looks.extend(mtl(&String::from_utf8_lossy(&utf8(&bytes))));
        }
    }
    looks
}

/// A material library: `newmtl`, `Kd`, `Ni`, `d`, `Tr`, `Tf`, `illum`, and `Pm` and `Pr` of its extension.
fn mtl(text: &str) -> Vec<Look> {
    let mut looks = Vec::new();
    for block in text.split("newmtl ").skip(1) {
        let mut lines = block.lines();
        let name = lines.next().unwrap_or_default().trim().to_owned();
        let words: Vec<Vec<&str>> = lines.map(|line| line.split_whitespace().collect()).collect();
        let numbers = |key: &str| -> Option<Vec<f64>> {
            let line = words.iter().find(|words| words.first() == Some(&key))?;
            line[1..].iter().map(|word| word.parse().ok()).collect()
        };
        let one = |key: &str| numbers(key).and_then(|v| v.first().copied());
        let three = |key: &str| numbers(key).and_then(|v| v.first_chunk::<3>().copied());
        let base = three("Kd").unwrap_or([0.8; 3]);
        let filter = three("Tf").filter(|rgb| rgb.iter().any(|c| *c < 1.0));
        let clear = one("d").is_some_and(|d| d < 0.95) || one("Tr").is_some_and(|t| t > 0.05);
        let refracts = one("illum").is_some_and(|model| [4.0, 6.0, 7.0, 9.0].contains(&model));
        let kind = if clear || refracts || filter.is_some() {
            Kind::Transparent { index: one("Ni").unwrap_or(1.5), abbe: None, colour: None }
        } else if one("Pm").is_some_and(|metal| metal >= 0.5) || one("illum") == Some(3.0) {
            Kind::Metal(base)
        } else {
            Kind::Opaque(base)
        };
        looks.push(Look { name, kind, roughness: one("Pr").unwrap_or(0.0) });
    }
    looks
}
