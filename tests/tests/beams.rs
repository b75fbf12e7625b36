//! Areas in place of points: exact coverage, a closed account of energy, and the colours that many points come to.

use backend_cpu::{Instructions, cpu_in};
use gemtrace_tests::prelude::*;
use spectral_core::settings::{Coverage, Quality};

const SIZE: u32 = 12;

/// Those that can follow areas.
fn ways() -> impl Iterator<Item = Backend> {
    [CPU, REFERENCE].into_iter().filter(|backend| backend.areas)
}

fn areas(settings: RenderSettings, samples: u32) -> RenderSettings {
    let split = 20.0 * settings.threshold;
    RenderSettings { coverage: Coverage::Area, ..settings }.with_split(split).with_samples(samples)
}

/// A stone under an eye and in parallel rays, so large that some of it is outside of the picture, and within one pixel.
fn cameras() -> [Camera; 4] {
    let from = DVec3::new(5.0, -13.0, 17.0);
    [eye(from, 22.0), parallel(from, 8.0), eye(from, 9.0), eye(from, 140.0)]
}

fn gems() -> [(&'static str, Stone); 5] {
    [
        ("brilliant", gem("round-brilliant", glass(2.417))),
        ("step cut", gem("step", glass(1.57))),
        ("Portuguese cut", gem("portuguese", glass(1.77))),
        ("zircon", zircon()),
        ("peridot", peridot()),
    ]
}

fn zircon() -> Stone {
    lying(gem("round-brilliant", crystal(&[1.925, 1.984])), [0.5, 0.3, 0.8])
}

/// Biaxial.
fn peridot() -> Stone {
    lying(gem("step", crystal(&[1.654, 1.671, 1.689])), [0.2, -0.7, 0.5])
}

fn tourmaline() -> Stone {
    lying(gem("step", pleochroic(&[1.644, 1.624], &[0.3, 0.1])), [0.0, 1.0, 0.3])
}

#[test]
fn in_uniform_light_a_stone_is_as_dark_as_what_was_dropped_of_it() {
    for backend in ways() {
        for ((name, stone), camera) in
            gems().into_iter().flat_map(|gem| cameras().map(|camera| (gem.clone(), camera)))
        {
            let world = scene(camera, SIZE, furnace(), vec![stone]);
            for (leftover, max_depth) in [(Leftover::Exit, 8), (Leftover::Drop, 4), (Leftover::Drop, 1)] {
                let settings = RenderSettings { leftover, max_depth, threshold: 1e-3, ..settings(&[550.0]) };
                let picture = render(&backend, &world, &areas(settings, 1));
                let values = picture.first_line();
                let what = format!("{}, {name}, {leftover:?} at {max_depth}", backend.name);
                assert!(values.iter().all(|v| (0.0..1.0 + 1e-6).contains(v)), "{what}: {values:?}");
                let dark = values.iter().map(|v| 1.0 - v).sum::<f64>() / values.len() as f64;
                let dropped = picture.report.energy.dropped_share();
                assert!(dropped > 0.0, "{what}");
                close(dark, dropped, 1e-6, &what);
                assert_eq!(picture.report.energy.lost, 0.0, "{what}");
            }
        }
    }
}

#[test]
fn coverage_is_exact_and_what_is_past_the_stone_is_transparent() {
    for backend in ways() {
        for camera in cameras() {
            let mut world = scene(camera, SIZE, furnace(), vec![gem("step", tinted(1.57, 0.2))]);
            let settings = areas(RenderSettings { threshold: 1e-2, ..settings(&[550.0]) }, 1);
            let opaque = render(&backend, &world, &settings);
            world.background = Background::Transparent;
            let picture = render(&backend, &world, &settings);
            let scene = prepared(&world, &settings);
            let silhouette = scene.silhouette.as_ref().expect("a lone convex stone");
            let coverage = picture.coverage();
            for (i, (x, y)) in pixels(&picture.film).enumerate() {
                let past = silhouette.pieces(x, y, &mut Vec::new()).map_or(0.0, |rest| rest.area);
                close(coverage[i], 1.0 - past, 1e-6, format!("{}, {x} {y}", backend.name));
                let [with, without] = [&opaque, &picture].map(|p| f64::from(p.film.radiance(x, y)[0]));
                close(with - without, past, 1e-6, format!("{}, {x} {y}", backend.name));
            }
        }
    }
}

/// The relative difference of luminance that so many thousandths of the pixels do not exceed.
fn apart(a: &Film, b: &Film, share: usize) -> f64 {
    let of = |film: &Film, (x, y)| f64::from(film.xyz(x, y)[1]);
    let mut all: Vec<f64> =
        pixels(a).map(|at| (of(a, at) - of(b, at)).abs() / (of(a, at) + of(b, at)).max(1e-3)).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() * share / 1000]
}

#[test]
fn areas_have_the_colours_of_many_points() {
    let light = || Environment::image(LatLong::studio());
    for backend in ways() {
        for (name, stone, polarized) in [
            ("brilliant", gem("round-brilliant", glass(2.417)), true),
            ("brilliant", gem("round-brilliant", glass(2.417)), false),
            ("step cut", gem("step", tinted(1.57, 0.3)), true),
            ("Portuguese cut", gem("portuguese", tinted(1.77, 0.05)), true),
            ("tourmaline", tourmaline(), true),
            ("peridot", peridot(), true),
        ] {
            for (camera, limit) in
                [(eye(DVec3::new(4.0, -12.0, 22.0), 2.0), 0.01), (parallel(DVec3::Z * 30.0, 8.0), 0.04)]
            {
                let world = scene(camera, SIZE, light(), vec![stone.clone()]);
                let settings =
                    RenderSettings { polarized, threshold: 1e-4, ..settings(&[450.0, 550.0, 650.0]) };
                let points = render(&CPU, &world, &settings.with_split(0.1).with_samples(36 * 36));
                let found = render(&backend, &world, &areas(settings, 1));
                let apart = apart(&points.film, &found.film, 950);
                println!("{}, {name}, polarised: {polarized}: {apart:.4}", backend.name);
                assert!(apart < limit, "{}, {name}, {polarized}: {apart}", backend.name);
            }
        }
    }
}

