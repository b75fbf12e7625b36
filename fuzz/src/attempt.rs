//! A file of each kind that the program reads, from its bytes as far as they get: on the way to a prepared scene, to a
//! joined picture, to a page of a batch.
//!
//! The fuzz targets and the tests of the library share this.

use gemtrace::batch::entry::{Entry, ExpectedItem};
use gemtrace::batch::{manifest, merge, page, sweep};
use gemtrace::part::Joint;
use gemtrace::shard::Shard;
use gemtrace::{import, scene_file};
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Stone;
use std::path::Path;
use std::sync::{Arc, LazyLock};

/// The kinds of file: each has a folder of samples in `fuzz/corpus`.
pub const KINDS: [&str; 13] = [
    "scene",
    "asc",
    "gem",
    "gcs",
    "glb",
    "obj",
    "stl",
    "ply",
    "environment",
    "part",
    "manifest",
    "plan",
    "sweep",
];

/// The folder of the files that scenes and sweeps of the corpus name.
const FRAME: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fuzz/frame");

/// Reads a file of a kind; whether it is sound. Panics for another kind.
pub fn run(kind: &str, bytes: &[u8]) -> bool {
    let text = || String::from_utf8_lossy(bytes);
    let path = Path::new("file").with_extension(kind);
    match kind {
        "scene" => scene(&text()),
        "asc" | "gem" | "gcs" => import::cut::solid(&path, bytes).is_ok_and(|(mesh, _)| stone(mesh)),
        "glb" | "obj" | "stl" | "ply" => import::mesh::read(&path, bytes).is_ok_and(|(mesh, _)| stone(mesh)),
        "environment" => import::environment::read(&path, bytes).is_ok(),
        "part" => part(bytes),
        "manifest" => lines(bytes),
        "plan" => plan(bytes),
        "sweep" => sweep::parse(&text(), &path, Path::new(FRAME)).is_ok(),
        other => panic!("there is no kind of file called '{other}'"),
    }
}

fn scene(text: &str) -> bool {
    let loaded = scene_file::parse(text, Path::new("scene.toml"), Path::new(FRAME));
    loaded.is_ok_and(|loaded| PreparedScene::new(&loaded.scene, &loaded.settings).is_ok())
}

/// A cut or a mesh as the one stone of a small scene.
fn stone(mesh: spectral_core::mesh::Mesh) -> bool {
    static SCENE: LazyLock<scene_file::LoadedScene> = LazyLock::new(|| {
        let text = include_str!("../frame/stone.toml");
        scene_file::parse(text, Path::new("stone.toml"), Path::new(FRAME)).expect("a sound scene")
    });
    let mut scene = SCENE.scene.clone();
    let material = scene.stones[0].material.clone();
    scene.stones = vec![Stone { width: Some(6.5), ..Stone::new("any", Arc::new(mesh), material) }];
    PreparedScene::new(&scene, &SCENE.settings).is_ok()
}

/// A part as the first of two.
fn part(bytes: &[u8]) -> bool {
    let mut joint = Joint::default();
    let added = joint.add(Shard::new(0, 2).expect("a share"), Path::new("a.part-1-of-2.exr"), bytes);
    added.is_ok() && joint.finish(Path::new("")).is_ok_and(|(picture, _)| !picture.rgba().is_empty())
}

/// The lines of a manifest, written again and shown on a page.
fn lines(bytes: &[u8]) -> bool {
    let events = manifest::parse(bytes);
    let entries: Vec<Entry> = events.iter().filter_map(shown).collect();
    let again = events.iter().all(|event| serde_json::to_string(event).is_ok());
    let page = page::html(Path::new("no such folder"), "title", &entries);
    again && !events.is_empty() && !page.is_empty()
}

fn shown(event: &manifest::Event) -> Option<Entry> {
    let manifest::Event::Done(done) = event else { return None };
    let (item, identity) = (done.item.clone(), done.identity.clone());
    let item = ExpectedItem { item, values: done.values.clone(), identity, files: Vec::new() };
    Some(Entry { item, outcome: Ok(done.clone()) })
}

fn plan(bytes: &[u8]) -> bool {
    let Ok(expected) = merge::parse(Path::new("plan.json"), bytes) else { return false };
    let missing = |item| Entry { item, outcome: Err("missing".to_owned()) };
    let entries: Vec<Entry> = expected.items.into_iter().map(missing).collect();
    !page::html(Path::new("no such folder"), &expected.title, &entries).is_empty()
}
