//! The expected colours of the probe are those of the reference, and every device of this machine reproduces them.

use backend_vulkan::{Intersection, VULKAN};
use backend_wgpu::WGPU;
use gemtrace_tests::prelude::*;
use spectral_core::probe::{Subject, probe, subjects};

fn reference(subject: &Subject) -> Vec<[f32; 3]> {
    let mut film = Film::new(&subject.scene);
    trace(open(&REFERENCE, &subject.scene, &OpenOptions::default()).as_mut(), 0..1, &mut film);
    pixels(&film).map(|(x, y)| film.xyz(x, y)).collect()
}

#[test]
fn the_numbers_are_those_of_the_reference() {
    for subject in subjects().expect("valid scenes") {
        let found = reference(&subject);
        // Systems differ in the last bits of sine and logarithm.
        let close = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-5 * b.abs() + 1e-7;
        let same = found.iter().flatten().zip(subject.expected.iter().flatten()).all(close);
        assert!(same, "{} has changed; spectral-core/data/probe should contain\n{found:?}", subject.name);
    }
}

#[test]
fn every_device_passes() {
    let forms = Intersection::ALL.map(Intersection::backend);
    for backend in [CPU, REFERENCE, WGPU, VULKAN].into_iter().chain(forms) {
        for device in (backend.devices)() {
            probe(&backend, &device, &OpenOptions::default()).expect("a sound device");
        }
    }
}
