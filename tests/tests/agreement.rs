//! One answer from every backend: each scene of the gallery, on each device of this machine, against the
//! double-precision oracle.
//!
//! Samples and wavelengths are the same everywhere, so pictures are compared pixel by pixel. At the edges of facets
//! two sound renderers may fall on different sides, hence the share of pixels that may be off.
//!
//! `REQUIRE_BACKENDS` names backends that must have a device here: see [`gemtrace_tests::device`].

use backend_cpu::REFERENCE;
use gemtrace_tests::{
    agreement::Agreement,
    device::{Way, ways},
    gallery::{Exhibit, gallery},
};
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
    let (present, mut trials) = ways();
    for way in present {
        for case in &cases {
            let name = format!("[{}] {}", way.name, case.exhibit.name);
            let (case, way) = (case.clone(), way.clone());
            trials.push(Trial::test(name, move || agree(&case, &way)));
        }
    }
    libtest_mimic::run(&arguments, trials).exit();
}

fn render(backend: &Backend, device: &DeviceInfo, exhibit: &Exhibit) -> Result<Film, Failed> {
    let prepared = Arc::new(PreparedScene::new(&exhibit.scene, &exhibit.settings)?);
    let mut film = Film::new(&prepared);
    let mut tracer = backend.tracer(device, prepared, &OpenOptions::default())?;
    let report = tracer.trace(0..exhibit.settings.samples, &mut film, &mut |_| ControlFlow::Continue(()))?;
    // Of the stones here none is damaged: no light may leave by a surface that rounding hid.
    let lost = report.energy.lost / report.energy.started;
    if report.finished && lost < 1e-6 { Ok(film) } else { Err(format!("{report:?}").into()) }
}

fn agree(case: &Case, way: &Way) -> Result<(), Failed> {
    let exhibit = &case.exhibit;
    let expected = match case.expected.get() {
        Some(film) => film,
        None => {
            let film = render(&REFERENCE, &(REFERENCE.devices)()[0], exhibit)?;
            case.expected.get_or_init(|| film)
        }
    };
    let found = render(&way.backend, &way.device, exhibit)?;
    let agreement = Agreement::of(exhibit, expected, &found);
    let trial = format!("[{}] {}", way.name, exhibit.name);
    eprintln!("{trial}: {agreement}");
    if agreement.holds() {
        return Ok(());
    }
    let folder = agreement.keep(&trial, expected, &found)?;
    Err(format!("{agreement}; see {}", folder.display()).into())
}
