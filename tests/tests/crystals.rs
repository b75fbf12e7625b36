//! Crystals in the reference tracer and on GPUs: an independent program's pictures, energy, the isotropic limit, and what other backends
//! say.

use backend_vulkan::VULKAN;
use backend_wgpu::WGPU;
use gemtrace::scene_file::{LoadedScene, load};
use gemtrace_tests::prelude::*;
use spectral_core::{
    cie::Illuminant,
    film::{PixelSample, Tile, TileSums},
    material::{Kind, Material},
    scene::Orientation,
};
use std::path::Path;

/// A scene of the reference, its kept pixels and their radiances.
type Kept = (LoadedScene, Vec<([u32; 2], Vec<f64>)>);

fn reference(name: &str) -> Kept {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/crystals");
    let scene = load(&data.join(format!("{name}.toml"))).expect("the reference's scene");
    let text = std::fs::read_to_string(data.join(format!("{name}.txt"))).expect("the reference's picture");
    let numbers = |line: &str| line.split(' ').map(|word| word.parse().expect("a number")).collect();
    let pixel = |line: &str| {
        let row: Vec<f64> = numbers(line);
        ([row[0] as u32, row[1] as u32], row[2..].to_vec())
    };
    (scene, text.lines().skip(1).map(pixel).collect())
}

/// A film in which all pixels but some count as done.
fn film_of(scene: &PreparedScene, pixels: &[([u32; 2], Vec<f64>)]) -> Film {
    let mut film = Film::new(scene);
    let wanted = |x, y| pixels.iter().any(|(at, _)| *at == [x, y]);
    for (x, y) in (0..scene.height).flat_map(|y| (0..scene.width).map(move |x| (x, y))) {
        if !wanted(x, y) {
            let tile = Tile { x, y, width: 1, height: 1 };
            let radiance = vec![0.0; scene.wavelength_count()];
            film.add(&TileSums { tile, samples: vec![PixelSample::default()], radiance }).expect("room");
        }
    }
    film
}

/// The backends of this machine that render crystals, with the error that arithmetic may make in the furnace.
fn backends() -> Vec<(Backend, f64)> {
    // The film is in single precision.
    let all = [(REFERENCE, 1e-7), (CPU, 1e-5), (WGPU, 1e-5), (VULKAN, 1e-5)];
    all.into_iter().filter(|(backend, _)| !(backend.devices)().is_empty()).collect()
}

/// The kept pixels by a backend against the independent program's.
fn difference(backend: &Backend, change: impl FnOnce(&mut Scene), name: &str) -> Difference {
    let (LoadedScene { mut scene, settings, .. }, pixels) = reference(name);
    // Texel 1 is radiance 1.
    scene.environment.illuminant = Illuminant::E;
    change(&mut scene);
    let scene = prepared(&scene, &settings);
    let mut film = film_of(&scene, &pixels);
    trace(open(backend, &scene, &OpenOptions::default()).as_mut(), 0..1, &mut film);
    let pairs = pixels.iter().flat_map(|([x, y], expected)| {
        let found: Vec<f64> = film.radiance(*x, *y).into_iter().map(f64::from).collect();
        expected.clone().into_iter().zip(found)
    });
    Difference::of(pairs)
}

#[test]
fn an_independent_programs_pictures() {
    for ((backend, _), name) in backends().iter().flat_map(|b| ["zircon", "tourmaline"].map(|name| (b, name)))
    {
        let difference = difference(backend, |_| (), name);
        println!("{}, {name}: {difference}", backend.name);
        assert!(difference.median < 1e-4 && difference.over_1_percent < 5e-3, "{name}: {difference}");
    }
}

/// What is wrong, and how a scene gets it.
type Fault<'a> = (&'a str, &'a dyn Fn(&mut Scene));

/// Faults that must show: o and e exchanged, the axis turned by 1°, the absorption of the wrong axis.
#[test]
fn faults_show() {
    let edit = |scene: &mut Scene, change: fn(&mut Material)| {
        let mut material = (*scene.stones[0].material).clone();
        change(&mut material);
        scene.stones[0].material = Arc::new(material);
    };
    let faults: [Fault; 3] = [
        ("o and e exchanged", &|scene| {
            edit(scene, |material| {
                let Kind::Dielectric { dispersion, .. } = &mut material.kind else { return };
                std::mem::swap(dispersion, &mut material.axes[0].dispersion);
            });
        }),
        ("axis turned by 1°", &|scene| {
            if let Some(Orientation::OpticAxis(axis)) = &mut scene.stones[0].orientation {
                *axis += axis.length() * 1_f64.to_radians() * axis.any_orthonormal_vector();
            }
        }),
        ("absorption exchanged", &|scene| {
            edit(scene, |material| {
                let Kind::Dielectric { absorption, .. } = &mut material.kind else { return };
                std::mem::swap(absorption, &mut material.axes[0].absorption);
            });
        }),
    ];
    for (fault, change) in faults {
        let difference = difference(&CPU, change, "tourmaline");
        println!("{fault}: {difference}");
        assert!(difference.median > 1e-4 || difference.over_1_percent > 5e-3, "{fault}: {difference}");
    }
}

