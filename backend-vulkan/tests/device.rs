//! Devices are offered and refused as they should be. Without a Vulkan driver there are none, which is no error.

use backend_vulkan::{Intersection, VULKAN};
use spectral_core::{
    camera::{Camera, Projection},
    environment::Environment,
    film::Film,
    prepare::PreparedScene,
    scene::{Background, Scene},
    settings::RenderSettings,
    tracer::{Backend, DeviceInfo, OpenOptions},
};
use std::ops::ControlFlow;
use std::sync::Arc;

/// No stones, an even light.
fn empty() -> Arc<PreparedScene> {
    let camera = Camera {
        position: [0.0, -10.0, 5.0].into(),
        look_at: [0.0; 3].into(),
        up: [0.0, 0.0, 1.0].into(),
        projection: Projection::Perspective { fov: 20.0 },
    };
    let environment = Environment::uniform([1.0, 0.5, 0.25]);
    let background = Background::Environment;
    let scene = Scene { camera, width: 9, height: 5, background, environment, stones: Vec::new() };
    Arc::new(PreparedScene::new(&scene, &RenderSettings::default().with_samples(2)).expect("valid"))
}

fn backends() -> impl Iterator<Item = Backend> {
    std::iter::once(VULKAN).chain(Intersection::ALL.map(Intersection::backend))
}

#[test]
fn a_form_is_named_by_the_devices_that_offer_it() {
    let all = (VULKAN.devices)();
    for form in Intersection::ALL {
        for device in (form.backend().devices)() {
            assert_eq!(device.intersection, form.name());
            assert_eq!(device.name, all[device.index].name);
        }
    }
    // Every device has the software form.
    assert_eq!((Intersection::Software.backend().devices)().len(), all.len());
}

#[test]
fn a_device_that_is_gone_is_refused_by_name() {
    let device = DeviceInfo {
        backend: "vulkan",
        index: 99,
        name: "a card that was sold".into(),
        driver: String::new(),
        api: "",
        memory: 0,
        intersection: Intersection::Software.name(),
        hardware: true,
    };
    for backend in backends() {
        let error = (backend.open)(&device, &OpenOptions::default()).err().expect("refused");
        assert_eq!(error.to_string(), "a card that was sold: the device is no longer there");
    }
}

#[test]
fn an_empty_scene_shows_its_light_and_stops_when_asked() {
    for device in (VULKAN.devices)() {
        let scene = empty();
        let mut tracer = VULKAN.tracer(&device, scene.clone(), &OpenOptions::default()).expect("opens");
        let mut film = Film::new(&scene);
        let stopped = tracer.trace(0..1, &mut film, &mut |_| ControlFlow::Break(())).expect("traces");
        assert!(!stopped.finished);
        let report = tracer.trace(0..2, &mut film, &mut |_| ControlFlow::Continue(())).expect("traces");
        assert!(report.finished);
        let first = film.xyz(0, 0);
        assert!(first[1] > 0.0);
        for (x, y) in [(8, 0), (4, 2), (8, 4)] {
            assert_eq!(film.xyz(x, y), first, "at {x}, {y}");
        }
    }
}
