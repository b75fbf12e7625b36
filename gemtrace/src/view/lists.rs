//! What can be chosen: cuts, materials, lights, and the keys of a scene that each choice stands for.

use super::store::Store;
use crate::import;
use serde_json::{Value as Json, json};
use spectral_core::color::{Response, RgbSpace, Tone, ViewTransform, srgb_encode};
use spectral_core::dispersion::fraunhofer;
use spectral_core::environment::Pattern;
use spectral_core::material::{Catalogue, Material};
use spectral_core::settings::Quality;
use spectral_core::shape::ShapeSpec;
use spectral_core::wavelength::WavelengthGrid;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// One entry of a list.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub id: String,
    pub label: String,
    pub group: &'static str,
    /// Its keys of the section that the list is about.
    pub keys: Table,
    /// What else the scene must have for it.
    pub besides: Table,
}

impl Choice {
    /// With keys as a scene has them.
    pub fn new(id: impl Into<String>, label: impl Into<String>, group: &'static str, keys: &str) -> Self {
        let keys = keys.parse().unwrap_or_default();
        Choice { id: id.into(), label: label.into(), group, keys, besides: Table::new() }
    }

    fn json(&self) -> Json {
        json!({ "id": self.id, "label": self.label, "group": self.group })
    }
}

/// All lists, by the names of the settings that they are for.
#[derive(Debug, Clone)]
pub struct Lists {
    pub cuts: Vec<Choice>,
    pub materials: Vec<Choice>,
    pub lights: Vec<Choice>,
    pub grounds: Vec<Choice>,
    pub qualities: Vec<Choice>,
    pub backgrounds: Vec<Choice>,
    pub tones: Vec<Choice>,
    pub axes: Vec<Choice>,
}

/// Names that people write in a way of their own.
const WRITTEN: [(&str, &str); 7] = [
    ("aset", "ASET"),
    ("cos", "COS"),
    ("ideal-scope", "Ideal-Scope"),
    ("iso", "ISO"),
    ("n-bk7", "N-BK7"),
    ("sc2", "SC2"),
    ("yag", "YAG"),
];

