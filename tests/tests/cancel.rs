//! Breaking off: within a second, with what is finished kept.

use backend_cpu::{CPU, REFERENCE};
use gemtrace_tests::{
    render::render,
    scene::{eye, gem, glass, scene, settings, stone, with_speck},
    solid::sphere,
};
use glam::DVec3;
use spectral_core::{
    environment::{Environment, LatLong},
    film::Film,
    prepare::PreparedScene,
    scene::Scene,
    settings::RenderSettings,
    tracer::{Backend, OpenOptions},
};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

fn view(size: u32) -> Scene {
    let camera = eye(DVec3::new(4.0, -12.0, 22.0), 18.0);
    scene(camera, size, Environment::image(LatLong::studio()), vec![gem("round-brilliant", glass(2.417))])
}

/// Breaks off after `after`, and checks that what came back is part of `whole`, if that is given.
fn break_off(backend: &Backend, scene: &Scene, settings: &RenderSettings, after: Duration) -> Film {
    let prepared = Arc::new(PreparedScene::new(scene, settings).expect("a valid scene"));
    let mut film = Film::new(&prepared);
    let device = &(backend.devices)()[0];
    let mut tracer = backend.tracer(device, prepared, &OpenOptions::default()).expect("a device");
    let (start, mut asked) = (Instant::now(), None);
    let mut calls = 0;
    let report = tracer
        .trace(0..settings.samples, &mut film, &mut |progress| {
            calls += 1;
            assert!(progress.done <= progress.total);
            if start.elapsed() < after {
                return ControlFlow::Continue(());
            }
            asked.get_or_insert_with(Instant::now);
            ControlFlow::Break(())
        })
        .expect("a cancel is no error");
    let waited = asked.expect("the render is longer than the wait").elapsed();
    println!("{}: {calls} calls, returned after {waited:?}", backend.name);
    assert!(waited < Duration::from_secs(1), "{}: returned after {waited:?}", backend.name);
    assert!(!report.finished && !film.is_complete(settings.samples));
    film
}

#[test]
fn a_long_render_stops_within_a_second() {
    let settings = RenderSettings { samples: 4096, ..settings(&[450.0, 550.0, 650.0]) };
    let wait = Duration::from_millis(300);
    break_off(&CPU, &view(1024), &settings, wait);
    break_off(&CPU, &with_speck(&view(1024)), &settings, wait);
    break_off(&REFERENCE, &view(1024), &settings, wait);
}

#[test]
fn a_single_endless_pixel_stops_within_a_second() {
    // A ball within a ball and no threshold: a tree of paths that would not end in years.
    let ball = |radius: f64, n: f64| stone(sphere(radius, 8, 16), glass(n));
    let scene = Scene { stones: vec![ball(3.0, 1.5), ball(2.0, 2.4)], ..view(1) };
    let settings = RenderSettings { max_depth: 2000, ..settings(&[550.0]) };
    break_off(&CPU, &scene, &settings, Duration::from_millis(300));
}

#[test]
fn what_is_finished_is_right() {
    let settings = RenderSettings { samples: 16, ..settings(&[450.0, 600.0]) };
    let scene = view(96);
    let whole = render(&CPU, &scene, &settings).film;
    let part = break_off(&CPU, &scene, &settings, Duration::from_millis(20));
    let mut finished = 0;
    for (x, y) in (0..96).flat_map(|y| (0..96).map(move |x| (x, y))) {
        // Pixels come whole passes at a time.
        if part.samples(x, y) == 16 {
            finished += 1;
            assert_eq!(part.xyz(x, y), whole.xyz(x, y));
            assert_eq!(part.radiance(x, y), whole.radiance(x, y));
        } else {
            assert_eq!((part.samples(x, y), part.xyz(x, y)), (0, [0.0; 3]));
        }
    }
    println!("{finished} pixels of {} were finished", 96 * 96);
}
