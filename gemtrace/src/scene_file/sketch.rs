//! A scene to start from, written from what a mesh file holds.

use crate::import::look::{Inventory, Kind, Look, Object, inventory};
use crate::{Error, import};
use glam::DVec3;
use spectral_core::camera::{Camera, Projection};
use spectral_core::cie::Illuminant;
use spectral_core::color::{Response, RgbSpace, delta_e_2000, lab, matrix::apply};
use spectral_core::dispersion::fraunhofer;
use spectral_core::fresnel::conductor;
use spectral_core::material::{Catalogue, Material};
use spectral_core::upsample::Upsampler;
use spectral_core::wavelength::WavelengthGrid;
use std::fmt::Write;
use std::path::Path;

/// Whatever is smaller is given in metres.
const METRES: f64 = 0.5;

/// The text of a scene with the objects of the mesh file `path`, which the scene calls `name`: their materials as far as the
/// file says something physical, its camera, and remarks on what was left out.
///
/// # Errors
/// As [`import::mesh::read`].
pub fn sketch(path: &Path, name: &str) -> Result<String, Error> {
    let bytes = import::read_file(path)?;
    let Inventory { objects, looks, camera, rest } = inventory(path, &bytes)?;
    let low = objects.iter().map(|object| object.low).reduce(DVec3::min).unwrap_or_default();
    let high = objects.iter().map(|object| object.high).reduce(DVec3::max).unwrap_or_default();
    let scale = if (high - low).max_element() < METRES { 1000.0 } else { 1.0 };
    let mut text =
        format!("# Made from {name} by 'gemtrace scene'. docs/scene.md lists every key.\n\nformat = 1\n\n");
    text += &camera_text(&camera.unwrap_or_else(|| view(low, high)));
    if scale != 1.0 {
        let object = &objects[0];
        let width = (object.high - object.low).truncate().min_element() * scale;
        let _ = write!(
            text,
            "# The file seems to be in metres: this makes them millimetres.\n[pose]\nsize = {width:.6}\n\n"
        );
    }
    let mut described = Vec::new();
    for object in &objects {
        let look = object.material.as_ref().and_then(|name| looks.iter().find(|look| look.name == *name));
        stone_text(&mut text, name, object, look);
        described.extend(look.filter(|look| own(look).is_none() && !described.contains(look)));
    }
    for look in described {
        material_text(&mut text, look, scale);
    }
    if !rest.is_empty() {
        let _ = writeln!(text, "# Left out, since a scene has nothing like it: {}.", rest.join(", "));
    }
    Ok(text)
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn vector(v: DVec3) -> String {
    let [x, y, z] = v.to_array().map(|c| (c * 1e6).round() / 1e6 + 0.0);
    format!("[{x:?}, {y:?}, {z:?}]")
}

/// From above and before, with everything in the picture.
fn view(low: DVec3, high: DVec3) -> Camera {
    let (fov, look_at) = (14.0_f64, 0.5 * (low + high));
    let distance = 0.55 * (high - low).length() / (0.5 * fov).to_radians().tan();
    let position = look_at + distance * DVec3::new(0.0, -0.6, 0.8);
    Camera { position, look_at, up: DVec3::Z, projection: Projection::Perspective { fov } }
}

fn camera_text(camera: &Camera) -> String {
    let [position, look_at, up] = [camera.position, camera.look_at, camera.up].map(vector);
    let projection = match camera.projection {
        Projection::Perspective { fov } => format!("fov = {fov:?}"),
        Projection::Orthographic { height } => format!("orthographic = {height:?}"),
    };
    format!("[camera]\nposition = {position}\nlook_at = {look_at}\nup = {up}\n{projection}\n\n")
}

/// The catalogue's material of this name, if there is one.
fn own(look: &Look) -> Option<&'static Material> {
    Catalogue::builtin().get(&look.name.to_ascii_lowercase()).ok()
}

fn stone_text(text: &mut String, mesh: &str, object: &Object, look: Option<&Look>) {
    let size = object.high - object.low;
    let _ = writeln!(text, "# {} triangles, {:.4} × {:.4} × {:.4}", object.triangles, size.x, size.y, size.z);
    // What a file says nothing about is left out by a remark sign.
    let mut sign = "";
    let material = match (look, &object.material) {
        (Some(look), _) if own(look).is_some() => quoted(&look.name.to_ascii_lowercase()),
        (Some(Look { kind: Kind::Opaque(_), name, .. }), _) => {
            let name = quoted(name);
            let _ = writeln!(
                text,
                "# Its material, {name}, is opaque and no metal, which is not rendered; a metal would be:"
            );
            sign = "# ";
            "\"gold\"".to_owned()
        }
        (Some(look), _) => quoted(&look.name),
        (None, Some(name)) if Catalogue::builtin().get(&name.to_ascii_lowercase()).is_ok() => {
            quoted(&name.to_ascii_lowercase())
        }
        (None, name) => {
            let said = name.as_ref().map_or("no material".to_owned(), |name| {
                format!("the material {} and no more", quoted(name))
            });
            let _ = writeln!(text, "# The file gives it {said}: choose one of 'gemtrace materials'.");
            "\"diamond\"".to_owned()
        }
    };
    let _ = writeln!(text, "{sign}[[stone]]\n{sign}mesh = {}", quoted(mesh));
    if let Some(name) = &object.name {
        let _ = writeln!(text, "{sign}object = {}", quoted(name));
    }
    let _ = writeln!(text, "{sign}material = {material}\n");
}