/// Names as people write them: "round-brilliant" is "Round brilliant".
pub fn spoken(name: &str) -> String {
    if let Some((_, written)) = WRITTEN.iter().find(|(known, _)| *known == name) {
        return (*written).to_owned();
    }
    let text = name.replace('-', " ");
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

impl Lists {
    /// What the program brings, and the files of the start folder.
    pub fn new(store: &Store) -> Self {
        let shape = |name: &&str| Choice::new(*name, spoken(name), "Shapes", &format!("shape = {name:?}"));
        let material =
            |name: &str| Choice::new(name, spoken(name), "Materials", &format!("material = {name:?}"));
        let tone = |t: &Tone| Choice::new(t.name(), spoken(t.name()), "", &format!("tone = {:?}", t.name()));
        let quality =
            |q: &Quality| Choice::new(q.name(), spoken(q.name()), "", &format!("quality = {:?}", q.name()));
        let mut lists = Lists {
            cuts: ShapeSpec::NAMES.iter().map(shape).collect(),
            materials: Catalogue::builtin().names().map(material).collect(),
            lights: lights(),
            grounds: vec![
                Choice::new("none", "None", "", ""),
                Choice::new("matt", "Matt", "", "diffuse = 0.5"),
                Choice::new("mirror", "Mirror", "", "mirror = true"),
                Choice::new("gold", "Gold", "", "material = \"gold\""),
            ],
            qualities: Quality::ALL.iter().map(quality).collect(),
            backgrounds: backgrounds(),
            tones: [Tone::Hue, Tone::Neutral, Tone::Clip].iter().map(tone).collect(),
            axes: axes(),
        };
        for path in files(store.start()) {
            lists.add_file(&path, store, "Files here");
        }
        lists
    }

    /// Adds a cut, a mesh or an environment, if the file is one. Returns the choice's id and which list has it now.
    pub fn add_file(
        &mut self,
        path: &Path,
        store: &Store,
        group: &'static str,
    ) -> Option<(&'static str, String)> {
        let name = Value::String(path.to_string_lossy().replace('\\', "/"));
        let (list, key, path_of) = match kind(path)? {
            Kind::Cut => (&mut self.cuts, "cut", "cut"),
            Kind::Mesh => (&mut self.cuts, "mesh", "cut"),
            Kind::Light => (&mut self.lights, "image", "light"),
            Kind::Scene => return None,
        };
        let keys = Table::from_iter([(key.to_owned(), name)]);
        if let Some(known) = list.iter().find(|choice| choice.keys == keys) {
            return Some((path_of, known.id.clone()));
        }
        let label = store.label(path);
        let count = list.iter().filter(|choice| choice.label == label).count();
        let id = if count > 0 { format!("file:{label}:{}", count + 1) } else { format!("file:{label}") };
        let group = if path_of == "light" { "Photographs" } else { group };
        list.insert(0, Choice { id: id.clone(), label, group, keys, besides: Table::new() });
        Some((path_of, id))
    }

    pub fn json(&self) -> Json {
        let plain = |list: &[Choice]| list.iter().map(Choice::json).collect::<Vec<_>>();
        let backgrounds: Vec<Json> = self.backgrounds.iter().map(background_json).collect();
        json!({
            "cuts": plain(&self.cuts), "lights": plain(&self.lights), "grounds": plain(&self.grounds),
            "qualities": plain(&self.qualities), "axes": plain(&self.axes), "tones": plain(&self.tones), "backgrounds": backgrounds,
            "materials": self.materials.iter().map(material_json).collect::<Vec<_>>(),
        })
    }
}

fn lights() -> Vec<Choice> {
    let model = |name: &str| {
        Choice::new(name, spoken(name), "Models", &format!("model = {name:?}\nhead_shadow = 10.0"))
    };
    let bare = |name: &str| Choice::new(name, spoken(name), "Models", &format!("model = {name:?}"));
    let mut all = vec![
        Choice::new("studio", "Studio", "Photographs", "preset = \"studio\""),
        Choice::new("uniform", "Even light", "Models", "uniform = [1.0, 1.0, 1.0]"),
    ];
    all.extend(["iso", "cos", "sc2"].map(model));
    all.extend(
        Pattern::NAMES.iter().filter(|name| !["iso", "cos", "sc2"].contains(name)).map(|name| bare(name)),
    );
    all
}

fn backgrounds() -> Vec<Choice> {
    let colour = |hex: &str, label: &str| Choice::new(hex, label, "", &format!("background = {hex:?}"));
    vec![
        colour("#333333", "Dark grey"),
        colour("#1e1e1e", "Near black"),
        colour("#777777", "Middle grey"),
        colour("#ffffff", "White"),
        Choice::new("environment", "Environment", "", "background = \"environment\""),
        Choice::new("transparent", "Transparent", "", "background = \"transparent\""),
    ]
}

fn background_json(choice: &Choice) -> Json {
    let mut json = choice.json();
    json["css"] = choice.id.starts_with('#').then(|| choice.id.clone()).into();
    json
}

/// How a crystal lies: which way its z, the optic axis of a uniaxial one, points.
fn axes() -> Vec<Choice> {
    vec![
        Choice::new("table", "Along the table’s normal", "", ""),
        Choice::new(
            "x",
            "In the girdle’s plane, along x",
            "",
            "crystal_axes = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]",
        ),
        Choice::new(
            "y",
            "In the girdle’s plane, along y",
            "",
            "crystal_axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]",
        ),
        Choice::new("one", "One index, not doubly refracting", "", "crystal = false"),
    ]
}

fn material_json(choice: &Choice) -> Json {
    let mut json = choice.json();
    let known = choice.keys.get("material").and_then(Value::as_str).filter(|_| choice.besides.is_empty());
    if let Some(material) = known.and_then(|name| Catalogue::builtin().get(name).ok()) {
        json["index"] = material.index(fraunhofer::D).into();
        // As the trade has it; that of opticians, between F and C, is about half of it.
        json["dispersion"] = (material.index(fraunhofer::G) - material.index(fraunhofer::B)).into();
        json["metal"] = material.is_conductor().into();
        json["approximate"] = material.is_approximate().into();
        json["isotropic"] = (!material.is_crystal()).into();
        json["swatch"] = swatch(material).into();
    } else {
        json["isotropic"] = true.into();
        json["swatch"] = "#cccccc".into();
    }
    json
}

/// The colour of daylight that crossed 6 mm of a stone, or that a metal reflects straight back.
fn swatch(material: &Material) -> String {
    let share = |nm: f64| {
        let (n, k) = (material.index(nm), material.extinction(nm));
        if k > 0.0 {
            return ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
        }
        let axes = material.absorptions(nm);
        axes.iter().map(|alpha| (-6.0 * alpha).exp()).sum::<f64>() / axes.len() as f64
    };
    let grid = WavelengthGrid::default();
    let light: Vec<f64> = spectral_core::cie::Illuminant::D65.sample(&grid);
    let seen: Vec<f64> = light.iter().zip(grid.nm()).map(|(light, nm)| light * share(*nm)).collect();
    let rgb = Response::new(&grid).map_or([0.8; 3], |response| response.to_linear_srgb(&seen));
    hex(rgb)
}

/// Linear sRGB as `#rrggbb`.
pub fn hex(rgb: [f64; 3]) -> String {
    let rgb = ViewTransform::new(Tone::Hue, RgbSpace::Srgb).shown(rgb);
    let [r, g, b] = rgb.map(|c| (srgb_encode(c.clamp(0.0, 1.0)) * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// What a file is, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Cut,
    Mesh,
    Light,
    Scene,
}

pub fn kind(path: &Path) -> Option<Kind> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    match extension.as_str() {
        "hdr" | "exr" => Some(Kind::Light),
        "toml" => Some(Kind::Scene),
        _ if import::cut::Format::of(path).is_some() => Some(Kind::Cut),
        _ => import::mesh::Format::of(path).map(|_| Kind::Mesh),
    }
}

/// Folders deeper than this are not looked into, nor more entries than that.
const DEEPEST: usize = 3;
const ENTRIES: usize = 4000;
/// Files that are listed.
const LISTED: usize = 100;

/// The cuts, meshes and environments of a folder, in the order of their names; links are not followed.
fn files(start: &Path) -> Vec<PathBuf> {
    let (mut found, mut seen) = (Vec::new(), 0);
    let mut folders = vec![(start.to_owned(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        for entry in entries.flatten().take(ENTRIES - seen.min(ENTRIES)) {
            seen += 1;
            let (path, name) = (entry.path(), entry.file_name());
            let hidden =
                name.to_string_lossy().starts_with('.') || name == "target" || name == "node_modules";
            match entry.file_type() {
                Ok(kind) if kind.is_dir() && depth < DEEPEST && !hidden => folders.push((path, depth + 1)),
                Ok(kind) if kind.is_file() && !hidden && is_listed(&path) => found.push(path),
                _ => {}
            }
        }
    }
    found.sort();
    found.truncate(LISTED);
    found.reverse();
    found
}

/// Pictures are EXR, too: only those twice as wide as high are lights.
fn is_listed(path: &Path) -> bool {
    match kind(path) {
        Some(Kind::Light) if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) => {
            let meta = exr::meta::MetaData::read_from_file(path, false);
            let size = meta.ok().and_then(|meta| meta.headers.first().map(|header| header.layer_size));
            size.is_some_and(|size| size.width() == 2 * size.height())
        }
        Some(kind) => kind != Kind::Scene,
        None => false,
    }
}
