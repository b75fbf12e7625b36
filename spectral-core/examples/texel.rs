//! A colour becomes light, passes 1 mm of a pink glass, and is seen: `cargo run --example texel`.

use spectral_core::color::{Response, srgb_encode};
use spectral_core::upsample::Upsampler;
use spectral_core::wavelength::WavelengthGrid;

fn main() -> Result<(), spectral_core::Error> {
    let grid = WavelengthGrid::midpoints([380.0, 740.0], 32)?;
    let response = Response::new(&grid)?;
    let light = Upsampler::new(&grid, &response)?.spectrum([0.6, 0.8, 1.0]);
    let absorption = |nm: f64| 0.9 * (-0.5 * ((nm - 553.0) / 38.0).powi(2)).exp();
    let through: Vec<f64> =
        grid.nm().iter().zip(&light).map(|(&nm, l)| l * (-absorption(nm)).exp()).collect();
    println!("before: {:.3?}", response.to_linear_srgb(&light).map(srgb_encode));
    println!("behind: {:.3?}", response.to_linear_srgb(&through).map(srgb_encode));
    Ok(())
}
