//! `[[stone]]`.

use super::fields::{Entry, Fields, either};
use super::material::Materials;
use super::source::{Sources, sha256};
use crate::import::mesh::Selection;
use crate::{Error, import};
use glam::{DMat3, EulerRot};
use spectral_core::material::Material;
use spectral_core::mesh::Mesh;
use spectral_core::scene::{Orientation, Stone, Up};
use spectral_core::shape::ShapeSpec;
use spectral_core::{Warning, shown};
use std::path::Path;
use std::sync::Arc;

const FORMS: [&str; 3] = ["cut", "mesh", "shape"];

pub(super) fn read(root: &Fields, materials: &Materials, sources: &mut Sources) -> Result<Vec<Stone>, Error> {
    let Some(entry) = root.get("stone") else { return Ok(Vec::new()) };
    let tables = entry.tables("[[stone]]")?;
    let mut stones = Vec::new();
    for (number, fields) in tables.iter().enumerate() {
        stones.extend(stone(number + 1, fields, materials, sources)?);
    }
    Ok(stones)
}

/// A stone, or its copies.
fn stone(
    number: usize,
    fields: &Fields,
    materials: &Materials,
    sources: &mut Sources,
) -> Result<Vec<Stone>, Error> {
    // A misspelt key is reported before any error that its absence would cause.
    let own = fields.get("name").map(|e| e.text("a name for messages")).transpose()?;
    let (width, rotation, position) = (fields.get("width"), fields.get("rotation"), fields.get("position"));
    let (priority, material, copies) = (fields.get("priority"), fields.get("material"), fields.get("at"));
    let (up, crystal) = (fields.get("up"), fields.get("crystal"));
    let parts = [fields.get("object"), fields.get("hull")];
    let orientation = fields.one_of(&["optic_axis", "crystal_axes"])?;
    let form = fields.one_of(&FORMS)?;
    fields.finish()?;
    let missing = |what: &str| fields.error(format!("[[stone]] {number} needs {what}"));
    let (key, form) = form.ok_or_else(|| missing(&format!("exactly one of {}", either(&FORMS))))?;
    let material = material.ok_or_else(|| missing("'material': the name of a material"))?;
    let width = width.map(|e| e.number("a width in mm")).transpose()?;
    let design = match key {
        "cut" => materials.design(&material, &form, width.unwrap_or(1.0), sources)?,
        _ => None,
    };
    let mut material = design.map_or_else(|| materials.get(&material), Ok)?;
    let selection = selection(key, &parts, &material)?;
    let (mesh, source) = match key {
        "shape" => (shape(&form, sources)?, "shape"),
        _ => (mesh(key, &form, &selection, sources)?, form.text("the name of a file")?),
    };
    let label = own.map_or_else(|| format!("stone {number} ({})", shown(source)), shown);
    if !crystal.map_or(Ok(true), |entry| entry.flag())? {
        material = Arc::new(material.isotropic());
    }
    let mut stone = Stone::new(label, mesh, material);
    stone.orientation = orientation.map(|(_, entry)| orientation_of(&entry)).transpose()?;
    stone.width = width;
    if let Some(entry) = &up {
        stone.up = upright(entry, key)?;
    }
    if let Some(entry) = priority {
        stone.priority = entry.whole("a whole number")?;
    }
    if stone.width.is_none() && key != "mesh" {
        let message = format!("{} has no width: its design's own unit is taken for 1 mm", stone.name);
        sources.warn(vec![Warning::new(message)]);
    }
    let stones = match (copies, rotation, position) {
        (None, rotation, position) => {
            place(&mut stone, fields, [rotation.as_ref(), position.as_ref()])?;
            vec![stone]
        }
        (Some(copies), None, None) => copies_of(&stone, &copies)?,
        (Some(copies), rotation, position) => {
            let key = rotation.or(position).map(|entry| entry.key).unwrap_or_default();
            let message = format!("[[stone]] {number} has both 'at' and '{key}'; give '{key}' in 'at'");
            return Err(copies.error(message));
        }
    };
    if key == "mesh" && up.is_none() {
        sources.warn(stones.iter().find_map(laid_down).into_iter().collect());
    }
    Ok(stones)
}

