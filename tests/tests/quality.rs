//! Adaptive sampling: the accuracy of the qualities, and determinism.

use gemtrace::{
    registry,
    rendering::{self, Watch},
    scene_file,
};
use gemtrace_tests::prelude::*;
use spectral_core::{
    color::{RgbSpace, delta_e_2000, lab},
    film::BLOCK,
    settings::Quality,
};

/// Cancels a render after a number of calls.
struct CancelAfter(usize);

impl Watch for CancelAfter {
    fn progress(&mut self, _: Progress) -> ControlFlow<()> {
        self.0 = self.0.saturating_sub(1);
        if self.0 == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// A part of a stone's crown at the resolution of a picture 512 pixels wide.
fn quartz() -> Scene {
    let stones = vec![gem("round-brilliant", material("quartz"))];
    let camera = eye(DVec3::new(4.0, -12.0, 22.0), 1.2);
    Scene { height: 26, ..scene(camera, 34, studio(), stones) }
}

/// The middle of the diamond in `scenes/brilliant.toml` at the resolution of that picture of 512 pixels. The lamps of the
/// hall are a thousand times as bright as its walls.
fn diamond() -> Scene {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/brilliant.toml");
    let mut scene = scene_file::load(path.as_ref()).expect("a scene of the project").scene;
    let part = 64;
    let Projection::Perspective { fov } = &mut scene.camera.projection else { panic!("a perspective") };
    *fov *= f64::from(part) / f64::from(scene.height);
    Scene { width: part, height: part, ..scene }
}

/// The film and the number of its rays.
fn render(scene: &Arc<PreparedScene>, options: &OpenOptions, breaks: &[usize]) -> (Film, u64) {
    let (mut film, mut rays) = (Film::new(scene), 0);
    for calls in breaks.iter().chain([&usize::MAX]) {
        let candidates = registry::choose("cpu", None).expect("the processor");
        let rendered = rendering::render(candidates, scene, &mut film, options, &mut CancelAfter(*calls));
        assert!(rendered.failure.is_none(), "{:?}", rendered.failure);
        rays += rendered.traced.rays;
    }
    (film, rays)
}

/// ΔE00 that 95 % of the pixels do not exceed.
fn difference(a: &Film, b: &Film) -> f64 {
    let white = RgbSpace::Xyz.white_xyz();
    let seen = |film: &Film, x, y| lab(film.xyz(x, y).map(f64::from), white);
    let mut all: Vec<f64> = pixels(a).map(|(x, y)| delta_e_2000(seen(a, x, y), seen(b, x, y))).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() * 95 / 100]
}

#[test]
fn the_default_quality_is_within_one_step_of_the_converged_picture_and_each_is_better_than_the_one_before() {
    let plain = RenderSettings::default();
    let (converged, all_rays) = render(
        &prepared(&quartz(), &plain.at(Quality::Final).with_samples(36 * 36)),
        &OpenOptions::default(),
        &[],
    );
    let (differences, rays): (Vec<_>, Vec<_>) = Quality::ALL
        .into_iter()
        .map(|quality| render(&prepared(&quartz(), &plain.at(quality)), &OpenOptions::default(), &[]))
        .map(|(film, rays)| (difference(&film, &converged), rays))
        .unzip();
    println!("ΔE00, p95: {differences:.2?}; rays: {rays:?} and {all_rays}");
    assert!(differences[1] < 1.0 && differences[2] < 0.5, "{differences:?}");
    assert!(differences.is_sorted_by(|a, b| a > b) && rays.is_sorted());
}

/// The most difficult light of the scenes: each lamp shows in every facet, in every colour.
#[test]
fn the_default_quality_is_within_one_step_on_a_diamond_under_lamps_too() {
    let normal = RenderSettings::default();
    let of =
        |settings: &RenderSettings| render(&prepared(&diamond(), settings), &OpenOptions::default(), &[]);
    let (converged, _) = of(&normal.with_samples(36 * 36));
    let far = |settings: &RenderSettings| {
        let (film, rays) = of(settings);
        (difference(&film, &converged), rays)
    };
    // With this tolerance no visible block is settled, so this is the lattice alone.
    let lattice = far(&RenderSettings { samples: 243, tolerance: 1e-6, ..normal.clone() });
    let grid = far(&normal.with_samples(16 * 16));
    let adaptive = far(&normal);
    println!("ΔE00, p95, and rays: lattice {lattice:?}, grid {grid:?}, adaptive {adaptive:?}");
    assert!(lattice.0 < 1.25 * grid.0 && lattice.1 < grid.1, "{lattice:?} {grid:?}");
    assert!(adaptive.0 < 1.0, "{adaptive:?}");
}

#[test]
fn samples_go_where_they_change_the_picture() {
    let scene = prepared(&quartz(), &RenderSettings::default());
    let (film, _) = render(&scene, &OpenOptions::default(), &[]);
    let mut counts = std::collections::BTreeMap::new();
    for (x, y) in pixels(&film) {
        let samples = film.samples(x, y);
        *counts.entry(samples).or_insert(0u32) += 1;
        assert_eq!(samples, film.samples(x / BLOCK * BLOCK, y / BLOCK * BLOCK), "one block, one number");
    }
    assert!(counts.keys().all(|n| [9, 27, 81, 243, 729].contains(n)), "{counts:?}");
    assert!(counts.len() > 2 && film.is_complete(729), "{counts:?}");
}

#[test]
fn settling_gives_the_same_bits_however_the_work_is_divided() {
    let settings = RenderSettings { samples: 27, tolerance: 1.0, jitter: true, ..settings(&[450.0, 600.0]) };
    let scene = prepared(&quartz(), &settings);
    let options = |threads, tile| OpenOptions { threads: Some(threads), tile: Some(tile), deadline: None };
    let (first, rays) = render(&scene, &options(1, 16), &[]);
    for (threads, tile) in [(2, 16), (2, 7), (3, 64)] {
        assert!(render(&scene, &options(threads, tile), &[]) == (first.clone(), rays), "{threads}, {tile}");
    }
    // Cancelled at several times and continued.
    for breaks in [&[1usize, 2][..], &[9], &[30, 4]] {
        assert!(render(&scene, &options(2, 5), breaks) == (first.clone(), rays), "{breaks:?}");
    }
}