fn material_text(text: &mut String, look: &Look, scale: f64) {
    let mut lines = match &look.kind {
        Kind::Opaque(_) => return,
        Kind::Metal(rgb) => metal(*rgb),
        Kind::Transparent { index, abbe, colour } => {
            // Single precision has no more digits.
            let index = &((index * 1e6).round() / 1e6);
            let mut lines = match abbe {
                Some(abbe) => cauchy(*index, *abbe),
                None => format!("index = {index:?}\n"),
            };
            if let Some((rgb, at)) = colour {
                let [r, g, b] = rgb.map(|c| (c * 1e6).round() / 1e6);
                let _ = writeln!(lines, "color = {{ rgb = [{r:?}, {g:?}, {b:?}], at = {:?} }}", at * scale);
            }
            lines + &near_gem(*index)
        }
    };
    if look.roughness > 0.05 {
        let _ = writeln!(lines, "# The file gives it a roughness of {:.2}.", look.roughness);
    }
    let _ = writeln!(text, "[material.{}]\n{lines}", quoted(&look.name));
}

/// n = A + B/λ² with this n_d and V.
fn cauchy(index: f64, abbe: f64) -> String {
    let inverse = |nm: f64| (1000.0 / nm).powi(2);
    let b = (index - 1.0) / abbe / (inverse(486.13) - inverse(656.27));
    let a = index - b * inverse(587.56);
    format!("# n = {index} and V = {abbe:.1}\ncauchy = [{a:.6}, {b:.6}]\n")
}

fn near_gem(index: f64) -> String {
    let gems = Catalogue::builtin().materials().filter(|material| !material.is_conductor());
    let apart = |material: &Material| (material.index(fraunhofer::D) - index).abs();
    let near = gems.min_by(|a, b| apart(a).total_cmp(&apart(b)));
    near.map_or_else(String::new, |near| {
        format!("# The nearest of the catalogue is {}, n = {:.3}.\n", near.name, near.index(fraunhofer::D))
    })
}

/// A conductor with this colour at normal incidence: a smooth reflectance R, of which n = (1 − R)/(1 + R) is the least index
/// and k follows (Gulbrandsen, "Artist Friendly Metallic Fresnel", 2014).
fn metal(rgb: [f64; 3]) -> String {
    let colour = rgb.map(|c| c.clamp(0.0, 1.0));
    let rows = reflectance(colour).map(|rows| {
        let row = |(nm, r): (f64, f64)| {
            let r = r.clamp(0.001, 0.999);
            let n = (1.0 - r) / (1.0 + r);
            let k = ((r * (n + 1.0).powi(2) - (n - 1.0).powi(2)) / (1.0 - r)).max(0.0).sqrt();
            format!("[{nm}, {n:.4}, {k:.4}]")
        };
        rows.into_iter().map(row).collect::<Vec<_>>().join(", ")
    });
    let near = near_metal(colour).map_or_else(String::new, |name| {
        format!(
            "# The nearest measured metal is {name}; it is right at every angle: material = \"{name}\".\n"
        )
    });
    near + &rows.map_or_else(
        |_| "like = \"silver\"\n".to_owned(),
        |rows| format!("conductor = {{ table = [{rows}] }}\n"),
    )
}

fn reflectance(rgb: [f64; 3]) -> Result<Vec<(f64, f64)>, spectral_core::Error> {
    let grid = WavelengthGrid::stepped(380.0, 740.0, 20.0)?;
    let light = Illuminant::D65.sample(&grid);
    let spectrum = Upsampler::new(&grid, &Response::new(&grid)?)?.spectrum(rgb);
    Ok(grid
        .nm()
        .iter()
        .zip(spectrum.iter().zip(light))
        .map(|(nm, (seen, light))| (*nm, seen / light))
        .collect())
}

fn near_metal(rgb: [f64; 3]) -> Option<String> {
    let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0).ok()?;
    let (response, light) = (Response::new(&grid).ok()?, Illuminant::D65.sample(&grid));
    let white = RgbSpace::Srgb.white_xyz();
    let wanted = lab(apply(&RgbSpace::Srgb.to_xyz(), rgb), white);
    let apart = |metal: &&Material| {
        let share = |nm: &f64| conductor(1.0, 1.0, metal.index(*nm), metal.extinction(*nm)).reflectance_s;
        let seen: Vec<f64> = light.iter().zip(grid.nm()).map(|(light, nm)| light * share(nm)).collect();
        delta_e_2000(lab(response.to_xyz(&seen), white), wanted)
    };
    let metals = Catalogue::builtin().materials().filter(|material| material.is_conductor());
    metals.min_by(|a, b| apart(a).total_cmp(&apart(b))).map(|metal| metal.name.clone())
}
