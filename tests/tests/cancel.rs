//! Cancelling: a render stops within a second and keeps what is finished.

use gemtrace_tests::prelude::*;
use std::time::{Duration, Instant};

fn view(size: u32) -> Scene {
    let camera = eye(DVec3::new(4.0, -12.0, 22.0), 18.0);
    scene(camera, size, studio(), vec![gem("round-brilliant", glass(2.417))])
}

/// Cancels after `after`, and checks that the render stops within a second.
fn cancel(backend: &Backend, scene: &Scene, settings: &RenderSettings, after: Duration) -> Film {
    let prepared = prepared(scene, settings);
    let mut film = Film::new(&prepared);
    let mut tracer = open(backend, &prepared, &OpenOptions::default());
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
    cancel(&CPU, &view(1024), &settings, wait);
    cancel(&CPU, &with_speck(&view(1024)), &settings, wait);
    cancel(&REFERENCE, &view(1024), &settings, wait);
}

#[test]
fn a_single_endless_pixel_stops_within_a_second() {
    // A ball within a ball and no threshold: the tree of paths would take years.
    let ball = |radius: f64, n: f64| stone(sphere(radius, 8, 16), glass(n));
    let scene = Scene { stones: vec![ball(3.0, 1.5), ball(2.0, 2.4)], ..view(1) };
    let settings = RenderSettings { max_depth: 2000, ..settings(&[550.0]) };
    cancel(&CPU, &scene, &settings, Duration::from_millis(300));
}

#[test]
fn what_is_finished_is_right() {
    let settings = RenderSettings { samples: 16, ..settings(&[450.0, 600.0]) };
    let scene = view(96);
    let whole = render(&CPU, &scene, &settings).film;
    let part = cancel(&CPU, &scene, &settings, Duration::from_millis(20));
    let mut finished = 0;
    for (x, y) in pixels(&part) {
        // A pass finishes all samples of a pixel.
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
