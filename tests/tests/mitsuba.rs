//! Each scene of `scripts/verify/scenes` on each device of this machine against Mitsuba 3, with and without polarisation;
//! and deliberate faults, which the comparison must detect.
//!
//! `REQUIRE_BACKENDS` names backends that must have a device here: see [`gemtrace_tests::device`].

use gemtrace_tests::{
    device::{Target, targets},
    mitsuba::{Reference, SCENES, agree, at, scene},
    prelude::{render_on, *},
};
use libtest_mimic::{Arguments, Failed, Trial};
use spectral_core::{
    absorption::{Absorption, Term},
    dispersion::Dispersion,
    material::Kind,
};

fn main() {
    let mut arguments = Arguments::from_args();
    // One thread, the main one: a worker that ends while the process exits meets the destructors of the software driver,
    // and has been seen to find its heap corrupted there, after all trials had passed.
    arguments.test_threads.get_or_insert(1);
    let (present, mut trials) = targets();
    for target in present {
        for name in SCENES {
            let (trial, target) = (format!("[{}] {name}", target.name), target.clone());
            trials.push(Trial::test(trial, move || reproduces(name, &target)));
        }
    }
    trials.extend(
        FAULTS.map(|fault| Trial::test(format!("[fault] {}", fault.name), move || is_detected(&fault))),
    );
    libtest_mimic::run(&arguments, trials).exit();
}

fn reproduces(name: &str, target: &Target) -> Result<(), Failed> {
    for polarized in [false, true] {
        let loaded = scene(name, polarized);
        let film = render_on(&target.backend, &target.device, &loaded.scene, &loaded.settings)?.film;
        let nm = loaded.settings.wavelengths.nm();
        let differences = Reference::of(name, polarized).differences(&film, nm);
        let trial = format!("[{}] {name}, polarised {polarized}", target.name);
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

/// A possible error of a renderer.
#[derive(Clone, Copy)]
struct Fault {
    name: &'static str,
    scene: &'static str,
    nm: f64,
    /// The reference: that of the scene, or one with the fault in it.
    reference: &'static str,
    /// Introduces the fault at the given wavelength.
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
    // Exchanging s and p everywhere changes no intensity, as exchanging E and H does not. The fault is to exchange them in
    // reflection alone. No input of gemtrace does that, so it is in Mitsuba's picture.
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
fn is_detected(fault: &Fault) -> Result<(), Failed> {
    let loaded = scene(fault.scene, true);
    let settings = at(fault.nm, loaded.settings);
    let compare = |scene: &Scene, reference: &str| -> Result<Vec<Difference>, Failed> {
        let film = render(&CPU, scene, &settings).film;
        Ok(Reference::of(reference, true).differences(&film, &[fault.nm]))
    };
    let sound = compare(&loaded.scene, fault.scene)?;
    let mut faulty = loaded.scene;
    (fault.plant)(&mut faulty, fault.nm);
    let found = compare(&faulty, fault.reference)?;
    eprintln!("[fault] {}: {}; without it {}", fault.name, list(&found), list(&sound));
    if !agree(&sound) {
        return Err(format!("the scene differs without the fault: {}", list(&sound)).into());
    }
    if agree(&found) { Err(format!("not detected: {}", list(&found)).into()) } else { Ok(()) }
}
