//! How a file is opened: a scene as it stands, a cut or a mesh with a scene around it.

use super::document::{Setup, list};
use super::lists::{Kind, Lists, kind};
use super::setting;
use super::store::Store;
use crate::batch::sweep::base::rename_files;
use crate::scene_file::{Assets, Draft};
use crate::{Error, import};
use spectral_core::mesh::Mesh;
use spectral_core::scene::Up;
use std::path::Path;
use toml::{Table, Value};

/// What a lone stone is shown with: its width, mm, and the angle between its table's normal and the eye, degrees.
const WIDTH: f64 = 6.5;
const TILT: f64 = 25.0;
/// The share of the picture's half height that the sphere about the stone takes.
const FILLED: f64 = 0.9;
/// What a design without an index is made of.
const MATERIAL: &str = "diamond";

/// Opens a scene, a cut or a mesh; `named` says that the command line names it, and so all that it names may be read.
///
/// # Errors
/// As [`scene_file::load`](crate::scene_file::load) and the readers of cuts and meshes.
pub fn open(
    path: &Path,
    named: bool,
    store: &Store,
    lists: &mut Lists,
    assets: &mut Assets,
) -> Result<Setup, Error> {
    if named {
        store.grant(path);
    }
    let setup = match kind(path) {
        Some(Kind::Scene) => scene(path, named, store, assets)?,
        Some(Kind::Cut | Kind::Mesh) => {
            lists.add_file(path, store, "Opened");
            stone(path, lists)?
        }
        _ => {
            let message =
                "a view opens scenes (.toml), cuts (.asc, .gem, .gcs) and meshes (.obj, .stl, .ply)";
            return Err(Error::file(path, message));
        }
    };
    setting::register(&setup, lists, &store.label(path));
    Ok(setup)
}

/// What is shown if nothing was opened.
pub fn nothing() -> Setup {
    let keys = Table::from_iter([("shape".to_owned(), Value::from("round-brilliant"))]);
    Setup::new(around("round-brilliant.toml".as_ref(), keys, MATERIAL, Table::new(), [0.0, 0.0, -0.45], 3.6))
}

fn scene(path: &Path, named: bool, store: &Store, assets: &mut Assets) -> Result<Setup, Error> {
    let mut draft = Draft::read(path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    rename_files(&mut draft.table, &mut |name| {
        let file = folder.join(name);
        if named {
            store.grant(&file);
        }
        let place = store.admit(&file).unwrap_or(file);
        place.to_string_lossy().replace('\\', "/")
    });
    // As it stands, so that faults have the file's lines.
    assets.load(path)?;
    Ok(Setup::new(draft))
}

/// A stone alone, in the built-in studio.
fn stone(path: &Path, lists: &mut Lists) -> Result<Setup, Error> {
    let bytes = import::read_file(path)?;
    let (mesh, key, index) = if kind(path) == Some(Kind::Cut) {
        let (cut, _) = import::cut::read(path, &bytes)?;
        let (mesh, _) = cut.solid().map_err(|e| Error::file(path, e))?;
        (mesh, "cut", cut.index_of_refraction)
    } else {
        (import::mesh::read(path, &bytes)?.0, "mesh", None)
    };
    let name = Value::String(path.to_string_lossy().replace('\\', "/"));
    let keys = Table::from_iter([(key.to_owned(), name)]);
    let index = index.filter(|n| *n > 1.0 && *n <= 5.0);
    let material = index.map_or_else(|| MATERIAL.to_owned(), |n| format!("design, n = {n}"));
    let own = index.map(|n| Table::from_iter([("index".to_owned(), Value::Float(n))]));
    let besides =
        own.map(|own| Table::from_iter([(material.clone(), Value::Table(own))])).unwrap_or_default();
    let (middle, radius) = frame(&mesh);
    let setup = Setup::new(around(path, keys, &material, besides, middle, radius));
    setting::register(&setup, lists, &material);
    Ok(setup)
}

/// The middle of a mesh that is [`WIDTH`] wide, and the radius of a sphere about it, mm.
fn frame(mesh: &Mesh) -> ([f64; 3], f64) {
    let (low, high) = mesh.bounds();
    let width = (Up::Z.matrix() * (high - low)).truncate().min_element();
    let (scale, middle) = (WIDTH / width, (low + high) / 2.0);
    let radius = mesh.positions().iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
    ((middle * scale).to_array(), radius * scale)
}

/// A scene around one stone.
fn around(path: &Path, form: Table, material: &str, own: Table, middle: [f64; 3], radius: f64) -> Draft {
    let distance = radius / (FILLED * (crate::scene_file::DEFAULT_FOV.to_radians() / 2.0).tan());
    let (sin, cos) = TILT.to_radians().sin_cos();
    let [x, y, z] = middle;
    // A hundredth of a millimetre is enough for an eye, and is readable.
    let point = |p: [f64; 3]| list(&p.map(|v| (v * 100.0).round() / 100.0 + 0.0));
    let camera = Table::from_iter([
        ("position".to_owned(), point([x, y - distance * sin, z + distance * cos])),
        ("look_at".to_owned(), point(middle)),
    ]);
    let mut stone = form;
    stone.insert("width".to_owned(), Value::Float(WIDTH));
    stone.insert("material".to_owned(), Value::from(material));
    let film = Table::from_iter([("background".to_owned(), Value::from("#333333"))]);
    let environment = Table::from_iter([("preset".to_owned(), Value::from("studio"))]);
    let mut table = Table::new();
    table.insert("format".to_owned(), Value::Integer(crate::scene_file::FORMAT));
    table.insert("camera".to_owned(), Value::Table(camera));
    table.insert("film".to_owned(), Value::Table(film));
    table.insert("environment".to_owned(), Value::Table(environment));
    if !own.is_empty() {
        table.insert("material".to_owned(), Value::Table(own));
    }
    table.insert("stone".to_owned(), Value::Array(vec![Value::Table(stone)]));
    Draft { path: path.with_extension("toml"), table }
}
