//! Colours of other primaries and whites than sRGB's.

use spectral_core::color::matrix::{Matrix, apply, product};
use spectral_core::color::{RgbSpace, bradford, rgb_to_xyz};

/// Nearer chromaticities are the same: files round them.
const SAME: f64 = 2e-3;
/// Twice the area of a triangle of primaries that are still apart.
const LEAST: f64 = 1e-3;
/// Components below this share of the largest are zero but for rounding.
const ROUNDING: f64 = 1e-6;

/// The chromaticities (x, y) of red, green, blue and white.
pub(super) type Chromaticities = [[f64; 2]; 4];

/// The space that these are of, if it is one of ours. XYZ's white is the equal-energy one, as the OpenEXR standard has it.
fn known(given: &Chromaticities) -> Option<RgbSpace> {
    RgbSpace::ALL.into_iter().find(|space| {
        let [red, green, blue] = space.primaries();
        let white = if *space == RgbSpace::Xyz { [1.0 / 3.0; 2] } else { space.white() };
        let own = [red, green, blue, white];
        own.iter().flatten().zip(given.iter().flatten()).all(|(a, b)| (a - b).abs() < SAME)
    })
}

/// The matrix to linear sRGB, adapted to its white by Bradford; `None` where these chromaticities span no colours.
fn to_srgb(given: &Chromaticities) -> Option<Matrix> {
    let [red, green, blue, [x, y]] = *given;
    let [along, across] = [green, blue].map(|end| [end[0] - red[0], end[1] - red[1]]);
    let area = along[0] * across[1] - along[1] * across[0];
    if area.abs() < LEAST || y <= 0.0 {
        return None;
    }
    let white = [x / y, 1.0, (1.0 - x - y) / y];
    let native = rgb_to_xyz([red, green, blue], white).ok()?;
    let adapted = product(&bradford(white, RgbSpace::Srgb.white_xyz()).ok()?, &native);
    let matrix = product(&RgbSpace::Srgb.from_xyz(), &adapted);
    matrix.iter().flatten().all(|v| v.is_finite()).then_some(matrix)
}

/// Converts texels to linear sRGB; says what is wrong with chromaticities that span no colours.
pub(super) fn convert(texels: &mut [[f32; 3]], given: &Chromaticities) -> Result<(), String> {
    match known(given) {
        Some(RgbSpace::Srgb) => Ok(()),
        Some(space) => apply_to(texels, &space.to_linear_srgb()),
        None => adapt(texels, given),
    }
}

/// The same where the white is to be white, whatever the space: our own XYZ has D65 for white all the same.
pub(super) fn adapt(texels: &mut [[f32; 3]], given: &Chromaticities) -> Result<(), String> {
    apply_to(texels, &to_srgb(given).ok_or("its primaries and white span no colours")?)
}

fn apply_to(texels: &mut [[f32; 3]], matrix: &Matrix) -> Result<(), String> {
    for texel in texels {
        let rgb = apply(matrix, texel.map(f64::from));
        let least = ROUNDING * rgb.into_iter().fold(0.0, f64::max);
        *texel = rgb.map(|c| if c.abs() < least { 0.0 } else { c as f32 });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_stays_white_and_our_own_spaces_come_back() {
        let [red, green, blue] = RgbSpace::AcesCg.primaries();
        let mut texels = [[1.0_f32; 3], RgbSpace::AcesCg.from_linear_srgb().map(|row| row[0] as f32)];
        convert(&mut texels, &[red, green, blue, RgbSpace::AcesCg.white()]).unwrap();
        assert!(texels[0].iter().all(|c| (c - 1.0).abs() < 1e-6), "{texels:?}");
        assert!((texels[1][0] - 1.0).abs() < 1e-6 && texels[1][1..] == [0.0; 2], "{texels:?}");
        // Radiance's own primaries, whose white is that of equal energy (color.h).
        let mut grey = [[0.25_f32; 3]];
        convert(&mut grey, &[[0.64, 0.33], [0.29, 0.6], [0.15, 0.06], [0.3333, 0.3333]]).unwrap();
        assert!(grey[0].iter().all(|c| (c - 0.25).abs() < 1e-6), "{grey:?}");
        for bad in [[[0.0; 2]; 4], [[0.1, 0.1], [0.2, 0.2], [0.3, 0.3], [0.3, 0.3]]] {
            assert!(convert(&mut grey, &bad).is_err());
        }
    }
}
