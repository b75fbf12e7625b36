//! `[ground]`: something level to stand on.

use super::fields::{Entry, Fields, either};
use super::material::Materials;
use crate::{Error, shade};
use glam::DVec3;
use spectral_core::environment::Environment;
use spectral_core::material::{ConductorSpec, Material, MaterialSpec};
use spectral_core::mesh::{Mesh, MeshOptions};
use spectral_core::scene::Stone;
use std::sync::Arc;

const KINDS: [&str; 3] = ["diffuse", "material", "mirror"];

/// How far below the lowest stone a slab lies, mm: nearer surfaces would be in optical contact with it, and stones lie
/// on dust.
const GAP: f64 = 0.01;
/// A slab's width if none is given, in extents of what stands on it.
const EXTENTS: f64 = 20.0;

/// `[ground]` and what it stands beneath.
struct Site<'a> {
    fields: Fields<'a>,
    height: Option<Entry<'a>>,
    size: Option<Entry<'a>>,
    /// What the scene was enlarged by.
    scale: f64,
    stones: &'a [Stone],
    /// The box around the stones.
    bounds: (DVec3, DVec3),
}

/// A diffuse ground goes into the environment, any other is a slab with its top at the height of the ground; `scale` is
/// what the scene was enlarged by, and `coarse` says how a diffuse ground is shaded.
pub(super) fn read(
    root: &Fields,
    materials: &Materials,
    scale: f64,
    stones: &[Stone],
    environment: &mut Environment,
    coarse: bool,
) -> Result<Option<Stone>, Error> {
    let Some(entry) = root.get("ground") else { return Ok(None) };
    let fields = entry.fields("[ground]")?;
    let (height, size) = (fields.get("height"), fields.get("size"));
    let kind = fields.one_of(&KINDS)?;
    fields.finish()?;
    let needs = || fields.error(format!("[ground] needs exactly one of {}", either(&KINDS)));
    let (key, kind) = kind.ok_or_else(needs)?;
    let bounds = shade::bounds(stones).map_err(|e| fields.blame(e))?;
    let site = Site { fields, height, size, scale, stones, bounds };
    let material = match key {
        "diffuse" => {
            let ground = shade::ground(albedo(&kind)?, site.diffuse_height()?, stones, environment, coarse);
            environment.ground = Some(Arc::new(ground.map_err(|e| site.fields.error(e))?));
            return Ok(None);
        }
        "material" => materials.get(&kind)?,
        _ if kind.flag()? => Arc::new(mirror().map_err(|e| site.fields.blame(e))?),
        _ => return Err(kind.refuse("true, or leave [ground] out")),
    };
    site.slab(material).map(Some)
}

/// A reflectance, grey or linear sRGB.
fn albedo(entry: &Entry) -> Result<[f64; 3], Error> {
    let expected = "a reflectance from 0 to 1, or three of them: linear sRGB [r, g, b]";
    let rgb = match entry.number(expected) {
        Ok(grey) => [grey; 3],
        Err(_) => entry.vector(expected)?,
    };
    if rgb.iter().all(|c| (0.0..=1.0).contains(c)) { Ok(rgb) } else { Err(entry.refuse(expected)) }
}

impl Site<'_> {
    /// The height that is asked for, or that of the lowest stone.
    fn height(&self) -> Result<Option<f64>, Error> {
        let asked =
            self.height.as_ref().map(|entry| entry.number("the height of its upper side, mm")).transpose()?;
        if asked.is_none() && self.stones.is_empty() {
            return Err(self.missing("height"));
        }
        Ok(asked.map(|height| height * self.scale))
    }

    fn missing(&self, key: &str) -> Error {
        self.fields.error(format!("[ground] needs '{key}' in a scene without stones"))
    }

    fn diffuse_height(&self) -> Result<f64, Error> {
        if let Some(entry) = &self.size {
            return Err(entry.error("a diffuse ground reaches to the horizon; leave 'size' out"));
        }
        Ok(self.height()?.unwrap_or(self.bounds.0.z))
    }

    fn slab(&self, material: Arc<Material>) -> Result<Stone, Error> {
        let (low, high) = self.bounds;
        let top = self.height()?.unwrap_or(low.z - GAP);
        let width = match &self.size {
            Some(entry) => {
                let expected = "a width in mm, above 0 and at most 1e6";
                let width = entry.number(expected)?;
                if !(width > 0.0 && width <= 1e6) {
                    return Err(entry.refuse(expected));
                }
                width * self.scale
            }
            None if self.stones.is_empty() => return Err(self.missing("size")),
            None => EXTENTS * (high - low).max_element(),
        };
        let middle = if self.stones.is_empty() { DVec3::ZERO } else { (low + high) / 2.0 };
        let mesh = plate(width).map_err(|e| self.fields.error(e))?;
        let mut stone = Stone::new("the ground", Arc::new(mesh), material);
        stone.position = DVec3::new(middle.x, middle.y, top);
        stone.check_place().map_err(|e| self.fields.blame(e))?;
        Ok(stone)
    }
}

/// A square plate with the origin in the middle of its upper side, a hundredth as thick as wide.
fn plate(width: f64) -> Result<Mesh, spectral_core::Error> {
    let (half, depth) = (width / 2.0, width / 100.0);
    let corner = |i: usize| {
        let side = |bit: usize| if i >> bit & 1 == 1 { half } else { -half };
        DVec3::new(side(0), side(1), if i >> 2 & 1 == 1 { 0.0 } else { -depth })
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh::from_triangles((0..8).map(corner).collect(), triangles, &MeshOptions::default())
        .map(|(mesh, _)| mesh)
}

/// A metal with next to no loss: n = 10⁻⁶, k = 1000 reflects all but 10⁻⁸ at every angle.
fn mirror() -> Result<Material, spectral_core::Error> {
    let conductor = Some(ConductorSpec { table: vec![[550.0, 1e-6, 1e3]] });
    let spec = MaterialSpec { conductor, ..MaterialSpec::default() };
    let unread = |name: &str| Err(spectral_core::Error::value("absorption", name, "no file"));
    spec.build("mirror", unread).map(|(material, _)| material)
}