/// `object = "gem"` and `hull = true`: what is taken of a mesh.
fn selection(
    form: &str,
    [object, hull]: &[Option<Entry>; 2],
    material: &Material,
) -> Result<Selection, Error> {
    if let Some(entry) = object.iter().chain(hull).next().filter(|_| form != "mesh") {
        return Err(entry.error(format!("'{}' is for a 'mesh'; a '{form}' is one convex solid", entry.key)));
    }
    let name = object.as_ref().map(|e| e.text("the name of an object of the mesh file")).transpose()?;
    let hull = hull.as_ref().map_or(Ok(false), Entry::flag)?;
    Ok(Selection { object: name.map(str::to_owned), hull, opaque: material.is_conductor() })
}

/// `up = "y"`: the axis of a mesh's file that is the table's normal.
fn upright(entry: &Entry, form: &str) -> Result<Up, Error> {
    let name = entry.text(&format!("one of {}", either(&Up::NAMES)))?;
    if form != "mesh" {
        return Err(
            entry.error(format!("'up' is for a 'mesh'; the table of a '{form}' is always towards +z"))
        );
    }
    Up::by_name(name).map_err(|e| entry.error(e))
}

/// A remark on a mesh with a width that its rotation turns onto its side: the width is then not what it looks like.
fn laid_down(stone: &Stone) -> Option<Warning> {
    let angles = stone.rotation * std::f64::consts::PI / 180.0;
    let height = DMat3::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x).row(2).abs();
    let (up, axis) = [(Up::X, "x"), (Up::Y, "y"), (Up::Z, "z")][height.max_position()];
    let stood = Stone { up, ..stone.clone() };
    let differs = (stood.file_width() / stone.file_width() - 1.0).abs() > 1e-3;
    (stone.width.is_some() && height.max_element() > 0.9 && differs).then(|| {
        Warning::new(format!(
            "{}: its width is measured across the x and y of its file, but 'rotation' turns the file's {axis} upright; \
             if {axis} is the normal of the table, write up = \"{axis}\" in place of that rotation",
            stone.name
        ))
    })
}

/// Where a stone stands.
fn place(stone: &mut Stone, fields: &Fields, [rotation, position]: [Option<&Entry>; 2]) -> Result<(), Error> {
    if let Some(entry) = rotation {
        stone.rotation = entry.vector("three angles [x, y, z], degrees")?.into();
    }
    if let Some(entry) = position {
        stone.position = entry.vector("three numbers [x, y, z], mm")?.into();
    }
    // Preparation places it again; here the complaint has a line.
    stone.check_place().map_err(|e| fields.blame(e))
}

/// `at = [{ position = […], rotation = […] }, …]`: the same stone in several places, one mesh for all.
fn copies_of(stone: &Stone, entry: &Entry) -> Result<Vec<Stone>, Error> {
    let places = entry.tables("at = [{ position = [0, 0, 0], rotation = [0, 0, 0] }, …]")?;
    if places.is_empty() {
        return Err(entry.refuse("at least one { position, rotation }"));
    }
    let copy = |(number, fields): (usize, &Fields)| {
        let (rotation, position) = (fields.get("rotation"), fields.get("position"));
        fields.finish()?;
        let mut copy = Stone { name: format!("{}, copy {}", stone.name, number + 1), ..stone.clone() };
        place(&mut copy, fields, [rotation.as_ref(), position.as_ref()])?;
        Ok(copy)
    };
    places.iter().enumerate().map(copy).collect()
}

