//! On a GPU, how the facets of one convex stone are guessed cannot show: the same bits in every form of guessing, on
//! every device, for any number of wavelengths and facets.

use backend_vulkan::VULKAN;
use backend_wgpu::WGPU;
use gemtrace_tests::{
    render::{Picture, render, render_with},
    scene::{eye, gem, glass, material, scene, settings, stone},
    solid::{cuboid, prism, sphere},
};
use glam::DVec3;
use spectral_core::{
    environment::{Environment, LatLong},
    kernel::facets::{Facets, Guess},
    prepare::PreparedScene,
    scene::{Scene, Stone},
    settings::RenderSettings,
    tracer::{Backend, OpenOptions},
};

/// A backend with its forms of guessing.
type Forms = (Backend, fn(Guess) -> Backend);

const BACKENDS: [Forms; 2] = [(WGPU, backend_wgpu::guessing), (VULKAN, backend_vulkan::guessing)];

fn view(stone: Stone, size: u32) -> Scene {
    let camera = eye(DVec3::new(3.0, -11.0, 20.0), 19.0);
    scene(camera, size, Environment::image(LatLong::studio()), vec![stone])
}

/// `count` wavelengths.
fn lines(count: u32) -> RenderSettings {
    let wavelengths: Vec<f64> = (0..count).map(|i| 400.0 + 300.0 * f64::from(i) / f64::from(count)).collect();
    RenderSettings { threshold: 1e-4, max_depth: 24, ..settings(&wavelengths) }
}

/// Colours and radiances as bits.
fn bits(picture: &Picture) -> Vec<u32> {
    let film = &picture.film;
    let pixels = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    let numbers = pixels.flat_map(|(x, y)| [film.xyz(x, y).to_vec(), film.radiance(x, y)].concat());
    numbers.map(f32::to_bits).collect()
}

/// Renders in every form that this machine's devices have, and by default, and compares.
fn same_bits(scene: &Scene, settings: &RenderSettings, what: &str) {
    for (backend, guessing) in BACKENDS {
        if (backend.devices)().is_empty() {
            eprintln!("skipped: {} has no device here", backend.name);
            continue;
        }
        let expected = render(&guessing(Guess::Nothing), scene, settings);
        let shown = (0..scene.height).any(|y| (0..scene.width).any(|x| expected.film.coverage(x, y) > 0.0));
        assert!(shown, "{what}: no stone to be seen");
        let able = |guess: &Guess| !(guessing(*guess).devices)().is_empty();
        let forms = Guess::ALL.into_iter().filter(able).map(|guess| (guess.name(), guessing(guess)));
        for (name, form) in forms.chain([("default", backend)]) {
            let found = render(&form, scene, settings);
            assert!(bits(&expected) == bits(&found), "{what}: {}, guessing {name}", backend.name);
            assert_eq!(expected.report.rays, found.report.rays, "{what}: {}, {name}", backend.name);
            assert_eq!(expected.report.energy, found.report.energy, "{what}: {}, {name}", backend.name);
        }
    }
}

#[test]
fn for_any_number_of_wavelengths_polarised_or_not() {
    // As many as a subgroup, fewer, and one more than the largest: lanes of several samples in a subgroup.
    for (count, polarized) in [(1, true), (8, false), (8, true), (16, true), (32, true), (33, false)] {
        let settings = RenderSettings { polarized, samples: 2, ..lines(count) };
        let scene = view(gem("round-brilliant", material("diamond")), 12);
        same_bits(&scene, &settings, &format!("{count} wavelengths, polarised {polarized}"));
    }
}

#[test]
fn for_few_facets_and_for_more_than_workgroup_memory_holds() {
    let around = DVec3::splat(2.0);
    let solids =
        [("prism", prism(60.0, 4.0)), ("box", cuboid(-around, around)), ("sphere", sphere(3.0, 13, 40))];
    for (name, mesh) in solids {
        let scene = view(stone(mesh, glass(1.7)), 16);
        let settings = lines(8);
        let prepared = PreparedScene::new(&scene, &settings).expect("a valid scene");
        let lone = prepared.lone_convex_stone().unwrap_or_else(|| panic!("{name} is one convex stone"));
        let facets = Facets::new(&prepared, Guess::Start, 16 << 10);
        assert_eq!(facets.count as usize, lone.facets.len());
        assert_eq!(facets.fits(), name != "sphere", "{name}, {} facets", facets.count);
        same_bits(&scene, &settings, name);
    }
}

#[test]
fn however_the_work_is_cut_up() {
    let scene = view(gem("step", material("diamond")), 12);
    let settings = RenderSettings { samples: 5, ..lines(8) };
    for (backend, guessing) in BACKENDS {
        for guess in Guess::ALL {
            let form = guessing(guess);
            if (form.devices)().is_empty() {
                eprintln!("skipped: {} cannot guess by {} here", backend.name, guess.name());
                continue;
            }
            let whole = render(&form, &scene, &settings);
            let tiled = OpenOptions { tile: Some(3), ..OpenOptions::default() };
            let pieces = render_with(&form, &scene, &settings, &tiled, &[0..2, 2..3, 3..5]);
            assert!(bits(&whole) == bits(&pieces), "{}, guessing {}", backend.name, guess.name());
        }
    }
}
