//! The picture has the same bits however the work is divided.

use backend_cpu::{Instructions, cpu_in};
use gemtrace_tests::prelude::*;

fn ruby() -> Scene {
    let camera = eye(DVec3::new(4.0, -12.0, 22.0), 18.0);
    let stones = vec![gem("round-brilliant", material("ruby"))];
    Scene { height: 31, ..scene(camera, 45, studio(), stones) }
}

fn quick() -> RenderSettings {
    RenderSettings {
        samples: 8,
        wavelengths: WavelengthGrid::midpoints([400.0, 700.0], 3).expect("a valid grid"),
        jitter: true,
        max_depth: 10,
        threshold: 1e-3,
        ..settings(&[550.0])
    }
}

/// Checks film, rays and energies bit for bit; times may differ.
fn assert_same(a: &Picture, b: &Picture, what: &str) {
    assert!(a.film == b.film, "{what}: the pixels differ");
    assert_eq!((a.report.rays, a.report.energy), (b.report.rays, b.report.energy), "{what}");
}

fn however_divided(backend: &Backend, scene: &Scene) {
    let run = |threads: usize, tile: u32, ranges: &[std::ops::Range<u32>]| {
        let options = OpenOptions { threads: Some(threads), tile: Some(tile), ..OpenOptions::default() };
        render_with(backend, scene, &quick(), &options, ranges)
    };
    let whole = std::slice::from_ref(&(0..8));
    let first = run(1, 16, whole);
    assert!(first.film.is_complete(8));
    for threads in [2, 5] {
        assert_same(&first, &run(threads, 16, whole), &format!("{threads} threads"));
    }
    for tile in [1, 7, 64] {
        assert_same(&first, &run(2, tile, whole), &format!("tiles of {tile}"));
    }
    assert_same(&first, &run(2, 16, &[0..3, 3..8]), "in two calls");
    assert_same(&first, &run(3, 5, &[0..1, 1..2, 2..7, 7..8]), "in four calls");
}

#[test]
fn by_planes() {
    however_divided(&CPU, &ruby());
}

/// A packet has sixteen wavelengths in every instruction set.
#[test]
fn in_any_instruction_set() {
    for polarized in [false, true] {
        for lines in [1, 8, 21] {
            let grid = WavelengthGrid::midpoints([400.0, 700.0], lines).expect("a valid grid");
            let settings = RenderSettings { polarized, wavelengths: grid, ..quick() };
            let picture = |set: Instructions| {
                let whole = std::slice::from_ref(&(0..8));
                render_with(&cpu_in(set), &ruby(), &settings, &OpenOptions::default(), whole)
            };
            let portable = picture(Instructions::Portable);
            for set in Instructions::ALL.into_iter().filter(|set| set.available()) {
                let what = format!("{}, {lines} wavelengths, polarised: {polarized}", set.name());
                assert_same(&portable, &picture(set), &what);
            }
        }
    }
}

#[test]
fn through_the_hierarchy() {
    however_divided(&CPU, &with_speck(&ruby()));
}

#[test]
fn by_the_oracle() {
    let small = Scene { width: 17, height: 13, ..ruby() };
    however_divided(&REFERENCE, &small);
}