/// Lossless crystals in uniform light are invisible: every pixel is 1, with folding.
#[test]
fn furnace_of_crystals() {
    let kinds: [(&[f64], [f64; 3]); 4] = [
        (&[1.925, 1.984], [0.5, 0.3, 0.8]),
        (&[1.65835, 1.48640], [1.0, 0.2, 0.1]),
        (&[1.654, 1.671, 1.689], [0.3, -0.7, 0.6]),
        (&[1.5, 1.9, 2.4], [0.0, 1.0, 1.0]),
    ];
    let backends = backends();
    for (indices, axis) in kinds {
        let stone = lying(gem("round-brilliant", crystal(indices)), axis);
        let inclusion = lying(stone.clone(), [1.0, 0.0, 0.0]);
        let inclusion = Stone { width: Some(1.0), position: DVec3::new(0.4, 0.2, -0.6), ..inclusion };
        for stones in [vec![stone.clone()], vec![stone, inclusion]] {
            let scene = scene(eye(DVec3::new(5.0, -13.0, 17.0), 24.0), 6, furnace(), stones);
            let settings =
                RenderSettings { max_depth: 400, threshold: 1e-9, split: 0.3, ..settings(&[550.0]) };
            for (backend, most) in &backends {
                let picture = render(backend, &scene, &settings);
                let error = picture.first_line().iter().map(|v| (v - 1.0).abs()).fold(0.0, f64::max);
                println!("{}, {indices:?}: {error:.1e}, {} rays", backend.name, picture.report.rays);
                assert!(error < *most, "{}, {indices:?}: {error}", backend.name);
            }
        }
    }
}

/// A crystal that splits hardly any light shows the isotropic stone's picture but for the coherence of its modes; with equal
/// indices it is this picture.
#[test]
fn the_isotropic_limit() {
    for (backend, n) in [(&REFERENCE, 1.7), (&CPU, 1.55), (&CPU, 1.7), (&CPU, 1.95)] {
        let picture = |material: Material| {
            let stone = lying(gem("round-brilliant", material), [0.4, 0.1, 0.8]);
            let scene = scene(eye(DVec3::new(5.0, -13.0, 17.0), 24.0), 96, studio(), vec![stone]);
            let settings =
                RenderSettings { threshold: 1e-5, split: 0.01, ..settings(&[450.0, 550.0, 650.0]) };
            render(backend, &scene, &settings)
        };
        let isotropic = picture(glass(n));
        assert_eq!(picture(crystal(&[n, n])).bits(), isotropic.bits());
        let sum = |picture: &Picture| picture.radiances().concat().iter().sum::<f64>();
        // 6.5 mm × 2e-5 is a quarter of a wavelength: still two modes, hardly any other way.
        let weak = picture(crystal(&[n, n + 2e-5]));
        println!("{n}, {}: {:.1e}", backend.name, sum(&weak) / sum(&isotropic) - 1.0);
        close(sum(&weak) / sum(&isotropic), 1.0, 2e-3, "mean");
        assert_ne!(weak.bits(), isotropic.bits());
    }
}

/// Uniaxial and biaxial, weak and strong, with and without polarisation; a stone within and in contact, a metal beside.
#[test]
fn the_cpu_agrees_with_the_reference() {
    let kinds: [(&str, &[f64]); 6] = [
        ("weak", &[1.5442, 1.5533]),
        ("calcite", &[1.65835, 1.48640]),
        ("high", &[2.616, 2.903]),
        ("peridot", &[1.654, 1.671, 1.689]),
        ("topaz", &[1.609, 1.611, 1.618]),
        ("strong", &[1.5, 1.9, 2.4]),
    ];
    let axis = DVec3::new(0.4, -0.3, 0.7).to_array();
    let mut failures = Vec::<String>::new();
    for (name, indices) in kinds {
        let stone = lying(gem("round-brilliant", crystal(indices)), axis);
        let within = |material| {
            let within = lying(gem("step", material), [1.0, 0.3, 0.2]);
            Stone { width: Some(1.5), position: DVec3::new(0.3, 0.2, -0.6), ..within }
        };
        let other = within(crystal(&[1.7, 1.9]));
        let scenes = [
            ("alone", vec![stone.clone()], true),
            ("unpolarised", vec![stone.clone()], false),
            ("glass within", vec![stone.clone(), within(glass(1.5))], true),
            ("crystal within", vec![stone.clone(), other], true),
            ("metal within", vec![stone, within(metal(0.2, 3.4))], true),
        ];
        for (kind, stones, polarized) in scenes {
            let scene = scene(eye(DVec3::new(5.0, -13.0, 17.0), 24.0), 32, studio(), stones);
            let settings =
                RenderSettings { threshold: 1e-3, polarized, max_depth: 12, ..settings(&[450.0, 650.0]) };
            let [cpu, reference] = [&CPU, &REFERENCE].map(|backend| render(backend, &scene, &settings));
            let difference = Difference::of_stones(&reference, &cpu);
            println!("{name}, {kind}: {difference}");
            if difference.median > 1e-5 || difference.over_1_percent > 5e-3 {
                failures.push(format!("{name}, {kind}: {difference}"));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
