//! The picture has the same bits however the work is divided.

use backend_cpu::{Instructions, cpu_in};
use backend_vulkan::VULKAN;
use backend_wgpu::WGPU;
use gemtrace_tests::prelude::*;
use spectral_core::material::Material;

fn ruby() -> Scene {
    brilliant(material("ruby"))
}

/// A uniaxial crystal and a biaxial one that absorbs.
fn crystals() -> [Material; 2] {
    [crystal(&[1.925, 1.984]), pleochroic(&[1.654, 1.671, 1.689], &[0.1, 0.0, 0.3])]
}

fn brilliant(material: Material) -> Scene {
    let camera = eye(DVec3::new(4.0, -12.0, 22.0), 18.0);
    let stones = vec![lying(gem("round-brilliant", material), [0.5, 0.3, 0.8])];
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

#[test]
fn in_a_stream() {
    for material in crystals() {
        however_divided(&CPU, &brilliant(material));
    }
}

/// A packet has sixteen wavelengths in every instruction set.
#[test]
fn in_any_instruction_set() {
    let [uniaxial, biaxial] = crystals().map(brilliant);
    for (polarized, scene) in [(false, &ruby()), (true, &ruby()), (true, &uniaxial), (false, &biaxial)] {
        for lines in [1, 8, 21] {
            let grid = WavelengthGrid::midpoints([400.0, 700.0], lines).expect("a valid grid");
            let settings = RenderSettings { polarized, wavelengths: grid, ..quick() };
            let picture = |set: Instructions| {
                let whole = std::slice::from_ref(&(0..8));
                render_with(&cpu_in(set), scene, &settings, &OpenOptions::default(), whole)
            };
            let portable = picture(Instructions::Portable);
            for set in Instructions::ALL.into_iter().filter(|set| set.available()) {
                let what = format!(
                    "{}, {lines} wavelengths, polarised: {polarized}, {}",
                    set.name(),
                    scene.stones[0].material.axes.len()
                );
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

/// A device keeps what scenes share, and each picture is that of a device opened for it alone.
#[test]
fn scene_after_scene_on_one_device() {
    let mut pair = ruby();
    pair.stones.push(at(gem("step", material("quartz")), [9.0, 0.0, 0.0]));
    let [mut other_material, mut other_pose, mut other_light] = [(); 3].map(|()| pair.clone());
    other_material.stones[1] = at(gem("step", material("diamond")), [9.0, 0.0, 0.0]);
    other_pose.stones[0].rotation.z = 20.0;
    other_light.environment = half(DVec3::Z);
    for backend in [CPU, WGPU, VULKAN] {
        let (options, Some(device)) = (OpenOptions::default(), (backend.devices)().into_iter().next()) else {
            continue;
        };
        let mut kept = (backend.open)(&device, &options).expect("opens");
        let mut last: Option<Arc<PreparedScene>> = None;
        let scenes = [&pair, &other_material, &ruby(), &other_pose, &other_light, &pair];
        for (number, scene) in scenes.into_iter().enumerate() {
            let shared = match last {
                Some(last) => Arc::new(last.update(scene, &quick()).expect("a valid scene")),
                None => prepared(scene, &quick()),
            };
            let mut film = Film::new(&shared);
            trace(&mut *kept.load(shared.clone()).expect("loads"), 0..8, &mut film);
            let alone = render(&backend, scene, &quick());
            assert!(film == alone.film, "{}, scene {number}: the pixels differ", backend.name);
            last = Some(shared);
        }
    }
}
