//! The optics of a scene by wavelength: one table a wavelength grid.

use super::{
    Medium,
    substance::{Substance, substances},
};
use crate::{
    Error, Warning,
    cie::Illuminant,
    color::Response,
    environment::Environment,
    lattice,
    scene::Scene,
    settings::{Coverage, RenderSettings},
    upsample::{BASES, Upsampler},
    wavelength::WavelengthGrid,
};
use std::sync::Arc;

/// All that transport asks of a wavelength grid. Every array runs over the grid's wavelengths, ascending.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SpectralTable {
    /// nm.
    pub wavelengths: Vec<f64>,
    /// Weights in X, Y and Z: the pixel is Σ response × radiance.
    pub response: Vec<[f64; 3]>,
    /// Radiance of the [`Upsampler`]'s bases under the environment's illuminant, its scale included.
    pub basis: Vec<[f64; BASES]>,
    /// For each distinct material, and for each orientation of a crystal, in order of first use.
    pub media: Vec<Vec<Medium>>,
}

/// The most distinct wavelength grids. With more samples their offsets repeat; these lie about 1/256 of a cell apart.
const MOST_GRIDS: u32 = 256;

/// The same for the offsets of the [`lattice`](crate::lattice): a power of its base, so that with more samples three or
/// nine lattices share the offsets. The error of 729 samples of a diamond is 3 % larger than with 729 grids, which take
/// more time to make than that gains.
const MOST_GRIDS_ON_LATTICE: u32 = lattice::PLACES;

/// Where wavelengths lie in their cells from sample to sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sequence {
    GoldenRatio,
    Lattice,
    Area,
}

/// The optics of a scene.
#[derive(Debug)]
#[non_exhaustive]
pub struct Optics {
    /// One table for all samples, or one a sample where wavelengths are jittered.
    pub tables: Vec<SpectralTable>,
    pub(super) warnings: Vec<Warning>,
    grids: Arc<Grids>,
    substances: Vec<Substance>,
    illuminant: Illuminant,
    scale: f64,
}

impl Optics {
    /// The optics of a scene; those made `before` where they are the same, and of them what can be kept.
    pub(super) fn new(
        scene: &Scene,
        settings: &RenderSettings,
        before: Option<&Arc<Optics>>,
    ) -> Result<Arc<Self>, Error> {
        Self::of(substances(&scene.stones)?.0, &scene.environment, settings, before)
    }

    /// The optics of the same scene with other settings.
    pub(super) fn with(
        &self,
        light: &Environment,
        settings: &RenderSettings,
        before: Option<&Arc<Optics>>,
    ) -> Result<Arc<Self>, Error> {
        Self::of(self.substances.clone(), light, settings, before)
    }

    fn of(
        substances: Vec<Substance>,
        light: &Environment,
        settings: &RenderSettings,
        before: Option<&Arc<Optics>>,
    ) -> Result<Arc<Self>, Error> {
        let Environment { illuminant, scale, .. } = light;
        let before = before.filter(|before| before.grids.key == Grids::key(settings));
        if let Some(before) = before
            && (&before.substances, &before.illuminant, before.scale) == (&substances, illuminant, *scale)
        {
            return Ok(before.clone());
        }
        let mut warnings = Vec::new();
        for (k, Substance { material, .. }) in substances.iter().enumerate() {
            if !substances[..k].iter().any(|other| other.material == *material) {
                warnings.extend(material.check(settings.wavelengths.range())?);
            }
        }
        let grids = before.map_or_else(|| Grids::new(settings).map(Arc::new), |b| Ok(b.grids.clone()))?;
        warnings.extend(grids.warning());
        let tables = grids.grids.iter().map(|grid| SpectralTable::new(grid, light, &substances)).collect();
        Ok(Arc::new(Optics {
            tables,
            warnings,
            grids,
            substances,
            illuminant: illuminant.clone(),
            scale: *scale,
        }))
    }
}

/// The samples' wavelength grids with the colours that they carry. This is what takes time; it depends on the settings
/// alone.
#[derive(Debug)]
struct Grids {
    key: GridKey,
    grids: Vec<Grid>,
}

/// What grids depend on: the wavelengths, whether they are jittered, along what, and how many grids.
type GridKey = (WavelengthGrid, bool, Sequence, u32);

#[derive(Debug)]
struct Grid {
    wavelengths: WavelengthGrid,
    response: Response,
    upsampler: Upsampler,
}

impl Grids {
    fn key(settings: &RenderSettings) -> GridKey {
        let RenderSettings { wavelengths, jitter, samples, tolerance, coverage, .. } = settings;
        let (sequence, most) = match coverage {
            Coverage::Area => (Sequence::Area, MOST_GRIDS_ON_LATTICE),
            _ if *tolerance > 0.0 => (Sequence::Lattice, MOST_GRIDS_ON_LATTICE),
            _ => (Sequence::GoldenRatio, MOST_GRIDS),
        };
        let moves = *jitter && wavelengths.can_jitter();
        (wavelengths.clone(), *jitter, sequence, if moves { (*samples).min(most) } else { 1 })
    }

    fn new(settings: &RenderSettings) -> Result<Self, Error> {
        let key = Self::key(settings);
        let grid = |sample| {
            let wavelengths = settings.grid(sample);
            let response = Response::new(&wavelengths)?;
            let upsampler = Upsampler::new(&wavelengths, &response)?;
            Ok(Grid { wavelengths, response, upsampler })
        };
        let grids = (0..key.3).map(grid).collect::<Result<_, Error>>()?;
        Ok(Grids { key, grids })
    }

    /// How well the grids carry colour, if not well.
    fn warning(&self) -> Option<Warning> {
        let count = self.key.0.len();
        if self.grids.iter().any(|grid| !grid.response.white_exact()) {
            return Some(Warning::new(format!(
                "{count} wavelengths cannot carry white: the picture shows the colour of these wavelengths alone"
            )));
        }
        let residual = self.grids.iter().map(|grid| grid.upsampler.residual()).fold(0.0, f64::max);
        (residual > 4e-3).then(|| {
            Warning::new(format!(
                "{count} wavelengths are too few to show every colour of the environment: saturated ones are off \
                 by up to {:.1} % (8 wavelengths or more are exact)",
                100.0 * residual
            ))
        })
    }
}

impl SpectralTable {
    fn new(grid: &Grid, light: &Environment, substances: &[Substance]) -> Self {
        let lit = grid.upsampler.clone().with_illuminant(&light.illuminant);
        let scale = light.scale;
        let wavelengths = grid.wavelengths.nm().to_vec();
        let basis = (0..wavelengths.len())
            .map(|i| std::array::from_fn(|base| lit.basis()[base][i] * scale))
            .collect();
        let media =
            substances.iter().map(|s| wavelengths.iter().map(|&nm| Medium::new(s, nm)).collect()).collect();
        SpectralTable { response: grid.response.xyz().to_vec(), basis, media, wavelengths }
    }
}
