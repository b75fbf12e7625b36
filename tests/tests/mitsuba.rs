//! One answer from every backend and from Mitsuba 3: each scene of `scripts/verify/scenes`, on each device of this
//! machine, with and without polarisation; and faults that must not go unnoticed.
//!
//! `REQUIRE_BACKENDS` names backends that must have a device here: see [`gemtrace_tests::device`].

use backend_cpu::CPU;
use gemtrace_tests::{
    compare::Difference,
    device::{Way, ways},
    mitsuba::{Reference, SCENES, agree, at, scene},
};
use libtest_mimic::{Arguments, Failed, Trial};
use spectral_core::{
    absorption::{Absorption, Term},
    dispersion::Dispersion,
    film::Film,
    material::Kind,
    prepare::PreparedScene,
    scene::{Scene, Stone},
    settings::RenderSettings,
    tracer::{Backend, DeviceInfo, OpenOptions},
};
use std::ops::ControlFlow;
use std::sync::Arc;

fn main() {
    let arguments = Arguments::from_args();
    let (present, mut trials) = ways();
    for way in present {
        for name in SCENES {
            let (trial, way) = (format!("[{}] {name}", way.name), way.clone());
            trials.push(Trial::test(trial, move || reproduces(name, &way)));
        }
    }
    trials.extend(FAULTS.map(|fault| {
        Trial::test(format!("[fault] {}", fault.name), move || notices(&fault, &CPU, &(CPU.devices)()[0]))
    }));
    libtest_mimic::run(&arguments, trials).exit();
}

fn render(
    scene: &Scene,
    settings: &RenderSettings,
    backend: &Backend,
    device: &DeviceInfo,
) -> Result<Film, Failed> {
    let prepared = Arc::new(PreparedScene::new(scene, settings)?);
    let mut film = Film::new(&prepared);
    let mut tracer = backend.tracer(device, prepared, &OpenOptions::default())?;
    tracer.trace(0..settings.samples, &mut film, &mut |_| ControlFlow::Continue(()))?;
    Ok(film)
}

fn reproduces(name: &str, way: &Way) -> Result<(), Failed> {
    for polarized in [false, true] {
        let loaded = scene(name, polarized);
        let film = render(&loaded.scene, &loaded.settings, &way.backend, &way.device)?;
        let nm = loaded.settings.wavelengths.nm();
        let differences = Reference::of(name, polarized).differences(&film, nm);
        let trial = format!("[{}] {name}, polarised {polarized}", way.name);
        eprintln!("{trial}: {}", list(&differences));
        if !agree(&differences) {
            return Err(format!("{trial}: {}", list(&differences)).into());
        }
    }
    Ok(())
}

fn list(differences: &[Difference]) -> String {
    differences.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// A mistake that a renderer could make.
#[derive(Clone, Copy)]
struct Fault {
    name: &'static str,
    scene: &'static str,
    nm: f64,
    /// The reference to compare with: the scene's own, or one with the fault in it.
    reference: &'static str,
    /// Makes the mistake at the given wavelength.
    plant: fn(&mut Scene, f64),
}

const FAULTS: [Fault; 4] = [
    Fault {
        name: "n off by 0.001",
        scene: "portuguese-quartz",
        nm: 550.0,
        reference: "portuguese-quartz",
        plant: |scene, nm| each_dielectric(scene, |n, a| (n + 1e-3, a), nm),
    },
    Fault {
        name: "absorption per cm taken for absorption per mm",
        scene: "step-sapphire",
        nm: 450.0,
        reference: "step-sapphire",
        plant: |scene, nm| each_dielectric(scene, |n, a| (n, 10.0 * a), nm),
    },
    Fault {
        name: "the light turned by 1°",
        scene: "slab-grazing",
        nm: 550.0,
        reference: "slab-grazing",
        plant: |scene, _| scene.environment.rotation += 1.0,
    },
    // Exchanged everywhere, s and p give the same intensities, as E and H do: the fault is to exchange them in reflection
    // alone. No input of gemtrace does that, so Mitsuba's picture has it.
    Fault {
        name: "s and p exchanged in reflection",
        scene: "slab-grazing",
        nm: 550.0,
        reference: "faults/s-and-p-exchanged",
        plant: |_, _| {},
    },
];

/// Gives every dielectric other optics: (n, α) from its own.
fn each_dielectric(scene: &mut Scene, change: fn(f64, f64) -> (f64, f64), nm: f64) {
    for Stone { material, .. } in &mut scene.stones {
        let (n, coefficient) = change(material.index(nm), material.absorption(nm));
        let absorption = Absorption::new(vec![Term::Constant(coefficient)]).expect("a coefficient");
        let kind = Kind::Dielectric { dispersion: Dispersion::Constant(n), absorption };
        Arc::make_mut(material).kind = kind;
    }
}

/// The comparison must hold without the fault and fail with it.
fn notices(fault: &Fault, backend: &Backend, device: &DeviceInfo) -> Result<(), Failed> {
    let loaded = scene(fault.scene, true);
    let settings = at(fault.nm, loaded.settings);
    let compare = |scene: &Scene, reference: &str| -> Result<Vec<Difference>, Failed> {
        let film = render(scene, &settings, backend, device)?;
        Ok(Reference::of(reference, true).differences(&film, &[fault.nm]))
    };
    let sound = compare(&loaded.scene, fault.scene)?;
    let mut faulty = loaded.scene;
    (fault.plant)(&mut faulty, fault.nm);
    let found = compare(&faulty, fault.reference)?;
    eprintln!("[fault] {}: {}; without it {}", fault.name, list(&found), list(&sound));
    if !agree(&sound) {
        return Err(format!("the sound scene differs: {}", list(&sound)).into());
    }
    if agree(&found) { Err(format!("not noticed: {}", list(&found)).into()) } else { Ok(()) }
}