#[test]
fn single_precision_agrees_with_double() {
    for (name, stone, polarized) in [
        ("brilliant", gem("round-brilliant", glass(2.417)), true),
        ("brilliant", gem("round-brilliant", glass(2.417)), false),
        ("step cut", gem("step", tinted(1.57, 0.3)), true),
        ("zircon", zircon(), true),
        ("tourmaline", tourmaline(), true),
        ("peridot", peridot(), true),
    ] {
        for camera in [eye(DVec3::new(4.0, -12.0, 22.0), 12.0), parallel(DVec3::new(3.0, 5.0, 30.0), 2.0)] {
            let world = scene(camera, 2 * SIZE, Environment::image(LatLong::studio()), vec![stone.clone()]);
            let settings = RenderSettings { polarized, threshold: 1e-4, ..settings(&[450.0, 550.0, 650.0]) };
            let [single, double] =
                [CPU, REFERENCE].map(|backend| render(&backend, &world, &areas(settings.clone(), 1)));
            let [median, most] = [500, 995].map(|share| apart(&double.film, &single.film, share));
            println!("{name}, polarised: {polarized}: {median:.1e}, {most:.1e}");
            assert!(median < 1e-5 && most < 0.01, "{name}, {polarized}: {median}, {most}");
        }
    }
}

#[test]
fn finer_pixels_add_up_to_coarse_ones() {
    for backend in ways() {
        let camera = eye(DVec3::new(4.0, -12.0, 22.0), 3.0);
        let stones = || vec![gem("round-brilliant", material("diamond"))];
        let settings = areas(RenderSettings { threshold: 1e-5, ..settings(&[550.0]) }, 1);
        let [coarse, fine] = [1, 2].map(|n| {
            let light = Environment::image(LatLong::studio());
            render(&backend, &scene(camera.clone(), n * SIZE, light, stones()), &settings).film
        });
        let mut differences: Vec<f64> = pixels(&coarse)
            .map(|(x, y)| {
                let quarters = [(0, 0), (1, 0), (0, 1), (1, 1)];
                let sum: f32 = quarters.iter().map(|(i, j)| fine.xyz(2 * x + i, 2 * y + j)[1]).sum();
                f64::from((sum / 4.0 - coarse.xyz(x, y)[1]).abs() / coarse.xyz(x, y)[1].max(1e-3))
            })
            .collect();
        differences.sort_by(f64::total_cmp);
        let p95 = differences[differences.len() * 95 / 100];
        assert!(p95 < 0.02, "{}: {p95}", backend.name);
    }
}

#[test]
fn the_same_bits_however_the_work_is_divided() {
    let stones = || [gem("step", material("ruby")), zircon()];
    for (backend, stone) in ways().flat_map(|way| stones().map(|stone| (way, stone))) {
        let world = scene(cameras()[2].clone(), SIZE, furnace(), vec![stone]);
        let base = RenderSettings {
            spectral: true,
            threshold: 1e-2,
            ..RenderSettings::default().at(Quality::Normal)
        };
        let settings = areas(
            RenderSettings { wavelengths: WavelengthGrid::midpoints([400.0, 700.0], 4).unwrap(), ..base },
            5,
        );
        // One call up to each of these samples.
        let of = |threads, tile, ends: &[u32]| {
            let options = OpenOptions { threads: Some(threads), tile: Some(tile), deadline: None };
            let starts = [0].iter().chain(ends);
            let ranges: Vec<_> = starts.zip(ends).map(|(start, end)| *start..*end).collect();
            let picture = render_with(&backend, &world, &settings, &options, &ranges);
            (picture.bits(), picture.report.rays, picture.report.energy)
        };
        let first = of(1, 16, &[5]);
        for (threads, tile, ends) in [(2, 7, &[5][..]), (3, 1, &[2, 5]), (1, 64, &[1, 4, 5])] {
            assert!(of(threads, tile, ends) == first, "{}: {threads} threads, tiles of {tile}", backend.name);
        }
        if backend.name == CPU.name {
            for set in [Instructions::Avx2, Instructions::Portable] {
                assert!(render(&cpu_in(set), &world, &settings).bits() == first.0, "{set:?}");
            }
        }
    }
}

#[test]
fn devices_that_cannot_are_given_points_and_never_mix_them_with_areas() {
    use gemtrace::{Session, registry};
    let world =
        scene(eye(DVec3::new(5.0, -13.0, 17.0), 22.0), 6, furnace(), vec![gem("step", material("quartz"))]);
    let scene = prepared(&world, &RenderSettings { samples: 9, ..RenderSettings::default() });
    assert!(scene.silhouette.is_some());
    let blind = Backend { name: "blind", areas: false, ..CPU };
    let device = (CPU.devices)().remove(0);
    assert!(blind.tracer(&device, scene.clone(), &OpenOptions::default()).is_err() || CPU.areas);
    let choice = registry::Choice { backend: blind, device, reason: String::new() };
    let mut film = Film::new(&scene);
    let rendered = Session::new([choice], OpenOptions::default()).fill(&scene, &mut film, &mut ());
    assert!(rendered.traced.finished, "{:?}", rendered.failure);
    let shown = rendered.shown(&scene);
    assert_eq!((shown.settings.coverage, shown.settings.samples), (Coverage::Points, 9));
    assert!(film.is_complete(9));
}
