//! Samples where the picture needs them: what the qualities promise, and that it stays deterministic.

use gemtrace::{
    registry, scene_file,
    session::{Session, Watch},
};
use gemtrace_tests::scene::{eye, gem, material, scene, settings};
use glam::DVec3;
use spectral_core::{
    camera::Projection,
    color::{RgbSpace, delta_e_2000, lab},
    environment::{Environment, LatLong},
    film::{BLOCK, Film},
    prepare::PreparedScene,
    scene::Scene,
    settings::{Coverage, Quality, RenderSettings},
    tracer::{OpenOptions, Progress},
    wavelength::WavelengthGrid,
};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Breaks a render off after so many calls.
struct Impatient(usize);

impl Watch for Impatient {
    fn progress(&mut self, _: Progress) -> ControlFlow<()> {
        self.0 = self.0.saturating_sub(1);
        if self.0 == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// A part of a stone's crown with its pixels as fine as in a picture 512 pixels wide.
fn quartz() -> Scene {
    let stones = vec![gem("round-brilliant", material("quartz"))];
    let camera = eye(DVec3::new(4.0, -12.0, 22.0), 1.2);
    Scene { height: 26, ..scene(camera, 34, Environment::image(LatLong::studio()), stones) }
}

/// The middle of the diamond in `scenes/brilliant.toml`, as it is in that picture of 512 pixels: in a hall whose lamps are a
/// thousand times as bright as its walls.
fn diamond() -> Scene {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/brilliant.toml");
    let mut scene = scene_file::load(path.as_ref()).expect("a scene of the project").scene;
    let part = 64;
    let Projection::Perspective { fov } = &mut scene.camera.projection else { panic!("a perspective") };
    *fov *= f64::from(part) / f64::from(scene.height);
    Scene { width: part, height: part, ..scene }
}

fn prepared(scene: &Scene, settings: &RenderSettings) -> Arc<PreparedScene> {
    Arc::new(PreparedScene::new(scene, settings).expect("a valid scene"))
}

/// The film, and the rays that it took.
fn render(scene: &Arc<PreparedScene>, options: &OpenOptions, breaks: &[usize]) -> (Film, u64) {
    let (mut film, mut rays) = (Film::new(scene), 0);
    for patience in breaks.iter().chain([&usize::MAX]) {
        let candidates = registry::choose("cpu", None).expect("the processor");
        let rendered = Session::new(candidates, *options).fill(scene, &mut film, &mut Impatient(*patience));
        assert!(rendered.failure.is_none(), "{:?}", rendered.failure);
        rays += rendered.traced.rays;
    }
    (film, rays)
}

/// ΔE00 that 95 % of the pixels do not exceed.
fn difference(a: &Film, b: &Film) -> f64 {
    let white = RgbSpace::Xyz.white_xyz();
    let place = (0..a.height()).flat_map(|y| (0..a.width()).map(move |x| (x, y)));
    let seen = |film: &Film, x, y| lab(film.xyz(x, y).map(f64::from), white);
    let mut all: Vec<f64> = place.map(|(x, y)| delta_e_2000(seen(a, x, y), seen(b, x, y))).collect();
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

/// The hardest light among the scenes: each lamp shows in every facet, in every colour.
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
    // So small a tolerance settles nothing that shows: the lattice by itself.
    let points = RenderSettings { coverage: Coverage::Points, ..normal.clone() };
    let lattice = far(&RenderSettings { samples: 243, tolerance: 1e-6, ..points.clone() });
    let grid = far(&normal.with_samples(16 * 16));
    let [adaptive, default] = [&points, &normal].map(far);
    println!(
        "ΔE00, p95, and rays: lattice {lattice:?}, grid {grid:?}, adaptive {adaptive:?}, default {default:?}"
    );
    assert!(lattice.0 < 1.25 * grid.0 && lattice.1 < grid.1, "{lattice:?} {grid:?}");
    assert!(adaptive.0 < 1.0, "{adaptive:?}");
    // What is left of the error is that of the points that it is compared with, too.
    assert!(default.0 < 1.1, "{default:?}");
}

#[test]
fn samples_go_where_they_change_the_picture() {
    let of = |coverage| RenderSettings { coverage, ..RenderSettings::default() };
    let cases = [
        (of(Coverage::Points), BLOCK, &[9, 27, 81, 243, 729][..], 729),
        (of(Coverage::Auto).with_tolerance(0.3), 2, &[3, 9, 27], 27),
    ];
    for (settings, block, numbers, most) in cases {
        let scene = prepared(&quartz(), &settings);
        // The oracle would take minutes.
        if settings.coverage == Coverage::Auto && !backend_cpu::CPU.areas {
            continue;
        }
        let (film, _) = render(&scene, &OpenOptions::default(), &[]);
        let mut counts = std::collections::BTreeMap::new();
        for (x, y) in (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y))) {
            let samples = film.samples(x, y);
            *counts.entry(samples).or_insert(0u32) += 1;
            assert_eq!(samples, film.samples(x / block * block, y / block * block), "one block, one number");
        }
        assert!(counts.keys().all(|n| numbers.contains(n)), "{counts:?}");
        assert!(counts.len() > 1 && film.is_complete(most), "{counts:?}");
    }
}

#[test]
fn settling_gives_the_same_bits_however_the_work_is_divided() {
    let cells = WavelengthGrid::midpoints([400.0, 700.0], 2).expect("two cells");
    let plain = RenderSettings { wavelengths: cells, jitter: true, threshold: 1e-5, ..settings(&[550.0]) };
    for coverage in [Coverage::Points, Coverage::Area] {
        let settings = RenderSettings { coverage, ..plain.clone() }.with_samples(27).with_tolerance(1.0);
        settling_gives_the_same_bits(&settings);
    }
}

fn settling_gives_the_same_bits(settings: &RenderSettings) {
    let scene = prepared(&quartz(), settings);
    let options = |threads, tile| OpenOptions { threads: Some(threads), tile: Some(tile), deadline: None };
    let (first, rays) = render(&scene, &options(1, 16), &[]);
    for (threads, tile) in [(2, 16), (2, 7), (3, 64)] {
        assert!(render(&scene, &options(threads, tile), &[]) == (first.clone(), rays), "{threads}, {tile}");
    }
    // Broken off and carried on, at several moments.
    for breaks in [&[1usize, 2][..], &[9], &[30, 4]] {
        assert!(render(&scene, &options(2, 5), breaks) == (first.clone(), rays), "{breaks:?}");
    }
}
