//! GemCad binary.

use super::Cut;
use glam::DVec3;
use indicatrix_formats::gem;
use spectral_core::Warning;
use spectral_core::cut::CutFacet;
use spectral_core::mesh::Plane;

pub(super) fn read(bytes: &[u8]) -> Result<(Cut, Vec<Warning>), String> {
    let design = gem::parse_gem(bytes).map_err(|e| format!("not a complete GemCad design: {e}"))?;
    if design.facets.len() > Cut::MAX_FACETS {
        return Err(format!("{} facets; at most {} are read", design.facets.len(), Cut::MAX_FACETS));
    }
    let mut warnings = Vec::new();
    if design.gear == 0 {
        warnings.push(Warning::new("its gear has 0 teeth; the facets' planes do not depend on it"));
    }
    if design.preform.is_some() {
        warnings.push(Warning::new("its preform is ignored"));
    }
    let facets = design.facets.iter().enumerate().map(|(number, facet)| {
        // The file holds p with p·x = 1 on the plane: the normal is p/|p| and the distance 1/|p|.
        let plane = Plane::new(DVec3::from_array(facet.plane), 1.0)
            .map_err(|e| format!("facet {}: {e}", number + 1))?;
        let instructions = Some(facet.instructions.clone()).filter(|i| !i.is_empty());
        Ok(CutFacet { plane, name: facet.name.clone(), instructions })
    });
    let facets = facets.collect::<Result<_, String>>()?;
    let kept = |lines: [String; 4]| lines.into_iter().filter(|l| !l.is_empty()).collect();
    let index = Some(design.refractive_index).filter(|n| n.is_finite() && *n > 1.0);
    let cut = Cut {
        facets,
        title: kept(design.headings),
        footnotes: kept(design.footnotes),
        gear: Some(design.gear),
        index_of_refraction: index,
        colour: None,
    };
    Ok((cut, warnings))
}
