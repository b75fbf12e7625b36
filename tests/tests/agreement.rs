//! One answer from every backend: each scene of the gallery, on each device of this machine, against the
//! double-precision oracle.
//!
//! Samples and wavelengths are the same everywhere, so pictures are compared pixel by pixel. At the edges of facets
//! two sound renderers may fall on different sides, hence the share of pixels that may be off.
//!
//! `REQUIRE_BACKENDS=cpu,wgpu` makes it a failure if a backend named has no device here; else it is left out, and
//! said so.

use backend_cpu::{CPU, REFERENCE};
use backend_wgpu::WGPU;
use gemtrace_tests::gallery::{Exhibit, MEAN, MEDIAN, TOLERANCE, gallery};
use libtest_mimic::{Arguments, Failed, Trial};
use spectral_core::{
    film::Film,
    prepare::PreparedScene,
    tracer::{Backend, DeviceInfo, OpenOptions},
};
use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

/// A scene with the oracle's picture of it, made once.
struct Case {
    exhibit: Exhibit,
    expected: OnceLock<Film>,
}

fn main() {
    let arguments = Arguments::from_args();
    let cases: Vec<_> =
        gallery().into_iter().map(|exhibit| Arc::new(Case { exhibit, expected: OnceLock::new() })).collect();
    let required = std::env::var("REQUIRE_BACKENDS").unwrap_or_default();
    let mut trials = Vec::new();
    for backend in [CPU, WGPU] {
        let devices = (backend.devices)();
        if devices.is_empty() {
            let missing = required.split(',').any(|name| name.trim() == backend.name);
            let name = format!("[{}] has a device", backend.name);
            trials.push(
                Trial::test(name, || Err("no device on this machine".into())).with_ignored_flag(!missing),
            );
        }
        for device in devices {
            for case in &cases {
                let name = format!("[{}] {}", short(&device), case.exhibit.name);
                let (case, device) = (case.clone(), device.clone());
                trials.push(Trial::test(name, move || agree(&case, &backend, &device)));
            }
        }
    }
    libtest_mimic::run(&arguments, trials).exit();
}

/// "wgpu/llvmpipe".
fn short(device: &DeviceInfo) -> String {
    let word = device.name.split_whitespace().next().unwrap_or("?");
    if device.backend == CPU.name { CPU.name.to_owned() } else { format!("{}/{word}", device.backend) }
}

fn render(backend: &Backend, device: &DeviceInfo, exhibit: &Exhibit) -> Result<(Film, f64), Failed> {
    let prepared = Arc::new(PreparedScene::new(&exhibit.scene, &exhibit.settings)?);
    let mut film = Film::new(&prepared);
    let mut tracer = (backend.open)(device, prepared, &OpenOptions::default())?;
    let report = tracer.trace(0..exhibit.settings.samples, &mut film, &mut |_| ControlFlow::Continue(()))?;
    Ok((film, report.energy.lost / report.energy.started))
}

fn agree(case: &Case, backend: &Backend, device: &DeviceInfo) -> Result<(), Failed> {
    let exhibit = &case.exhibit;
    let expected = match case.expected.get() {
        Some(film) => film,
        None => {
            let (film, _) = render(&REFERENCE, &(REFERENCE.devices)()[0], exhibit)?;
            case.expected.get_or_init(|| film)
        }
    };
    let (found, lost) = render(backend, device, exhibit)?;
    let pixels: Vec<_> = (0..expected.height())
        .flat_map(|y| (0..expected.width()).map(move |x| (x, y)))
        .filter(|&(x, y)| expected.coverage(x, y) + found.coverage(x, y) > 0.0)
        .map(|(x, y)| (expected.xyz(x, y).map(f64::from), found.xyz(x, y).map(f64::from)))
        .collect();
    let mut errors: Vec<f64> = pixels.iter().map(|(e, f)| difference(e, f)).collect();
    errors.sort_by(f64::total_cmp);
    let median = errors[errors.len() / 2];
    let off = errors.iter().filter(|e| **e > TOLERANCE).count() as f64 / errors.len() as f64;
    let worst = errors[errors.len() - 1];
    let mean = |pick: fn(&([f64; 3], [f64; 3])) -> &[f64; 3]| {
        [0, 1, 2].map(|c| pixels.iter().map(|pair| pick(pair)[c]).sum::<f64>())
    };
    let mean = difference(&mean(|p| &p.0), &mean(|p| &p.1));
    let summary = format!(
        "[{}] {}: {} pixels, median {median:.1e}/{MEDIAN:.0e}, {:.2}/{:.2} % off, mean {mean:.1e}/{MEAN:.0e}, \
         worst {worst:.1e}, lost {lost:.1e}",
        short(device),
        exhibit.name,
        errors.len(),
        100.0 * off,
        100.0 * exhibit.outliers,
    );
    eprintln!("{summary}");
    let agrees = median <= MEDIAN && off <= exhibit.outliers && mean <= MEAN;
    if agrees { Ok(()) } else { Err(summary.into()) }
}

/// Distance of two colours relative to the expected one.
fn difference(expected: &[f64; 3], found: &[f64; 3]) -> f64 {
    let size = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let distance = size([0, 1, 2].map(|c| found[c] - expected[c]));
    let error = distance / size(*expected).max(1e-6);
    if error.is_nan() { f64::INFINITY } else { error }
}
