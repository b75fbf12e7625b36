//! The optics of a scene by wavelength: one table a wavelength grid.

use super::geometry::material_indices;
use crate::{
    Error, Warning, color::Response, material::Material, scene::Scene, settings::RenderSettings,
    upsample::Upsampler, wavelength::WavelengthGrid,
};

/// The optics of a material at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Index of refraction (real part).
    pub n: f64,
    /// Extinction coefficient, the index's imaginary part; above 0 for metals only.
    pub k: f64,
    /// Napierian absorption coefficient, 1/mm; 0 for metals, in which nothing is followed.
    pub absorption: f64,
}

/// All that transport asks of a wavelength grid. Every array runs over the grid's wavelengths, ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralTable {
    /// nm.
    pub wavelengths: Vec<f64>,
    /// Weights in X, Y and Z: the pixel is Σ response × radiance.
    pub response: Vec<[f64; 3]>,
    /// Radiance of Smits's seven bases (order of [`smits::COLORS`](crate::upsample::smits::COLORS)) under
    /// the environment's illuminant, its scale included.
    pub basis: Vec<[f64; 7]>,
    /// For each distinct material, in order of first use.
    pub media: Vec<Vec<Medium>>,
}

/// The most distinct wavelength grids: beyond, the offsets repeat, which then lie about 1/256 of a cell from each other.
const MOST_GRIDS: u32 = 256;

/// The same for the offsets of the [`lattice`](crate::lattice), a power of its base: beyond, three or nine lattices of so
/// many points lie beside each other in the pixel, at the same offsets. The error of 729 samples of a diamond is 3 % larger
/// than with as many grids, which take longer to make than that is worth.
const MOST_GRIDS_ON_LATTICE: u32 = 243;

/// One table for all samples, or one a sample where wavelengths are jittered.
pub(super) fn tables(
    scene: &Scene,
    settings: &RenderSettings,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<SpectralTable>, Error> {
    let grid = &settings.wavelengths;
    let materials = distinct_materials(scene);
    for material in &materials {
        warnings.extend(material.check(grid.range())?);
    }
    let jitter = settings.jitter && grid.can_jitter() && settings.samples > 1;
    let most = if settings.tolerance > 0.0 { MOST_GRIDS_ON_LATTICE } else { MOST_GRIDS };
    let grids = if jitter { settings.samples.min(most) } else { 1 };
    let tables = (0..grids)
        .map(|sample| SpectralTable::new(&settings.grid(sample), scene, &materials))
        .collect::<Result<Vec<_>, _>>()?;
    warnings.extend(coarseness(&tables));
    Ok(tables.into_iter().map(|(table, _)| table).collect())
}

fn distinct_materials(scene: &Scene) -> Vec<&Material> {
    let mut materials = Vec::new();
    for (stone, index) in scene.stones.iter().zip(material_indices(&scene.stones)) {
        if index as usize == materials.len() {
            materials.push(&*stone.material);
        }
    }
    materials
}

/// How well a grid carries colour.
struct Quality {
    white_exact: bool,
    residual: f64,
}

fn coarseness(tables: &[(SpectralTable, Quality)]) -> Option<Warning> {
    let residual = tables.iter().map(|(_, q)| q.residual).fold(0.0, f64::max);
    let count = tables.first().map_or(0, |(t, _)| t.wavelengths.len());
    if tables.iter().any(|(_, q)| !q.white_exact) {
        return Some(Warning::new(format!(
            "{count} wavelengths cannot carry white: the picture shows the colour of these wavelengths alone"
        )));
    }
    (residual > 4e-3).then(|| {
        Warning::new(format!(
            "{count} wavelengths are too few to show every colour of the environment: saturated ones are off \
             by up to {:.1} % (8 wavelengths or more are exact)",
            100.0 * residual
        ))
    })
}

impl SpectralTable {
    fn new(grid: &WavelengthGrid, scene: &Scene, materials: &[&Material]) -> Result<(Self, Quality), Error> {
        let response = Response::new(grid)?;
        let upsampler = Upsampler::new(grid, &response)?;
        let quality = Quality { white_exact: response.white_exact(), residual: upsampler.residual() };
        let lit = upsampler.with_illuminant(&scene.environment.illuminant);
        let scale = scene.environment.scale;
        let wavelengths = grid.nm().to_vec();
        let basis = (0..wavelengths.len())
            .map(|i| std::array::from_fn(|base| lit.basis()[base][i] * scale))
            .collect();
        let media =
            materials.iter().map(|m| wavelengths.iter().map(|&nm| Medium::new(m, nm)).collect()).collect();
        Ok((SpectralTable { response: response.xyz().to_vec(), basis, media, wavelengths }, quality))
    }
}

impl Medium {
    fn new(material: &Material, nm: f64) -> Self {
        let metal = material.is_conductor();
        Medium {
            n: material.index(nm),
            k: material.extinction(nm),
            absorption: if metal { 0.0 } else { material.absorption(nm) },
        }
    }
}
