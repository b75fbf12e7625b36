//! What the pages are told about the state.

use super::document::{Document, History, Setup};
use super::lists::Lists;
use super::message::Letter;
use super::setting;
use super::side::Side;
use super::solid::{Solid, shown};
use super::store::Store;
use serde_json::{Value, json};
use spectral_core::camera::{Camera, Projection};
use spectral_core::dispersion::fraunhofer;
use std::path::Path;

/// The message `state`.
pub fn state(history: &History, sides: &[Option<Side>; 2], lists: &Lists, store: &Store) -> Value {
    let [undo, redo] = history.labels();
    let side =
        |letter: Letter| sides[letter as usize].as_ref().map(|side| one(side, &history.now, lists, store));
    json!({
        "type": "state", "undo": undo, "redo": redo, "compare": sides[1].is_some(),
        "sides": { "A": side(Letter::A), "B": side(Letter::B) },
    })
}

fn one(side: &Side, document: &Document, lists: &Lists, store: &Store) -> Value {
    let (setup, loaded) = (&side.setup, &side.loaded);
    let pose = setup.pose();
    let solid = Solid::new(loaded, pose);
    let stone = loaded.scene.stones.first();
    let width = stone.map_or(0.0, |stone| stone.width.unwrap_or_else(|| stone.file_width()));
    let mut all = setting::all(setup, lists, width);
    let carat = stone.and_then(|stone| {
        let volume = stone.placed().ok()?.volume();
        // g/cm³ and mm³: a carat is 200 mg.
        Some(volume * stone.material.density? / 200.0)
    });
    all.extend([
        ("name".to_owned(), json!(name(setup, store))),
        ("facets".to_owned(), json!(solid.facet_count())),
        ("exposure_auto".to_owned(), json!(document.auto)),
        ("pose".to_owned(), json!(pose.to_array())),
        ("distance".to_owned(), json!(setup.distance())),
        ("middle".to_owned(), json!(shown(solid.middle))),
        ("normal".to_owned(), json!(shown(solid.normal()))),
        ("edges".to_owned(), solid.edges()),
        ("tiers".to_owned(), solid.tiers()),
        ("camera".to_owned(), camera(&loaded.scene.camera)),
        ("carat".to_owned(), json!(carat)),
        ("n".to_owned(), json!(stone.map(|stone| stone.material.index(fraunhofer::D)))),
        ("material_name".to_owned(), json!(stone.map(|stone| stone.material.name.clone()))),
    ]);
    Value::Object(all)
}

/// The file of the stone, else that of the scene.
fn name(setup: &Setup, store: &Store) -> String {
    let file = setup.stone().and_then(|stone| stone.get("cut").or(stone.get("mesh"))?.as_str());
    let file = file.map_or(setup.draft.path.as_path(), Path::new);
    store.label(file).rsplit('/').next().unwrap_or_default().to_owned()
}

fn camera(camera: &Camera) -> Value {
    let forward = (camera.look_at - camera.position).normalize_or_zero();
    let right = forward.cross(camera.up).normalize_or_zero();
    let (fov, height) = match camera.projection {
        Projection::Perspective { fov } => (Some(fov), None),
        Projection::Orthographic { height } => (None, Some(height)),
    };
    json!({
        "eye": camera.position.to_array(), "forward": forward.to_array(), "right": right.to_array(),
        "up": right.cross(forward).to_array(), "fov": fov, "height": height,
    })
}
