//! Every case on each device of this machine against the double-precision reference.
//!
//! All backends use the same samples and wavelengths, so pictures are compared pixel by pixel. At the edges of facets two
//! correct renderers may take different sides, hence the allowed share of outliers.
//!
//! `REQUIRE_BACKENDS` names backends that must have a device here: see [`gemtrace_tests::device`].

use gemtrace_tests::{
    agreement::Comparison,
    cases::{Case, cases},
    crystals::crystals,
    device::{Target, targets},
    prelude::*,
};
use libtest_mimic::{Arguments, Failed, Trial};
use std::sync::OnceLock;

fn main() {
    let mut arguments = Arguments::from_args();
    // One thread, the main one: a worker that ends while the process exits meets the destructors of the software driver,
    // and has been seen to find its heap corrupted there, after all trials had passed.
    arguments.test_threads.get_or_insert(1);
    let cases = cases().into_iter().chain(crystals());
    let cases: Vec<_> = cases.map(|case| Arc::new((case, OnceLock::new()))).collect();
    let (present, mut trials) = targets();
    for target in present {
        for case in &cases {
            let name = format!("[{}] {}", target.name, case.0.name);
            let (case, target) = (case.clone(), target.clone());
            trials.push(Trial::test(name, move || agree(&case.0, &case.1, &target)));
        }
    }
    libtest_mimic::run(&arguments, trials).exit();
}

fn film(backend: &Backend, device: &DeviceInfo, case: &Case) -> Result<Film, Failed> {
    let Picture { film, report } = render_on(backend, device, &case.scene, &case.settings)?;
    // The stones here are not damaged: no light may leave through a gap between facets.
    let lost = report.energy.lost / report.energy.started;
    if report.finished && lost < 1e-6 { Ok(film) } else { Err(format!("{report:?}").into()) }
}

/// Compares with the reference picture, which is rendered once.
fn agree(case: &Case, expected: &OnceLock<Film>, target: &Target) -> Result<(), Failed> {
    let expected = match expected.get() {
        Some(film) => film,
        None => {
            let film = film(&REFERENCE, &(REFERENCE.devices)()[0], case)?;
            expected.get_or_init(|| film)
        }
    };
    let found = film(&target.backend, &target.device, case)?;
    let comparison = Comparison::of(case, expected, &found);
    let trial = format!("[{}] {}", target.name, case.name);
    eprintln!("{trial}: {comparison}");
    if comparison.holds() {
        return Ok(());
    }
    let folder = comparison.keep(&trial, expected, &found)?;
    Err(format!("{comparison}; see {}", folder.display()).into())
}
