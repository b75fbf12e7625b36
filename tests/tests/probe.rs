//! The numbers of the probe are the reference's, and every device of this machine shows them.

use backend_cpu::{CPU, REFERENCE};
use backend_vulkan::{Intersection, VULKAN};
use backend_wgpu::WGPU;
use spectral_core::{
    film::Film,
    probe::{SIZE, Subject, probe, subjects},
    tracer::OpenOptions,
};
use std::ops::ControlFlow;

fn reference(subject: &Subject) -> Vec<[f32; 3]> {
    let device = &(REFERENCE.devices)()[0];
    let mut tracer = REFERENCE
        .tracer(device, subject.scene.clone(), &OpenOptions::default())
        .expect("the reference opens");
    let mut film = Film::new(&subject.scene);
    tracer.trace(0..1, &mut film, &mut |_| ControlFlow::Continue(())).expect("the reference works");
    (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y))).map(|(x, y)| film.xyz(x, y)).collect()
}

#[test]
fn the_numbers_are_those_of_the_reference() {
    for subject in subjects().expect("valid scenes") {
        let found = reference(&subject);
        // Systems differ in the last bits of sines and logarithms.
        let close = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-5 * b.abs() + 1e-7;
        let same = found.iter().flatten().zip(subject.expected.iter().flatten()).all(close);
        assert!(
            same,
            "{} has changed; spectral-core/src/probe/expected.rs should say\n{found:?}",
            subject.name
        );
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