/// `optic_axis = [x, y, z]` or `crystal_axes = [[x, y, z], [x, y, z]]`.
fn orientation_of(entry: &Entry) -> Result<Orientation, Error> {
    if entry.key == "optic_axis" {
        return Ok(Orientation::OpticAxis(entry.vector("a direction [x, y, z]")?.into()));
    }
    let axes: [[f64; 3]; 2] =
        entry.read().map_err(|_| entry.refuse("two directions [[x, y, z], [x, y, z]]"))?;
    Ok(Orientation::Axes(axes.map(Into::into)))
}

/// `shape = "step"`, or with parameters `shape = { name = "step", … }`.
fn shape(entry: &Entry, sources: &mut Sources) -> Result<Arc<Mesh>, Error> {
    let spec = match entry.value.get_ref().as_str() {
        Some(name) => ShapeSpec::by_name(name).map_err(|e| entry.error(e))?,
        None => {
            let fields = entry.fields("shape")?;
            let expected = format!("one of {}", either(&ShapeSpec::NAMES));
            let name = fields.need("name", &expected)?;
            ShapeSpec::by_name(name.text(&expected)?).map_err(|e| name.error(e))?;
            entry.read()?
        }
    };
    sources.shaped(&spec).map_err(|e| entry.error(e))
}

/// A solid from a file; many stones of one file share it.
fn mesh(key: &str, entry: &Entry, selection: &Selection, sources: &mut Sources) -> Result<Arc<Mesh>, Error> {
    let name = Path::new(entry.text("the name of a file")?);
    let other = if key == "cut" { import::mesh::Format::of(name).map(|_| "mesh") } else { None };
    let other = other.or_else(|| import::cut::Format::of(name).filter(|_| key == "mesh").map(|_| "cut"));
    if let Some(other) = other {
        return Err(entry.refuse(&format!("{} file; write {other} = … for this one", article(key))));
    }
    match key {
        "cut" => sources.import(entry, |path, bytes| import::cut::solid(path, &bytes)),
        _ => {
            let links = links(entry, name, sources)?;
            let open = |link: &str| {
                let found = links.iter().find(|(known, _)| known == link);
                found.map(|(_, bytes)| bytes.to_vec()).ok_or_else(|| "a buffer is missing".to_owned())
            };
            // Parts of one file are told apart, and so is a file whose buffers have changed.
            let held: Vec<_> = links.iter().map(|(link, bytes)| (link, sha256(bytes))).collect();
            let variant = format!("{selection:?} {held:?}");
            let read = |path: &Path, bytes: Vec<u8>| import::mesh::read_with(path, bytes, selection, &open);
            let text = entry.text("the name of a file")?;
            sources.read_variant(text, &variant, read).map_err(|e| entry.error(e))
        }
    }
}

/// The name of a file that another one names, and its bytes.
type Link = (String, Arc<Vec<u8>>);

/// The files that a glTF file names, with their bytes.
#[cfg(feature = "formats")]
fn links(entry: &Entry, name: &Path, sources: &mut Sources) -> Result<Vec<Link>, Error> {
    if import::mesh::Format::of(name) != Some(import::mesh::Format::Gltf) {
        return Ok(Vec::new());
    }
    let names = sources.import(entry, |path, bytes| {
        let links = import::guarded(|| import::gltf::File::parse(&bytes)?.links());
        Ok((links.map_err(|message| Error::file(path, message))?, Vec::new()))
    })?;
    let folder = name.parent().unwrap_or(Path::new(""));
    let read = |link: &String| {
        let path = folder.join(link);
        let bytes = sources.read(&path.to_string_lossy(), |_, bytes| Ok((bytes, Vec::new())));
        Ok((link.clone(), bytes.map_err(|e| entry.error(e))?))
    };
    names.iter().map(read).collect()
}

#[cfg(not(feature = "formats"))]
fn links(_: &Entry, _: &Path, _: &mut Sources) -> Result<Vec<Link>, Error> {
    Ok(Vec::new())
}

fn article(key: &str) -> &'static str {
    if key == "cut" { "a cut (.asc, .gem, .gcs)" } else { "a mesh (.glb, .gltf, .obj, .stl, .ply)" }
}
