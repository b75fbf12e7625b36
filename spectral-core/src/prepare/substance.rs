//! What stones are made of, and how it is oriented.

use crate::{Error, Warning, material::Material, scene::Stone};
use glam::DVec3;
use std::sync::Arc;

/// A material with the axes of the crystal in the scene's frame; without axes it is traced as isotropic.
#[derive(Debug, Clone)]
pub(super) struct Substance {
    pub material: Arc<Material>,
    pub axes: Option<[DVec3; 3]>,
}

impl PartialEq for Substance {
    fn eq(&self, other: &Self) -> bool {
        let same = Arc::ptr_eq(&self.material, &other.material) || self.material == other.material;
        same && self.axes == other.axes
    }
}

impl Substance {
    fn of(stone: &Stone) -> Result<Self, Error> {
        let axes = if splits_light(stone)? { Some(stone.crystal_axes()?) } else { None };
        Ok(Substance { material: stone.material.clone(), axes })
    }
}

/// Two modes whose paths differ by less than this share of a wavelength are one.
const LEAST_RETARDATION: f64 = 0.1;

/// Whether a crystal's two modes are far enough apart to be seen as two, at some visible wavelength.
fn splits_light(stone: &Stone) -> Result<bool, Error> {
    if !stone.material.is_crystal() {
        return Ok(false);
    }
    let (low, high) = stone.bounds()?;
    let size = (high - low).max_element() * 1e6; // nm
    let retardation = |nm: f64| {
        let indices = stone.material.indices(nm);
        let [least, most] = [f64::min, f64::max].map(|pick| indices.into_iter().reduce(pick).unwrap_or(1.0));
        (most - least) * size / nm
    };
    Ok((380..=740).step_by(40).any(|nm| retardation(f64::from(nm)) >= LEAST_RETARDATION))
}

/// The distinct substances, in order of first use, and for each stone the index of its own.
pub(super) fn substances(stones: &[Stone]) -> Result<(Vec<Substance>, Vec<u32>), Error> {
    let mut distinct: Vec<Substance> = Vec::new();
    let mut indices = Vec::new();
    for stone in stones {
        let substance = Substance::of(stone)?;
        let known = distinct.iter().position(|other| *other == substance);
        indices.push(known.unwrap_or(distinct.len()) as u32);
        if known.is_none() {
            distinct.push(substance);
        }
    }
    Ok((distinct, indices))
}

/// Remarks about crystals: stones too small to split light, and orientations that are not given or serve nothing. A
/// [`PreparedScene`](super::PreparedScene) has them among its warnings.
///
/// # Errors
/// [`Error`] for a stone that cannot be placed.
pub fn remarks(stones: &[Stone]) -> Result<Vec<Warning>, Error> {
    let mut warnings: Vec<Warning> = Vec::new();
    let mut remark = |text: String| {
        if !warnings.iter().any(|known| known.message == text) {
            warnings.push(Warning::new(text));
        }
    };
    for stone in stones {
        let (name, material) = (&stone.name, &stone.material.name);
        if !stone.material.is_crystal() {
            if stone.orientation.is_some() {
                remark(format!("{name}: an axis is given, but '{material}' is not doubly refracting"));
            }
        } else if !splits_light(stone)? {
            remark(format!(
                "{name}: '{material}' delays its two rays by less than a tenth of a wavelength; it is traced as isotropic"
            ));
        } else if stone.orientation.is_none() {
            remark(format!(
                "the axes of '{material}' are not given: its optic axis, or z, is taken along the table's normal"
            ));
        }
    }
    Ok(warnings)
}
