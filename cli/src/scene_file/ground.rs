//! `[ground]`: something level to stand on.

use super::fields::{Fields, either};
use super::material::Materials;
use super::pose;
use crate::Error;
use glam::DVec3;
use spectral_core::material::{ConductorSpec, Material, MaterialSpec};
use spectral_core::mesh::{Mesh, MeshOptions};
use spectral_core::scene::Stone;
use std::sync::Arc;

const KINDS: [&str; 2] = ["material", "mirror"];

/// How far below the lowest stone the ground lies, mm: nearer surfaces would be in optical contact with it, and stones
/// lie on dust.
const GAP: f64 = 0.01;
/// The ground's width if none is given, in extents of what stands on it.
const EXTENTS: f64 = 20.0;

/// A slab with its top at the height of the ground; `scale` is what the scene was enlarged by.
pub(super) fn read(
    root: &Fields,
    materials: &Materials,
    scale: f64,
    stones: &[Stone],
) -> Result<Option<Stone>, Error> {
    let Some(entry) = root.get("ground") else { return Ok(None) };
    let fields = entry.fields("[ground]")?;
    let (height, size) = (fields.get("height"), fields.get("size"));
    let kind = fields.one_of(&KINDS)?;
    fields.finish()?;
    let needs = || fields.error(format!("[ground] needs exactly one of {}", either(&KINDS)));
    let (key, kind) = kind.ok_or_else(needs)?;
    let material = match key {
        "material" => materials.get(&kind)?,
        _ if kind.flag()? => Arc::new(mirror().map_err(|e| fields.blame(e))?),
        _ => return Err(kind.refuse("true, or leave [ground] out")),
    };
    let (low, high) = pose::bounds(stones).map_err(|e| fields.blame(e))?;
    let missing = |key: &str| fields.error(format!("[ground] needs '{key}' in a scene without stones"));
    let top = match height {
        Some(entry) => entry.number("the height of its upper side, mm")? * scale,
        None if stones.is_empty() => return Err(missing("height")),
        None => low.z - GAP,
    };
    let width = match size {
        Some(entry) => {
            let expected = "a width in mm, above 0 and at most 1e6";
            let width = entry.number(expected)?;
            if !(width > 0.0 && width <= 1e6) {
                return Err(entry.refuse(expected));
            }
            width * scale
        }
        None if stones.is_empty() => return Err(missing("size")),
        None => EXTENTS * (high - low).max_element(),
    };
    let middle = if stones.is_empty() { DVec3::ZERO } else { (low + high) / 2.0 };
    let mesh = slab(width).map_err(|e| fields.error(e))?;
    let mut stone = Stone::new("the ground", Arc::new(mesh), material);
    stone.position = DVec3::new(middle.x, middle.y, top);
    stone.check_place().map_err(|e| fields.blame(e))?;
    Ok(Some(stone))
}

/// A square plate with the origin in the middle of its upper side, a hundredth as thick as wide.
fn slab(width: f64) -> Result<Mesh, spectral_core::Error> {
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
