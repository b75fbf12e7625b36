//! The scenes that are measured: those of the program, and files.

use crate::console::Console;
use gemtrace::Error;
use gemtrace::scene_file::{self, LoadedScene, Override};
use glam::DVec3;
use spectral_core::material::Catalogue;
use spectral_core::mesh::{Mesh, MeshOptions};
use spectral_core::prepare::PreparedScene;
use spectral_core::scene::Stone;
use spectral_core::settings::Coverage;
use std::f64::consts::TAU;
use std::path::{MAIN_SEPARATOR, Path};
use std::sync::Arc;

/// A scene of the program, which needs no files.
pub struct Builtin {
    pub name: &'static str,
    pub about: &'static str,
    text: &'static str,
}

/// The scenes that are measured where none is named.
pub const BUILTIN: [Builtin; 4] = [
    Builtin {
        name: "brilliant",
        about: "a diamond brilliant, one convex stone",
        text: include_str!("scene/brilliant.toml"),
    },
    Builtin {
        name: "inclusion",
        about: "a ruby inside a quartz, a zircon beside them",
        text: include_str!("scene/inclusion.toml"),
    },
    Builtin {
        name: "step",
        about: "an emerald step cut, large facets and absorption",
        text: include_str!("scene/step.toml"),
    },
    Builtin {
        name: TORUS,
        about: "a glass torus, a mesh that is not convex",
        text: include_str!("scene/torus.toml"),
    },
];

const TORUS: &str = "torus";

/// A scene that can be measured.
pub struct Subject {
    /// As the command line names it.
    pub name: String,
    /// The hash of all that it was read from (see [`LoadedScene::hash`]).
    pub hash: String,
    pub prepared: Arc<PreparedScene>,
}

impl Subject {
    /// Reads and prepares one of [`BUILTIN`] or a scene file; remarks go to the console.
    pub fn new(name: &str, change: Override, console: &mut Console) -> Result<Self, Error> {
        let mut loaded = load(name)?;
        change.apply(&mut loaded);
        // What every device can render.
        loaded.settings.coverage = Coverage::Points;
        let prepared = PreparedScene::new(&loaded.scene, &loaded.settings)
            .map_err(|error| if change.is_given() { Error::Core(error) } else { Error::file(name, error) })?;
        for warning in loaded.warnings.iter().chain(&prepared.warnings) {
            console.warn(format_args!("{name}: {warning}"));
        }
        Ok(Subject { name: name.to_owned(), hash: loaded.hash, prepared: Arc::new(prepared) })
    }
}

/// A name of [`BUILTIN`] comes before a file of the same name; what looks like a file is one.
fn load(name: &str) -> Result<LoadedScene, Error> {
    if let Some(builtin) = BUILTIN.iter().find(|b| b.name == name) {
        return builtin.load();
    }
    let path = Path::new(name);
    if path.exists() || path.extension().is_some() || name.contains(['/', MAIN_SEPARATOR]) {
        return scene_file::load(path);
    }
    let names = BUILTIN.iter().map(|b| b.name);
    let unknown = spectral_core::Error::unknown("scene", name, names);
    Err(Error::Usage(format!("{unknown} (or the name of a scene file)")))
}

impl Builtin {
    fn load(&self) -> Result<LoadedScene, Error> {
        let mut loaded = scene_file::parse(self.text, Path::new(self.name), Path::new(""))?;
        if self.name == TORUS {
            loaded.scene.stones.push(glass_torus()?);
        }
        Ok(loaded)
    }
}

/// 4,096 triangles; 6.4 mm across.
fn glass_torus() -> Result<Stone, Error> {
    const AROUND: u32 = 64;
    const ACROSS: u32 = 32;
    let (major, minor) = (2.3, 0.9);
    let point = |i: u32, j: u32| {
        let (a, b) = (TAU * f64::from(i) / f64::from(AROUND), TAU * f64::from(j) / f64::from(ACROSS));
        let out = major + minor * b.cos();
        DVec3::new(out * a.cos(), out * a.sin(), minor * b.sin())
    };
    let index = |i: u32, j: u32| (i % AROUND) * ACROSS + j % ACROSS;
    let places = || (0..AROUND).flat_map(|i| (0..ACROSS).map(move |j| (i, j)));
    let positions = places().map(|(i, j)| point(i, j)).collect();
    let triangles = places()
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let (mesh, _) = Mesh::from_triangles(positions, triangles, &MeshOptions::default())?;
    Ok(Stone::new(TORUS, Arc::new(mesh), Arc::new(Catalogue::builtin().get("n-bk7")?.clone())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_programs_own_scenes_are_what_they_say() {
        let stones = |name: &str| load(name).unwrap().scene.stones;
        assert!(stones("brilliant").len() == 1 && stones("brilliant")[0].mesh.is_convex());
        assert_eq!(stones("inclusion").len(), 3);
        let torus = &stones("torus")[0].mesh;
        // Pappus: 2π² R r², less what the flat faces cut off.
        let wanted = 2.0 * std::f64::consts::PI.powi(2) * 2.3 * 0.9 * 0.9;
        assert!(!torus.is_convex() && (torus.volume() / wanted - 1.0).abs() < 0.01);
        for builtin in &BUILTIN {
            let loaded = builtin.load().unwrap();
            assert!(loaded.warnings.is_empty() && loaded.files.is_empty(), "{}", builtin.name);
        }
    }

    #[test]
    fn misspelt_scenes_are_recognised_and_files_are_files() {
        let error = load("briliant").unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("did you mean 'brilliant'?"), "{error}");
        assert_eq!(load("missing.toml").unwrap_err().exit_code(), 3);
    }
}
