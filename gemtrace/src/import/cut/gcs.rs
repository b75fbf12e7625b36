//! Gem Cut Studio.

use super::Cut;
use glam::DVec3;
use indicatrix_formats::gcs::{self, GcsColor, GcsFacet, GcsTier};
use spectral_core::color::srgb_decode;
use spectral_core::cut::CutFacet;
use spectral_core::mesh::Plane;
use spectral_core::{Warning, shown};

pub(super) fn read(bytes: &[u8]) -> Result<(Cut, Vec<Warning>), String> {
    let design = gcs::parse_gcs_bytes(bytes).map_err(|e| format!("not a Gem Cut Studio design: {e}"))?;
    let count: usize = design.tiers.iter().map(GcsTier::facet_plane_count).sum();
    if count > Cut::MAX_FACETS {
        return Err(format!("{count} facets; at most {} are read", Cut::MAX_FACETS));
    }
    if design.index.gear == 0 {
        return Err("<index gear=\"0\">: a gear needs at least 1 tooth".into());
    }
    let mut warnings: Vec<Warning> = design.warnings.iter().map(Warning::new).collect();
    let mut facets = Vec::new();
    for (number, tier) in design.tiers.iter().enumerate() {
        let name = Some(tier.name.clone()).filter(|n| !n.is_empty());
        let label = name.as_deref().map_or_else(|| (number + 1).to_string(), shown);
        if !tier.visible {
            warnings.push(Warning::new(format!("tier '{label}' is hidden and is ignored")));
            continue;
        }
        if tier.guide {
            warnings.push(Warning::new(format!(
                "tier '{label}' is a guide tier; it is taken for facets of the stone: hide it if it is none"
            )));
        }
        if tier.is_frosted() {
            warnings.push(Warning::new(format!("tier '{label}' is frosted; it is taken for polished")));
        }
        for facet in &tier.facets {
            let plane = plane(tier, facet).map_err(|e| format!("tier '{label}': {e}"))?;
            let instructions = Some(tier.instructions.clone()).filter(|i| !i.is_empty());
            facets.push(CutFacet { plane, name: name.clone(), instructions });
        }
    }
    let info = design.info.unwrap_or_default();
    let cut = Cut {
        facets,
        title: info.title.into_iter().filter(|t| !t.is_empty()).collect(),
        footnotes: Vec::new(),
        gear: i32::try_from(design.index.gear).ok(),
        index_of_refraction: design.render.as_ref().map(|r| r.refractive_index).filter(|n| *n > 1.0),
        colour: design.render.as_ref().and_then(|r| colour(&r.color)),
    };
    Ok((cut, warnings))
}

/// The colour of a preview, encoded in sRGB; white and black, which stand for none, are none.
fn colour(color: &GcsColor) -> Option<[f64; 3]> {
    let encoded = [color.r, color.g, color.b];
    let some = encoded.iter().all(|c| (0.0..=1.0).contains(c)) && encoded != [1.0; 3] && encoded != [0.0; 3];
    some.then(|| encoded.map(srgb_decode))
}

/// The plane through the facet's own outline where it has one: normals carry more digits than the tier's
/// angles, which are written in single precision.
fn plane(tier: &GcsTier, facet: &GcsFacet) -> Result<Plane, String> {
    let unit = Plane::new(DVec3::from_array(facet.normal), 0.0).map_err(|e| e.to_string())?.normal;
    let offsets: Vec<f64> = facet.vertices.iter().map(|v| unit.dot(DVec3::new(v.x, v.y, v.z))).collect();
    let offset =
        if offsets.is_empty() { tier.depth } else { offsets.iter().sum::<f64>() / offsets.len() as f64 };
    Plane::new(unit, offset).map_err(|e| e.to_string())
}
