//! The wgpu backend beyond the picture: the same bits however the work is divided, correct energies, cancelling, and errors
//! that give the reason.

use backend_wgpu::WGPU;
use gemtrace_tests::gpu::gpus;
use gemtrace_tests::prelude::*;

fn two_stones(environment: Environment) -> Scene {
    let stones = vec![gem("round-brilliant", glass(1.8)), at(gem("step", glass(1.6)), [4.0, 4.0, -1.0])];
    scene(eye(DVec3::new(3.0, -11.0, 28.0), 20.0), 24, environment, stones)
}

fn few_samples() -> RenderSettings {
    RenderSettings { samples: 5, threshold: 1e-3, max_depth: 24, ..settings(&[450.0, 550.0, 650.0]) }
}

#[test]
fn the_same_bits_for_any_batches() {
    if gpus().is_empty() {
        return;
    }
    let (scene, settings) = (two_stones(studio()), few_samples());
    let whole = render(&WGPU, &scene, &settings);
    let tiled = OpenOptions { tile: Some(3), ..OpenOptions::default() };
    let pieces = render_with(&WGPU, &scene, &settings, &tiled, &[0..2, 2..3, 3..5]);
    assert!(whole.bits() == pieces.bits(), "the picture depends on the division of the work");
    assert_eq!(whole.report.rays, pieces.report.rays);
}

#[test]
fn the_energies_are_those_of_the_cpu() {
    if gpus().is_empty() {
        return;
    }
    let (scene, settings) = (two_stones(studio()), few_samples());
    let [found, expected] = [WGPU, CPU].map(|backend| render(&backend, &scene, &settings).report);
    assert_eq!(found.energy.started, expected.energy.started);
    let close = |found: f64, expected: f64| (found - expected).abs() <= 1e-3 * expected + 1e-6;
    for (found, expected, what) in [
        (found.energy.dropped_threshold, expected.energy.dropped_threshold, "dropped by the threshold"),
        (found.energy.left_at_limit, expected.energy.left_at_limit, "left at the limit"),
        (found.energy.dropped_depth, expected.energy.dropped_depth, "dropped at the limit"),
        (found.rays as f64, expected.rays as f64, "rays"),
    ] {
        assert!(close(found, expected), "{what}: {found}, on the CPU {expected}");
    }
    assert_eq!(found.energy.lost, 0.0);
}

#[test]
fn a_cancelled_trace_keeps_what_is_finished() {
    if gpus().is_empty() {
        return;
    }
    let prepared = prepared(&two_stones(studio()), &few_samples());
    let mut film = Film::new(&prepared);
    let options = OpenOptions { tile: Some(4), ..OpenOptions::default() };
    let report = open(&WGPU, &prepared, &options)
        .trace(0..5, &mut film, &mut |progress| {
            if progress.done >= 50 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .expect("a device that works");
    assert!(!report.finished);
    assert_eq!(film.samples(0, 0), 5);
    assert_eq!(film.samples(23, 23), 0);
}

#[test]
fn an_image_beyond_the_device_is_refused_by_name() {
    for gpu in gpus() {
        let width = gpu.limits.max_texture_dimension_2d + 1;
        let (image, _) = LatLong::new(width, 1, vec![[1.0; 3]; width as usize]).expect("a valid image");
        let error = backend_wgpu::upload(&gpu, &Environment::image(image).source).expect_err("too wide");
        assert!(matches!(error, Error::Device { .. }));
        let (message, limit) = (error.to_string(), format!("at most {} an edge", width - 1));
        assert!(message.contains(&width.to_string()) && message.contains(&limit), "{message}");
    }
}

#[test]
fn a_buffer_beyond_the_device_is_refused_with_its_size() {
    for gpu in gpus() {
        let limit = gpu.largest_buffer();
        let message = gpu.storage("the stacks", limit + 1, false).expect_err("too large").to_string();
        assert!(message.contains("the stacks need"), "{message}");
        assert!(message.contains(&format!("at most {} MiB", limit.div_ceil(1 << 20))), "{message}");
    }
}
