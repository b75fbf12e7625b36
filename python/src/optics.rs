//! Optics over rows of arrays; the package checks them and gives them their shapes.

use crate::error::Failure;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use spectral_core::color::{Response, RgbSpace};
use spectral_core::crystal::Crystal;
use spectral_core::dispersion::Dispersion;
use spectral_core::fresnel::{Fresnel, conductor, dielectric};
use spectral_core::stokes::Mueller;
use spectral_core::upsample::{Gamut, Upsampler};
use spectral_core::wavelength::WavelengthGrid;

type Rows<'py> = PyReadonlyArray1<'py, f64>;
type Flat<'py> = Bound<'py, PyArray1<f64>>;

/// `function` of every row of `N`, one after the other.
fn each<'py, const N: usize, const M: usize>(
    py: Python<'py>,
    rows: &Rows<'_>,
    function: impl Fn([f64; N]) -> [f64; M] + Send + Sync,
) -> Flat<'py> {
    let rows = rows.as_array().to_vec();
    let values: Vec<[f64; M]> = py.detach(|| rows.as_chunks().0.iter().map(|&row| function(row)).collect());
    PyArray1::from_vec(py, values.into_flattened())
}

/// Rows of cos θ, n₁, n₂ and k₂ to R_s, R_p, T_s, T_p, the two parts of r_s r_p*, √(T_s T_p), cos θ₂ and 1 for total reflection.
#[pyfunction]
pub fn fresnel<'py>(py: Python<'py>, rows: Rows<'_>, metal: bool) -> Flat<'py> {
    each(py, &rows, |[cos, n1, n2, k2]: [f64; 4]| {
        let event = if metal { conductor(cos, n1, n2, k2) } else { dielectric(cos, n1 / n2) };
        let Fresnel { reflectance_s, reflectance_p, transmittance_s, transmittance_p, .. } = event;
        let [re, im] = event.reflected_cross;
        let tir = f64::from(u8::from(event.tir));
        [
            reflectance_s,
            reflectance_p,
            transmittance_s,
            transmittance_p,
            re,
            im,
            event.refracted_cross,
            event.cos_t,
            tir,
        ]
    })
}

/// Rows of the powers s and p, the product of the amplitudes (its two parts), and cos 2φ and sin 2φ of the frame before the
/// event, to Mueller matrices.
#[pyfunction]
pub fn mueller<'py>(py: Python<'py>, rows: Rows<'_>) -> Flat<'py> {
    each(py, &rows, |[reflectance_s, reflectance_p, re, im, cos2, sin2]: [f64; 6]| {
        let event = Fresnel { reflectance_s, reflectance_p, reflected_cross: [re, im], ..Fresnel::default() };
        let matrix = Mueller::reflection(&event).then(&Mueller::rotation(cos2, sin2)).0;
        std::array::from_fn::<f64, 16, _>(|i| matrix[i / 4][i % 4])
    })
}

/// Rows of three indices, three axes and a direction, the last four unit, to each of two waves' index, walk-off (radians), ray
/// and electric field (unit).
#[pyfunction]
pub fn crystal<'py>(py: Python<'py>, rows: Rows<'_>) -> Flat<'py> {
    each(py, &rows, |row: [f64; 15]| {
        let three = |at: usize| [row[at], row[at + 1], row[at + 2]];
        let crystal = Crystal::new(three(0), [three(3), three(6), three(9)]);
        let waves = crystal.waves([0.0; 3], three(12), 1.0).map(|wave| {
            let field = wave.electric.map(|part| part.re);
            let length = field.iter().map(|part| part * part).sum::<f64>().sqrt();
            let ([x, y, z], [u, v, w]) = (wave.ray(), field.map(|part| part / length));
            [wave.index(), wave.walk_off(), x, y, z, u, v, w]
        });
        std::array::from_fn::<f64, 16, _>(|i| waves[i / 8][i % 8])
    })
}

/// Spectra of rows of colours at wavelengths, a remark about colours that no light has, and the largest error of a colour.
#[pyfunction]
pub fn upsample<'py>(
    py: Python<'py>,
    colours: Rows<'_>,
    nm: Vec<f64>,
    space: &str,
) -> Result<(Flat<'py>, Option<String>, f64), Failure> {
    let space = RgbSpace::by_name(space)?;
    let colours = colours.as_array().to_vec();
    let grid = WavelengthGrid::list(nm)?;
    let (spectra, gamut, residual) = py.detach(|| {
        let upsampler = Upsampler::new(&grid, &Response::new(&grid)?)?;
        let mut gamut = Gamut::new(space);
        let spectra: Vec<f64> =
            colours.as_chunks().0.iter().flat_map(|&rgb| upsampler.spectrum(gamut.convert(rgb))).collect();
        Ok::<_, spectral_core::Error>((spectra, gamut, upsampler.residual()))
    })?;
    Ok((PyArray1::from_vec(py, spectra), gamut.warning().map(|warning| warning.message), residual))
}

/// Cauchy's A, B and C of rows of indices at wavelengths, and remarks.
#[pyfunction]
pub fn cauchy_fit<'py>(
    py: Python<'py>,
    nm: Vec<f64>,
    indices: Rows<'_>,
) -> Result<(Flat<'py>, Vec<String>), Failure> {
    let indices = indices.as_array().to_vec();
    let (mut fitted, mut remarks) = (Vec::new(), Vec::new());
    for row in indices.chunks_exact(nm.len().max(1)) {
        let measured: Vec<[f64; 2]> = nm.iter().zip(row).map(|(&nm, &n)| [nm, n]).collect();
        let (dispersion, warnings) = Dispersion::fit(&measured)?;
        if let Dispersion::Cauchy(coefficients) = dispersion {
            fitted.extend(coefficients);
        }
        remarks.extend(
            warnings
                .iter()
                .map(ToString::to_string)
                .filter(|text| !remarks.contains(text))
                .collect::<Vec<_>>(),
        );
    }
    Ok((PyArray1::from_vec(py, fitted), remarks))
}
