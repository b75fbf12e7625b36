//! Every colour of a dense cube and 10⁵ bright ones, by the iteration and by the bases of the renderer.

use spectral_core::cie::Illuminant;
use spectral_core::color::Response;
use spectral_core::upsample::{Stop, Upsampler, refine_smits};
use spectral_core::wavelength::WavelengthGrid;

mod support;
use support::Random;

/// The 33³ cube of linear sRGB.
fn cube() -> impl Iterator<Item = [f64; 3]> {
    (0..33 * 33 * 33).map(|i| [i % 33, i / 33 % 33, i / 1089].map(|level| f64::from(level) / 32.0))
}

/// 10⁵ colours whose components lie log-uniformly over ten decades, 10⁻⁴ to 10⁶, one in eight of them zero.
fn bright() -> impl Iterator<Item = [f64; 3]> {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut component =
        move || if random.unit() < 0.125 { 0.0 } else { 10f64.powf(10.0 * random.unit() - 4.0) };
    (0..100_000).map(move |_| [component(), component(), component()])
}

fn error(response: &Response, spectrum: &[f64], rgb: [f64; 3]) -> f64 {
    assert!(spectrum.iter().all(|x| *x >= 0.0), "{rgb:?}: negative radiance");
    let brightest = rgb.into_iter().fold(0.0, f64::max);
    let shown = response.to_linear_srgb(spectrum);
    let summed: f64 = shown.iter().zip(rgb).map(|(a, b)| (a - b).abs()).sum();
    if brightest > 0.0 { summed / brightest } else { summed }
}

fn check_iteration(tolerance: f64, most_sweeps: u32) {
    let grid = WavelengthGrid::stepped(380.0, 780.0, 5.0).unwrap();
    let response = Response::new(&grid).unwrap();
    let stop = Stop { tolerance, ..Stop::default() };
    let mut slowest = (0, [0.0; 3]);
    let (mut total, mut colors) = (0u64, 0u64);
    for rgb in cube().chain(bright()) {
        let found = refine_smits(&grid, &response, rgb, stop).unwrap();
        assert!(found.converged, "{rgb:?} stopped at {}", found.residual);
        let shown = error(&response, &found.spectrum, rgb);
        assert!(shown <= tolerance * (1.0 + 1e-9), "{rgb:?}: {shown}");
        slowest = if found.sweeps > slowest.0 { (found.sweeps, rgb) } else { slowest };
        total += u64::from(found.sweeps);
        colors += 1;
    }
    println!("tolerance {tolerance}: mean {:.2} sweeps, most {slowest:?}", total as f64 / colors as f64);
    assert!(slowest.0 <= most_sweeps, "{slowest:?}");
}

#[test]
fn every_colour_converges_to_four_tenths_of_a_percent() {
    check_iteration(4e-3, 16);
}

#[test]
fn every_colour_converges_to_a_millionth_when_asked() {
    check_iteration(1e-6, 400);
}

#[test]
fn the_upsampler_is_exact_on_every_usual_grid() {
    let midpoints = |count| WavelengthGrid::midpoints([380.0, 740.0], count).unwrap();
    let grids = [
        WavelengthGrid::stepped(380.0, 780.0, 5.0).unwrap(),
        midpoints(32),
        midpoints(8),
        midpoints(8).jittered(37),
        WavelengthGrid::midpoints([395.0, 740.0], 24).unwrap(),
        WavelengthGrid::midpoints([405.0, 720.0], 16).unwrap(),
    ];
    for grid in grids {
        let response = Response::new(&grid).unwrap();
        let upsampler = Upsampler::new(&grid, &response).unwrap();
        assert!(upsampler.exact(), "{} wavelengths: {}", grid.len(), upsampler.residual());
        for rgb in cube().chain(bright()) {
            let shown = error(&response, &upsampler.spectrum(rgb), rgb);
            assert!(shown <= 1e-9, "{} wavelengths, {rgb:?}: {shown}", grid.len());
        }
    }
}

/// The upsamplers on 64 offsets of a grid.
fn jittered(count: usize) -> impl Iterator<Item = Upsampler> {
    (0..64).map(move |sample| {
        let grid = WavelengthGrid::midpoints([380.0, 740.0], count).unwrap().jittered(sample);
        Upsampler::new(&grid, &Response::new(&grid).unwrap()).unwrap()
    })
}

#[test]
fn seven_wavelengths_have_exact_bases_at_every_jitter_offset() {
    for count in [7, 8, 12, 16, 32] {
        for upsampler in jittered(count) {
            assert!(upsampler.exact(), "{count} wavelengths: {}", upsampler.residual());
        }
    }
}

#[test]
fn fewer_wavelengths_report_their_error() {
    // (wavelengths, largest residual over 64 offsets): six lose the last digits, five and four lose bases.
    for (count, largest) in [(6, 1e-6), (5, 0.7), (4, 1.7)] {
        let mut worst = 0f64;
        for upsampler in jittered(count) {
            assert!(upsampler.basis().iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
            worst = worst.max(upsampler.residual());
        }
        assert!(worst <= largest && worst > 1e-11, "{count} wavelengths: {worst}");
    }
}

#[test]
fn a_grey_is_exactly_grey_times_the_illuminant() {
    let grid = WavelengthGrid::midpoints([380.0, 740.0], 32).unwrap();
    let response = Response::new(&grid).unwrap();
    for illuminant in [Illuminant::D65, Illuminant::A, Illuminant::E] {
        let upsampler = Upsampler::new(&grid, &response).unwrap().with_illuminant(&illuminant);
        for grey in [0.0, 0.18, 1.0, 4096.0] {
            for (i, &nm) in grid.nm().iter().enumerate() {
                assert_eq!(upsampler.radiance([grey; 3], i), grey * illuminant.at(nm), "{illuminant:?} {nm}");
            }
        }
    }
}
